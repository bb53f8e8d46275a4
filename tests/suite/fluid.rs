//! What a scene can ask of the flow, against exact solutions: forces, walls, periodic sides,
//! expressions with time, shapes.

use crate::case::{Case, V};
use immersa::fem::{Basis, Cells, integrate};
use immersa::scene::Problem;
use std::f64::consts::PI;

#[test]
fn heavy_fluid_at_rest_has_the_hydrostatic_pressure() {
    let closed = "mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [8, 6] }
        fluid = { density = 2, viscosity = 0.1, gravity = [0.3, -1] }
        time = { end = 0.3, step = 0.1 }
        output.forces.box = { boundary = \"walls\", about = [0, 0] }";
    let case = Case::new(closed).run();
    assert!(case.largest_error(|_, _| V::zeros()) < 1e-10);
    assert!(case.pressure_error(|x| 0.6 * (x[0] - 1.0) - 2.0 * (x[1] - 0.5)) < 1e-10);
    // The box bears the weight of the fluid, which acts at its centre: by the residual and by the
    // stress.
    for (column, exact) in [("x", 1.2), ("y", -4.0), ("moment", -4.6)] {
        assert!((case.get(&format!("box_{column}")) - exact).abs() < 1e-10, "{column}");
        assert!((case.get(&format!("box_stress_{column}")) - exact).abs() < 1e-10, "{column}");
    }
    // An open end sets the level: no stress there.
    let open = "mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [8, 6] }
        fluid = { density = 2, viscosity = 0.1, gravity = [0, -1] }
        boundary.walls.no_slip = true
        boundary.top.open = true
        time = { end = 0.3, step = 0.1 }
        output.forces.bed = { boundary = \"bottom\", about = [0, 0] }";
    let case = Case::new(open).run();
    assert!(case.largest_error(|_, _| V::zeros()) < 1e-10);
    assert!(case.pressure_error(|x| 2.0 * (1.0 - x[1])) < 1e-10);
    // The fluid weighs 2 x 2 x 1 on its bed; about the left corner that turns clockwise.
    for (column, exact) in
        [("bed_stress_x", 0.0), ("bed_stress_y", -4.0), ("bed_stress_moment", -4.0)]
    {
        assert!((case.get(column) - exact).abs() < 1e-10, "{column}");
    }
}

#[test]
fn a_force_drives_poiseuille_flow_through_periodic_sides() {
    let case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [6, 6] }
        fluid = { viscosity = 0.5, force = [0.8, 0], initial_velocity = [\"0.8*y*(1-y)\", 0] }
        boundary.left.periodic = \"right\"
        boundary.walls.no_slip = true
        time = { end = 0.4, step = 0.1 }
        output.forces.bed = { boundary = \"bottom\", about = [1, 1] }
        output.fluxes.out = { boundary = \"right\" }",
    )
    .run();
    assert!(case.largest_error(|x, _| V::new(0.8 * x[1] * (1.0 - x[1]), 0.0)) < 1e-10);
    assert!((case.get("out") - 0.8 / 6.0).abs() < 1e-10);
    // Each wall bears half of the force, at an arm of one about [1, 1].
    for name in ["bed_x", "bed_stress_x", "bed_stress_moment"] {
        assert!((case.get(name) - 0.8).abs() < 1e-10, "{name}");
    }
    // The force does the work that viscosity takes.
    assert!((case.get("dissipation") - 0.8 * 0.8 / 6.0 * 2.0).abs() < 1e-10);
    assert!(case.get("energy_balance").abs() < 1e-10);
}

/// Vortices between slip walls, which are lines of symmetry of them, decay by exp(-2 nu pi^2 t).
#[test]
fn taylor_green_vortices_in_a_box_that_slips() {
    let exact = |x: &V, t: f64| {
        V::new((PI * x[0]).sin() * (PI * x[1]).cos(), -(PI * x[0]).cos() * (PI * x[1]).sin())
            * (-2.0 * 0.02 * PI * PI * t).exp()
    };
    let error = |n: usize, step: f64| {
        let case = Case::new(&format!(
            "mesh.rectangle = {{ min = [0, 0], max = [1, 1], cells = [{n}, {n}] }}
            fluid = {{ viscosity = 0.02, initial_velocity = \
            [\"sin(pi*x)*cos(pi*y)\", \"-cos(pi*x)*sin(pi*y)\"] }}
            boundary.walls.slip = true
            time = {{ end = 0.5, step = {step} }}"
        ))
        .run();
        // The scheme may take energy, and gives none.
        assert!(
            (-0.03..1e-4).contains(&case.get("energy_balance")),
            "{}",
            case.get("energy_balance")
        );
        case.error(exact)
    };
    let (coarse, fine) = (error(8, 0.05), error(16, 0.025));
    assert!(fine < 1.5e-3 && coarse / fine > 3.4, "{coarse:e} {fine:e}");
}

/// Stokes' second problem: a wall that swings in its own plane drags the fluid along. The far wall
/// has the exact velocity too.
#[test]
fn a_swinging_wall_is_given_by_an_expression_of_time() {
    let (nu, omega): (f64, f64) = (0.1, 2.0 * PI);
    let k = (omega / (2.0 * nu)).sqrt();
    let error = |cells: usize, step: f64| {
        let u = format!("exp(-{k}*y)*cos({omega}*t - {k}*y)");
        let case = Case::new(&format!(
            "mesh.rectangle = {{ min = [0, 0], max = [0.2, 1], cells = [2, {cells}] }}
            fluid = {{ viscosity = {nu}, initial_velocity = [\"exp(-{k}*y)*cos({k}*y)\", 0] }}
            boundary.left.periodic = \"right\"
            boundary.bottom.velocity = [\"{u}\", 0]
            boundary.top.velocity = [\"{u}\", 0]
            time = {{ end = 1, step = {step} }}"
        ))
        .run();
        case.largest_error(|x, t| V::new((-k * x[1]).exp() * (omega * t - k * x[1]).cos(), 0.0))
    };
    let (coarse, fine) = (error(10, 0.05), error(20, 0.025));
    assert!(fine < 5e-3 && coarse / fine > 3.4, "{coarse:e} {fine:e}");
}

/// The pressure of an open end is zero on average, and falls along the channel as Poiseuille's
/// does.
#[test]
fn an_open_outlet_sets_the_level_of_the_pressure() {
    let case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [4, 1], cells = [32, 8] }
        fluid = { viscosity = 0.5, initial_velocity = [\"y*(1-y)\", 0] }
        boundary.walls.no_slip = true
        boundary.left.velocity = [\"y*(1-y)\", 0]
        boundary.right.open = true
        time = { end = 8, step = 0.2 }
        [output]
        probes.a = { at = [0.5, 0.5], of = \"pressure\" }
        probes.b = { at = [2.0, 0.5], of = \"pressure\" }
        probes.v = { at = [2.0, 0.25], of = \"velocity\" }
        profiles.across = { from = [2, 0], to = [2, 1], points = 5, of = \"velocity\" }
        fluxes.inflow = { boundary = \"left\" }
        fluxes.outflow = { boundary = \"right\" }",
    )
    .run();
    // dp/dx = -2 mu for u = y (1 - y).
    assert!(
        (case.get("a") - case.get("b") - 1.5).abs() < 1e-5,
        "{}",
        case.get("a") - case.get("b")
    );
    // What the stress-free end adds is a fraction of mu U / H.
    assert!((case.get("b") - 2.0).abs() < 0.05, "{}", case.get("b"));
    assert!((case.get("v_x") - 0.1875).abs() < 1e-5 && case.get("v_y").abs() < 1e-5);
    assert!(
        (case.get("inflow") + 1.0 / 6.0).abs() < 1e-10
            && (case.get("outflow") - 1.0 / 6.0).abs() < 1e-10
    );
    // The kinetic energy that enters and leaves is in the balance.
    assert!(case.get("energy_balance").abs() < 1e-3, "{}", case.get("energy_balance"));
    // A profile of the velocity has a column for each component.
    let profile = case.model.profile(0);
    assert_eq!(profile.iter().map(|c| c.0).collect::<Vec<_>>(), ["_x", "_y"]);
    assert!((profile[0].1[1] - 0.1875).abs() < 1e-5 && profile[1].1.iter().all(|v| v.abs() < 1e-5));
}

/// A lid does not blow through the walls at its ends: no fluid leaves the cavity there, and it
/// keeps none either.
#[test]
fn the_driven_cavity_is_watertight() {
    let case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
        fluid.viscosity = 1.0
        boundary.walls.no_slip = true
        boundary.top.velocity = [1, 0]
        time = { end = 0.1, step = 0.1 }
        output.fluxes.left = { boundary = \"left\" }
        output.fluxes.top = { boundary = \"top\" }",
    )
    .run();
    assert!(case.get("left").abs() < 1e-14 && case.get("top").abs() < 1e-14);
    // A plug flow into a channel keeps its flux up to the walls.
    let case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
        fluid.viscosity = 1.0
        boundary.walls.no_slip = true
        boundary.left.velocity = [1, 0]
        boundary.right.open = true
        time = { end = 0.1, step = 0.1 }
        output.fluxes.inflow = { boundary = \"left\" }
        output.fluxes.outflow = { boundary = \"right\" }",
    )
    .run();
    assert!((case.get("inflow") + 1.0).abs() < 1e-12 && (case.get("outflow") - 1.0).abs() < 1e-10);
}

/// Once around a periodic channel: the membrane is carried through the side and comes back to where
/// it started.
#[test]
fn a_membrane_passes_a_periodic_side() {
    let mut case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [32, 16] }
        fluid = { viscosity = 0.1, initial_velocity = [1, 0] }
        boundary.left.periodic = \"right\"
        boundary.walls.slip = true
        time = { end = 2, step = 0.05 }
        [[membrane]]
        name = \"m\"
        shape.circle = { centre = [1.7, 0.5], radius = 0.25 }
        area.linear = { modulus = 1 }",
    );
    let start = [case.get("m.area"), case.get("m.perimeter")];
    assert!(
        (start[0] / (0.0625 * PI) - 1.0).abs() < 1e-4 && (start[1] / (0.5 * PI) - 1.0).abs() < 1e-4
    );
    // Half-way through the side: area and perimeter are those of both parts, which have no common
    // centre.
    case.steps(6);
    assert!(case.get("m.centre_x").is_nan() && case.get("m.axis_1").is_nan());
    assert!((case.get("m.area") / start[0] - 1.0).abs() < 1e-3);
    assert!((case.get("m.perimeter") / start[1] - 1.0).abs() < 1e-3);
    let case = case.run();
    assert!(
        (case.get("m.centre_x") - 1.7).abs() < 1e-3 && (case.get("m.centre_y") - 0.5).abs() < 1e-3
    );
    assert!((case.get("m.area") / start[0] - 1.0).abs() < 1e-3);
    assert!(
        (case.get("m.axis_1") / 0.25 - 1.0).abs() < 5e-3
            && (case.get("m.axis_2") / 0.25 - 1.0).abs() < 5e-3
    );
    assert!(case.largest_error(|_, _| V::new(1.0, 0.0)) < 1e-2);
}

fn ellipse_perimeter(a: f64, b: f64) -> f64 {
    let k = 2000;
    (0..k)
        .map(|i| 2.0 * PI * i as f64 / k as f64)
        .map(|t| (a * t.sin()).hypot(b * t.cos()) * 2.0 * PI / k as f64)
        .sum()
}

/// Every shape that a scene can name: area and perimeter at the start, and that it runs.
#[test]
fn shapes_have_their_areas_and_perimeters() {
    let lens = {
        // Two circles of radius 0.3, 0.3 apart: each loses a segment of half-angle acos(0.5).
        let half = 0.5f64.acos();
        let segment = 0.09 * (half - half.sin() * half.cos());
        [2.0 * (PI * 0.09 - segment), 2.0 * 0.3 * (2.0 * PI - 2.0 * half)]
    };
    let ellipse = [0.1 * PI, ellipse_perimeter(0.4, 0.25)];
    // The contour rounds corners off by a fraction of an edge.
    let cases: [(&str, [f64; 2], f64); 6] = [
        ("circle = { centre = [1, 1], radius = 0.3 }", [0.09 * PI, 0.6 * PI], 1e-4),
        ("ellipse = { centre = [1, 1], semi_axes = [0.4, 0.25], angle = 30 }", ellipse, 1e-4),
        (
            "rounded_box = { centre = [1, 1], half_size = [0.4, 0.3], radius = 0.15, angle = 20 }",
            [0.48 - (4.0 - PI) * 0.0225, 2.8 - (8.0 - 2.0 * PI) * 0.15],
            1e-3,
        ),
        (
            "polygon = { points = [[0.6, 0.7], [1.4, 0.7], [1.4, 1.3], [0.6, 1.3]] }",
            [0.48, 2.8],
            6e-3,
        ),
        (
            "union = [{ circle = { centre = [0.85, 1], radius = 0.3 } }, \
             { circle = { centre = [1.15, 1], radius = 0.3 } }]",
            lens,
            6e-3,
        ),
        ("expression = \"((x-1)/0.4)^2 + ((y-1)/0.25)^2 - 1\"", ellipse, 1e-4),
    ];
    for (shape, exact, tolerance) in cases {
        let mut case = Case::new(&format!(
            "mesh.rectangle = {{ min = [0, 0], max = [2, 2], cells = [40, 40] }}
            fluid.viscosity = 0.1
            time = {{ end = 1, step = 0.01 }}
            [[membrane]]
            shape.{shape}
            stretch = 1.2
            area.linear = {{ modulus = 1 }}"
        ));
        let found = [case.get("membrane.area"), case.get("membrane.perimeter")];
        for (found, exact) in found.iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < tolerance, "{shape}: {found} {exact}");
        }
        case.steps(3);
        assert!((case.get("membrane.area") / found[0] - 1.0).abs() < 1e-3, "{shape}");
        // Corners that smooth themselves out within a cell take energy.
        assert!(case.get("energy_balance") < 1e-2, "{shape}: {}", case.get("energy_balance"));
    }
}

fn ellipses(membranes: &str) -> Case {
    Case::new(&format!(
        "mesh.rectangle = {{ min = [0, 0], max = [3, 1.5], cells = [60, 30] }}
        fluid.viscosity = 0.05
        time = {{ end = 0.2, step = 0.01 }}
        numerics.thickness = 0.125
        {membranes}"
    ))
}

#[test]
fn two_membranes_share_a_flow() {
    let [left, right] =
        [("a", "[0.75, 0.75]", 0), ("b", "[2.25, 0.75]", 90)].map(|(name, centre, angle)| {
            format!(
                "[[membrane]]
            name = \"{name}\"
            shape.ellipse = {{ centre = {centre}, semi_axes = [0.4, 0.3], angle = {angle} }}
            stretch = 1.3
            area.linear = {{ modulus = 1 }}
            "
            )
        });
    let (one, other, both) =
        (ellipses(&left), ellipses(&right), ellipses(&format!("{left}{right}")));
    let sum = one.get("energy_elastic") + other.get("energy_elastic");
    assert!((both.get("energy_elastic") / sum - 1.0).abs() < 1e-12);
    let both = both.run();
    for name in ["a", "b"] {
        let get = |what: &str| both.get(&format!("{name}.{what}"));
        assert!((get("area") / (0.12 * PI) - 1.0).abs() < 1e-3);
        assert!(get("axis_1") < 0.4 && get("axis_2") > 0.3);
    }
    // Mirror images of one another, but for the diagonals of the mesh and the distances of the
    // walls.
    assert!((both.get("a.axis_1") - both.get("b.axis_1")).abs() < 5e-3);
    assert!(
        (both.get("a.centre_x") - 0.75).abs() < 1e-3
            && (both.get("b.centre_x") - 2.25).abs() < 1e-3
    );
    assert!(both.get("energy_balance").abs() < 5e-3, "{}", both.get("energy_balance"));
}

/// A membrane with mass in a box without walls: its mass is that at rest, and the momentum of all
/// stays what it was.
#[test]
fn a_heavy_membrane_keeps_mass_and_momentum() {
    let mut case = Case::new(
        "mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [30, 30] }
        fluid = { viscosity = 0.02, initial_velocity = [0.3, 0.1] }
        boundary.left.periodic = \"right\"
        boundary.bottom.periodic = \"top\"
        time = { end = 0.6, step = 0.02 }
        [[membrane]]
        shape.ellipse = { centre = [1, 1], semi_axes = [0.6, 0.4], angle = 20 }
        stretch = 1.25
        area.linear = { modulus = 1 }
        mass = 0.5",
    );
    let totals = |case: &Case| {
        let sim = &case.model.simulation;
        let density = sim.density();
        let basis =
            Basis::new(sim.space(), &std::sync::Arc::new(immersa::fem::Rule::simplex(2, 8)));
        integrate(&basis, Cells::All, |at| {
            let rho = density(at.cell, &at.barycentric);
            let u = basis.value(at, case.velocity());
            [rho, rho * u[0], rho * u[1]]
        })
    };
    let start = totals(&case);
    // 4 of fluid, and half a unit of mass a length at rest.
    let exact = 4.0 + 0.5 * ellipse_perimeter(0.6, 0.4) / 1.25;
    assert!((start[0] / exact - 1.0).abs() < 1e-3, "{start:?} {exact}");
    case = case.run();
    let end = totals(&case);
    assert!((end[0] / start[0] - 1.0).abs() < 1e-3, "{start:?} {end:?}");
    for i in 1..3 {
        assert!((end[i] - start[i]).abs() < 5e-3 * start[1], "{start:?} {end:?}");
    }
    assert!(case.get("energy_balance").abs() < 0.02, "{}", case.get("energy_balance"));
}

#[test]
fn a_band_that_reaches_a_wall_is_refused_and_one_that_reaches_a_periodic_side_is_not() {
    let scene = |boundary: &str| {
        format!(
            "mesh.rectangle = {{ min = [0, 0], max = [2, 1], cells = [40, 20] }}
            fluid.viscosity = 1.0
            {boundary}
            time = {{ end = 1, step = 0.1 }}
            [[membrane]]
            shape.circle = {{ centre = [0.26, 0.5], radius = 0.25 }}
            area.tension = {{ tension = 1 }}
            force = \"smeared\""
        )
    };
    let parse = |text: &str| {
        immersa::scene::Scene::parse(text, std::path::Path::new("scene.toml")).unwrap()
    };
    let refused =
        immersa::scene::ImmersedFlow::<2>::new(&parse(&scene("boundary.walls.no_slip = true")))
            .err()
            .unwrap();
    assert!(refused.to_string().contains("reaches the boundary"), "{refused}");
    Case::new(&scene("boundary.walls.no_slip = true\nboundary.left.periodic = \"right\"")).steps(2);
}
