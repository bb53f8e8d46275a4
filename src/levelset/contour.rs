//! The contour `phi = 0` of a P2 field in the plane, cut cell by cell into parabolic segments.

use super::quadratic::{Quadratic, barycentric_direction};
use super::sign::cut_cells;
use crate::base::Result;
use crate::fem::{EDGES, Element, Space};
use crate::mesh::Point;
use nalgebra::SVector;
use std::ops::Range;

/// The four triangles of the P2 lattice of a triangle, positively oriented, by local nodes.
pub(super) const LATTICE: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
/// The tetrahedra at the corners of the P2 lattice of a tetrahedron, by local nodes; between them
/// is an octahedron.
pub(super) const CORNERS: [[usize; 4]; 4] =
    [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// A piece of the contour inside one cell: the parabola through three points of the P2 zero set.
///
/// From start to end, the set `phi < 0` lies on its left.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The cell.
    pub cell: u32,
    /// Start, middle (at parameter 1/2) and end.
    pub points: [Point<2>; 3],
    /// Barycentric coordinates of the three points in the cell; the middle may lie outside of it by
    /// a little.
    pub barycentric: [[f64; 4]; 3],
}

impl Segment {
    /// Weights of the three points at parameter `t` in `[0, 1]`.
    fn weights(t: f64) -> [f64; 3] {
        [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)]
    }
    /// The point at parameter `t` in `[0, 1]`.
    pub fn point(&self, t: f64) -> Point<2> {
        let [a, b, c] = Segment::weights(t);
        self.points[0] * a + self.points[1] * b + self.points[2] * c
    }
    /// The derivative of the point with respect to `t`.
    pub fn derivative(&self, t: f64) -> SVector<f64, 2> {
        self.points[0] * (4.0 * t - 3.0)
            + self.points[1] * (4.0 - 8.0 * t)
            + self.points[2] * (4.0 * t - 1.0)
    }
    /// Barycentric coordinates of the point at parameter `t`.
    pub(super) fn barycentric_at(&self, t: f64) -> [f64; 4] {
        let w = Segment::weights(t);
        std::array::from_fn(|k| (0..3).map(|i| w[i] * self.barycentric[i][k]).sum())
    }
}

/// A connected part of the contour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Its segments in [`Contour::segments`], each starting at the end of the one before.
    pub range: Range<usize>,
    /// True if the last segment ends at the start of the first; otherwise both ends lie on the
    /// boundary of the mesh.
    pub closed: bool,
}

/// The contour `phi = 0` of a P2 field on a plane mesh.
///
/// The lattice of the P2 nodes divides a cell into four triangles. If the signs at two lattice
/// nodes differ, `phi` is quadratic on the line between them and its zero there is exact, and
/// identical from both sides of an edge; the middle of each segment is the zero of `phi` on the
/// perpendicular bisector of its chord, also exact.
///
/// Limits: a loop or a thin neck between the nodes of the lattice (half an edge apart) changes no
/// sign and is missed. A value that is exactly 0 counts as positive (outside).
#[derive(Clone, Debug, Default)]
pub struct Contour {
    segments: Vec<Segment>,
    lines: Vec<Line>,
    walls: Vec<[Point<2>; 2]>,
}

/// The lattice edge on which a segment starts or ends, by its two nodes.
type Key = (u32, u32);

impl Contour {
    /// The contour of `phi`. Only cells with a change of sign are processed further.
    ///
    /// # Errors
    /// A space that is not P2, a value of `phi` that is not finite.
    pub fn new(space: &Space<2>, phi: &[f64]) -> Result<Contour> {
        let cells = cut_cells(space, phi)?;
        let mut pieces = Vec::with_capacity(4 * cells.len());
        for c in cells {
            Cell { space, phi, c }.cut(&mut pieces);
        }
        let (segments, lines) = chain(pieces);
        Ok(Contour { segments, lines, walls: negative_walls(space, phi) })
    }
    /// The same contour, not closed by the boundary: for a mesh that covers only its surroundings.
    pub(super) fn without_walls(self) -> Contour {
        Contour { walls: Vec::new(), ..self }
    }
    /// The segments, line by line.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }
    /// The connected parts.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }
    /// True if there is no contour.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }
    /// The parts of the boundary of the mesh where `phi < 0`, with the mesh on their left: together
    /// with the segments they enclose the set `phi < 0`.
    pub fn walls(&self) -> &[[Point<2>; 2]] {
        &self.walls
    }
    /// The points of a line, for a picture: starts and middles of its segments, and the end. For a
    /// closed line the last point is the first.
    pub fn polyline(&self, line: &Line) -> Vec<Point<2>> {
        let segments = self.segments.get(line.range.clone()).unwrap_or_default();
        let mut points: Vec<_> = segments.iter().flat_map(|s| [s.points[0], s.points[1]]).collect();
        points.extend(segments.last().map(|s| s.points[2]));
        points
    }
}

