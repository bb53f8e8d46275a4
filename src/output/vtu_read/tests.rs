use super::super::{FieldData, write_vtu};
use super::*;
use crate::mesh::{Diagonals, rectangle};
use proptest::prelude::*;

fn two_dimensional() -> (Space<2>, Vec<f64>, Vec<SVector<f64, 2>>) {
    // Large enough for several blocks.
    let mut mesh = rectangle([0.0, -1.0], [2.0, 1.0], [40, 30], Diagonals::Right).unwrap();
    mesh.set_region("left half", (0..mesh.cell_count() as u32 / 2).collect());
    let space = Space::new(&Arc::new(mesh), Element::P2);
    let phi = space.interpolate(|x| x.norm() - 0.3);
    let u = space.interpolate(|x| SVector::<f64, 2>::new(x[1].sin(), x[0] / 3.0));
    (space, phi, u)
}

#[test]
fn p2_fields_on_triangles_come_back_bit_by_bit() {
    let (space, phi, u) = two_dimensional();
    let pressure: Vec<f64> = space.mesh().points().iter().map(|x| 3.0 * x[0] - x[1]).collect();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtu");
    let fields = [
        ("phi <m>", FieldData::Scalar(&phi[..])),
        ("velocity", FieldData::Vector(&u)),
        ("pressure", FieldData::Scalar(&pressure)),
    ];
    write_vtu(&path, &space, 0.1 + 0.2, &fields).unwrap();
    let back = read_vtu::<2>(&path).unwrap();
    assert_eq!(back.time, 0.1 + 0.2);
    assert_eq!(back.space.nodes(), space.nodes());
    assert!(
        (0..space.mesh().cell_count()).all(|c| back.space.cell_nodes(c) == space.cell_nodes(c))
    );
    assert_eq!(back.space.mesh().regions(), space.mesh().regions());
    assert_eq!(back.scalar("phi <m>").unwrap(), phi);
    assert_eq!(back.vector("velocity").unwrap(), u);
    for (p, x) in back.scalar("pressure").unwrap().iter().zip(space.nodes()) {
        assert!((p - (3.0 * x[0] - x[1])).abs() < 1e-14);
    }
    let e = back.scalar("velocity").unwrap_err();
    assert!(e.advice().contains("velocity (vector)"), "{e}");
    assert!(read_vtu::<3>(&path).unwrap_err().wrong_value().contains("22"));
}

#[test]
fn p1_and_p2_fields_on_tetrahedra_come_back() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 1., 1.]];
    let points = corners.iter().map(|&c| Point::<3>::from(c)).collect();
    let mesh = Arc::new(Mesh::new(points, vec![0, 1, 2, 3, 1, 2, 3, 4]).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtu");
    for element in [Element::P1, Element::P2] {
        let space = Space::new(&mesh, element);
        let u = space.interpolate(|x| x * 2.0);
        write_vtu(&path, &space, 1.0, &[("u", FieldData::Vector(&u))]).unwrap();
        let back = read_vtu::<3>(&path).unwrap();
        assert_eq!(back.space.element(), element);
        assert_eq!(back.vector("u").unwrap(), u);
    }
}

#[test]
fn a_field_of_the_wrong_length_is_named() {
    let (space, phi, _) = two_dimensional();
    let dir = tempfile::tempdir().unwrap();
    let e =
        write_vtu(&dir.path().join("a.vtu"), &space, 0.0, &[("phi", FieldData::Scalar(&phi[1..]))]);
    assert!(e.unwrap_err().place().contains("phi"));
}

#[test]
fn foreign_and_truncated_files_are_refused() {
    let (space, phi, _) = two_dimensional();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtu");
    write_vtu(&path, &space, 0.0, &[("phi", FieldData::Scalar(&phi))]).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for n in [0, 10, 300, 1500, bytes.len() / 2, bytes.len() - 100] {
        let e = parse::<2>(&bytes[..n]).unwrap_err();
        assert!(e.what().contains("not written by") || e.what().contains("damaged"), "{n}: {e}");
    }
}

proptest! {
    #[test]
    fn corrupt_bytes_never_panic(changes in prop::collection::vec((0usize..4000, any::<u8>()), 1..8)) {
        let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let phi = space.interpolate(|x| x[0]);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vtu");
        write_vtu(&path, &space, 0.0, &[("phi", FieldData::Scalar(&phi))]).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let n = bytes.len();
        changes.iter().for_each(|&(i, b)| bytes[i % n] = b);
        let _ = parse::<2>(&bytes);
    }
}
