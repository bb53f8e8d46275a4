//! Drops: fluids in the fluid, their tension, and what is measured of them.

use super::case::{Case, V, refused};
use immersa::fem::Element;
use std::f64::consts::PI;

const DROP: &str = "
    mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [16, 16] }
    fluid.viscosity = 0.1
    time = { end = 0.1, step = 0.01 }
    [[drop]]
    shape.circle = { centre = [0.5, 0.5], radius = 0.2 }
    tension = 1";

fn case(changes: &[&str]) -> Case {
    Case::with(DROP, changes)
}

/// Surface tension in a uniform flow that nothing disturbs: the mean velocity of the drop is that
/// of the fluid, and it is round.
#[test]
fn a_drop_in_a_uniform_flow_goes_with_it() {
    let sides = [
        "boundary.left.periodic=right",
        "fluid.initial_velocity=[1, 0]",
        "boundary.bottom.slip=true",
        "boundary.top.slip=true",
    ];
    let mut case = case(&sides);
    case.steps(5);
    assert!((case.get("drop.velocity_x") - 1.0).abs() < 2e-3, "{}", case.get("drop.velocity_x"));
    assert!(case.get("drop.velocity_y").abs() < 2e-3);
    assert!((case.get("drop.circularity") - 1.0).abs() < 1e-4);
    assert!((case.get("drop.centre_x") - 0.55).abs() < 1e-3);
}

/// An ellipse has the circularity of its perimeter.
#[test]
fn the_circularity_is_that_of_the_perimeter() {
    let case =
        case(&["drop.0.shape={ ellipse = { centre = [0.5, 0.5], semi_axes = [0.3, 0.15] } }"]);
    let [area, perimeter] = ["drop.area", "drop.perimeter"].map(|c| case.get(c));
    assert!(
        (area - PI * 0.045).abs() < 1e-3
            && (case.get("drop.circularity") - 2.0 * (PI * area).sqrt() / perimeter).abs() < 1e-12
    );
}

/// Jump of the pressure over a circular band of half-width `eps` with tension 1: in equilibrium
/// `dp/dr = -delta(r - radius)/r`, with the cosine kernel.
fn jump_over_band(radius: f64, eps: f64) -> f64 {
    let points = 1000;
    let at = |k: usize| {
        let s = (2.0 * (k as f64 + 0.5) / points as f64 - 1.0) * eps;
        (1.0 + (PI * s / eps).cos()) / (points as f64 * (radius + s))
    };
    (0..points).map(at).sum()
}

/// All schemes of surface tension hold a drop whose pressure is higher inside by what equilibrium
/// in their band asks for; on the interface that is `tension/radius`.
#[test]
fn every_scheme_has_the_jump_of_the_pressure() {
    let probes = [
        "output.probes.in={ at = [0.5, 0.5], of = 'pressure' }",
        "output.probes.out={ at = [0.03, 0.97], of = 'pressure' }",
    ];
    let schemes = ["brackbill1992", "lafaurie1994", "baensch2001", "cottet2016"]
        .map(|s| format!("numerics.surface_tension={s}"));
    for scheme in schemes.iter().map(String::as_str).chain(["drop.0.force=sharp"]) {
        for pressure in ["numerics.pressure=P1", "numerics.pressure='P1+P0'"] {
            let mesh = ["time.order=1", "mesh.rectangle.cells=[24, 24]", "numerics.thickness=0.1"];
            let mut case = case(&[&probes[..], &[scheme, pressure], &mesh].concat());
            case.steps(2);
            let jump = case.get("in") - case.get("out");
            let exact = if scheme.ends_with("sharp") { 5.0 } else { jump_over_band(0.2, 0.1) };
            // With constants the probe reads that of its cell. The semi-implicit scheme takes the
            // force of a predicted interface, which has shrunk: an error of first order in the step.
            let bound = match (scheme, pressure) {
                ("numerics.surface_tension=cottet2016", _) => 0.04,
                (scheme, pressure) if scheme.ends_with("sharp") || pressure.contains("P0") => 5e-3,
                _ => 2.5e-3,
            };
            assert!((jump / exact - 1.0).abs() < bound, "{scheme} {pressure}: {jump} {exact}");
            assert!(
                case.get("velocity_max") < 0.02,
                "{scheme} {pressure}: {}",
                case.get("velocity_max")
            );
        }
    }
}