struct Cell<'a> {
    space: &'a Space<2>,
    phi: &'a [f64],
    c: usize,
}

/// A zero on a lattice edge.
struct Crossing {
    key: Key,
    point: Point<2>,
    barycentric: [f64; 4],
}

impl Cell<'_> {
    fn value(&self, a: usize) -> f64 {
        self.phi[self.space.cell_nodes(self.c)[a] as usize]
    }
    /// Appends the segments of this cell with the lattice edges on which they start and end.
    fn cut(&self, out: &mut Vec<(Key, Key, Segment)>) {
        for triangle in LATTICE {
            let negative = triangle.map(|a| self.value(a) < 0.0);
            // The vertex whose sign differs from the other two.
            let Some(alone) = (0..3).find(|&k| {
                negative[k] != negative[(k + 1) % 3] && negative[k] != negative[(k + 2) % 3]
            }) else {
                continue;
            };
            let [a, b, c] = [0, 1, 2].map(|k| triangle[(alone + k) % 3]);
            let (first, second) = (self.crossing(a, b), self.crossing(a, c));
            let (start, end) = if negative[alone] { (first, second) } else { (second, first) };
            let (middle, l) = self.middle(&start, &end);
            let segment = Segment {
                cell: self.c as u32,
                points: [start.point, middle, end.point],
                barycentric: [start.barycentric, l, end.barycentric],
            };
            out.push((start.key, end.key, segment));
        }
    }
    /// The zero between the local nodes `a` and `b`, computed in the same way from both sides of an
    /// edge.
    fn crossing(&self, a: usize, b: usize) -> Crossing {
        let nodes = self.space.cell_nodes(self.c);
        let (a, b) = if nodes[a] < nodes[b] { (a, b) } else { (b, a) };
        let (la, lb) = (Element::P2.node(a, 2), Element::P2.node(b, 2));
        let (va, vb) = (self.value(a), self.value(b));
        let t = Quadratic::through(va, self.half_way(a, b), vb).crossing();
        let (pa, pb) =
            (self.space.nodes()[nodes[a] as usize], self.space.nodes()[nodes[b] as usize]);
        Crossing {
            key: (nodes[a], nodes[b]),
            point: pa + (pb - pa) * t,
            barycentric: std::array::from_fn(|k| la[k] + t * (lb[k] - la[k])),
        }
    }
    /// The value half-way between two nodes of the lattice.
    fn half_way(&self, a: usize, b: usize) -> f64 {
        if a >= 3 && b >= 3 {
            let (la, lb) = (Element::P2.node(a, 2), Element::P2.node(b, 2));
            return self.space.value(
                self.phi,
                self.c,
                &std::array::from_fn(|k| 0.5 * (la[k] + lb[k])),
            );
        }
        // On an edge, in a form that is the same from both sides.
        let (vertex, middle) = (a.min(b), a.max(b));
        let (i, j) = EDGES[middle - 3];
        0.375 * self.value(vertex) + 0.75 * self.value(middle) - 0.125 * self.value(i + j - vertex)
    }
    /// The point of the zero set half-way between two crossings.
    fn middle(&self, start: &Crossing, end: &Crossing) -> (Point<2>, [f64; 4]) {
        let chord = end.point - start.point;
        let m = (start.point + end.point) * 0.5;
        let l = std::array::from_fn(|k| 0.5 * (start.barycentric[k] + end.barycentric[k]));
        let across = SVector::<f64, 2>::new(-chord[1], chord[0]);
        let s = Quadratic::on_line(self.space, self.phi, self.c, &l, &across).roots()[0];
        // Farther than half the chord: another branch, or rounding on a chord of length zero.
        if s.abs() > 0.5 {
            return (m, l);
        }
        let dl = barycentric_direction(self.space, self.c, &across);
        (m + across * s, std::array::from_fn(|k| l[k] + s * dl[k]))
    }
}

/// Orders the pieces: lines that start on the boundary of the mesh, then closed ones. Pieces of
/// length zero, which occur at a zero at a node, are dropped.
fn chain(pieces: Vec<(Key, Key, Segment)>) -> (Vec<Segment>, Vec<Line>) {
    let mut starts: Vec<(Key, usize)> = pieces.iter().enumerate().map(|(i, p)| (p.0, i)).collect();
    starts.sort_unstable();
    // A lattice edge belongs to two triangles at most, and phi < 0 is on the left in both: one
    // segment starts there.
    let next: Vec<Option<usize>> = pieces
        .iter()
        .map(|p| starts.binary_search_by_key(&p.1, |s| s.0).ok().map(|k| starts[k].1))
        .collect();
    let mut first = vec![true; pieces.len()];
    next.iter().flatten().for_each(|&i| first[i] = false);
    let mut rest: Vec<Option<Segment>> = pieces.into_iter().map(|p| Some(p.2)).collect();
    let (mut segments, mut lines) = (Vec::with_capacity(rest.len()), Vec::new());
    let open = (0..rest.len()).filter(|&i| first[i]);
    for (start, closed) in
        open.map(|i| (i, false)).chain((0..rest.len()).map(|i| (i, true))).collect::<Vec<_>>()
    {
        let begin = segments.len();
        let mut at = Some(start);
        while let Some(segment) = at.and_then(|i| rest[i].take()) {
            if segment.points[0] != segment.points[2] {
                segments.push(segment);
            }
            at = at.and_then(|i| next[i]);
        }
        if segments.len() > begin {
            lines.push(Line { range: begin..segments.len(), closed });
        }
    }
    (segments, lines)
}

