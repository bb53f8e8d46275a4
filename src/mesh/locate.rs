//! Point location: by walking along a segment from a known cell, or with a grid.

use super::{Mesh, NONE, Point};
use nalgebra::SVector;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// A barycentric coordinate above `-TOLERANCE` counts as inside. Coordinates of size `|x|` are
/// rounded by `1e-16 |x|`, so this holds for cells larger than about `1e-4 |x|`.
pub const TOLERANCE: f64 = 1e-12;

/// Barycentric distance within which a point lies on a facet, when a walk passes a vertex or an
/// edge.
const NEAR: f64 = 1e-9;
/// A segment at a smaller angle to a facet (relative to its length) runs along the facet.
const GRAZING: f64 = 1e-12;
/// Number of facets crossed without progress before the cells around the point are searched.
const PATIENCE: usize = 32;
/// Largest number of cells searched around a vertex.
const STAR: usize = 256;

/// A point given by its cell and barycentric coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Number of the cell.
    pub cell: u32,
    /// Barycentric coordinates in that cell; entries `0..=D` are used. None is below
    /// `-`[`TOLERANCE`].
    pub barycentric: [f64; 4],
}

impl<const D: usize> Mesh<D> {
    /// The point at a location.
    #[inline]
    pub fn point_at(&self, at: &Location) -> Point<D> {
        let cell = self.cell(at.cell as usize);
        (0..=D).fold(Point::<D>::zeros(), |x, k| {
            x + self.points()[cell[k] as usize] * at.barycentric[k]
        })
    }

    /// The displacement that changes the barycentric coordinates `l_k`, `k = 1..=D`, of cell `c` by
    /// `change`.
    #[inline]
    pub fn spanned(&self, c: usize, change: &SVector<f64, D>) -> SVector<f64, D> {
        let cell = self.cell(c);
        let origin = self.points()[cell[0] as usize];
        (0..D).fold(SVector::zeros(), |step, k| {
            step + (self.points()[cell[k + 1] as usize] - origin) * change[k]
        })
    }

    /// Walks along the straight segment from `from`, which lies in `cell`, to `to`.
    ///
    /// Returns the location of `to` and `true`; or, if the segment leaves the domain, the location
    /// of the point where it first does (with barycentric coordinates `>= 0`) and `false`. The
    /// boundary belongs to the domain: a segment may run along it or touch it. A point counts as
    /// inside a cell up to [`TOLERANCE`]. If `to` is not finite the result is `cell` with NaN
    /// coordinates, and `false`.
    ///
    /// Does not allocate. The cost is two small products per crossed cell.
    pub fn walk(&self, cell: u32, from: &Point<D>, to: &Point<D>) -> (Location, bool) {
        let map = self.map(cell as usize);
        let mut at = Location { cell, barycentric: map.barycentric(from) };
        let inside = self.walk_on(&mut at, &map.barycentric(to), from, to);
        (at, inside)
    }

    /// [`walk`](Self::walk) from the location `at` of `from`, which becomes that of the end, where
    /// the barycentric coordinates `end` of `to` in the cell of `at` are known, too.
    #[inline]
    pub fn walk_on(
        &self,
        at: &mut Location,
        end: &[f64; 4],
        from: &Point<D>,
        to: &Point<D>,
    ) -> bool {
        if !to.iter().all(|x| x.is_finite()) {
            at.barycentric = [f64::NAN; 4];
            return false;
        }
        let mut cell = at.cell as usize;
        let (mut a, mut b) = (at.barycentric, *end);
        let mut reached = 0.0;
        let mut stalled = 0;
        let mut ignored = [false; 4];
        // A segment meets a cell once; the bound is a safeguard against a defective mesh.
        for _ in 0..(PATIENCE + 1) * (self.cell_count() + 1) {
            let Some((k, t)) = exit::<D>(&a, &b, &ignored) else {
                let within = ignored == [false; 4];
                let barycentric = if within { b } else { within_tolerance::<D>(b) };
                *at = Location { cell: cell as u32, barycentric };
                return true;
            };
            ignored = [false; 4];
            if t > reached {
                reached = t;
                stalled = 0;
            } else {
                stalled += 1;
            }
            let next = self.neighbours(cell)[k];
            if next != NONE && stalled < PATIENCE {
                cell = next as usize;
            } else {
                stalled = 0;
                match self.onward(cell, from, to, reached) {
                    Some((other, along)) => (cell, ignored) = (other, along),
                    None => break,
                }
            }
            (a, b) = (self.map(cell).barycentric(from), self.map(cell).barycentric(to));
        }
        *at = self.on_segment(cell, from, to, reached);
        false
    }

