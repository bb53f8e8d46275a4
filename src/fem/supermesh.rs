//! The common refinement of two triangulations of a domain: the intersections of their triangles.

use super::element::{Element, MAX_LOCAL};
use super::quadrature::Rule;
use super::space::{Space, Value};
use crate::base::{Error, Result, parallel};
use crate::mesh::{Locator, Mesh, NONE};
use std::sync::Arc;

/// Tolerance for the total area of the intersections of a new triangle, relative to its area.
const COVERED: f64 = 1e-9;
/// Largest number of corners of the intersection of two triangles, plus one for rounding.
const CORNERS: usize = 7;

/// The old triangles that intersect every new one. Intersections are computed on demand, because
/// storing them takes far more memory.
#[derive(Clone, Debug)]
pub(super) struct Supermesh {
    from: Arc<Mesh<2>>,
    /// Old cells that intersect new cell `c`: `cells[starts[c]..starts[c + 1]]`.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

/// A corner of an intersection in the barycentric coordinates of both triangles.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    old: [f64; 3],
    new: [f64; 3],
}

impl Corner {
    fn between(&self, other: &Corner, t: f64) -> Corner {
        let mix = |a: &[f64; 3], b: &[f64; 3]| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
        Corner { old: mix(&self.old, &other.old), new: mix(&self.new, &other.new) }
    }
}

/// A convex polygon with few corners.
#[derive(Clone, Copy, Debug, Default)]
struct Polygon {
    corners: [Corner; CORNERS],
    count: usize,
}

impl Polygon {
    fn push(&mut self, corner: Corner) {
        if self.count < CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// The part where barycentric coordinate `k` of the old triangle is not negative.
    fn clipped(&self, k: usize) -> Polygon {
        let mut out = Polygon::default();
        for i in 0..self.count {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % self.count]);
            let (p, q) = (a.old[k], b.old[k]);
            if p >= 0.0 {
                out.push(*a);
            }
            if (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0) {
                let mut cut = a.between(b, p / (p - q));
                cut.old[k] = 0.0;
                out.push(cut);
            }
        }
        out
    }

    /// The triangles of a fan that fills it, with their areas as parts of the new triangle.
    fn fan(&self) -> impl Iterator<Item = ([Corner; 3], f64)> + '_ {
        (2..self.count).map(|i| {
            let part = [self.corners[0], self.corners[i - 1], self.corners[i]];
            let [a, b, c] = part.map(|p| p.new);
            let area = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
            (part, area)
        })
    }

    fn area(&self) -> f64 {
        self.fan().map(|(_, area)| area).sum()
    }
}

/// The intersection of cell `c` of `new` with cell `o` of `old`.
fn intersection(old: &Mesh<2>, o: usize, new: &Mesh<2>, c: usize) -> Polygon {
    let mut polygon = Polygon::default();
    for (k, &v) in new.cell(c).iter().enumerate() {
        let b = old.map(o).barycentric(&new.points()[v as usize]);
        let mut corner = Corner { old: [b[0], b[1], b[2]], new: [0.0; 3] };
        corner.new[k] = 1.0;
        polygon.push(corner);
    }
    (0..3).fold(polygon, |p, k| p.clipped(k))
}

impl Supermesh {
    /// # Errors
    /// Input, if a new triangle is not covered by old ones.
    pub fn new(from: &Arc<Mesh<2>>, to: &Mesh<2>) -> Result<Supermesh> {
        let locator = Locator::new(from);
        let (mut starts, mut cells) = (vec![0], Vec::new());
        // The last new cell that visited an old one.
        let mut seen = vec![NONE; from.cell_count()];
        let mut waiting = Vec::new();
        for c in 0..to.cell_count() {
            let centre = to
                .cell(c)
                .iter()
                .fold(crate::mesh::Point::<2>::zeros(), |s, &v| s + to.points()[v as usize])
                / 3.0;
            waiting.extend(locator.locate(from, &centre).map(|at| at.cell));
            let mut area = 0.0;
            // The open triangle is connected, so what meets it is found across sides.
            while let Some(o) = waiting.pop() {
                if std::mem::replace(&mut seen[o as usize], c as u32) == c as u32 {
                    continue;
                }
                let part = intersection(from, o as usize, to, c).area();
                if part > 0.0 {
                    area += part;
                    cells.push(o);
                    waiting.extend(from.neighbours(o as usize).iter().filter(|&&n| n != NONE));
                }
            }
            if (area - 1.0).abs() > COVERED {
                return Err(Error::input("a field is carried to a mesh of another domain")
                    .at(format!("triangle {c} (counted from 0) about {:?}", centre.as_slice()))
                    .value(format!("{:e} of it is covered by the old mesh", area)));
            }
            starts.push(cells.len() as u32);
        }
        Ok(Supermesh { from: Arc::clone(from), starts, cells })
    }

    /// The integrals of `f`, a function of the space `from` on the old mesh, times the basis
    /// functions of the space `to` on the new one, with `rule` on the triangles of all
    /// intersections.
    pub fn moments<T: Value>(
        &self,
        from: &Space<2>,
        f: &[T],
        to: &Space<2>,
        rule: &Rule,
    ) -> Vec<T> {
        let n = to.local_count();
        let mut local = vec![T::ZERO; n * to.mesh().cell_count()];
        parallel::fill(&mut local, n, |first, part| {
            for (i, out) in part.chunks_exact_mut(n).enumerate() {
                self.moments_of_cell(first + i, from, f, to, rule, out);
            }
        });
        let mut moments = vec![T::ZERO; to.len()];
        for (c, local) in local.chunks_exact(n).enumerate() {
            for (&node, v) in to.cell_nodes(c).iter().zip(local) {
                moments[node as usize] = moments[node as usize] + *v;
            }
        }
        moments
    }

    fn moments_of_cell<T: Value>(
        &self,
        c: usize,
        from: &Space<2>,
        f: &[T],
        to: &Space<2>,
        rule: &Rule,
        out: &mut [T],
    ) {
        let volume = to.mesh().map(c).volume;
        for &o in &self.cells[self.starts[c] as usize..self.starts[c + 1] as usize] {
            for (corners, part) in intersection(&self.from, o as usize, to.mesh(), c).fan() {
                for (l, w) in rule.points.iter().zip(&rule.weights) {
                    let weigh = |of: fn(&Corner) -> &[f64; 3]| {
                        let at = |k: usize| (0..3).map(|i| l[i] * of(&corners[i])[k]).sum::<f64>();
                        [at(0), at(1), at(2), 0.0]
                    };
                    let value = from.value(f, o as usize, &weigh(|c| &c.old)) * (w * part * volume);
                    let basis: [f64; MAX_LOCAL] =
                        Element::values::<2>(to.element(), &weigh(|c| &c.new));
                    out.iter_mut().zip(basis).for_each(|(m, b)| *m = *m + value * b);
                }
            }
        }
    }
}