/// With constants of the cells in the pressure no cell gains or loses fluid, but for those with two
/// walls and one more.
#[test]
fn a_pressure_that_jumps_conserves_the_volume_of_each_cell() {
    let outflow = |pressure: &str| {
        let lid = "boundary.top.velocity=['16 * x^2 * (1 - x)^2', '0']";
        let mut case =
            case(&[pressure, lid, "boundary.walls.no_slip=true", "numerics.grad_div=0.1"]);
        case.steps(3);
        let sim = &case.model.simulation;
        let (space, u) = (sim.space(), &sim.state().flow.u);
        let mesh = space.mesh();
        let through = |c: usize| {
            let weights = [1.0 / 3.0; 3].iter().enumerate();
            // The divergence of P2 is linear: its mean is that of its values at the vertices.
            let divergence = weights
                .map(|(a, w)| space.jacobian(u, c, &Element::P1.node(a, 2)).trace() * w)
                .sum::<f64>();
            divergence.abs() * mesh.map(c).volume
        };
        let mut all: Vec<f64> = (0..mesh.cell_count()).map(through).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() - 4]
    };
    let [continuous, jumping] = ["numerics.pressure=P1", "numerics.pressure='P1+P0'"].map(outflow);
    assert!(
        continuous > 1e-5 && jumping < 1e-13,
        "{continuous:.1e} with P1, {jumping:.1e} with P1+P0"
    );
}

/// Each drop puts its fluid in place of what was there, and the Boussinesq form keeps the inertia
/// of the liquid.
#[test]
fn fluids_are_those_of_the_drops() {
    let text = "
        mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [40, 20] }
        fluid = { density = 3, viscosity = 0.1 }
        time = { end = 0.1, step = 0.01 }
        numerics.thickness = 0.1
        [[drop]]
        name = \"a\"
        shape.circle = { centre = [0.6, 0.5], radius = 0.3 }
        density = 1
        [[drop]]
        name = \"b\"
        shape.circle = { centre = [1.4, 0.5], radius = 0.3 }
        density = 5
        viscosity = 0.7";
    let at = |case: &Case, x: f64| {
        let mesh = case.model.simulation.space().mesh();
        let place = immersa::mesh::Locator::new(mesh).locate(mesh, &V::new(x, 0.5)).unwrap();
        let (cell, l) = (place.cell as usize, place.barycentric);
        let sim = &case.model.simulation;
        [sim.density()(cell, &l), sim.viscosity()(cell, &l)]
    };
    let case = Case::new(text);
    let near = |case: &Case, expected: [[f64; 2]; 3]| {
        for (x, expected) in [0.6, 1.4, 1.0].into_iter().zip(expected) {
            let found = at(case, x);
            assert!(
                (0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12),
                "at {x}: {found:?}, {expected:?}"
            );
        }
    };
    near(&case, [[1.0, 0.1], [5.0, 0.7], [3.0, 0.1]]);
    let case = Case::with(text, &["fluid.boussinesq=true"]);
    near(&case, [[3.0, 0.1], [3.0, 0.7], [3.0, 0.1]]);
}

/// For a small difference of densities both forms of the equations say the same, to first order in
/// it.
#[test]
fn the_boussinesq_form_is_the_limit_of_small_differences() {
    let rise = |density: f64, boussinesq: &str| {
        let density = format!("drop.0.density={density}");
        let mut case =
            case(&[&density, boussinesq, "fluid.gravity=[0, -1]", "drop.0.force=smeared"]);
        case.steps(10);
        case.get("drop.velocity_y")
            / (1.0 - case.scene.inside(&*case.scene.structures()[0]).unwrap().density)
    };
    let difference = |density| {
        (rise(density, "fluid.boussinesq=true") / rise(density, "fluid.boussinesq=false") - 1.0)
            .abs()
    };
    let [large, small] = [0.8, 0.9].map(difference);
    assert!(small < 0.05 && (large / small - 2.0).abs() < 0.2, "{large} {small}");
}