    /// A point of `cell` near `x`: `x` itself if the cell holds it, or else on the boundary of the
    /// cell.
    pub fn nearby(&self, cell: u32, x: &Point<D>) -> Location {
        Location { cell, barycentric: clamped::<D>(self.map(cell as usize).barycentric(x)) }
    }

    /// The point `from + t (to - from)` of `cell`.
    fn on_segment(&self, cell: usize, from: &Point<D>, to: &Point<D>, t: f64) -> Location {
        let p = from + (to - from) * t;
        Location { cell: cell as u32, barycentric: clamped::<D>(self.map(cell).barycentric(&p)) }
    }

    /// A cell around `from + t (to - from)` into which the segment continues, with the facets that
    /// contain its start (by which it cannot leave). `None` if there is none: the segment leaves
    /// the domain here.
    #[cold]
    fn onward(
        &self,
        cell: usize,
        from: &Point<D>,
        to: &Point<D>,
        t: f64,
    ) -> Option<(usize, [bool; 4])> {
        let p = from + (to - from) * t;
        let mut star = [NONE; STAR];
        star[0] = cell as u32;
        let mut found = 1;
        let mut next = 0;
        while next < found {
            let c = star[next] as usize;
            next += 1;
            let map = self.map(c);
            let (a, b, here) = (map.barycentric(from), map.barycentric(to), map.barycentric(&p));
            let step = (0..=D).map(|k| (b[k] - a[k]).abs()).fold(0.0, f64::max);
            let mut on = [false; 4];
            let mut inward = true;
            for k in 0..=D {
                on[k] = here[k] <= NEAR;
                inward &= !on[k] || b[k] - a[k] >= -GRAZING * step;
            }
            if inward && here[..=D].iter().all(|&l| l >= -NEAR) {
                return Some((c, on));
            }
            for (k, &n) in self.neighbours(c).iter().enumerate() {
                if on[k] && n != NONE && found < STAR && !star[..found].contains(&n) {
                    let there = self.map(n as usize).barycentric(&p);
                    if there[..=D].iter().all(|&l| l >= -NEAR) {
                        star[found] = n;
                        found += 1;
                    }
                }
            }
        }
        None
    }
}

/// The facet by which the segment with end points `a`, `b` (barycentric) leaves a cell, and the
/// parameter in `[0, 1]`.
#[inline(always)]
fn exit<const D: usize>(a: &[f64; 4], b: &[f64; 4], ignored: &[bool; 4]) -> Option<(usize, f64)> {
    let (mut first, mut least) = (D + 1, f64::INFINITY);
    for k in 0..=D {
        if b[k] < -TOLERANCE && !ignored[k] {
            let t = if a[k] > 0.0 { a[k] / (a[k] - b[k]) } else { 0.0 };
            if t < least {
                (first, least) = (k, t);
            }
        }
    }
    (first <= D).then_some((first, least))
}

/// `b` if it is that of a point of the cell, or else clamped.
fn within_tolerance<const D: usize>(b: [f64; 4]) -> [f64; 4] {
    if b[..=D].iter().all(|&l| l >= -TOLERANCE) { b } else { clamped::<D>(b) }
}

/// Sets negative barycentric coordinates to zero; the sum stays 1.
fn clamped<const D: usize>(mut b: [f64; 4]) -> [f64; 4] {
    let mut sum = 0.0;
    for l in &mut b[..=D] {
        *l = l.max(0.0);
        sum += *l;
    }
    for l in &mut b[..=D] {
        *l /= sum;
    }
    b
}

