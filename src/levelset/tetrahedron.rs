//! The zero set of a P2 function in one tetrahedron, as curved triangles.

use super::patch::Triangle;
use super::quadratic::{Quadratic, barycentric_direction};
use crate::fem::{EDGES, Space};
use crate::mesh::{NONE, Point};
use nalgebra::SVector;

/// The edges of the sorted vertices, in lexicographic order; node `4 + e` of the lattice is the
/// middle of edge `e`.
const SORTED_EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The tetrahedra at the corners of the lattice, positively oriented.
const CORNERS: [[usize; 4]; 4] = [[0, 4, 5, 6], [4, 1, 7, 8], [5, 7, 2, 9], [6, 8, 9, 3]];

/// The octahedron between them: one of its diagonals, and the other four nodes around it.
const DIAGONALS: [([usize; 2], [usize; 4]); 3] =
    [([4, 9], [5, 6, 8, 7]), ([5, 8], [4, 7, 9, 6]), ([6, 7], [4, 5, 9, 8])];

/// The faces opposite to the vertices, seen from outside, with the lattice nodes of their corners
/// and of the middles of their sides.
const FACES: [[usize; 6]; 4] =
    [[1, 2, 3, 7, 9, 8], [0, 3, 2, 6, 9, 5], [0, 1, 3, 4, 8, 6], [0, 2, 1, 5, 7, 4]];

/// The four triangles of a face by its six nodes.
const QUARTERS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// Largest distance of a zero from the middle of a chord, as a fraction of the chord; farther zeros
/// belong to another branch.
const FARTHEST: f64 = 0.5;

/// A tetrahedron with its vertices sorted by their numbers in the mesh. Points on a face are
/// computed from the vertices of the face only (the others add exact zeros) and in their order,
/// hence are bit-identical from both cells.
pub(super) struct Tetrahedron<'a> {
    space: &'a Space<3>,
    phi: &'a [f64],
    c: usize,
    /// Local numbers of the sorted vertices.
    order: [usize; 4],
    /// True if sorting reversed the orientation.
    odd: bool,
    vertices: [Point<3>; 4],
    /// At the nodes of the lattice.
    values: [f64; 10],
}

/// A point of the cell, by its barycentric coordinates for the sorted vertices.
type Sorted = [f64; 4];

/// The middle of a side: its place, and its barycentric coordinates.
type Middle = (Point<3>, Sorted);

