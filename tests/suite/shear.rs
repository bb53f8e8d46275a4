//! Membranes that resist shear: scenes through the program, and what must hold for any of them.

use super::program::*;
use immersa::elastic::{AreaLaw, RestMap, ShearLaw, ShearMembrane, SurfaceLaw};
use immersa::fem::{Condition, Element, Space};
use immersa::levelset::{Circle, signed_distance};
use immersa::mesh::{Point, box_mesh};
use immersa::scene::Scene;
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface};
use nalgebra::SVector;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::sync::Arc;

const SPHERE: &str = r#"title = "A sheared sphere"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }
[fluid]
viscosity = 0.05
[boundary.walls]
no_slip = true
[[membrane]]
name = "sphere"
shape.sphere = { centre = [0, 0, 0], radius = 0.45 }
area.linear = { modulus = 1.0 }
shear.linear = { modulus = 0.1 }
map = ["x*cos(pi*z) + y*sin(pi*z)", "-x*sin(pi*z) + y*cos(pi*z)", "z"]
force = "smeared"
rings.equator = { centre = [0, 0, 0], normal = [0, 0, 1], modes = [4, 8] }
[time]
end = 0.06
step = 0.02
[numerics]
thickness = 0.5
[output]
fields = 0.02
pictures = 0.02
picture.field = "checkerboard"
checkpoint = 0
"#;

fn last(run: &Path, column: &str) -> f64 {
    *series(run).column(column).unwrap().last().unwrap()
}

#[test]
fn a_sheared_sphere_runs_goes_on_bit_by_bit_and_is_drawn() {
    for coupling in ["explicit", "implicit"] {
        let scene = SPHERE
            .replace("thickness = 0.5", &format!("thickness = 0.5\ncoupling = \"{coupling}\""));
        let folder = folder_with(&scene);
        let [whole, parts] = run_whole_and_in_parts(folder.path(), "done: 3 steps");
        if coupling == "implicit" {
            assert_same(&whole, &parts);
        } else {
            // A factor that is made once is made again: the counts of the two runs differ, their
            // results do not.
            for file in ["series.csv", "fields/000003.vtu"] {
                assert!(
                    fs::read(whole.join(file)).unwrap() == fs::read(parts.join(file)).unwrap(),
                    "{file}"
                );
            }
        }
        // Twisted on a sphere, with no change of area: Z2 = 1 + pi^2 r^4/(2 R^2), and r^4 is 8/15
        // R^4 in the mean.
        let first = |c: &str| series(&whole).column(c).unwrap()[0];
        assert!(
            (first("sphere.shear_mean") - (1.0 + 4.0 / 15.0 * (PI * 0.45).powi(2))).abs() < 5e-3
        );
        assert!(first("sphere.area_change_max") < 1.3 && first("determinant_error") < 1e-14);
        assert!(
            (first("sphere.equator_radius") - 0.45).abs() < 2e-3
                && first("sphere.equator_mode_4") < 2e-3
        );
        assert!(
            last(&whole, "energy_kinetic") > 1e-4 && last(&whole, "energy_balance").abs() < 0.02
        );
        assert!(
            last(&whole, "sphere.determinant_error") < 1e-2
                && last(&whole, "determinant_error") > 1e-8
        );
        assert!(whole.join("pictures/000003.png").exists());
        for field in ["shear", "area_change", "speed"] {
            let field = format!("output.picture.field={field}");
            immersa(folder.path(), &["render", "whole", "--set", &field]).expect(0, &[]);
        }
        let slice = [
            "--set",
            "output.picture.field=pressure",
            "--set",
            "output.picture.slice={ axis = \"y\" }",
        ];
        immersa(folder.path(), &[&["render", "whole"], &slice[..]].concat()).expect(0, &[]);
    }
}

#[test]
fn a_level_set_from_the_map_moves_as_the_carried_one() {
    let folder = folder_with(SPHERE);
    let mut found = Vec::new();
    let ways = [
        "numerics.transport=nodal",
        "membrane.0.level_set=mapped",
        "numerics.transport=composed",
        "numerics.transport=projected",
        "membrane.0.area_change=map",
    ];
    for (k, way) in ways.into_iter().enumerate() {
        let out = format!("run{k}");
        let more = [
            "--quiet",
            "--set",
            "output.fields=false",
            "--set",
            "output.pictures=false",
            "--set",
            way,
        ];
        immersa(folder.path(), &[&["run", "scene.toml", "--out", &out], &more[..]].concat())
            .expect(0, &[]);
        let run = folder.path().join(out);
        found.push(["sphere.axis_1", "sphere.volume", "energy_kinetic"].map(|c| last(&run, c)));
    }
    // The shape is that of one flow; the force of a mapped area follows from other derivatives.
    for f in &found[1..] {
        for ((a, b), bound) in f.iter().zip(&found[0]).zip([2e-4, 1e-4, 5e-3]) {
            assert!((a / b - 1.0).abs() < bound, "{found:?}");
        }
    }
}

