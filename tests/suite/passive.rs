//! Scenes with a prescribed velocity, passive level sets, markers, and composed transport in
//! scenes.

use super::case::{Built, Case, refused};
use super::program::immersa;
use immersa::output::{GreyImage, Series};
use immersa::scene::{Advected, ImmersedFlow, Problem, Scene};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

const VORTEX: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [16, 16] }
[fluid]
prescribed_velocity = ["-sin(pi*x)^2*sin(2*pi*y)", "sin(2*pi*x)*sin(pi*y)^2"]
[[level_set]]
name = "disc"
shape.circle = { centre = [0.5, 0.75], radius = 0.15 }
markers = 500
[time]
end = 1.0
step = 0.125
[numerics]
transport = "composed"
"#;

const MEMBRANE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
[fluid]
viscosity = 0.01
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
stretch = 1.2625316
area.linear = { modulus = 1.0 }
[[level_set]]
name = "dye"
shape.circle = { centre = [0.4, 0.4], radius = 0.2 }
markers = 100
[time]
end = 0.4
step = 0.02
[numerics]
thickness = 0.2
transport = "composed"
"#;

#[test]
fn a_prescribed_velocity_leaves_the_flow_out() {
    let mut case = Case::<Advected>::of(VORTEX, &[]);
    let plan = case.model.plan().unwrap().to_string();
    for line in [
        "no flow: the velocity is prescribed as",
        "no matrix of a flow",
        "500 markers follow it",
        "backward map",
    ] {
        assert!(plan.contains(line), "{line} is missing in\n{plan}");
    }
    let facts = case.model.facts();
    assert!(case.model.advection.state().flow.p.is_empty() && facts.unknowns[..2] == [0, 0]);
    assert!(facts.factor.is_none() && case.model.energies().is_none());
    case.steps(8);
    // Area and length of the markers' polygon, which inscribes the filament.
    assert!((case.get("disc.area") / (PI * 0.0225) - 1.0).abs() < 2e-3);
    assert!((case.get("disc.perimeter") / case.get("disc.markers_length") - 1.0).abs() < 2e-3);
    assert!(case.get("map_error") < 0.05 && case.get("submaps") > 2.0);
}

#[test]
fn a_scene_with_a_prescribed_velocity_reads_back() {
    let scene = Scene::parse(VORTEX, Path::new("case/scene.toml")).unwrap();
    let again = Scene::parse(&scene.to_toml(), Path::new("runs/scene.toml")).unwrap();
    assert_eq!(again, scene);
    assert_eq!(again.to_toml(), scene.to_toml());
    assert!(scene.boundaries.is_empty());
}

#[test]
fn what_has_no_meaning_with_a_prescribed_velocity_is_refused() {
    for (set, part) in [
        ("fluid.viscosity=1", "means nothing beside `prescribed_velocity`"),
        (
            "membrane=[{ shape.circle = { centre = [0.5, 0.5], radius = 0.1 }, area.linear = { modulus = 1 } }]",
            "acts on the flow",
        ),
        ("level_set=[]", "carries nothing"),
        ("boundary.walls={ no_slip = true }", "means nothing where the velocity is prescribed"),
        ("output.probes.p={ at = [0.5, 0.5], of = 'pressure' }", "there is no pressure"),
        ("output.forces.f={ boundary = 'walls' }", "there are no forces"),
        ("level_set.0.markers=2", "out of range"),
        ("level_set.0.marker=2", "did you mean `markers`?"),
        ("fluid.prescribed_velocity=['1/(x - 0.5)', 0]", "no finite value everywhere"),
        (
            "level_set.0.shape={ circle = { centre = [2, 0.5], radius = 0.1 } }",
            "does not lie inside",
        ),
        ("numerics.remap=0", "must be positive"),
    ] {
        let shown = refused(VORTEX, &[set]);
        assert!(shown.contains(part), "{set}: {shown}");
    }
    assert!(refused(MEMBRANE, &["level_set.0.name=membrane"]).contains("two interfaces are named"));
    let periodic = ["boundary.left={ periodic = 'right' }", "fluid.prescribed_velocity=[1, 0]"];
    assert!(refused(VORTEX, &periodic).contains("markers do not pass"));
}

#[test]
fn composed_transport_is_refused_where_fluid_comes_in() {
    let shown = refused(VORTEX, &["fluid.prescribed_velocity=[1, 0]"]);
    assert!(shown.contains("where fluid comes in") && shown.contains("nodal"), "{shown}");
    // Another half turn of the wind, later.
    refused(VORTEX, &["fluid.prescribed_velocity=['max(t - 0.9, 0)', 0]"]);
    for set in ["boundary.left={ velocity = ['y*(2 - y)', 0] }", "boundary.left={ open = true }"] {
        assert!(
            refused(
                MEMBRANE,
                &[set, "boundary.right={ open = true }", "boundary.walls={ no_slip = true }"]
            )
            .contains("boundary `left`")
        );
    }
    // A lid only moves along itself.
    Case::with(
        MEMBRANE,
        &["boundary.top={ velocity = [1, 0] }", "boundary.walls={ no_slip = true }"],
    );
}