/// A bubble a thousand times lighter and a hundred times thinner than the liquid.
#[test]
fn a_contrast_of_a_thousand_is_stable() {
    let mut case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [1, 2], cells = [20, 40] }
        fluid = { density = 1000, viscosity = 10, gravity = [0, -0.98] }
        boundary.left.slip = true
        boundary.right.slip = true
        boundary.walls.no_slip = true
        time = { end = 1.5, step = 0.03 }
        numerics.redistance = { method = \"exact\", every = 5, volume = true }
        [[drop]]
        name = \"bubble\"
        shape.circle = { centre = [0.5, 0.5], radius = 0.25 }
        density = 1
        viscosity = 0.1
        tension = 1.96
        force = \"smeared\"",
    );
    let mut fastest: f64 = 0.0;
    for _ in 0..25 {
        case.steps(2);
        fastest = fastest.max(case.get("bubble.velocity_y"));
    }
    let (area, balance) =
        (case.get("bubble.area") / (PI * 0.0625) - 1.0, case.get("energy_balance"));
    // Published: .250 to .252; this mesh of 20 x 40 squares gives .2484.
    assert!(
        (fastest - 0.251).abs() < 0.0035 && area.abs() < 0.003 && balance.abs() < 0.003,
        "{fastest} {area} {balance}"
    );
}

#[test]
fn what_a_drop_cannot_have_is_refused() {
    for (changes, words) in [
        (
            vec!["numerics.surface_tension=baensch2001", "numerics.coupling=explicit"],
            "keep one of the two",
        ),
        (
            vec!["numerics.surface_tension=brackbill1992", "drop.0.force=sharp"],
            "spread over a band",
        ),
        (vec!["numerics.coupling=fully-explicit"], "time.order = 1"),
        (
            vec!["fluid.density={ inside = 1, outside = 2 }", "drop.0.density=3"],
            "the drop its own density or viscosity",
        ),
        (vec!["drop.0.tension=-1"], "tension"),
        (vec!["drop.0.stretch=2"], "stretch"),
        (vec!["drop.0.rings={ a = { centre = [0, 0], normal = [0, 1] } }"], "ask for chords"),
        (vec!["numerics.pressure='P1+P0'", "mesh.adapt.edge=0.05"], "not brought to a new mesh"),
    ] {
        let message = refused(DROP, &changes);
        assert!(message.contains(words), "{changes:?}: {message}");
    }
}

/// Water in oil in water: the inner drop has the fluid that lies outside of both, and says so.
#[test]
fn a_drop_in_a_drop_has_its_own_fluid() {
    let case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [40, 40] }
        fluid = { density = 1, viscosity = 0.1 }
        time = { end = 0.1, step = 0.01 }
        [[drop]]
        name = \"oil\"
        shape.circle = { centre = [0.5, 0.5], radius = 0.3 }
        density = 0.1
        viscosity = 0.01
        [[drop]]
        name = \"water\"
        shape.circle = { centre = [0.5, 0.5], radius = 0.15 }
        density = 1
        viscosity = 0.1",
    );
    let mesh = case.model.simulation.space().mesh();
    let density = |x: f64| {
        let place = immersa::mesh::Locator::new(mesh).locate(mesh, &V::new(x, 0.5)).unwrap();
        case.model.simulation.density()(place.cell as usize, &place.barycentric)
    };
    assert!(
        (density(0.5) - 1.0).abs() < 1e-12 && (density(0.725) - 0.1).abs() < 1e-12,
        "{}",
        density(0.5)
    );
}

