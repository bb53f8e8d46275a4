//! The work of a band grows with the band, not with the mesh.

use immersa::elastic::{AreaLaw, Band, Membrane};
use immersa::fem::{Basis, Cells, Element, Rule, Space};
use immersa::flow::term::MomentumTerm;
use immersa::levelset::{Ellipse, signed_distance, surface_weight};
use immersa::mesh::{Diagonals, Point, box_mesh, rectangle};
use nalgebra::SVector;
use std::f64::consts::PI;
use std::sync::Arc;

const STRETCH: f64 = 1.3;

fn membrane(eps: f64, band: Band) -> Membrane<2> {
    Membrane::new(AreaLaw::Linear { modulus: 1.0 }, eps).with_band(band, STRETCH)
}

fn ellipse(n: usize) -> (Basis<2>, Vec<f64>) {
    let mesh = Arc::new(rectangle([0.0; 2], [2.0; 2], [n; 2], Diagonals::UnionJack).unwrap());
    let space = Arc::new(Space::new(&mesh, Element::P2));
    let shape = Ellipse::new(Point::<2>::new(1.01, 0.98), Point::<2>::new(0.7, 0.5), 20.0).unwrap();
    let phi = signed_distance(&space, &shape).iter().map(|d| STRETCH * d).collect();
    (Basis::new(&space, &Arc::new(Rule::simplex(2, 5))), phi)
}

fn visited<const D: usize>(membrane: &Membrane<D>) -> Vec<u32> {
    match membrane.support().cells() {
        Cells::Some(cells) => cells.to_vec(),
        Cells::All => panic!("all cells are visited"),
    }
}

#[test]
fn the_cells_that_a_membrane_visits_are_those_of_its_band() {
    for band in [Band::Renormalised, Band::Carried] {
        let mut counts = Vec::new();
        for n in [16, 32, 64] {
            let (basis, phi) = ellipse(n);
            let (h, cells) = (2.0 / n as f64, 2 * n * n);
            let eps = 2.5 * h;
            let mut membrane = membrane(eps, band);
            membrane.prepare(&basis, &phi, None);
            let found = visited(&membrane);
            // Nothing is missed: by brute force, at points that are not those of the rule too.
            let fine = Basis::new(basis.space(), &Arc::new(Rule::simplex(2, 8)));
            for c in (0..cells).filter(|c| found.binary_search(&(*c as u32)).is_err()) {
                for q in 0..fine.rule().len() {
                    let at = fine.at(c, q);
                    let r = if band == Band::Carried {
                        STRETCH
                    } else {
                        fine.gradient(&at, &phi).norm()
                    };
                    assert_eq!(
                        surface_weight(fine.value(&at, &phi), r, eps),
                        0.0,
                        "cell {c} is missed"
                    );
                }
            }
            // Nothing is visited but the cells that the band meets, which lie within a diagonal of
            // it.
            let (a, b): (f64, f64) = (0.7, 0.5);
            let perimeter = PI * (3.0 * (a + b) - ((3.0 * a + b) * (a + 3.0 * b)).sqrt());
            let reached = perimeter * 2.0 * (eps + 2f64.sqrt() * h) / (4.0 / cells as f64);
            assert!(
                (found.len() as f64) < reached,
                "{} cells visited, {reached} within reach",
                found.len()
            );
            counts.push(found.len() as f64);
        }
        // A band of as many cells across on a mesh of four times as many cells.
        for pair in counts.windows(2) {
            let growth = pair[1] / pair[0];
            assert!((growth - 2.0).abs() < 0.15, "{band:?}: {counts:?}");
        }
    }
}

#[test]
fn in_space_too() {
    let mut counts = Vec::new();
    for n in [6, 12] {
        let mesh = Arc::new(box_mesh([0.0; 3], [2.0; 3], [n; 3]).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let phi =
            space.interpolate(|x| STRETCH * ((x - SVector::<f64, 3>::repeat(1.0)).norm() - 0.6));
        let basis = Basis::new(&space, &Arc::new(Rule::simplex(3, 5)));
        let mut membrane = Membrane::new(AreaLaw::Linear { modulus: 1.0 }, 1.5 / n as f64);
        membrane.prepare(&basis, &phi, None);
        counts.push(visited(&membrane).len() as f64);
    }
    let growth = counts[1] / counts[0];
    assert!(growth > 3.0 && growth < 5.0, "a surface has four times as many: {counts:?}");
}

/// A level set that is small over its slope far from its zero, as one that a flow has wound up, has
/// no band there.
#[test]
fn what_is_far_from_the_interface_is_no_part_of_the_band() {
    let mesh = Arc::new(rectangle([0.0; 2], [4.0, 1.0], [64, 16], Diagonals::UnionJack).unwrap());
    let space = Arc::new(Space::new(&mesh, Element::P2));
    let basis = Basis::new(&space, &Arc::new(Rule::simplex(2, 5)));
    let plain = space.interpolate(|x| x[0] - 0.5);
    let wound = space.interpolate(|x| {
        x[0] - 0.5 + if x[0] > 2.5 { 0.8 * (40.0 * (x[0] - 2.5)).sin() } else { 0.0 }
    });
    let mut membrane = Membrane::new(AreaLaw::Linear { modulus: 1.0 }, 0.15);
    membrane.prepare(&basis, &plain, None);
    let cells = visited(&membrane);
    membrane.prepare(&basis, &wound, None);
    assert_eq!(visited(&membrane), cells);
    assert_eq!(membrane.energy(&basis, &wound), membrane.energy(&basis, &plain));
}
