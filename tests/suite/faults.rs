//! Inputs that once gave wrong results, or words that did not help.

use super::program::*;
use immersa::mesh::{Diagonals, freefem, gmsh, rectangle};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// `immersa explain` of a scene, with a file `m.msh` beside it.
fn explained(scene: &str, mesh: &str) -> Ended {
    let folder = folder_with(scene);
    fs::write(folder.path().join("m.msh"), mesh).unwrap();
    immersa(folder.path(), &["explain", "scene.toml"])
}

/// A column of the series of a run.
fn column(run: &Path, name: &str) -> Vec<f64> {
    let series = series(run);
    let k = series.names.iter().position(|n| n == name).unwrap();
    series.columns[k].clone()
}

const REST: &str = "[fluid]\ndensity = 1\nviscosity = 1\n[time]\nend = 0.5\nstep = 0.05\n";
const SQUARE: &str = "[mesh]\nrectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }\n";
const FILE: &str = "[mesh]\nfile = \"m.msh\"\n";

/// A square of two triangles in MSH 2.2: its sides, from below and against the clock, in the
/// physical groups `sides`, of which some have names.
fn square(names: &[(u32, &str)], sides: [u32; 4]) -> String {
    let names: Vec<String> = names.iter().map(|(k, n)| format!("1 {k} \"{n}\"\n")).collect();
    let lines = sides.iter().zip(1..).map(|(g, k)| format!("{k} 1 2 {g} {k} {k} {}\n", k % 4 + 1));
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n{}$EndPhysicalNames\n\
         $Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n6\n{}\
         5 2 2 9 1 1 2 3\n6 2 2 9 1 1 3 4\n$EndElements\n",
        names.len(),
        names.concat(),
        lines.collect::<String>()
    )
}

/// 09-columns-of-one-name.
#[test]
fn columns_of_one_name_are_refused() {
    let lid = "[boundary.walls]\nno_slip = true\n[boundary.top]\nvelocity = [1, 0]\n";
    for (output, twice, key) in [
        ("probes.time = { at = [0.5, 0.5], of = \"pressure\" }", "time", "probes.time"),
        ("fluxes.divergence = { boundary = \"top\" }", "divergence", "fluxes.divergence"),
        ("fluxes.cfl = { boundary = \"top\" }", "cfl", "fluxes.cfl"),
        (
            "probes = { p = { at = [0.5, 0.5], of = \"velocity\" }, \
             p_x = { at = [0.1, 0.5], of = \"pressure\" } }",
            "p_x",
            "probes.p_x",
        ),
    ] {
        let told = explained(&format!("{SQUARE}{lid}{REST}[output]\n{output}\n"), "");
        let twice = format!("two columns `{twice}`");
        told.expect(2, &[&twice, &format!("output.{key}"), "another name"]);
    }
}

/// 10-four-decimals: lengths of any size have digits.
#[test]
fn lengths_have_digits_at_every_scale() {
    for scale in [1e-6, 1.0, 1e5] {
        let scene = format!(
            "mesh.rectangle = {{ min = [0, 0], max = [{0:e}, {0:e}], cells = [16, 16] }}\n\
             fluid = {{ density = 0, viscosity = 1 }}\nboundary.walls.no_slip = true\n\
             time = {{ end = 0.1, step = 0.05 }}\n[[drop]]\nforce = \"smeared\"\ntension = 1\n\
             shape.circle = {{ centre = [{1:e}, {1:e}], radius = {2:e} }}\n\
             [numerics]\nthickness = {3:e}\n",
            scale,
            0.5 * scale,
            0.3 * scale,
            0.11 * scale
        );
        let told = explained(&scene, "");
        told.expect(0, &[]);
        let of_length = |l: &&str| l.contains("edge") || l.contains("half-width");
        let lines: Vec<&str> = told.stdout.lines().filter(of_length).collect();
        assert!(lines.len() >= 3, "{}", told.stdout);
        let says_nothing = |l: &&str| l.split(' ').any(|word| word.starts_with("0.0000"));
        assert!(!lines.iter().any(says_nothing), "{scale}: {lines:?}");
    }
}

