use super::*;
use crate::fem::Element;
use crate::levelset::{Kernel, Norm};
use crate::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use std::f64::consts::PI;
use std::sync::Arc;

/// A mesh whose inner points are moved by up to a fifth of an edge `h`, in the box from 0 to 2.
fn moved<const D: usize>(regular: &Mesh<D>, h: f64) -> Mesh<D> {
    let inside = |x: &Point<D>| x.iter().all(|&c| c > 1e-9 && c < 2.0 - 1e-9);
    let step = |x: &Point<D>| {
        Point::<D>::from_fn(|i, _| 0.2 * h * (37.0 * x[(i + 1) % D] + 11.0 * x[i]).sin())
    };
    let points =
        regular.points().iter().map(|x| if inside(x) { x + step(x) } else { *x }).collect();
    Mesh::new(points, (0..regular.cell_count()).flat_map(|c| regular.cell(c).to_vec()).collect())
        .unwrap()
}

fn plane(n: usize) -> Space<2> {
    let mesh = rectangle([0.0; 2], [2.0; 2], [n, n], Diagonals::Right).unwrap();
    Space::new(&Arc::new(moved(&mesh, 2.0 / n as f64)), Element::P2)
}
fn solid(n: usize) -> Space<3> {
    let mesh = box_mesh([0.0; 3], [2.0; 3], [n, n, n]).unwrap();
    Space::new(&Arc::new(moved(&mesh, 2.0 / n as f64)), Element::P2)
}
fn smeared(kernel: Kernel, width: Width, thickness: f64) -> Delta {
    Delta::Smeared(Smeared { kernel, width, thickness, degree: 6 })
}
fn all(thickness: f64) -> Vec<(Delta, f64)> {
    let mut all = vec![
        (Delta::Smereka1, 0.02),
        (Delta::Smereka2, 0.02),
        (Delta::Towers, 0.02),
        (Delta::Cut, 1e-4),
    ];
    for kernel in [Kernel::Cosine, Kernel::Hat] {
        for width in
            [Width::Renormalised(Norm::L2), Width::Renormalised(Norm::L1), Width::Carried(2.0)]
        {
            all.push((smeared(kernel, width, thickness), 0.02));
        }
    }
    all
}

#[test]
fn every_delta_measures_circles_and_spheres_on_crooked_meshes_whatever_the_slope() {
    let (space, r) = (plane(30), 0.6);
    let phi = space.interpolate(|x| 2.0 * ((x - Point::<2>::new(1.03, 0.98)).norm() - r));
    for (delta, tolerance) in all(0.15) {
        let length = delta.measure(&space, &phi).unwrap() / (2.0 * PI * r);
        assert!((length - 1.0).abs() < tolerance, "{delta:?}: {length}");
        // int x^2 over a circle about (a, b) is 2 pi r (a^2 + r^2/2).
        let moment = delta.integrate(&space, &phi, |at| at.x[0] * at.x[0]).unwrap();
        let exact = 2.0 * PI * r * (1.03 * 1.03 + 0.5 * r * r);
        assert!((moment / exact - 1.0).abs() < 2.0 * tolerance, "{delta:?}: {moment} {exact}");
        let area = delta.inside(&space, &phi).unwrap();
        assert_eq!(area.is_some(), delta.has_inside());
        assert!(
            area.is_none_or(|a| (a / (PI * r * r) - 1.0).abs() < tolerance),
            "{delta:?}: {area:?}"
        );
    }
    let space = solid(12);
    let phi = space.interpolate(|x| 2.0 * ((x - Point::<3>::new(1.03, 0.98, 1.01)).norm() - r));
    for (delta, tolerance) in all(0.15) {
        // A band about a sphere adds about .4 (eps/r)^2 to its volume, more than twice that with
        // the l1 norm.
        let wide = if matches!(delta, Delta::Smeared(_)) { 0.08 } else { 2.0 * tolerance };
        let area = delta.measure(&space, &phi).unwrap() / (4.0 * PI * r * r);
        assert!((area - 1.0).abs() < wide, "{delta:?}: {area}");
        let volume = delta.inside(&space, &phi).unwrap();
        assert!(
            volume.is_none_or(|v| (v / (4.0 / 3.0 * PI * r.powi(3)) - 1.0).abs() < wide),
            "{delta:?}: {volume:?}"
        );
    }
}

