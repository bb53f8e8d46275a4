//! Patch tests at random affine cells: every element reproduces the polynomials of its degree, in
//! 2-D and 3-D.

use immersa::fem::{Basis, Cells, Element, Rule, Space, integrate};
use immersa::mesh::{Mesh, Point};
use nalgebra::SVector;
use proptest::prelude::*;
use std::sync::Arc;

/// A polynomial of degree 2 (or 1, when the quadratic entries are zero): `c + b . x + x . A x`.
struct Polynomial<const D: usize> {
    entries: [f64; 13],
    degree: usize,
}

impl<const D: usize> Polynomial<D> {
    fn quadratic(&self, i: usize, j: usize) -> f64 {
        if self.degree == 2 { self.entries[4 + 3 * i + j] } else { 0.0 }
    }
    fn value(&self, x: &Point<D>) -> f64 {
        let linear: f64 = (0..D).map(|i| self.entries[1 + i] * x[i]).sum();
        let square: f64 = (0..D)
            .flat_map(|i| (0..D).map(move |j| (i, j)))
            .map(|(i, j)| self.quadratic(i, j) * x[i] * x[j])
            .sum();
        self.entries[0] + linear + square
    }
    fn gradient(&self, x: &Point<D>) -> SVector<f64, D> {
        SVector::from_fn(|i, _| {
            self.entries[1 + i]
                + (0..D).map(|j| (self.quadratic(i, j) + self.quadratic(j, i)) * x[j]).sum::<f64>()
        })
    }
}

/// The mesh of one cell with the given vertices, unless it is too flat.
fn cell<const D: usize>(vertices: &[[f64; 3]; 4]) -> Option<Arc<Mesh<D>>> {
    let points: Vec<Point<D>> =
        vertices[..=D].iter().map(|v| Point::<D>::from_fn(|i, _| v[i])).collect();
    let mesh = Mesh::new(points, (0..=D as u32).collect()).ok()?;
    let size = mesh.diameter(0).powi(D as i32);
    (mesh.volume() > 0.02 * size && size > 1e-3).then(|| Arc::new(mesh))
}

fn check<const D: usize>(
    element: Element,
    vertices: &[[f64; 3]; 4],
    entries: [f64; 13],
    weights: [f64; 4],
) {
    let Some(mesh) = cell::<D>(vertices) else { return };
    let space = Arc::new(Space::new(&mesh, element));
    let total: f64 = weights[..=D].iter().sum();
    let l: [f64; 4] = std::array::from_fn(|k| if k <= D { weights[k] / total } else { 0.0 });
    let x = (0..=D)
        .fold(Point::<D>::zeros(), |x, k| x + mesh.points()[mesh.cell(0)[k] as usize] * l[k]);
    // Rounding grows with the flatness of the cell.
    let tolerance = 1e-10;

    let polynomial = Polynomial::<D> { entries, degree: element.degree() };
    let f = space.interpolate(|x| polynomial.value(x));
    assert!(
        (space.value(&f, 0, &l) - polynomial.value(&x)).abs() < tolerance,
        "value, {element:?}, {D}-D"
    );
    assert!(
        (space.gradient(&f, 0, &l) - polynomial.gradient(&x)).norm() < tolerance,
        "gradient, {element:?}, {D}-D"
    );
    let v = space.interpolate(|x| polynomial.gradient(x));
    let jacobian = space.jacobian(&v, 0, &l);
    for i in 0..D {
        for j in 0..D {
            let exact = polynomial.quadratic(i, j) + polynomial.quadratic(j, i);
            assert!((jacobian[(i, j)] - exact).abs() < tolerance, "jacobian, {element:?}, {D}-D");
        }
    }

    // Partition of unity in physical coordinates, and the tabulated basis against the pointwise
    // one.
    let one = vec![1.0; space.len()];
    assert!(
        (space.value(&one, 0, &l) - 1.0).abs() < 1e-14
            && space.gradient(&one, 0, &l).norm() < tolerance
    );
    let basis = Basis::new(&space, &Arc::new(Rule::simplex(D, 4)));
    let [volume, difference] = integrate(&basis, Cells::All, |at| {
        [
            1.0,
            (basis.value(at, &f) - polynomial.value(&at.x)).abs()
                + (basis.gradient(at, &f) - polynomial.gradient(&at.x)).norm(),
        ]
    });
    assert!((volume / mesh.volume() - 1.0).abs() < 1e-13 && difference < tolerance);
}

proptest! {
    #[test]
    fn polynomials_pass_the_patch_test(
        vertices in prop::array::uniform4(prop::array::uniform3(-1.0..1.0f64)),
        entries in prop::array::uniform13(-1.0..1.0f64),
        weights in prop::array::uniform4(0.01..1.0f64),
    ) {
        for element in [Element::P1, Element::P2] {
            check::<2>(element, &vertices, entries, weights);
            check::<3>(element, &vertices, entries, weights);
        }
    }
}