/// 11-mesh-files-taken-for-something-else.
#[test]
fn mesh_files_are_taken_for_what_they_are() {
    let scene = format!("{FILE}{REST}");
    let plain = square(&[], [1, 2, 3, 4]);
    explained(&scene, &format!("\u{feff}{plain}")).expect(0, &[]);
    let first = "$NOD\n1\n1 0 0 0\n$ENDNOD\n$ELM\n0\n$ENDELM\n";
    explained(&scene, first).expect(3, &["version 1", "line 1", "gmsh FILE -save -format msh41"]);
    // What FreeFEM's savemesh writes.
    let saved = "4 2 4\n0 0 1\n1 0 2\n1 1 3\n0 1 4\n1 2 3 0\n1 3 4 0\n1 2 1\n2 3 2\n3 4 3\n4 1 4\n";
    let sides = "[boundary.1]\nno_slip = true\n[boundary.2]\nopen = true\n\
        [boundary.3]\nno_slip = true\n[boundary.4]\nvelocity = [\"y*(1-y)\", 0]\n";
    explained(&format!("{scene}{sides}"), saved).expect(0, &[]);
    for (wrong, said) in [
        (saved.replace("3 4 3\n4 1 4\n", "3 4 3\n"), ["two vertices and the label", "line 11"]),
        (saved.replace("1 3 4 0", "1 3 5 0"), ["a vertex that it does not have", "line 7"]),
        (saved.replace("1 1 3", "1 x 3"), ["x, y and the label", "line 4"]),
    ] {
        explained(&scene, &wrong).expect(3, &[said[0], said[1], "savemesh"]);
    }
}

/// What is written for FreeFEM is read as the same mesh.
#[test]
fn a_mesh_for_freefem_is_read_back() {
    let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [7, 5], Diagonals::UnionJack).unwrap();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("m.msh");
    fs::write(&path, freefem::text(&mesh).unwrap()).unwrap();
    let (read, warnings) = gmsh::read::<2>(&path).unwrap();
    assert_eq!((read.points(), warnings.len()), (mesh.points(), 0));
    assert!((0..mesh.cell_count()).all(|c| read.cell(c) == mesh.cell(c)));
    for (name, label) in freefem::labels(&mesh) {
        let [own, there] = [&mesh, &read].map(|m| m.boundaries().clone());
        let [mut a, mut b] = [own[&name].clone(), there[&label.to_string()].clone()];
        a.sort_unstable();
        b.sort_unstable();
        assert_eq!(a, b, "{name}");
    }
}

/// 12-group-named-like-a-number.
#[test]
fn a_group_named_like_the_number_of_another_is_refused() {
    let scene = format!("{FILE}{REST}");
    explained(&scene, &square(&[(1, "2")], [1, 2, 3, 3]))
        .expect(3, &["number of another one", "group 1 has the name \"2\"", "names of their own"]);
    for names in [&[(1, "2"), (2, "in")][..], &[(1, "1")], &[(1, "7")], &[]] {
        explained(&scene, &square(names, [1, 2, 3, 3])).expect(0, &[]);
    }
}

/// 14-boundary-value-not-finite, M1: at the start and at later steps.
#[test]
fn values_that_are_not_finite_at_some_time_are_refused() {
    let lid = |v: &str| {
        format!(
            "{SQUARE}{REST}[boundary.walls]\nno_slip = true\n[boundary.top]\nvelocity = [\"{v}\", 0]\n"
        )
    };
    explained(&lid("sin(t)/t"), "").expect(2, &["boundary.top.velocity", "t = 0", "finite"]);
    explained(&lid("if(t < 0.4, 1, 1/0)"), "").expect(2, &["boundary.top.velocity", "t = 0.4"]);
    explained(&lid("if(t > 0, sin(t)/t, 1)"), "").expect(0, &[]);
    let fluid = |key: &str, v: &str| {
        let held = if key == "force" { "density = 1\nviscosity = 1\n" } else { "" };
        format!(
            "{SQUARE}[fluid]\n{held}{key} = [\"{v}\", 0]\n[time]\nend = 0.5\nstep = 0.05\n\
             [[level_set]]\nshape.circle = {{ centre = [0.5, 0.5], radius = 0.2 }}\n"
        )
    };
    explained(&fluid("force", "1/(0.25-t)"), "").expect(2, &["fluid.force", "t = 0.25"]);
    let gone = fluid("prescribed_velocity", "sqrt(0.32-t)*y*(1-y)*x*(1-x)");
    explained(&gone, "").expect(2, &["fluid.prescribed_velocity", "t = 0.35"]);
}