#[test]
fn smereka_measures_straight_interfaces_exactly_on_any_mesh() {
    // A closed curve of straight parts is not to be had; a stripe ends on the walls at right
    // angles, where nothing is lost.
    let (space, solid) = (plane(7), solid(4));
    let phi = space.interpolate(|x| 3.0 * (x[0] - 0.93));
    let in_space = solid.interpolate(|x| 0.5 * (1.07 - x[2]));
    for delta in [Delta::Smereka1, Delta::Smereka2] {
        assert!((delta.measure(&space, &phi).unwrap() - 2.0).abs() < 1e-12);
        let area = delta.measure(&solid, &in_space).unwrap();
        assert!((area - 4.0).abs() < 1e-9, "{area}");
    }
}

#[test]
fn on_a_square_lattice_the_first_delta_of_smereka_is_his() {
    // d |d_x phi|/(h^2 |grad phi|) and so along y, at the four neighbours; here times the area h^2
    // of a node.
    let n = 12;
    let mesh = Arc::new(rectangle([0.0; 2], [2.0; 2], [n, n], Diagonals::Right).unwrap());
    let space = Space::new(&mesh, Element::P2);
    let (h, f) =
        (1.0 / n as f64, |x: &Point<2>| (x - Point::<2>::new(1.03, 0.98)).norm_squared() - 0.36);
    let points = Delta::Smereka1.points(&space, &space.interpolate(f)).unwrap();
    assert!(points.len() > 50);
    for p in &points {
        let mut sum = 0.0;
        for e in [
            Point::<2>::new(1.0, 0.0),
            Point::<2>::new(-1.0, 0.0),
            Point::<2>::new(0.0, 1.0),
            Point::<2>::new(0.0, -1.0),
        ] {
            let (inside, beyond) = (f(&p.x), f(&(p.x + e * h)));
            if (inside < 0.0) != (beyond < 0.0) {
                // Quadratic functions cross where they do.
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if (f(&(p.x + e * middle)) < 0.0) == (inside < 0.0) {
                        low = middle
                    } else {
                        high = middle
                    }
                }
                let normal = (p.x + e * low - Point::<2>::new(1.03, 0.98)).normalize();
                sum += (h - low) * normal.dot(&e).abs();
            }
        }
        assert!((p.weight - sum).abs() < 1e-10, "{} {sum}", p.weight);
    }
}

#[test]
fn without_an_interface_there_is_nothing_to_integrate_over() {
    let space = plane(4);
    for (delta, _) in all(0.1) {
        for (v, area) in [(1.0, 0.0), (-1.0, 4.0)] {
            let phi = vec![v; space.len()];
            assert!(delta.points(&space, &phi).unwrap().is_empty());
            assert!(delta.inside(&space, &phi).unwrap().is_none_or(|a| (a - area).abs() < 1e-12));
        }
        let mut phi = vec![1.0; space.len()];
        phi[3] = f64::NAN;
        assert!(delta.points(&space, &phi).unwrap_err().to_string().contains("node 3"));
    }
}

#[test]
fn kernels_have_the_integral_one_and_their_heaviside_functions() {
    let n = 4000;
    for kernel in [Kernel::Cosine, Kernel::Hat] {
        let mut sum = 0.0;
        for i in 0..n {
            let s = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(n);
            sum += kernel.value(s) / f64::from(n);
            assert!(
                (kernel.heaviside(s) - 2.0 * (sum - 0.5 * kernel.value(s) / f64::from(n))).abs()
                    < 1e-6
            );
        }
        assert!(
            (2.0 * sum - 1.0).abs() < 1e-6 && kernel.value(1.0) == 0.0 && kernel.value(-1.5) == 0.0
        );
        assert_eq!(
            [kernel.heaviside(-2.0), kernel.heaviside(0.0), kernel.heaviside(3.0)],
            [0.0, 0.5, 1.0]
        );
    }
}