#[test]
fn scenes_with_shear_come_back_from_what_they_are_written_as() {
    for (from, to) in [
        ("", ""),
        (
            "shear.linear = { modulus = 0.1 }",
            "shear.neo_hookean = { modulus = 0.1 }\nlevel_set = \"mapped\"",
        ),
        (
            "area.linear = { modulus = 1.0 }\nshear.linear = { modulus = 0.1 }",
            "law.skalak = { modulus = 0.1, area_ratio = 3 }\narea_change = \"map\"",
        ),
        (
            "area.linear = { modulus = 1.0 }\nshear.linear = { modulus = 0.1 }",
            "law.neo_hookean = { modulus = 0.1 }",
        ),
        (
            "picture.field = \"checkerboard\"",
            "picture = { field = \"shear\", view = [10, 20], slice = { axis = \"x\" } }",
        ),
    ] {
        let scene = Scene::parse(&SPHERE.replace(from, to), Path::new("scene.toml")).unwrap();
        let again = Scene::parse(&scene.to_toml(), Path::new("scene.toml")).unwrap();
        assert_eq!(scene, again, "{to}");
    }
}

#[test]
fn what_cannot_be_sheared_is_refused_where_it_is_written() {
    let refused = |from: &str, to: &str, words: &[&str]| {
        let folder = folder_with(&SPHERE.replace(from, to));
        immersa(folder.path(), &["explain", "scene.toml"]).expect(2, words);
    };
    refused(
        "force = \"smeared\"",
        "force = \"sharp\"\narea_change = \"map\"",
        &["for a smeared force", "membrane.0.area_change"],
    );
    refused(
        "shear.linear = { modulus = 0.1 }\n",
        "",
        &["for membranes that resist shear", "membrane.0.map"],
    );
    refused(
        "area.linear",
        "law.neo_hookean = { modulus = 1 }\narea.linear",
        &["on top of it", "`law` alone"],
    );
    refused(
        "force = \"smeared\"",
        "area_change = \"carried\"",
        &["no area change that the interface carries", "force = \"sharp\""],
    );
    refused("modes = [4, 8]", "modes = [3]", &["even"]);
    refused("\"z\"]", "\"z + t\"]", &["depends on time"]);
    refused(
        "thickness = 0.5",
        "thickness = 0.5\ncoupling = \"semi-implicit\"",
        &["nothing of shear", "implicit"],
    );
    refused(
        "no_slip = true",
        "no_slip = true\n[boundary.left]\nperiodic = \"right\"",
        &["periodic sides", "map"],
    );
    let plane = SPHERE.replace(
        "box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }",
        "rectangle = { min = [-1, -1], max = [1, 1], cells = [6, 6] }",
    );
    let folder = folder_with(&plane);
    immersa(folder.path(), &["explain", "scene.toml"]).expect(2, &["a curve", "length alone"]);
    let folder = folder_with(&SPHERE.replace("shear.linear = { modulus = 0.1 }\nmap", "#"));
    immersa(folder.path(), &["explain", "scene.toml"]).expect(2, &["backward characteristics"]);
}

