//! Meshes that follow the interfaces and the fields, through scenes.

use super::case::Case;
use immersa::levelset::band_edges;
use immersa::scene::{ImmersedFlow, Problem, Scene};
use std::path::Path;

const MEMBRANE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [8, 8], diagonals = "union-jack" }
[fluid]
viscosity = 0.01
[[membrane]]
name = "membrane"
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
stretch = 1.2625316
area.linear = { modulus = 10.0 }
[time]
end = 0.3
step = 0.01
[numerics]
thickness = 0.1
grad_div = 5
"#;

/// With edges of .035 across the interface and .07 along it.
fn adapted(more: &[&str]) -> Case {
    let mut set = vec!["mesh.adapt.edge=0.035", "mesh.adapt.along=0.07", "mesh.adapt.width=0.125"];
    set.extend(more);
    Case::with(MEMBRANE, &set)
}

fn unknowns(case: &Case) -> usize {
    case.model.simulation.flow().numbering().order()
}

/// Steps to the end and looks at the mesh every `interval` steps; how often it was made anew.
fn follow(case: &mut Case, interval: usize) -> usize {
    let mut count = 0;
    for step in 0..case.scene.time.steps() {
        if step > 0 && step % interval == 0 {
            count += usize::from(case.model.follow().unwrap());
        }
        case.steps(1);
    }
    count
}

#[test]
fn a_mesh_that_follows_gives_what_a_uniform_one_gives_with_a_third_of_the_unknowns() {
    ["membrane.0.force=sharp", "membrane.0.force=smeared"].into_iter().for_each(follows);
}

fn follows(force: &str) {
    let uniform = Case::with(MEMBRANE, &["mesh.rectangle.cells=[57, 57]", force]);
    let many = unknowns(&uniform);
    let uniform = uniform.run();
    let mut case = adapted(&[force]);
    let eps = case.model.thickness.unwrap();
    let edges = |case: &Case| {
        let sim = &case.model.simulation;
        band_edges(sim.space(), &sim.level_set(0), eps).unwrap().largest
    };
    assert!(3 * unknowns(&case) < many, "{} of {many}", unknowns(&case));
    assert!(edges(&case) < 1.9 * 0.035, "{}", edges(&case));
    let count = follow(&mut case, 5);
    // The membrane has moved by more than the fine part of the first mesh reaches.
    assert!((1..6).contains(&count), "{count} times");
    assert!(edges(&case) < 2.3 * 0.035, "{}", edges(&case));
    assert!(3 * unknowns(&case) < many, "{} of {many}", unknowns(&case));
    for (column, bound) in
        [("membrane.extent_x", 2e-3), ("membrane.extent_y", 2e-3), ("energy_kinetic", 1e-2)]
    {
        let (a, b) = (case.get(column), uniform.get(column));
        assert!((a - b).abs() < bound * b, "{column}: {a}, uniform {b}");
    }
    let transferred = case.get("energy_transferred");
    assert!(transferred != 0.0 && transferred.abs() < 1e-3, "{transferred}");
    assert!(case.get("energy_balance").abs() < 0.03, "{}", case.get("energy_balance"));
    assert_eq!(case.get("unknowns") as usize, unknowns(&case));
}

#[test]
fn transfer_changes_the_energy_by_less_than_a_ten_thousandth_whichever_way_fields_are_brought() {
    for transfer in ["interpolation", "projection"] {
        let transfer = format!("mesh.adapt.transfer={transfer}");
        let mut case = adapted(&[
            "mesh.adapt.every=0.1",
            "mesh.adapt.fields=[\"velocity\"]",
            "mesh.adapt.error=0.02",
            &transfer,
        ]);
        case.steps(10);
        let total = case.model.simulation.state().energies.total();
        let before = case.get("membrane.area");
        assert!(case.model.follow().unwrap());
        let [energy, area] =
            [case.get("energy_transferred") / total, case.get("membrane.area") / before - 1.0];
        assert!(
            energy != 0.0 && energy.abs() < 1e-4 && area.abs() < 1e-4,
            "{transfer}: {energy:e}, area {area:e}"
        );
    }
}

#[test]
fn what_cannot_be_adapted_is_refused_with_its_place() {
    let smeared = MEMBRANE.replace("[time]", "force = \"smeared\"\n[time]");
    let refused = |set: &[&str]| {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        let scene = Scene::parse_with(&smeared, Path::new("scene.toml"), &set);
        match scene.and_then(|scene| ImmersedFlow::<2>::new(&scene).map(drop)) {
            Ok(()) => panic!("{set:?} was not refused"),
            Err(e) => {
                assert!(
                    !e.place().is_empty() && !e.wrong_value().is_empty() && !e.advice().is_empty(),
                    "{e}"
                );
                e.to_string()
            }
        }
    };
    for (set, words) in [
        (&["mesh.adapt.edge=0.06", "numerics.transport=composed"][..], "composed"),
        (&["mesh.adapt.edge=0.06", "mesh.adapt.error=0.1"], "fields"),
        (&["mesh.adapt.fields=[\"speed\"]"], "velocity"),
        (&["mesh.adapt.fields=[\"velocity\", \"velocity\"]"], "twice"),
        (
            &[
                "mesh.adapt.fields=[\"velocity\"]",
                "mesh.adapt.error=0.1",
                "mesh.adapt.vertices=100",
            ],
            "both",
        ),
        (&["mesh.adapt.edge=0.06", "mesh.adapt.h_max=0.01"], "h_max"),
        (&["mesh.adapt.edge=0.06", "mesh.adapt.gradation=1"], "above 1"),
        (&["mesh.adapt.every=0.1", "numerics.thickness=auto"], "mesh.adapt.edge"),
        (&["mesh.adapt.edge=3"], "longer"),
        (&["mesh.adapt.edge=0.14"], "1.5 h"),
    ] {
        let message = refused(set);
        assert!(message.contains(words), "{set:?}: {message}");
    }
}