/// A band that reaches the middle of a drop, where a point of the mesh lies and no normal is.
#[test]
fn the_continuum_force_bears_the_middle_of_a_drop() {
    let drop = "drop.0.shape={ circle = { centre = [0.5, 0.5], radius = 0.15 } }";
    let mut case = case(&["numerics.surface_tension=brackbill1992", drop, "time.step=1e-3"]);
    case.steps(5);
    assert!(case.get("velocity_max") < 0.1, "{}", case.get("velocity_max"));
}

/// A surfactant on a circle of radius 1, in a fluid too thick to move: a wave decays by
/// `exp(-k t/R^2)`, and the amount stays.
#[test]
fn a_surfactant_spreads_by_its_diffusivity() {
    let mut case = Case::new(
        "
        mesh.rectangle = { min = [-2, -2], max = [2, 2], cells = [24, 24] }
        fluid = { density = 0, viscosity = 1e6 }
        boundary.walls.no_slip = true
        time = { end = 2, step = 0.02 }
        [[drop]]
        shape.circle = { centre = [0, 0], radius = 1 }
        tension = 1.0
        [drop.surfactant]
        elasticity = 0.01
        diffusivity = 0.5
        concentration = \"1 + 0.1*x/hypot(x, y)\"",
    );
    case.steps(100);
    let wave = 0.5 * (case.get("drop.concentration_max") - case.get("drop.concentration_min"));
    assert!((wave / (0.1 * (-1f64).exp()) - 1.0).abs() < 0.01, "{wave}");
    assert!((case.get("drop.concentration_mean") - 1.0).abs() < 1e-4);
}

/// In shear a surfactant is swept to the tips, where the tension falls: the drop is longer than
/// without it, the amount stays, and the energy balances.
#[test]
fn a_surfactant_is_swept_to_the_tips_of_a_drop_in_shear() {
    let text = "
        mesh.rectangle = { min = [-3, -3], max = [3, 3], cells = [24, 24] }
        fluid = { density = 0, viscosity = 1 }
        boundary.walls.velocity = [\"y\", 0]
        time = { end = 3, step = 0.05 }
        [[drop]]
        shape.circle = { centre = [0, 0], radius = 1 }
        tension = 5.0
        surfactant = { elasticity = 2.0, diffusivity = 0.05 }";
    let amount = |case: &Case| case.get("drop.concentration_mean") * case.get("drop.perimeter");
    let long = |case: &Case| case.get("drop.axis_1") / case.get("drop.axis_2");
    let mut case = Case::new(text);
    let before = amount(&case);
    case = case.run();
    assert!((amount(&case) / before - 1.0).abs() < 1e-10, "{before} {}", amount(&case));
    let [least, most] = ["min", "max"].map(|m| case.get(&format!("drop.concentration_{m}")));
    assert!(least < 0.9 && most > 1.1, "{least} {most}");
    assert!(case.get("elastic_balance").abs() < 0.02, "{}", case.get("elastic_balance"));
    let clean = text.replace("        surfactant", "#");
    let clean = Case::new(&clean).run();
    assert!(long(&case) > 1.2 * long(&clean), "{} {}", long(&case), long(&clean));
}

#[test]
fn a_surfactant_needs_an_interface_that_carries_it_and_leaves_some_tension() {
    let text = "
        mesh.rectangle = { min = [-2, -2], max = [2, 2], cells = [16, 16] }
        fluid.viscosity = 1
        boundary.walls.no_slip = true
        time = { end = 1, step = 0.1 }
        [[drop]]
        shape.circle = { centre = [0, 0], radius = 1 }
        tension = 1.0
        surfactant = { elasticity = 0.5 }";
    for (set, words) in [
        ("drop.0.force=smeared", "sharp force"),
        ("numerics.band=carried", "numerics.band"),
        ("drop.0.surfactant.concentration=x", "positive on the whole interface"),
        ("drop.0.surfactant.concentration=1+t", "depends on time"),
        ("drop.0.surfactant.elasticity=-1", "elasticity"),
        ("drop.0.surfactant.elasticity=1.5", "leaves no surface tension"),
    ] {
        let error = refused(text, &[set]);
        assert!(error.contains(words), "{set}: {error}");
    }
}