/// Passive surfaces in a given velocity have the strains of annex A, through the program: TC4.
#[test]
fn a_passive_surface_tells_its_area_and_shear() {
    let scene = r#"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [10, 10, 10] }
[fluid]
prescribed_velocity = ["-y*z", "x*z", 0]
[[level_set]]
name = "ball"
shape.sphere = { centre = [0, 0, 0], radius = 0.5 }
[time]
end = 1.0
step = 0.1
[output]
backward_map = true
picture.field = "shear"
fields = 1.0
pictures = false
"#;
    let folder = folder_with(scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
    let run = folder.path().join("run");
    // 1 + t^2 r^4/(2 R^2): 1 + 4/15 R^2 in the mean, 1 + R^2/2 at the equator.
    assert!(
        (last(&run, "ball.shear_mean") - (1.0 + 1.0 / 15.0)).abs() < 1e-3,
        "{}",
        last(&run, "ball.shear_mean")
    );
    assert!(
        (last(&run, "ball.shear_max") - 1.125).abs() < 1e-2,
        "{}",
        last(&run, "ball.shear_max")
    );
    let area = ["min", "max"].map(|end| last(&run, &format!("ball.area_change_{end}")));
    assert!(area.iter().all(|z| (z - 1.0).abs() < 5e-2), "{area:?}");
    assert!(last(&run, "ball.determinant_error") < 5e-3);
    immersa(folder.path(), &["render", "run", "--set", "output.pictures=1.0"]).expect(0, &[]);
    assert!(run.join("pictures/000010.png").exists());
}

/// Of a membrane with an area law the strain is that since it was at rest; a map of composed
/// transport through periodic sides is refused, as it would jump.
#[test]
fn backward_characteristics_can_be_asked_for_without_shear() {
    let scene = r#"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }
[fluid]
viscosity = 0.1
[[membrane]]
shape.sphere = { centre = [0, 0, 0], radius = 0.45 }
stretch = 1.3
area.linear = { modulus = 1 }
[time]
end = 0.02
step = 0.02
[numerics]
thickness = 0.5
[output]
backward_map = true
fields = false
pictures = false
"#;
    let folder = folder_with(scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
    let table = series(&folder.path().join("run"));
    let first = |c: &str| table.column(c).unwrap()[0];
    assert!(
        (first("membrane.area_change_max") - 1.3).abs() < 1e-9
            && (first("membrane.shear_max") - 1.0).abs() < 1e-9
    );
    let periodic = scene
        .replace("[[membrane]]", "[boundary.left]\nperiodic = \"right\"\n[[membrane]]")
        .replace("thickness = 0.5", "thickness = 0.5\ntransport = \"composed\"")
        .replace(
            "[time]",
            "[boundary.bottom]\nno_slip = true\n[boundary.top]\nno_slip = \
             true\n[boundary.front]\nno_slip = true\n[boundary.back]\nno_slip = true\n[time]",
        );
    let folder = folder_with(&periodic);
    immersa(folder.path(), &["explain", "scene.toml"]).expect(2, &["periodic sides", "nodal"]);
}

fn sphere(
    law: SurfaceLaw,
    map: Option<Arc<RestMap<3>>>,
    coupling: Coupling,
    dt: f64,
) -> Simulation<3> {
    let mut mesh = box_mesh([-1.0; 3], [1.0; 3], [6; 3]).unwrap();
    mesh.set_boundary("walls", (0..mesh.facets().len() as u32).collect());
    let mesh = Arc::new(mesh);
    let space = Space::new(&mesh, Element::P2);
    let shape = Circle::<3>::new(Point::<3>::zeros(), 0.45).unwrap();
    let shear = ShearMembrane::new(law, 0.5, 1.0);
    let structure = Immersed::boxed(
        ImmersedInterface::new("sphere", signed_distance(&space, &shape), 0.5).coupled(coupling),
        match map {
            Some(map) => shear.with_map(map),
            None => shear,
        },
    );
    let settings = SimulationSettings {
        grad_div: 5.0,
        ..SimulationSettings::new(
            dt,
            Fluid { density: 1.0, viscosity: 0.05 },
            vec![("walls".into(), Condition::NoSlip)],
        )
    };
    Simulation::new(&mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
}

const LAW: SurfaceLaw = SurfaceLaw::Split {
    area: AreaLaw::Linear { modulus: 1.0 },
    shear: ShearLaw::NeoHookean { modulus: 0.5 },
};

/// A membrane at rest, here or turned as a whole, pulls at nothing: what moves is the error of the
/// level set's slope (a smooth distance is not a P2 function).
#[test]
fn a_membrane_at_rest_stays_at_rest_however_it_was_turned() {
    let turn: Arc<RestMap<3>> = Arc::new(|x: &Point<3>| {
        let (s, c) = 1.1f64.sin_cos();
        Point::<3>::new(x[0] * c - x[1] * s + 2.0, x[0] * s + x[1] * c - 1.0, x[2] + 0.5)
    });
    let twist: Arc<RestMap<3>> = Arc::new(|x: &Point<3>| {
        let (s, c) = (PI * x[2]).sin_cos();
        Point::<3>::new(x[0] * c + x[1] * s, x[1] * c - x[0] * s, x[2])
    });
    let speed = |map| {
        let mut sim = sphere(LAW, map, Coupling::Explicit, 0.01);
        (0..3).for_each(|_| assert!(sim.step().is_ok()));
        sim.largest_speed()
    };
    let (rest, turned, twisted) = (speed(None), speed(Some(turn)), speed(Some(twist)));
    assert!((rest - turned).abs() < 1e-10, "{rest} {turned}");
    assert!(rest < 0.1 * twisted, "{rest} {twisted}");
}

#[test]
fn one_thread_and_two_shear_a_sphere_to_the_same_bits() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let twist: Arc<RestMap<3>> =
                Arc::new(|x: &Point<3>| Point::<3>::new(x[0] + 0.3 * x[2], x[1], x[2]));
            let mut sim = sphere(LAW, Some(twist), Coupling::Implicit, 0.02);
            (0..3).for_each(|_| assert!(sim.step().is_ok()));
            sim.state().to_bytes(0)
        })
    };
    assert!(run(1) == run(2));
}
