//! The relaxing ellipse in studies of convergence: orders in step, mesh size and thickness, and the
//! sharp-interface limit.

use immersa::output::Table;
use immersa::scene::Scene;
use immersa::studies::convergence::{Convergence, Halved, convergence};
use immersa::studies::{Campaign, Listener, Outcome, Trial};
use std::path::Path;
use std::sync::atomic::AtomicBool;

struct Deaf;

impl Listener for Deaf {
    fn begins(&mut self, _: usize, _: usize, _: &Trial) {}
    fn progress(&mut self, _: usize, _: usize, _: f64) {}
    fn ended(&mut self, _: &Outcome) {}
    fn note(&mut self, _: &str) {}
}

const STEP: Halved = Halved { space: false, time: true, thickness: false };
const MESH: Halved = Halved { space: true, time: false, thickness: false };
const THICKNESS: Halved = Halved { space: true, time: false, thickness: true };

/// The quantities, with the last change and order of each, and the limits with their bars.
struct Found(Table, Option<Table>);

impl Found {
    fn number(table: &Table, quantity: &str, column: &str) -> f64 {
        let k = table.position(column).unwrap();
        let row = table.rows.iter().rev().find(|r| r[0].shown() == quantity).unwrap();
        row[k].value().unwrap()
    }
    /// Size of the last change, and the order seen on the finest level.
    fn last(&self, quantity: &str) -> (f64, f64) {
        let (change, order) = (
            Found::number(&self.0, quantity, "change").abs(),
            Found::number(&self.0, quantity, "order"),
        );
        println!("  {quantity}: last change {change:.2e}, order {order:.2}");
        (change, order)
    }
    fn limit(&self, quantity: &str) -> (f64, f64) {
        let table = self.1.as_ref().unwrap();
        let (value, bar) = (
            Found::number(table, quantity, "eps -> 0"),
            Found::number(table, quantity, "error bar"),
        );
        println!("  {quantity}: limit {value:.5} within {bar:.5}");
        (value, bar)
    }
}

/// Three levels of an example from its values in `set` on, at t = 0.4.
fn study(example: &str, halved: Halved, levels: usize, set: &[&str]) -> Found {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(example).join("scene.toml");
    let scene =
        Scene::load(&path, &set.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let settings = Convergence { halved, levels, times: vec![0.4], ..Convergence::default() };
    let found = convergence(&mut Campaign::new(&scene, folder.path(), &stop, &mut Deaf), &settings)
        .unwrap();
    println!("{example}, {}", found.subtitle);
    Found(found.table("convergence").unwrap().clone(), found.table("limits").cloned())
}

/// BDF2 with the implicit coupling is of order two at fixed thickness: half-axes, energies, and the
/// whole interface.
#[test]
fn the_ellipse_in_time() {
    let found = study("listing", STEP, 4, &["numerics.thickness=0.15"]);
    for (quantity, bound) in [
        ("membrane.horizontal", 6e-7),
        ("membrane.vertical", 1.1e-6),
        ("energy_kinetic", 7e-7),
        ("energy_elastic", 6e-7),
        ("membrane.distance_mean", 7e-7),
    ] {
        let (change, order) = found.last(quantity);
        assert!(
            change < bound && (order - 2.0).abs() < 0.2,
            "{quantity}: {change:e}, order {order}"
        );
    }
}

/// Half-axes and interface converge with at least order two on finer meshes at fixed thickness.
#[test]
fn the_ellipse_in_space() {
    let set = ["mesh.rectangle.cells=[20, 20]", "numerics.thickness=0.2", "time.step=0.02"];
    let found = study("relaxing-ellipse", MESH, 3, &set);
    for (quantity, bound) in [
        ("membrane.horizontal", 2.5e-4),
        ("membrane.vertical", 5e-5),
        ("membrane.distance_mean", 7e-5),
    ] {
        let (change, order) = found.last(quantity);
        assert!(change < bound && order > 2.0, "{quantity}: {change:e}, order {order}");
    }
}

/// The thickness has order one, and leads to the half-axis of a sharp interface, 0.578, which was
/// computed by other means.
#[test]
fn the_ellipse_in_thickness() {
    let set = ["mesh.rectangle.cells=[20, 20]", "numerics.thickness=0.2"];
    let found = study("relaxing-ellipse", THICKNESS, 3, &set);
    let (change, order) = found.last("membrane.horizontal");
    let (limit, bar) = found.limit("membrane.horizontal");
    assert!((order - 1.0).abs() < 0.1 && change < 0.017, "{change:e}, order {order}");
    assert!((limit - 0.578).abs() < 0.002 && bar < 0.002, "{limit} +- {bar}");
}