/// The state is saved, read and gone on with in a new model: every bit is the same, the chain of
/// submaps and the markers included.
#[test]
fn a_composed_run_goes_on_bit_by_bit() {
    fn check<P: Built>(text: &str, half: usize, passive: usize) {
        let mut whole = Case::<P>::of(text, &[]);
        whole.steps(half);
        let bytes = whole.bytes();
        let mut resumed = Case::<P>::of(text, &[]);
        resumed.resume(&bytes);
        whole.steps(half);
        resumed.steps(half);
        assert_eq!(whole.bytes(), resumed.bytes());
        assert_eq!(whole.model.level_set(passive), resumed.model.level_set(passive));
    }
    check::<Advected>(VORTEX, 4, 0);
    check::<ImmersedFlow>(MEMBRANE, 10, 1);
}

#[test]
fn a_membrane_moves_as_well_by_composed_as_by_nodal_transport() {
    let run = |transport: &str| Case::with(MEMBRANE, &[transport, "fluid.viscosity=0.05"]).run();
    let (composed, nodal) = (run("numerics.transport=composed"), run("numerics.transport=nodal"));
    for column in [
        "membrane.axis_1",
        "membrane.axis_2",
        "membrane.area",
        "dye.area",
        "dye.perimeter",
        "dye.markers_length",
    ] {
        let [a, b] = [&composed, &nodal].map(|c| c.get(column));
        assert!((a / b - 1.0).abs() < 5e-3, "{column}: composed {a}, nodal {b}");
    }
    assert!(composed.get("energy_balance").abs() < 0.02);
    assert!((composed.get("dye.area") / (PI * 0.04) - 1.0).abs() < 1e-3);
    assert!(
        (composed.get("dye.markers_length") / composed.get("dye.perimeter") - 1.0).abs() < 2e-3
    );
}

/// A uniform stream carries a disc once through the mesh and back to its place: displacements are
/// unwrapped at the sides.
#[test]
fn a_stream_through_periodic_sides_brings_everything_back() {
    let set = [
        "fluid.prescribed_velocity=[1, 0.5]",
        "boundary.left={ periodic = 'right' }",
        "boundary.bottom={ periodic = 'top' }",
        "level_set.0.markers=0",
        "time.end=2",
        "time.step=0.1",
        "numerics.remap=0.001",
    ];
    let mut case = Case::<Advected>::of(VORTEX, &set);
    let before = case.model.level_set(0).into_owned();
    case.steps(20);
    let after = case.model.level_set(0);
    let worst = before.iter().zip(after.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst}");
    assert!(case.get("map_error") < 1e-12);
}

/// The interface is cut from the map, not from what its values at the nodes of a coarse mesh make
/// of it.
#[test]
fn a_filament_thinner_than_the_mesh_keeps_its_area() {
    let set = ["time.end=4", "mesh.rectangle.cells=[24, 24]", "time.step=0.0625"];
    let case = Case::<Advected>::of(VORTEX, &set).run();
    let area = PI * 0.0225;
    assert!((case.get("disc.area") / area - 1.0).abs() < 5e-3, "{}", case.get("disc.area"));
    let (space, phi) = (case.model.space(), case.model.level_set(0));
    let nodal = immersa::levelset::Contour::new(space, &phi).unwrap().measures().unwrap().area;
    assert!((nodal / area - 1.0).abs() > 0.02, "{nodal}");
}

const TURN: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [6, 6] }
[fluid]
prescribed_velocity = ["y - 0.5", "0.5 - x"]
[[level_set]]
name = "disc"
shape.circle = { centre = [0.5, 0.5], radius = 0.2 }
[time]
end = 0.1
step = 0.1
[output]
probes.turn = { at = [0.3, 0.6], of = "vorticity" }
profiles.line = { from = [0, 0.2], to = [1, 0.7], points = 9, of = "vorticity" }
pictures = 0.1
picture = { field = "vorticity", size = 200 }
film = false
"#;

/// A rigid rotation has the vorticity of twice its angular velocity. Zero is in the middle of the
/// colours though all fluid turns one way.
#[test]
fn vorticity_is_measured_and_shown_with_its_sign() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // Grey levels of the ends of the colours, blue and red, of ColorBrewer's RdBu.
    for (out, sign, velocity, grey) in [
        ("clockwise", -1.0, "['y - 0.5', '0.5 - x']", 0.160),
        ("counter", 1.0, "['0.5 - y', 'x - 0.5']", 0.135),
    ] {
        let run = path.join(out);
        fs::write(path.join("scene.toml"), TURN).unwrap();
        let set = format!("fluid.prescribed_velocity={velocity}");
        immersa(path, &["run", "scene.toml", "--quiet", "--out", out, "--set", &set])
            .expect(0, &[]);
        let is = |values: &[f64]| values.iter().all(|v| (v - 2.0 * sign).abs() < 1e-12);
        assert!(is(Series::read(&run.join("series.csv")).unwrap().column("turn").unwrap()));
        let profile = Series::read(&run.join("profiles/line.csv")).unwrap();
        assert!(is(profile.column(profile.names.last().unwrap()).unwrap()));
        let picture = GreyImage::read(&run.join("pictures/000001.png")).unwrap();
        let middle = picture.levels()[(picture.height() / 2) * picture.width() + 70];
        assert!((middle - grey).abs() < 0.005, "{middle}");
    }
}