/// Finds the cell of any point: a uniform grid of buckets, each with the cells that overlap it.
///
/// Also exact for domains that are not convex or have holes, because every cell near a point is
/// examined.
#[derive(Clone, Debug)]
pub struct Locator<const D: usize> {
    low: Point<D>,
    /// Buckets per unit length.
    density: Point<D>,
    shape: [usize; D],
    /// Cells of bucket `i`: `cells[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl<const D: usize> Locator<D> {
    /// Sorts the cells of a mesh into about one bucket per cell.
    pub fn new(mesh: &Mesh<D>) -> Locator<D> {
        let (low, high) = mesh.bounding_box();
        let extent = high - low;
        // A cell of a mesh has a volume, so every extent is positive.
        let spacing = (extent.product() / mesh.cell_count() as f64).powf(1.0 / D as f64);
        let shape =
            std::array::from_fn(|i| ((extent[i] / spacing) as usize).clamp(1, mesh.cell_count()));
        let density = Point::<D>::from_fn(|i, _| shape[i] as f64 / extent[i]);
        let mut grid = Locator { low, density, shape, starts: Vec::new(), cells: Vec::new() };
        let buckets = shape.iter().product::<usize>();
        let mut starts = vec![0u32; buckets + 1];
        for c in 0..mesh.cell_count() {
            grid.overlapped(mesh, c, |bucket| starts[bucket + 1] += 1);
        }
        for i in 0..buckets {
            starts[i + 1] += starts[i];
        }
        let mut cells = vec![NONE; starts[buckets] as usize];
        let mut free = starts.clone();
        for c in 0..mesh.cell_count() {
            grid.overlapped(mesh, c, |bucket| {
                cells[free[bucket] as usize] = c as u32;
                free[bucket] += 1;
            });
        }
        (grid.starts, grid.cells) = (starts, cells);
        grid
    }

    /// The location of `x`, or `None` outside the domain. `mesh` is the mesh that the locator was
    /// made from.
    ///
    /// Uses exact predicates. A point in no cell but within [`TOLERANCE`] of one (a rounded point
    /// of an oblique boundary) belongs to the nearest.
    pub fn locate(&self, mesh: &Mesh<D>, x: &Point<D>) -> Option<Location> {
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let bucket = self.bucket(&self.coordinates(x));
        let mut nearest = None;
        let mut depth = -TOLERANCE;
        for &c in &self.cells[self.starts[bucket] as usize..self.starts[bucket + 1] as usize] {
            let b = mesh.map(c as usize).barycentric(x);
            let least = b[..=D].iter().copied().fold(f64::INFINITY, f64::min);
            if least < depth {
                continue;
            }
            let at = Location { cell: c, barycentric: b };
            if least > TOLERANCE || contains(mesh, c as usize, x) {
                return Some(at);
            }
            depth = least;
            nearest = Some(at);
        }
        nearest
    }

    /// Calls `visit` with every bucket that overlaps the bounding box of cell `c`, enlarged
    /// slightly for rounding.
    fn overlapped(&self, mesh: &Mesh<D>, c: usize, mut visit: impl FnMut(usize)) {
        let points = mesh.cell(c).iter().map(|&v| mesh.points()[v as usize]);
        let mut low = Point::<D>::repeat(f64::INFINITY);
        let mut high = Point::<D>::repeat(f64::NEG_INFINITY);
        for p in points {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        let margin = (high - low) * NEAR;
        let (first, last) = (self.coordinates(&(low - margin)), self.coordinates(&(high + margin)));
        let mut at = first;
        loop {
            visit(self.bucket(&at));
            let Some(axis) = (0..D).find(|&i| at[i] < last[i]) else { return };
            at[axis] += 1;
            at[..axis].copy_from_slice(&first[..axis]);
        }
    }

    /// Grid coordinates of the bucket of `x`, the nearest one if `x` lies outside the grid.
    fn coordinates(&self, x: &Point<D>) -> [usize; D] {
        // A cast from float saturates: negative values become 0.
        std::array::from_fn(|i| {
            (((x[i] - self.low[i]) * self.density[i]) as usize).min(self.shape[i] - 1)
        })
    }

    fn bucket(&self, at: &[usize; D]) -> usize {
        (0..D).rev().fold(0, |n, i| n * self.shape[i] + at[i])
    }
}

/// True if cell `c`, with its boundary, contains `x`, without rounding error.
fn contains<const D: usize>(mesh: &Mesh<D>, c: usize, x: &Point<D>) -> bool {
    let cell = mesh.cell(c);
    (0..=D).all(|k| {
        let vertex = |i: usize| if i == k { x } else { &mesh.points()[cell[i] as usize] };
        if D == 2 {
            let p = |i| Coord { x: vertex(i)[0], y: vertex(i)[1] };
            orient2d(p(0), p(1), p(2)) >= 0.0
        } else {
            let p = |i| Coord3D { x: vertex(i)[0], y: vertex(i)[1], z: vertex(i)[2] };
            // Positive when the first three run clockwise seen from the fourth, the opposite of our
            // orientation.
            orient3d(p(0), p(1), p(2), p(3)) <= 0.0
        }
    })
}

#[cfg(test)]
#[path = "locate_tests.rs"]
mod tests;
