//! Nodal means of discontinuous functions, such as derivatives.

use super::space::{Space, Value};
use nalgebra::SVector;

impl<const D: usize> Space<D> {
    /// The volume-weighted mean of `f` over the cells of each node; `f` takes a cell and
    /// barycentric coordinates.
    pub fn means<T: Value>(&self, f: impl Fn(usize, &[f64; 4]) -> T) -> Vec<T> {
        let mut sums = vec![(T::ZERO, 0.0); self.len()];
        for c in 0..self.mesh().cell_count() {
            let volume = self.mesh().map(c).volume;
            for (k, &node) in self.cell_nodes(c).iter().enumerate() {
                let (sum, weight) = &mut sums[node as usize];
                *sum = *sum + f(c, &self.element().node(k, D)) * volume;
                *weight += volume;
            }
        }
        sums.into_iter().map(|(sum, weight)| sum * (1.0 / weight)).collect()
    }

    /// Vorticity of a velocity at the nodes, by [`means`](Self::means): `d_x u_y - d_y u_x`,
    /// positive for counter-clockwise rotation; in space the norm of `curl u`. Second order in the
    /// interior, for P2 functions on regular meshes.
    pub fn vorticity(&self, u: &[SVector<f64, D>]) -> Vec<f64> {
        let curl = self.means(|c, l| {
            let jacobian = self.jacobian(u, c, l);
            let turn = |i: usize, j: usize| {
                if i.max(j) < D { jacobian[(i, j)] - jacobian[(j, i)] } else { 0.0 }
            };
            SVector::<f64, 3>::new(turn(2, 1), turn(0, 2), turn(1, 0))
        });
        curl.iter().map(|w| if D == 2 { w[2] } else { w.norm() }).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::fem::{Element, Space};
    use crate::mesh::{Diagonals, Point, box_mesh, rectangle};
    use nalgebra::SVector;
    use std::sync::Arc;

    fn plane(n: usize) -> Space<2> {
        let mesh = rectangle([0.0; 2], [1.0, 1.0], [n, n], Diagonals::Right).unwrap();
        Space::new(&Arc::new(mesh), Element::P2)
    }

    #[test]
    fn means_of_what_is_continuous_are_its_values_and_jumps_are_weighed_by_volumes() {
        let space = plane(3);
        let f = space.interpolate(|x| x[0] * x[1] - x[1]);
        for (a, b) in space.means(|c, l| space.value(&f, c, l)).iter().zip(&f) {
            assert!((a - b).abs() < 1e-14);
        }
        // Halves of the interval from 0 to 1, the second three times as long; the value is 0 or 1.
        let mut points: Vec<Point<2>> = Vec::new();
        for x in [0.0, 0.25, 1.0] {
            points.extend([Point::<2>::new(x, 0.0), Point::<2>::new(x, 1.0)]);
        }
        let mesh =
            crate::mesh::Mesh::new(points, vec![0, 2, 1, 2, 3, 1, 2, 4, 3, 4, 5, 3]).unwrap();
        let space = Space::new(&Arc::new(mesh), Element::P1);
        let means = space.means(|c, _| f64::from(u8::from(c >= 2)));
        // Around point 2 lie two cells of 1/8 and one of 3/8, around point 3 one of 1/8 and two of
        // 3/8.
        let exact = [0.0, 0.0, 0.6, 6.0 / 7.0, 1.0, 1.0];
        assert!(means.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-14), "{means:?}");
    }

    #[test]
    fn quadratic_velocities_have_their_vorticity_and_smooth_ones_come_near_it() {
        let space = plane(4);
        let u =
            space.interpolate(|x| SVector::<f64, 2>::new(-x[1] * x[1], x[0] * x[1] + 2.0 * x[0]));
        for (w, x) in space.vorticity(&u).iter().zip(space.nodes()) {
            assert!((w - (x[1] + 2.0 + 2.0 * x[1])).abs() < 1e-12, "{x}: {w}");
        }
        let error = |n: usize| {
            let space = plane(n);
            let u = space.interpolate(|x| {
                SVector::<f64, 2>::new((3.0 * x[1]).sin(), (2.0 * x[0] + x[1]).cos())
            });
            let exact = |x: &Point<2>| -2.0 * (2.0 * x[0] + x[1]).sin() - 3.0 * (3.0 * x[1]).cos();
            let inside = |x: &Point<2>| x.iter().all(|v| (0.1..0.9).contains(v));
            let nodes = space.nodes().iter().zip(space.vorticity(&u)).filter(|(x, _)| inside(x));
            nodes.map(|(x, w)| (w - exact(x)).abs()).fold(0.0, f64::max)
        };
        let [coarse, fine] = [error(10), error(20)];
        assert!(fine < 0.02 && coarse / fine > 3.5, "{coarse} {fine}");
    }

    #[test]
    fn in_space_it_is_the_length_of_the_curl() {
        let space =
            Space::new(&Arc::new(box_mesh([0.0; 3], [1.0; 3], [2; 3]).unwrap()), Element::P2);
        let turn = SVector::<f64, 3>::new(1.0, -2.0, 2.0);
        let u = space.interpolate(|x| turn.cross(x) + x * 0.7);
        assert!(space.vorticity(&u).iter().all(|w| (w - 6.0).abs() < 1e-12));
    }
}