/// 15-layer-that-meets-walls.
#[test]
fn a_layer_between_walls_is_told_what_is_missing() {
    let scene = format!(
        "{SQUARE}{REST}[boundary.walls]\nslip = true\n[[drop]]\ntension = 1\n\
         shape.expression = \"y - 0.487\"\n"
    );
    explained(&scene, "")
        .expect(2, &["the interface meets the boundary", "make the sides", "periodic"]);
}

/// 16-gravity-that-nothing-holds.
#[test]
fn gravity_that_nothing_holds_is_told() {
    let scene = |sides: &str, gravity: &str, more: &str| {
        let fluid = format!("[fluid]\ndensity = 1\nviscosity = 1\ngravity = {gravity}\n{more}");
        format!("{SQUARE}{fluid}[time]\nend = 0.5\nstep = 0.05\n{sides}")
    };
    let periodic = "[boundary.right]\nperiodic = \"left\"\n[boundary.top]\nperiodic = \"bottom\"\n";
    let open = "[boundary.right]\nopen = true\n[boundary.walls]\nno_slip = true\n";
    let said = |sides: &str, gravity: &str, more: &str| {
        let told = explained(&scene(sides, gravity, more), "");
        told.expect(0, &[]);
        told.stdout
    };
    assert!(said(periodic, "[0, -1]", "").contains("warning: all sides are periodic"));
    assert!(said(open, "[0, -1]", "").contains("gravity acts along the open side boundary.right"));
    for (sides, gravity, more) in [
        (open, "[0, -1]", "boussinesq = true\n"),
        (open, "[-1, 0]", ""),
        (open, "[0, 0]", ""),
        ("", "[0, -1]", ""),
    ] {
        assert!(!said(sides, gravity, more).contains("warning"), "{gravity} {more}");
    }
}

/// 17-two-conditions-on-one-side.
#[test]
fn two_conditions_on_one_side_are_told() {
    let mesh = square(&[(1, "low"), (2, "out"), (3, "high"), (4, "in")], [1, 2, 3, 4])
        .replace("6\n1 1 2 1", "8\n7 1 2 5 1 1 2\n8 1 2 5 4 4 1\n1 1 2 1");
    let mesh = mesh.replace("$PhysicalNames\n4\n", "$PhysicalNames\n5\n1 5 \"wet\"\n");
    let scene = format!(
        "{FILE}{REST}[boundary.in]\nvelocity = [\"y*(1-y)\", 0]\n[boundary.wet]\nno_slip = true\n\
         [boundary.out]\nopen = true\n[boundary.high]\nno_slip = true\n[boundary.low]\nslip = true\n"
    );
    let told = explained(&scene, &mesh);
    told.expect(0, &[]);
    for pair in ["boundary.in and boundary.wet", "boundary.wet and boundary.low"] {
        assert!(told.stdout.contains(&format!("warning: {pair}")), "{}", told.stdout);
    }
    assert!(told.stdout.contains("that of boundary.in applies there"), "{}", told.stdout);
    let same = scene.replace("[boundary.low]\nslip", "[boundary.low]\nno_slip");
    assert!(!explained(&same, &mesh).stdout.contains("boundary.low applies"));
}