/// The parts of the boundary facets where `phi < 0`, with the mesh on their left.
fn negative_walls(space: &Space<2>, phi: &[f64]) -> Vec<[Point<2>; 2]> {
    let mut walls = Vec::new();
    for facet in space.mesh().facets() {
        let cell = Cell { space, phi, c: facet.cell as usize };
        let k = facet.opposite as usize;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        // The edges of a triangle are (0,1), (1,2), (2,0), with the middles 3, 4, 5.
        for (a, b) in [(i, 3 + i), (3 + i, j)] {
            let point = |a: usize| space.nodes()[space.cell_nodes(cell.c)[a] as usize];
            match (cell.value(a) < 0.0, cell.value(b) < 0.0) {
                (true, true) => walls.push([point(a), point(b)]),
                (true, false) => walls.push([point(a), cell.crossing(a, b).point]),
                (false, true) => walls.push([cell.crossing(a, b).point, point(b)]),
                (false, false) => {}
            }
        }
    }
    walls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, rectangle};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn space(n: usize) -> Space<2> {
        Space::new(
            &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n], Diagonals::Right).unwrap()),
            Element::P2,
        )
    }
    fn contour(n: usize, f: impl Fn(&Point<2>) -> f64) -> (Space<2>, Vec<f64>, Contour) {
        let space = space(n);
        let phi = space.interpolate(f);
        let contour = Contour::new(&space, &phi).unwrap();
        (space, phi, contour)
    }
    /// Every segment begins where the one before ends, `phi` vanishes on all its points, and
    /// barycentric coordinates fit.
    fn check(space: &Space<2>, phi: &[f64], contour: &Contour) {
        let mut covered = 0;
        for line in contour.lines() {
            assert_eq!(line.range.start, covered);
            covered = line.range.end;
            let part = &contour.segments()[line.range.clone()];
            for pair in part.windows(2) {
                assert_eq!(pair[0].points[2], pair[1].points[0]);
            }
            let ends = (part[0].points[0], part[part.len() - 1].points[2]);
            if line.closed {
                assert_eq!(ends.0, ends.1);
            } else {
                let wall = |p: Point<2>| (0..2).any(|i| p[i] == 0.0 || p[i] == 2.0);
                assert!(wall(ends.0) && wall(ends.1), "{ends:?}");
            }
            assert_eq!(contour.polyline(line).len(), 2 * part.len() + 1);
        }
        assert_eq!(covered, contour.segments().len());
        for s in contour.segments() {
            let cell = s.cell as usize;
            for k in 0..3 {
                let mut x = Point::<2>::zeros();
                for (a, &v) in space.mesh().cell(cell).iter().enumerate() {
                    x += space.mesh().points()[v as usize] * s.barycentric[k][a];
                }
                assert!((x - s.points[k]).norm() < 1e-14);
                // phi < 0 on the left.
                let left = Point::<2>::new(-s.derivative(0.5)[1], s.derivative(0.5)[0]);
                assert!(space.gradient(phi, cell, &s.barycentric[k]).dot(&left) < 0.0);
                assert!(space.value(phi, cell, &s.barycentric[k]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn two_circles_are_two_closed_lines() {
        let two = |x: &Point<2>| {
            let d = |a, b, r: f64| (x - Point::<2>::new(a, b)).norm_squared() - r * r;
            d(0.5, 0.5, 0.3).min(d(1.4, 1.3, 0.4))
        };
        let (space, phi, c) = contour(20, two);
        check(&space, &phi, &c);
        assert_eq!(c.lines().len(), 2);
        assert!(c.lines().iter().all(|l| l.closed));
        assert!(c.walls().is_empty());
    }

    #[test]
    fn a_line_through_the_mesh_is_open_and_ends_on_the_walls() {
        for f in [
            |x: &Point<2>| x[1] - 0.71,
            |x: &Point<2>| x[1] - 1.0,
            |x: &Point<2>| x[1] - x[0],
            |x: &Point<2>| 1.0 - x[0],
        ] {
            // With n = 8 the last three pass through nodes only, where phi is 0.
            let (space, phi, c) = contour(8, f);
            check(&space, &phi, &c);
            assert_eq!((c.lines().len(), c.lines()[0].closed), (1, false));
        }
    }

    #[test]
    fn zeros_on_nodes_leave_no_gap() {
        for half in [0.5, 0.625] {
            let (space, phi, c) = contour(8, |x| (x[0] - 1.0).abs().max((x[1] - 1.0).abs()) - half);
            assert_eq!((c.lines().len(), c.lines()[0].closed), (1, true));
            assert!(c.segments().iter().all(|s| s.points[0] != s.points[2]));
            assert_eq!(phi.len(), space.len());
        }
        // A positive function that touches 0 on nodes, a negative one that does, and 0 everywhere.
        assert!(contour(8, |x| (x[0] - 1.0).abs()).2.is_empty());
        let touching = contour(8, |x| -(x[0] - 1.0).abs()).2;
        assert!(
            touching.segments().iter().all(|s| s.points.iter().all(|p| (p[0] - 1.0).abs() < 1e-14))
        );
        assert!(contour(8, |_| 0.0).2.is_empty());
    }

    #[test]
    fn a_quadratic_zero_set_is_reproduced() {
        // A parabola lies in the space and in the segments; only lattice crossings and middles are
        // tested elsewhere.
        let (space, phi, c) = contour(7, |x| x[1] - 0.3 - 0.4 * x[0] * x[0]);
        check(&space, &phi, &c);
        for s in c.segments() {
            for t in [0.1, 0.3, 0.77] {
                let x = s.point(t);
                assert!((x[1] - 0.3 - 0.4 * x[0] * x[0]).abs() < 2e-5);
            }
        }
    }

    #[test]
    fn a_loop_between_the_nodes_is_not_seen() {
        // The stated limit: nodes are h/2 = 0.05 apart.
        let centre = Point::<2>::new(1.02, 1.04);
        assert!(contour(20, |x| (x - centre).norm() - 0.009).2.is_empty());
        assert_eq!(contour(20, |x| (x - centre).norm() - 0.04).2.lines().len(), 1);
    }

    #[test]
    fn what_cannot_be_cut_is_an_error() {
        let s = space(3);
        let mut phi = vec![1.0; s.len()];
        phi[7] = f64::NAN;
        assert!(Contour::new(&s, &phi).unwrap_err().to_string().contains("node 7"));
        assert!(Contour::new(&s, &phi[1..]).is_err());
        let p1 = Space::new(s.mesh(), Element::P1);
        assert!(Contour::new(&p1, &vec![1.0; p1.len()]).is_err());
    }

    #[test]
    fn the_contour_does_not_depend_on_the_number_of_threads() {
        let s = space(40);
        let phi = s.interpolate(|x| (7.0 * x[0]).sin() * (5.0 * x[1]).cos() - 0.2);
        let run = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| Contour::new(&s, &phi).unwrap().segments().to_vec())
        };
        assert_eq!(run(1), run(2));
    }

    proptest! {
        #[test]
        fn any_smooth_field_gives_chained_lines(a in 1.0..6.0f64, b in 1.0..6.0f64, c in -0.5..0.5f64, shift in 0.0..6.0f64) {
            let f = |x: &Point<2>| (a * x[0] + shift).sin() * (b * x[1]).cos() + 0.3 * x[0] - c;
            let (space, phi, contour) = contour(16, f);
            check_chains(&space, &phi, &contour);
        }

        #[test]
        fn any_node_values_give_chained_lines(values in prop::collection::vec(-2..3i32, 81)) {
            // Small integers: many exact zeros, crossings at nodes, saddles.
            let s = space(4);
            let phi: Vec<f64> = (0..s.len()).map(|i| f64::from(values[i % values.len()])).collect();
            check_chains(&s, &phi, &Contour::new(&s, &phi).unwrap());
        }
    }

    /// Checks properties of the contour of any field, also with kinks and degenerate cells.
    fn check_chains(space: &Space<2>, phi: &[f64], contour: &Contour) {
        let mut boundary = SVector::<f64, 2>::zeros();
        for line in contour.lines() {
            let part = &contour.segments()[line.range.clone()];
            assert!(part.windows(2).all(|w| w[0].points[2] == w[1].points[0]));
            assert!(!line.closed || part[0].points[0] == part[part.len() - 1].points[2]);
        }
        for s in contour.segments() {
            boundary += s.points[2] - s.points[0];
            for k in [0, 2] {
                assert!(space.value(phi, s.cell as usize, &s.barycentric[k]).abs() < 1e-13);
            }
        }
        // Segments and walls together close.
        contour.walls().iter().for_each(|[a, b]| boundary += b - a);
        assert!(boundary.norm() < 1e-12);
    }
}