impl<'a> Tetrahedron<'a> {
    pub(super) fn new(space: &'a Space<3>, phi: &'a [f64], c: usize) -> Tetrahedron<'a> {
        let (cell, nodal) = (space.mesh().cell(c), space.on_cell(phi, c));
        let mut order = [0, 1, 2, 3];
        order.sort_unstable_by_key(|&k| cell[k]);
        let inversions = SORTED_EDGES.iter().filter(|&&(i, j)| order[i] > order[j]).count();
        let vertices = order.map(|k| space.mesh().points()[cell[k] as usize]);
        let mut values = [0.0; 10];
        for k in 0..4 {
            values[k] = nodal.nodal()[order[k]];
        }
        for (e, &(i, j)) in SORTED_EDGES.iter().enumerate() {
            let ends = (order[i], order[j]);
            let own =
                EDGES.iter().position(|&(a, b)| (a, b) == ends || (b, a) == ends).unwrap_or(0);
            values[4 + e] = nodal.nodal()[4 + own];
        }
        Tetrahedron { space, phi, c, order, odd: inversions % 2 == 1, vertices, values }
    }

    /// Appends the triangles of the zero set in this cell.
    pub(super) fn cut(&self, out: &mut Vec<Triangle>) {
        for tetrahedron in CORNERS {
            self.march(&tetrahedron, out);
        }
        // Any diagonal is compatible with the neighbours; the shortest gives the best triangles.
        let length =
            |d: &[usize; 2]| (self.point(&node(d[0])) - self.point(&node(d[1]))).norm_squared();
        let mut best = &DIAGONALS[0];
        for other in &DIAGONALS[1..] {
            if length(&other.0) < length(&best.0) {
                best = other;
            }
        }
        let ([p, q], ring) = best;
        for i in 0..4 {
            self.march(&[*p, *q, ring[i], ring[(i + 1) % 4]], out);
        }
    }

    /// Appends the part of the face opposite to the local vertex `opposite` where `phi < 0`, with
    /// the normal out of the cell.
    pub(super) fn wall(&self, opposite: usize, out: &mut Vec<Triangle>) {
        let Some(k) = self.order.iter().position(|&o| o == opposite) else { return };
        for quarter in QUARTERS {
            let corners = quarter.map(|i| FACES[k][i]);
            let negative = corners.map(|a| self.values[a] < 0.0);
            match negative.iter().filter(|&&n| n).count() {
                3 => self.push(&corners.map(node), [None; 3], out),
                0 => {}
                count => {
                    let alone = (0..3).find(|&i| negative[i] == (count == 1)).unwrap_or(0);
                    let [a, b, c] = [0, 1, 2].map(|i| corners[(alone + i) % 3]);
                    let (ab, ac) = (self.crossing(a, b), self.crossing(a, c));
                    let middle = Some(self.middle(&ab, &ac, [a, b, c]));
                    if count == 1 {
                        self.push(&[node(a), ab, ac], [None, middle, None], out);
                    } else {
                        self.push(&[ab, node(b), node(c)], [None; 3], out);
                        self.push(&[ab, node(c), ac], [None, None, middle], out);
                    }
                }
            }
        }
    }

    /// Appends the triangles in one tetrahedron of the lattice, positively oriented.
    fn march(&self, nodes: &[usize; 4], out: &mut Vec<Triangle>) {
        let negative = nodes.map(|a| self.values[a] < 0.0);
        let count = negative.iter().filter(|&&n| n).count();
        if count == 2 {
            // Even permutations that put the negative pair first.
            let pairs = [
                [0, 1, 2, 3],
                [0, 2, 3, 1],
                [0, 3, 1, 2],
                [1, 2, 0, 3],
                [1, 3, 2, 0],
                [2, 3, 0, 1],
            ];
            if let Some(p) = pairs.iter().find(|p| negative[p[0]] && negative[p[1]]) {
                self.quadrangle(p.map(|k| nodes[k]), out);
            }
        } else if let Some(alone) =
            (0..4).find(|&k| negative[k] == (count == 1)).filter(|_| count % 2 == 1)
        {
            // Even permutations that put one vertex first.
            let [a, b, c, d] =
                [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]][alone].map(|k| nodes[k]);
            let (b, c) = if count == 1 { (b, c) } else { (c, b) };
            let corners = [self.crossing(a, b), self.crossing(a, c), self.crossing(a, d)];
            let middles = [(0, 1, [a, b, c]), (1, 2, [a, c, d]), (2, 0, [a, d, b])]
                .map(|(i, j, face)| Some(self.middle(&corners[i], &corners[j], face)));
            self.push(&corners, middles, out);
        }
    }

    /// Appends the two triangles between the negative nodes `a, b` and the others, `c, d`.
    fn quadrangle(&self, [a, b, c, d]: [usize; 4], out: &mut Vec<Triangle>) {
        let p =
            [self.crossing(a, c), self.crossing(a, d), self.crossing(b, d), self.crossing(b, c)];
        let faces = [[a, c, d], [d, a, b], [b, d, c], [c, b, a]];
        let side: [Option<Middle>; 4] =
            std::array::from_fn(|i| Some(self.middle(&p[i], &p[(i + 1) % 4], faces[i])));
        let x = p.map(|l| self.point(&l));
        if (x[0] - x[2]).norm_squared() <= (x[1] - x[3]).norm_squared() {
            let middle = Some(self.middle_inside(&p[0], &p[2], [self.c, self.c]));
            self.push(&[p[0], p[1], p[2]], [side[0], side[1], middle], out);
            self.push(&[p[0], p[2], p[3]], [middle, side[2], side[3]], out);
        } else {
            let middle = Some(self.middle_inside(&p[1], &p[3], [self.c, self.c]));
            self.push(&[p[1], p[2], p[3]], [side[1], side[2], middle], out);
            self.push(&[p[1], p[3], p[0]], [middle, side[3], side[0]], out);
        }
    }

    /// Appends a triangle with these corners; a side without a given middle is straight.
    fn push(&self, corners: &[Sorted; 3], middles: [Option<Middle>; 3], out: &mut Vec<Triangle>) {
        let straight = |i: usize| self.placed(between(&corners[i], &corners[(i + 1) % 3]));
        let m: [Middle; 3] = std::array::from_fn(|i| middles[i].unwrap_or_else(|| straight(i)));
        let [a, b, c] = corners.map(|l| self.placed(l));
        let all = if self.odd { [a, c, b, m[2], m[1], m[0]] } else { [a, b, c, m[0], m[1], m[2]] };
        let triangle = Triangle {
            cell: self.c as u32,
            points: all.map(|(x, _)| x),
            barycentric: all.map(|(_, l)| self.own_order(&l)),
        };
        // A zero at a node gives pieces of area zero.
        if (0..6).any(|k| triangle.area_vector(&corner(k)) != SVector::<f64, 3>::zeros()) {
            out.push(triangle);
        }
    }

    fn placed(&self, l: Sorted) -> Middle {
        (self.point(&l), l)
    }

    /// Barycentric coordinates in the order of the cell.
    fn own_order(&self, l: &Sorted) -> [f64; 4] {
        let mut own = [0.0; 4];
        (0..4).for_each(|k| own[self.order[k]] = l[k]);
        own
    }

    fn point(&self, l: &Sorted) -> Point<3> {
        self.vector(l)
    }
    /// The vector with these barycentric coordinates.
    fn vector(&self, l: &Sorted) -> SVector<f64, 3> {
        let v = &self.vertices;
        v[0] * l[0] + v[1] * l[1] + v[2] * l[2] + v[3] * l[3]
    }

    fn value(&self, l: &Sorted) -> f64 {
        let mut sum = 0.0;
        for k in 0..4 {
            sum += self.values[k] * (l[k] * (2.0 * l[k] - 1.0));
        }
        for (e, &(i, j)) in SORTED_EDGES.iter().enumerate() {
            sum += self.values[4 + e] * (4.0 * l[i] * l[j]);
        }
        sum
    }

    /// The zero between two nodes of the lattice with different signs.
    fn crossing(&self, a: usize, b: usize) -> Sorted {
        let (a, b) = (a.min(b), a.max(b));
        let (la, lb) = (node(a), node(b));
        let t = Quadratic::through(self.values[a], self.value(&between(&la, &lb)), self.values[b])
            .crossing();
        std::array::from_fn(|k| la[k] + t * (lb[k] - la[k]))
    }

    /// The zero half-way between two crossings on sides of the triangle `face` of the lattice.
    fn middle(&self, start: &Sorted, end: &Sorted, face: [usize; 3]) -> Middle {
        // The face of the cell that the triangle lies on, if any, and the cell beyond.
        let side = (0..4).find(|&k| face.iter().all(|&a| node(a)[k] == 0.0));
        let beyond = side.map(|k| self.space.mesh().neighbours(self.c)[self.order[k]]);
        match beyond {
            Some(NONE) => self.placed(self.middle_on_wall(start, end, face)),
            Some(other) => self.middle_inside(
                start,
                end,
                [self.c.min(other as usize), self.c.max(other as usize)],
            ),
            None => self.middle_inside(start, end, [self.c, self.c]),
        }
    }

    /// The same on the boundary of the mesh, on the perpendicular bisector of the chord in the
    /// plane of the facet.
    fn middle_on_wall(&self, start: &Sorted, end: &Sorted, face: [usize; 3]) -> Sorted {
        let middle = between(start, end);
        let chord: Sorted = std::array::from_fn(|k| end[k] - start[k]);
        let (v, p, q) = (node(face[0]), node(face[1]), node(face[2]));
        // A vector in the plane that is not along the chord; the corner between the two sides
        // stands first in `face`.
        let median: Sorted = std::array::from_fn(|k| 0.5 * (p[k] + q[k]) - v[k]);
        let (c, m) = (self.vector(&chord), self.vector(&median));
        let square = c.norm_squared();
        let along = m.dot(&c) / square;
        let across: Sorted = std::array::from_fn(|k| median[k] - along * chord[k]);
        let scale = (square / self.vector(&across).norm_squared()).sqrt();
        let step = across.map(|d| scale * d);
        let at = |s: f64| self.value(&std::array::from_fn(|k| middle[k] + s * step[k]));
        let s = Quadratic::about(at(-1.0), at(0.0), at(1.0)).roots()[0];
        if s.abs() <= FARTHEST && scale.is_finite() {
            std::array::from_fn(|k| middle[k] + s * step[k])
        } else {
            middle
        }
    }

    /// The zero half-way between two crossings along the mean gradient in two cells, that of the
    /// function in the first of them; independent of the calling cell.
    fn middle_inside(&self, start: &Sorted, end: &Sorted, [first, second]: [usize; 2]) -> Middle {
        let mesh = self.space.mesh();
        let middle = between(start, end);
        let x = self.point(&middle);
        let length = (self.point(end) - self.point(start)).norm();
        let gradient = |c: usize| self.space.gradient(self.phi, c, &mesh.map(c).barycentric(&x));
        let Some(normal) = (gradient(first) + gradient(second)).try_normalize(0.0) else {
            return (x, middle);
        };
        let step = normal * length;
        let l = mesh.map(first).barycentric(&x);
        let s = Quadratic::on_line(self.space, self.phi, first, &l, &step).roots()[0];
        if s.abs() > FARTHEST {
            return (x, middle);
        }
        let dl = barycentric_direction(self.space, self.c, &step);
        (x + step * s, std::array::from_fn(|k| middle[k] + s * dl[self.order[k]]))
    }
}

