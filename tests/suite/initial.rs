//! Scenes that start from the flow of another run.

use super::program::*;
use immersa::flow::FlowState;
use immersa::output::{Snapshot, read_vtu};
use immersa::scene::{ImmersedFlow, Problem, Scene};
use immersa::sim::Simulation;
use nalgebra::SVector;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A channel whose flow comes to rest at the profile of Poiseuille, which the spaces hold.
const CHANNEL: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 1], cells = [12, 6] }
[fluid]
viscosity = 1
[boundary.walls]
no_slip = true
[boundary.left]
velocity = ["4*y*(1-y)", 0]
[boundary.right]
velocity = ["4*y*(1-y)", 0]
[time]
end = 4
step = 0.1
[output]
every = 1
fields = 2
pictures = false
"#;

/// A box whose lid moves, slower towards its ends.
const BOX: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
[fluid]
viscosity = 0.02
[boundary.walls]
no_slip = true
[boundary.top]
velocity = ["16*x^2*(1-x)^2", 0]
[time]
end = 20
step = 0.1
[output]
every = 20
pictures = false
"#;

const MEMBRANE: &str = r#"
[[membrane]]
shape.ellipse = { centre = [1, 0.5], semi_axes = [0.3, 0.25] }
stretch = 1.2
area.linear = { modulus = 1 }
"#;

/// The scene with a start from `from`, and steps of this length.
fn after(scene: &str, from: &str, step: f64) -> String {
    let scene = scene.split("[time]").next().unwrap();
    format!(
        "{scene}[initial]\nfrom = \"{from}\"\n[time]\nend = {}\nstep = {step}\n[output]\n\
         every = {step}\nfields = {step}\npictures = false\n",
        10.0 * step
    )
}

/// A folder with the run `steady` of a scene.
fn steady(scene: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("steady.toml"), scene).unwrap();
    let ended = immersa(folder.path(), &["run", "steady.toml", "--out", "steady"]);
    ended.expect(0, &["done"]);
    folder
}

/// Writes `scene.toml` and runs it into `out` with the options.
fn run(folder: &TempDir, scene: &str, out: &str, options: &[&str]) -> Ended {
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let run = ["run", "scene.toml", "--out", out, "--overwrite"];
    immersa(folder.path(), &[&run, options].concat())
}

fn fields<const D: usize>(folder: &TempDir, file: &str) -> Snapshot<D> {
    read_vtu(&folder.path().join(file)).unwrap()
}

fn velocity(fields: &Snapshot<2>) -> &[SVector<f64, 2>] {
    fields.vector("velocity").unwrap()
}

