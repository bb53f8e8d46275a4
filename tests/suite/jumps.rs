//! The pressure with a constant of each cell added.

use immersa::fem::{Condition, Element, Numbering, Rule, Space};
use immersa::mesh::{Diagonals, NONE, rectangle};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Singular values of `(q, div v)` on the unknowns of a closed box, the least and the greatest.
fn spread(cells: usize, diagonals: Diagonals, element: Element) -> [f64; 2] {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [cells, cells], diagonals).unwrap());
    let (velocity, pressure) = (Space::new(&mesh, Element::P2), Space::new(&mesh, element));
    let names = ["left", "right", "bottom", "top"];
    let walls = names.map(|name| (name.to_string(), Condition::NoSlip)).to_vec();
    let numbering = Numbering::new(&velocity, &pressure, &walls).unwrap();
    let first = numbering.first_pressure();
    let mut b = DMatrix::<f64>::zeros(numbering.order() - first, first);
    let rule = Rule::simplex(2, 4);
    let mut unknowns = Vec::new();
    for c in 0..mesh.cell_count() {
        numbering.cell_unknowns(
            velocity.cell_nodes(c),
            Some(pressure.cell_nodes(c)),
            &mut unknowns,
        );
        let (of_velocity, of_pressure) = unknowns.split_at(12);
        let map = mesh.map(c);
        for (l, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = Element::P2.reference_gradients::<2>(l).map(|g| map.inverse.tr_mul(&g));
            let values = element.values::<2>(l);
            for (i, &p) in of_pressure.iter().enumerate().filter(|(_, p)| **p != NONE) {
                for (a, &u) in of_velocity.iter().enumerate().filter(|(_, u)| **u != NONE) {
                    b[(p as usize - first, u as usize)] +=
                        w * map.volume * values[i] * gradients[a / 2][a % 2];
                }
            }
        }
    }
    let values = b.singular_values();
    [values.min(), values.max()]
}

/// Without the constants that are left out there would be pressures that no velocity feels.
#[test]
fn no_pressure_with_jumps_is_without_effect() {
    for diagonals in [Diagonals::Right, Diagonals::UnionJack] {
        for cells in [3, 4, 6] {
            let [least, greatest] = spread(cells, diagonals, Element::P1P0);
            assert!(least > 1e-3 * greatest, "{cells} {diagonals:?}: {least:e} {greatest:e}");
        }
    }
}