/// The point half-way.
fn between(a: &Sorted, b: &Sorted) -> Sorted {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

/// Barycentric coordinates of a node of the lattice.
fn node(a: usize) -> Sorted {
    let mut l = [0.0; 4];
    if a < 4 {
        l[a] = 1.0;
    } else {
        let (i, j) = SORTED_EDGES[a - 4];
        (l[i], l[j]) = (0.5, 0.5);
    }
    l
}

/// Barycentric coordinates of a node of a curved triangle.
fn corner(a: usize) -> [f64; 4] {
    crate::fem::Element::P2.node(a, 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume, in the reference cell.
    fn determinant(t: &[usize; 4]) -> f64 {
        let x = |a: usize| Point::<3>::from_fn(|i, _| node(t[a])[i + 1]);
        (x(1) - x(0)).dot(&(x(2) - x(0)).cross(&(x(3) - x(0))))
    }

    #[test]
    fn the_lattice_fills_the_cell_with_positive_tetrahedra() {
        assert!(CORNERS.iter().all(|t| determinant(t) == 0.125));
        for ([p, q], ring) in DIAGONALS {
            assert!((0..4).all(|i| determinant(&[p, q, ring[i], ring[(i + 1) % 4]]) == 0.125));
        }
        for (k, face) in FACES.iter().enumerate() {
            assert!(determinant(&[face[0], face[1], face[2], k]) < 0.0);
            for (a, b, middle) in [(0, 1, 3), (1, 2, 4), (2, 0, 5)] {
                assert_eq!(node(face[middle]), between(&node(face[a]), &node(face[b])));
            }
        }
    }
}