/// 18-slit-called-walls: two squares that have no point in common.
#[test]
fn a_slit_is_not_called_walls() {
    let mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 1 \"side\"\n\
        $EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 1 1 0\n6 2 0 0\n\
        7 2 1 0\n8 1 0.5 0\n$EndNodes\n$Elements\n11\n\
        1 1 2 1 1 1 2\n2 1 2 1 1 3 4\n3 1 2 1 1 4 1\n4 1 2 1 1 2 6\n5 1 2 1 1 6 7\n6 1 2 1 1 7 5\n\
        7 2 2 9 1 1 8 4\n8 2 2 9 1 1 2 8\n9 2 2 9 1 4 8 3\n10 2 2 9 1 2 6 8\n11 2 2 9 1 6 7 8\n";
    let mesh = mesh.replace("$Elements\n11", "$Elements\n12").to_string()
        + "12 2 2 9 1 8 7 5\n$EndElements\n";
    let told = explained(&format!("{FILE}{REST}[boundary.side]\nno_slip = true\n"), &mesh);
    told.expect(2, &["no side but a slit", "stand at the place of another", "Coherence Mesh"]);
}

/// H1: a mesh that no machine holds is refused at once.
#[test]
fn meshes_without_bounds_are_refused_before_they_are_made() {
    let scene = |mesh: &str| format!("[mesh]\n{mesh}\n{REST}");
    let ball = "ball_in_box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [4, 4, 4], \
        centre = [0, 0, 0], radius = 0.5, band = 0.1, edge = 1e-99 }";
    explained(&scene(ball), "").expect(2, &["too many cells", "longer edge"]);
    let block = "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [4000, 4000, 4000] }";
    explained(&scene(block), "").expect(2, &["does not fit into the memory", "fewer cells"]);
    let plane = "rectangle = { min = [0, 0], max = [1, 1], cells = [100000, 100000] }";
    explained(&scene(plane), "").expect(2, &["does not fit into the memory", "fewer cells"]);
}

/// 02-backflow-open-side: a vortex that a stream carries out through an open side.
#[test]
fn a_vortex_leaves_through_an_open_side() {
    let scene = r#"
        constants = { r0 = 0.15, A = 20.0 }
        mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [48, 24] }
        boundary.left.velocity = [0.5, 0]
        boundary.right.open = true
        boundary.walls.slip = true
        time = { end = 2, step = 0.01 }
        output = { every = 0.1, fields = false, pictures = false, checkpoint = false }
        [fluid]
        density = 1
        viscosity = 1e-3
        initial_velocity = [
            "0.5 - A*(y-0.5)*exp(-((x-1.5)^2+(y-0.5)^2)/r0^2)",
            "A*(x-1.5)*exp(-((x-1.5)^2+(y-0.5)^2)/r0^2)",
        ]"#;
    let folder = folder_with(scene);
    let told = immersa(folder.path(), &["run", "scene.toml", "--out", "r"]);
    told.expect(0, &["warning: fluid comes in through boundary.right", "farther away"]);
    assert_eq!(told.stderr.matches("warning: fluid comes in").count(), 1, "{}", told.stderr);
    // The vortex has left: what remains is the stream, of speed .5 and energy .25.
    let [energy, speed] =
        ["energy_kinetic", "velocity_max"].map(|name| column(&folder.path().join("r"), name));
    assert!(energy.windows(2).all(|e| e[1] < e[0] + 1e-4), "{energy:?}");
    assert!((energy.last().unwrap() - 0.25).abs() < 2e-3, "{energy:?}");
    assert!(speed.iter().all(|v| *v < 1.8) && *speed.last().unwrap() < 0.7, "{speed:?}");
}

