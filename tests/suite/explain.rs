//! `immersa explain`: what it says of scenes, and that a run solves what it said.

use super::program::*;
use std::path::Path;
use tempfile::TempDir;

const LISTING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/listing/scene.toml");

fn explain(scene: &str, set: &[&str]) -> String {
    let set = set.iter().flat_map(|s| ["--set", *s]);
    let arguments: Vec<&str> = ["explain", scene].into_iter().chain(set).collect();
    let ended = immersa(Path::new("."), &arguments);
    ended.expect(0, &[]);
    assert_eq!(ended.stderr, "");
    ended.stdout
}

/// All lines are there, in this order, after any blanks.
fn says(plan: &str, lines: &[&str]) {
    let mut rest = plan.lines().map(str::trim);
    for line in lines {
        assert!(
            rest.any(|l| l.starts_with(line)),
            "`{line}` is missing, or not in its place, in\n{plan}"
        );
    }
}

/// The number before a word.
fn number_before(plan: &str, word: &str) -> f64 {
    let before = plan.split(word).next().unwrap().trim_end();
    before.rsplit(|c: char| !c.is_ascii_digit() && c != '.').next().unwrap().parse().unwrap()
}

#[test]
fn the_plan_of_the_listing_says_what_is_solved_and_what_is_left_out() {
    let plan = explain(LISTING, &[]);
    // 61^2 nodes of P2, of which 240 on the boundary are prescribed; 31^2 of P1, of which one is
    // fixed.
    says(
        &plan,
        &[
            "Mesh",
            "rectangle of 30 x 30 squares: 1800 triangles, 961 points",
            "boundary names: bottom, left, right, top, walls",
            "Solved",
            "Navier-Stokes flow (3.20)-(3.21)",
            "membrane `membrane`: stress (3.16) over its band with E'(r) = 1 (r - 1), initial stretch 1.2625316",
            "boundary walls: no slip",
            "Unknowns",
            "velocity 6962 (P2), pressure 960 (P1)",
            "level sets 1 x 3721 (P2)",
            "matrix changes with the interface (implicit coupling): solved by GMRES with an older \
             factor to the relative residual 1e-10, or factored anew, whichever is cheaper by \
             count: a factorisation costs 4.1 iterations",
            "Numerics",
            "BDF2 along characteristics, step 0.02",
            "grad-div 5.0000 (derived from the velocity scale 1.0000)",
            "band half-width 0.1000 on edges of 0.0667: 1.50 edges",
            "Left out",
            "backward characteristics: no shear and no bulk elasticity",
            "curvature: no bending",
            "redistancing: the slope of the level set is the stretch",
            "the mass matrix of the level set: nodal transport",
            "variable density and viscosity: both sides are the same",
            "the third dimension: the mesh is plane",
            "Steps",
            "500 steps of 0.02 to t = 10",
            "elastic wave of `membrane` at the start: period 3.33, 166 steps",
            "explicit step limit (1.54) at the start: 9.417e-3; the step is 2.12 of it",
            "the implicit coupling is not bound by it",
            "warning: the band is barely resolved",
        ],
    );
    // Entries of 8 bytes, and what solving takes beside them: scratch space, and the vectors of the
    // iterations.
    let (entries, all) =
        (number_before(&plan, " entries; memory"), number_before(&plan, " MB, of which"));
    let factors = number_before(&plan, " MB\n");
    assert!((5e5..8e5).contains(&entries), "{entries} entries in the factor");
    assert!((8e-6 * entries - 1.0..14e-6 * entries).contains(&factors), "{factors} MB");
    assert!(factors < all && all < 100.0, "{all} MB");

    let plan = explain(LISTING, &["numerics.coupling=explicit"]);
    says(
        &plan,
        &[
            "matrix constant: factored once",
            "membrane force explicit",
            "the explicit coupling will be unstable",
        ],
    );
    let plan = explain(LISTING, &["numerics.coupling=explicit", "time.step=5e-3"]);
    says(&plan, &["matrix constant: factored once", "explicit step limit"]);
    assert!(!plan.contains("unstable"), "{plan}");
    let sharp = ["membrane.0.force=sharp", "mesh.rectangle.cells=[24,24]"];
    let plan = explain(LISTING, &sharp);
    says(
        &plan,
        &[
            "grad-div 50.0000",
            "force of `membrane` on the interface itself, with the stretch carried along it",
        ],
    );
    assert!(!plan.contains("band half-width"), "{plan}");
    let semi = ["numerics.coupling=semi-implicit", "time.order=1"];
    let plan = explain(LISTING, &semi);
    says(
        &plan,
        &[
            "matrix constant: factored once",
            "membrane force semi-implicit (3.62)-(3.64): of a level set predicted by implicit \
             diffusion, its matrix factored in each step",
            "the semi-implicit coupling is made for constant tension",
        ],
    );
    let plan = explain(LISTING, &["time.end=0.2"]);
    says(
        &plan,
        &["warning: profile `pressure` is not written at t = 0.4, 10: the run ends at 0.2"],
    );
}

#[test]
fn the_plan_follows_the_scene() {
    let folder = TempDir::new().unwrap();
    let scene = folder.path().join("scene.toml");
    let scene = scene.to_str().unwrap();
    let stokes = SCENE.replace("viscosity = 0.01", "viscosity = 0.01\ndensity = 0");
    let no_membrane = "[mesh]\n\
        rectangle = { min = [0, 0], max = [1, 1], cells = [4, 4] }\n\
        [fluid]\nviscosity = 1\n\
        [boundary.walls]\nno_slip = true\n[boundary.left]\nopen = true\n\
        [time]\nend = 1\nstep = 0.5\n";
    let contrast =
        SCENE.replace("viscosity = 0.01", "viscosity = { inside = 0.1, outside = 0.01 }");
    let cases: [(&str, &[&str], &[&str]); 4] = [
        (
            &stokes,
            &[
                "Stokes flow (density 0)",
                "no time derivative in the flow",
                "inertia and convection: the density is 0",
            ],
            &["Navier", "BDF", "characteristics, step"],
        ),
        (
            no_membrane,
            &[
                "Navier-Stokes",
                "boundary left: open",
                "matrix constant",
                "level sets and elastic forces: no structure",
            ],
            &["band", "level sets 1", "explicit step limit", "zero mean", "curvature"],
        ),
        (
            &contrast,
            &[
                "density 1, viscosity 0.1 inside, 0.01 outside",
                "matrix changes with density or viscosity",
            ],
            &["both sides"],
        ),
        (
            &SCENE.replace("[numerics]", "[numerics]\ntransport = \"projected\""),
            &["level set projected at the quadrature points"],
            &["the mass matrix of the level set"],
        ),
    ];
    for (text, there, absent) in cases {
        std::fs::write(scene, text).unwrap();
        let plan = explain(scene, &[]);
        says(&plan, there);
        for word in absent {
            assert!(!plan.contains(word), "`{word}` in\n{plan}");
        }
    }
}
