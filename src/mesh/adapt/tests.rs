use super::*;
use crate::mesh::{Diagonals, Point, check, rectangle};

fn sizes(mesh: &Mesh<2>, h: impl Fn(&Point<2>) -> f64) -> Metric {
    Metric::isotropic(&mesh.points().iter().map(h).collect::<Vec<_>>())
}

#[test]
fn a_square_gets_the_sizes_of_a_circle() {
    let mesh = rectangle([0.0; 2], [2.0; 2], [20, 20], Diagonals::Right).unwrap();
    let metric = sizes(&mesh, |x| 0.02 + 0.3 * ((x - Point::<2>::new(1.0, 1.0)).norm() - 0.5).abs());
    let metric = metric.graded(&mesh, 1.5).unwrap();
    let new = adapt(&mesh, &metric, &AdaptOptions::default()).unwrap();
    assert!((new.mesh.volume() - 4.0).abs() < 1e-13);
    assert!(new.report.unit_edges > 0.97 && new.report.worst_quality > 0.6, "{:?}", new.report);
    let expected = metric.expected_vertices(&mesh).unwrap();
    assert!((new.report.vertices as f64 / expected - 1.0).abs() < 0.15, "{:?}, expected {expected}", new.report);
    let (quality, warnings) = check(&new.mesh);
    assert!(
        quality.smallest_angle.value > 25.0 && quality.parts == 1 && warnings.is_empty(),
        "{quality:?} {warnings:?}"
    );
}