/// W8: a rotating fluid with an open side at the edge of the vortex.
#[test]
fn a_vortex_at_an_open_side_dies_out() {
    let scene = "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [16, 16] }
        fluid = { viscosity = 1e-4, initial_velocity = [\"20*y-10\", \"-20*(x-0.9)\"] }
        boundary = { right.open = true, walls.slip = true }
        time = { end = 1, step = 0.01 }
        output = { every = 0.1, pictures = false, fields = false, checkpoint = false }";
    let folder = folder_with(scene);
    let told = immersa(folder.path(), &["run", "scene.toml", "--out", "r"]);
    told.expect(0, &["fluid comes in through boundary.right"]);
    let energy = column(&folder.path().join("r"), "energy_kinetic");
    assert!(energy.windows(2).all(|e| e[1] < e[0]), "{energy:?}");
    assert!(energy.last().unwrap() / energy[0] < 0.01, "{energy:?}");
}

/// 05-moment-at-periodic-side: Couette flow, which the spaces have, between periodic sides and
/// between sides that move with it and pull too.
#[test]
fn moments_on_walls_that_end_at_periodic_sides_are_exact() {
    let rest = "fluid = { density = 0, viscosity = 0.7 }
        time = { end = 0.1, step = 0.05 }
        output.fields = false\noutput.pictures = false\noutput.checkpoint = false
        boundary.bottom.no_slip = true";
    let plane = "mesh.rectangle = { min = [0, 0], max = [2, 1], cells = [5, 4] }
        boundary.top.velocity = [3, 0]
        output.forces.top = { boundary = \"top\", about = [0, 0] }
        output.forces.bottom = { boundary = \"bottom\", about = [0, 0] }";
    let space = "mesh.box = { min = [0, 0, 0], max = [2, 1, 1], cells = [3, 2, 2] }
        boundary.top.velocity = [3, 0, 0]
        boundary.back.periodic = \"front\"
        output.forces.top = { boundary = \"top\", about = [0, 0, 0] }
        output.forces.bottom = { boundary = \"bottom\", about = [0, 0, 0] }";
    let [periodic, moving] = [
        "boundary.right.periodic = \"left\"",
        "boundary.right.velocity = [\"3*y\", 0]\nboundary.left.velocity = [\"3*y\", 0]",
    ];
    for (scene, sides, axis) in
        [(plane, periodic, ""), (plane, moving, ""), (space, periodic, "_z")]
    {
        let folder = folder_with(&format!("{scene}\n{sides}\n{rest}"));
        immersa(folder.path(), &["run", "scene.toml", "--out", "r"]).expect(0, &[]);
        let moments = ["top", "bottom"].map(|wall| {
            *column(&folder.path().join("r"), &format!("{wall}_moment{axis}")).last().unwrap()
        });
        let error = (moments[0] - 4.2).abs().max(moments[1].abs());
        assert!(error < 1e-9, "{sides}: {moments:?}");
    }
}

/// 19-advice-that-is-refused: what the alarm says of a disc that turns in a square can be done,
/// and helps.
#[test]
fn the_advice_for_a_slotted_disc_is_taken_and_helps() {
    let scene = r#"
        constants.w = 6.283185307179586
        mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [24, 24] }
        fluid.prescribed_velocity = ["w*(0.5-y)", "w*(x-0.5)"]
        time = { end = 1, step = 0.02 }
        numerics.transport = "projected"
        output = { every = 0.1, fields = false, pictures = false, checkpoint = false }
        [[level_set]]
        name = "disc"
        shape.expression = "max(hypot(x-0.5,y-0.75)-0.15, min(min(0.025-abs(x-0.5), 2), 0.85-y))""#;
    let folder = folder_with(scene);
    let change = |more: &[&str], out: &str| {
        let told = immersa(folder.path(), &[&["run", "scene.toml", "--out", out], more].concat());
        told.expect(0, &[]);
        let area = column(&folder.path().join(out), "disc.area");
        (told.stderr, (area.last().unwrap() / area[0] - 1.0).abs())
    };
    let (said, first) = change(&[], "first");
    let alarm = said.lines().find(|l| l.contains("ALARM")).unwrap();
    assert!(alarm.contains("numerics.transport = \"nodal\"") && !alarm.contains("composed"));
    assert!(alarm.contains("numerics.redistance = { method = \"exact\", volume = true }"));
    let (_, nodal) = change(&["--set", "numerics.transport=\"nodal\""], "nodal");
    let redistance = "numerics.redistance={ method = \"exact\", volume = true }";
    let (_, kept) = change(&["--set", "numerics.transport=\"nodal\"", "--set", redistance], "kept");
    assert!(first > 1.0 && nodal < 0.3 && kept < 0.05, "{first} {nodal} {kept}");
}

/// The shell of fine cells about a ball holds the band, and a band that it does not hold is told
/// which key to change; the default thickness is that of the fine cells.
#[test]
fn a_band_beyond_the_fine_cells_of_a_ball_names_the_shell() {
    let scene = |band: &str, more: &str| {
        format!(
            "mesh.ball_in_box = {{ min = [-4, -4, -4], max = [4, 4, 4], cells = [4, 4, 4], \
             centre = [0, 0, 0], radius = 1, edge = 0.35{band} }}\n\
             fluid = {{ density = 0, viscosity = 1 }}\nboundary.walls.no_slip = true\n\
             time = {{ end = 0.1, step = 0.05 }}\n[[drop]]\ntension = 1\nforce = \"smeared\"\n\
             shape.sphere = {{ centre = [0, 0, 0], radius = 1 }}\n[numerics]\n{more}"
        )
    };
    let told = |band: &str, more: &str| explained(&scene(band, more), "");
    let fits = told("", "");
    fits.expect(0, &[]);
    assert!(!fits.stderr.contains("barely"), "{}", fits.stderr);
    let words = "mesh.ball_in_box.band = ";
    let narrow = told(", band = 0.1", "thickness = 0.875");
    assert!(narrow.stderr.contains(words), "{}", narrow.stderr);
    let advised: String = narrow
        .stderr
        .split(words)
        .nth(1)
        .unwrap()
        .chars()
        .take_while(|c| c.is_ascii_digit() || *c == '.')
        .collect();
    let wide = told(&format!(", band = {advised}"), "thickness = 0.875");
    wide.expect(0, &[]);
    assert!(!wide.stderr.contains(words), "{}", wide.stderr);
}

/// The numbers that characterise a flow are printed with their definitions, where they exist.
#[test]
fn numbers_without_units_are_in_the_plan() {
    let flow = "mesh.rectangle = { min = [-2, -1], max = [2, 1], cells = [32, 16] }
        fluid = { density = 2, viscosity = 0.5 }
        boundary = { top.velocity = [3, 0], bottom.velocity = [-3, 0], right.periodic = \"left\" }
        time = { end = 0.1, step = 0.01 }";
    let drop =
        "[[drop]]\ndensity = 1\nshape.circle = { centre = [0, 0], radius = 0.5 }\ntension = 4";
    let told = explained(&format!("{flow}\n{drop}\n[numerics]\nthickness = 0.3"), "");
    // Re = 2*3*2/.5, G = 6/2, Ca = .5*3*.5/4, We = 2*9*.125/4.
    for words in ["rho U L/mu = 24,", "U = 3.0000 ", "R/tension = 0.188", "R^3/tension = 0.563"] {
        assert!(told.stdout.contains(words), "{words}\n{}{}", told.stdout, told.stderr);
    }
    assert!(!told.stdout.contains("Bo ="), "{}", told.stdout);
    let heavy =
        format!("{flow}\n{drop}").replace("viscosity = 0.5", "viscosity = 0.5, gravity = [0, -8]");
    // Bo = 1*8*.25/4.
    let told = explained(&format!("{heavy}\n[numerics]\nthickness = 0.3"), "");
    assert!(told.stdout.contains("g R^2/tension = 0.5"), "{}{}", told.stdout, told.stderr);
    let rest = "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
        fluid = { density = 1, viscosity = 1 }
        time = { end = 0.1, step = 0.01 }";
    assert!(!explained(rest, "").stdout.contains("Numbers"));
}

/// A mesh whose sides have names, `walls` among them: all parts without a condition are named, and
/// `[boundary.walls]` is not advised for the rest.
#[test]
fn all_parts_of_a_mesh_without_a_condition_are_named() {
    let told = |boundary: &str| {
        let folder = folder_with(&format!("{FILE}{REST}[boundary]\n{boundary}\n"));
        fs::copy("meshes/channel.msh", folder.path().join("m.msh")).unwrap();
        immersa(folder.path(), &["explain", "scene.toml"])
    };
    let all = "add [boundary.inlet], [boundary.outlet], [boundary.cylinder] to the scene";
    told("walls.no_slip = true").expect(2, &[all, "the part of the mesh of this name"]);
    let rest = ["[boundary.cylinder]", "[boundary.outlet]", "[boundary.walls]"];
    told("inlet.open = true").expect(2, &rest);
}