fn difference<const D: usize>(a: &[SVector<f64, D>], b: &[SVector<f64, D>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_steady_flow_stays_as_it_is_on_every_mesh() {
    let folder = steady(CHANNEL);
    let source = fields(&folder, "steady/fields/000040.vtu");
    let scene = after(CHANNEL, "steady", 0.05);
    run(&folder, &scene, "same", &[]).expect(0, &["at t = 4: on the same mesh, as they are"]);
    let starts = ["same/start.vtu", "same/fields/000000.vtu"].map(|file| fields(&folder, file));
    for start in &starts {
        assert_eq!(velocity(start), velocity(&source), "every bit");
        let p = |f: &Snapshot<2>| f.scalar("pressure").unwrap().to_vec();
        assert!(p(&starts[0]) == p(&source));
    }
    let stays = |out: &str| {
        let [before, after] =
            [0, 1].map(|k| fields(&folder, &format!("{out}/fields/00000{k}.vtu")));
        let change = difference(velocity(&before), velocity(&after));
        assert!(change < 1e-10, "{out}: {change:e}");
    };
    stays("same");
    for cells in ["[7, 5]", "[17, 8]"] {
        let mesh = format!("mesh.rectangle.cells={cells}");
        run(&folder, &scene, "other", &["--set", &mesh]).expect(0, &["from another mesh"]);
        stays("other");
    }
    // A part of the channel, of which the flow knows all.
    let part = "mesh.rectangle={ min = [0.3, 0], max = [1.6, 1], cells = [9, 7] }";
    run(&folder, &scene, "other", &["--set", part]).expect(0, &["from another mesh"]);
    stays("other");

    // Without field files the same bits come from the checkpoint.
    fs::remove_dir_all(folder.path().join("steady/fields")).unwrap();
    run(&folder, &scene, "checkpoint", &[]).expect(0, &["at t = 4: on the same mesh"]);
    let [a, b] = ["same", "checkpoint"].map(|out| folder.path().join(out));
    assert_same(&a, &b);
}

#[test]
fn a_membrane_in_a_steady_flow_is_that_in_the_exact_one() {
    let folder = steady(CHANNEL);
    let scene = after(CHANNEL, "steady", 0.02) + MEMBRANE;
    run(&folder, &scene, "from", &[]).expect(0, &["done"]);
    let profile = "viscosity = 1\ninitial_velocity = [\"4*y*(1-y)\", 0]";
    let exact =
        scene.replace("[initial]\nfrom = \"steady\"\n", "").replace("viscosity = 1", profile);
    run(&folder, &exact, "exact", &[]).expect(0, &["done"]);
    let [from, exact] = ["from", "exact"].map(|out| series(&folder.path().join(out)));
    assert_eq!(from.column("time").unwrap().len(), 11);
    for name in ["membrane.centre_x", "membrane.axis_1", "energy_kinetic", "energy_elastic"] {
        let columns = [&from, &exact].map(|s| s.column(name).unwrap());
        let off = columns[0].iter().zip(columns[1]).map(|(a, b)| (a - b).abs());
        let (off, moved) = (off.fold(0.0, f64::max), (columns[0][10] - columns[0][0]).abs());
        assert!(off < 1e-6 && off < 1e-3 * moved, "{name}: {off:e} of {moved:e}");
    }
}

/// Without the projection, the first pressure takes up the gradient in the error of the
/// interpolation, over the step.
#[test]
fn another_mesh_changes_the_velocity_by_the_error_of_the_interpolation() {
    let mut errors = Vec::new();
    for [source, target] in [[8, 11], [16, 22]] {
        let cells = |n: usize| format!("cells = [{n}, {n}]");
        let folder = steady(&BOX.replace(&cells(8), &cells(source)));
        let scene = after(BOX, "steady", 1e-3).replace(&cells(8), &cells(target));
        let scene = Scene::parse(&scene, &folder.path().join("scene.toml")).unwrap();
        let mut flow = ImmersedFlow::<2>::new(&scene).unwrap();
        let file = folder.path().join("start.vtu");
        flow.write_start(&file).unwrap();
        let start: Snapshot<2> = read_vtu(&file).unwrap();
        let given = start.vector("interpolated velocity").unwrap();
        let before = flow.simulation.state().flow.clone();
        let projected = difference(&before.u, given);

        let (mesh, settings) =
            (flow.simulation.space().mesh().clone(), flow.simulation.settings().clone());
        let raw = FlowState { u: given.to_vec(), p: before.p.clone() };
        let mut raw = Simulation::from_flow(&mesh, settings, Vec::new(), raw).unwrap();
        flow.step().unwrap();
        raw.step().unwrap();
        let step = difference(&flow.simulation.state().flow.u, &before.u);
        let pressure =
            |p: &[f64]| p.iter().zip(&before.p).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let [p, p_raw] = [&flow.simulation, &raw].map(|s| pressure(&s.state().flow.p));
        assert!(step < projected, "{source}: {step:e} {projected:e}");
        assert!(p < 0.5 * p_raw, "{source}: {p:e} {p_raw:e}");
        let divergence = |u| flow.simulation.carried().divergence(u);
        assert!(divergence(&before.u) < 0.6 * divergence(given));
        errors.push(projected);
    }
    assert!(errors[1] < errors[0] / 4.0 && errors[1] < 0.004, "{errors:?}");
}

#[test]
fn a_run_goes_on_without_the_one_it_started_from() {
    let folder = steady(CHANNEL);
    let scene = after(CHANNEL, "steady", 0.02).replace("[12, 6]", "[17, 9]") + MEMBRANE;
    run(&folder, &scene, "whole", &[]).expect(0, &["done: 10 steps"]);
    interrupted(folder.path(), "parts", 3).expect(130, &["interrupted"]);
    fs::rename(folder.path().join("steady"), folder.path().join("gone")).unwrap();
    resume(folder.path(), "parts").expect(0, &["done: 10 steps"]);
    let [whole, parts] = ["whole", "parts"].map(|out| folder.path().join(out));
    assert_same(&whole, &parts);
    // The scene of the run folder resumes as well; another start is refused.
    let far = ["run", "whole/scene.toml", "--resume", "--out", "whole", "--set", "time.end=0.24"];
    immersa(folder.path(), &far).expect(0, &["done: 12 steps"]);
    let other = [&far[..], &["--set", "initial.from=gone"]].concat();
    immersa(folder.path(), &other).expect(2, &["another scene", "initial.from"]);
    // Without the start that was kept, that of another time does not pass for it.
    fs::remove_file(whole.join("start.vtu")).unwrap();
    immersa(folder.path(), &far).expect(3, &["there is no such folder"]);
}

#[test]
fn starts_that_cannot_be_had_are_refused_before_anything_is_computed() {
    let folder = steady(CHANNEL);
    let scene = after(CHANNEL, "steady", 0.05);
    let refused = |scene: &str, options: &[&str], code: i32, words: &[&str]| {
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let ended = immersa(folder.path(), &[&["explain", "scene.toml"], options].concat());
        ended.expect(code, &[words, &["remedy"]].concat());
    };
    let set = |change: &'static str, code: i32, words: &[&str]| {
        refused(&scene, &["--set", change], code, words);
    };
    set("initial.from=nowhere", 3, &["no such folder", "nowhere", "key initial.from"]);
    set("initial.from=.", 3, &["not the folder of a run", "key initial.from"]);
    set("initial.from=''", 2, &["name of the folder is empty"]);
    set("initial.time=2.5", 3, &["not stored this time", "2.5", "give initial.time: 0, 2, 4"]);
    set("initial.time=-1", 2, &["initial.time"]);
    set(
        "mesh.rectangle.max=[2.5, 1]",
        3,
        &["covers more", "nodes are outside, the farthest at [2.5", "by 5.0", "initial.from"],
    );
    set("fluid.initial_velocity=[0, 0]", 2, &["keep one of the two"]);
    let prescribed = "fluid={ prescribed_velocity = [1, 0] }";
    refused(&scene, &["--set", prescribed], 2, &["the velocity is prescribed", "initial"]);
    let cube = "mesh={ box = { min = [0, 0, 0], max = [1, 1, 1], cells = [2, 2, 2] } }";
    let space = after("[fluid]\nviscosity = 1\n", "steady", 0.05);
    refused(&space, &["--set", cube], 3, &["has 2 dimensions", "a run of 3"]);
    run(&folder, &scene, "steady", &[]).expect(2, &["its own folder", "--out"]);

    // Runs that have not finished start others only at a time that is given.
    let [summary, list] =
        ["summary.json", "fields.pvd"].map(|f| folder.path().join("steady").join(f));
    let said = fs::read_to_string(&summary).unwrap();
    fs::write(&summary, said.replace("\"finished\"", "\"failed\"")).unwrap();
    refused(&scene, &[], 3, &["has failed at t = 4", "initial.time", "0, 2, 4"]);
    fs::remove_file(&summary).unwrap();
    refused(&scene, &[], 3, &["has not ended", "--resume"]);
    for time in ["2", "4"] {
        let ended = run(&folder, &scene, "at", &["--set", &format!("initial.time={time}")]);
        ended.expect(0, &[&format!("at t = {time}: on the same mesh")]);
    }
    fs::remove_file(list).unwrap();
    fs::write(folder.path().join("steady/checkpoint/latest.bin"), "x").unwrap();
    set("initial.time=4", 3, &["the checkpoint is damaged", "latest.bin"]);
    fs::write(folder.path().join("steady/scene.toml"), "x").unwrap();
    refused(&scene, &[], 2, &["steady/scene.toml"]);
}

#[test]
fn runs_that_solved_no_flow_start_none() {
    let carried = "[mesh]\nrectangle = { min = [0, 0], max = [1, 1], cells = [6, 6] }\n[fluid]\n\
        prescribed_velocity = [0, 0]\n[[level_set]]\nshape.circle = { centre = [0.5, 0.5], radius = \
        0.3 }\n[time]\nend = 0.1\nstep = 0.1\n[output]\npictures = false\n";
    let folder = steady(carried);
    let ended = run(&folder, &after(BOX, "steady", 0.01), "next", &[]);
    ended.expect(3, &["has not solved a flow", "initial.from", "a run with a fluid"]);
}

/// The mesh of a source may follow its membrane, and periodic sides stay periodic.
#[test]
fn adapted_meshes_and_periodic_sides_start_others() {
    let periodic = CHANNEL.split("[boundary.left]").next().unwrap().to_string()
        + "[boundary.left]\nperiodic = \"right\"\n[time]\nend = 0.2\nstep = 0.02\n[output]\n\
           pictures = false\nevery = 0.1\n";
    let periodic = periodic.replace("viscosity = 1", "viscosity = 1\nforce = [\"8 + x*(2-x)\", 0]");
    let adapted =
        periodic.replace("[fluid]", "[mesh.adapt]\nedge = 0.08\nevery = 0.1\n[fluid]") + MEMBRANE;
    let folder = steady(&adapted);
    let scene = after(&periodic, "steady", 0.01).replace("[12, 6]", "[13, 8]");
    run(&folder, &scene, "next", &[]).expect(0, &["interpolated from another mesh"]);
    let start: Snapshot<2> = fields(&folder, "next/start.vtu");
    let (nodes, u) = (start.space.nodes(), velocity(&start));
    let mut pairs = 0;
    for (a, x) in nodes.iter().enumerate().filter(|(_, x)| x[0] == 0.0) {
        let across = |y: &SVector<f64, 2>| y[0] == 2.0 && (y[1] - x[1]).abs() < 1e-12;
        let b = nodes.iter().position(across).unwrap();
        assert!((u[a] - u[b]).norm() < 1e-12, "{x}: {} {}", u[a], u[b]);
        pairs += 1;
    }
    assert_eq!(pairs, 17);
    assert!(u.iter().any(|v| v.norm() > 0.1));
}

#[test]
fn flows_in_space_start_others() {
    let duct = r#"
[mesh]
box = { min = [0, 0, 0], max = [1, 1, 1], cells = [3, 3, 3] }
[fluid]
viscosity = 1
[boundary.walls]
velocity = ["y*z", 0, 0]
[time]
end = 2
step = 0.1
[output]
every = 1
pictures = false
"#;
    let folder = steady(duct);
    let scene = after(duct, "steady", 0.02);
    let exact = |file: &str| {
        let fields: Snapshot<3> = fields(&folder, file);
        let u = fields.vector("velocity").unwrap();
        let exact = fields.space.interpolate(|x| SVector::<f64, 3>::new(x[1] * x[2], 0.0, 0.0));
        difference(u, &exact)
    };
    for (cells, word) in [("[3, 3, 3]", "on the same mesh"), ("[4, 2, 3]", "another mesh")] {
        let mesh = format!("mesh.box.cells={cells}");
        run(&folder, &scene, "next", &["--set", &mesh]).expect(0, &[word]);
        for file in ["start.vtu", "fields/000001.vtu", "fields/000010.vtu"] {
            let off = exact(&format!("next/{file}"));
            assert!(off < 1e-10, "{cells} {file}: {off:e}");
        }
    }
}

/// Sides that are curved are divided in another way by each mesh: their nodes are a little outside.
#[test]
fn curved_sides_may_be_divided_in_another_way() {
    let disc = r#"
[mesh]
disc = { centre = [0, 0], radius = 1, cells = 5 }
[fluid]
viscosity = 1
[boundary.walls]
velocity = ["-y", "x"]
[time]
end = 4
step = 0.1
[output]
every = 1
pictures = false
"#;
    let folder = steady(disc);
    let scene = after(disc, "steady", 0.05);
    for cells in [4, 8] {
        let mesh = format!("mesh.disc.cells={cells}");
        run(&folder, &scene, "next", &["--set", &mesh]).expect(0, &["another mesh"]);
        let start: Snapshot<2> = fields(&folder, "next/start.vtu");
        let exact = start.space.interpolate(|x| SVector::<f64, 2>::new(-x[1], x[0]));
        assert!(difference(velocity(&start), &exact) < 0.03);
    }
    let wide = "mesh.disc.radius=1.3";
    run(&folder, &scene, "wide", &["--set", wide]).expect(3, &["covers more", "initial.from"]);
}

/// An obstacle or a wall where there was none: the misfit is told.
#[test]
fn a_start_that_does_not_fit_the_boundary_is_told() {
    let folder = steady(CHANNEL);
    let scene = after(CHANNEL, "steady", 0.05);
    let part = "mesh.rectangle={ min = [0.5, 0.2], max = [1.5, 0.8], cells = [8, 5] }";
    let walls = scene
        .replace("[boundary.left]\nvelocity = [\"4*y*(1-y)\", 0]\n", "")
        .replace("[boundary.right]\nvelocity = [\"4*y*(1-y)\", 0]\n", "");
    let ended = run(&folder, &walls, "closed", &["--set", part]);
    ended.expect(0, &["goes through boundary `walls`", "start from a run whose velocity fits"]);
    let u = fields::<2>(&folder, "closed/start.vtu");
    let on_wall = |x: &SVector<f64, 2>| x[0] == 0.5 || x[1] == 0.2;
    let pairs = u.space.nodes().iter().zip(velocity(&u));
    assert!(pairs.filter(|(x, _)| on_wall(x)).all(|(_, v)| v.norm() == 0.0));
    assert!(Path::new(&folder.path().join("closed/report.html")).is_file());
}

/// The first step is of order 1, also from a flow that is steady for steps of this length; implicit
/// convection leaves a steady flow where it is.
#[test]
fn the_first_step_moves_a_steady_flow_by_less_with_shorter_steps() {
    let by = |scheme: &str| {
        let numerics = format!("[numerics]\nconvection = \"{scheme}\"\n[time]");
        BOX.replace("[8, 8]", "[16, 16]").replace("[time]", &numerics)
    };
    let folder = steady(&by("baker1982"));
    run(&folder, &after(&by("baker1982"), "steady", 0.1), "next", &[]).expect(0, &[]);
    let still = series(&folder.path().join("next"));
    let energy = still.column("energy_kinetic").unwrap();
    assert!((energy[1] / energy[0] - 1.0).abs() < 1e-6, "{energy:?}");
    let fine = by("pironneau1982");
    for (step, expected) in [(0.1, 0.010), (0.05, 0.003), (0.025, 0.001)] {
        let length = |scene: String| scene.replace("step = 0.1\n", &format!("step = {step}\n"));
        let folder = steady(&length(fine.clone()));
        run(&folder, &after(&fine, "steady", step), "next", &[]).expect(0, &["on the same mesh"]);
        let series = series(&folder.path().join("next"));
        let energy = series.column("energy_kinetic").unwrap();
        let moved = (energy[1] / energy[0] - 1.0).abs();
        assert!((moved - expected).abs() < 0.00051, "{step}: {moved}");
        let steady = energy[0] - energy[1..].iter().copied().fold(f64::INFINITY, f64::min);
        assert!(steady < 1.2 * moved * energy[0], "and comes back: {energy:?}");
    }
}
