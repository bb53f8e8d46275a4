//! Broken scenes, through the program: the exit code, and a message with place, value and remedy.

use super::program::folder_with;
use assert_cmd::Command;
use immersa::scene::Scene;
use proptest::prelude::*;
use std::path::Path;

const GOOD: &str = r#"title = "A membrane"
[constants]
R = 0.5
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [20, 20] }
[fluid]
viscosity = 0.01
[boundary.walls]
no_slip = true
[boundary.top]
velocity = ["sin(pi*x)", 0]
[[membrane]]
shape.circle = { centre = [1, 1], radius = 0.5 }
area.linear = { modulus = 1 }
[time]
end = 1
step = 0.1
[output]
every = 0.1
probes.p = { at = [1, 1], of = "pressure" }
"#;

/// A change of the good scene: the text replaced, the new text, and what the message must contain.
type Broken = (&'static str, &'static str, &'static [&'static str]);

const BROKEN: [Broken; 50] = [
    // Keys that do not exist, at each level.
    ("title", "titel", &["scene.toml:1:1", "titel", "did you mean `title`?"]),
    ("[fluid]", "[fluids]", &["scene.toml:6:2", "fluids", "did you mean `fluid`?"]),
    ("viscosity", "viscosty", &["scene.toml:7:1", "fluid.viscosty", "did you mean `viscosity`?"]),
    ("cells =", "cell =", &["mesh.rectangle.cell", "did you mean `cells`?"]),
    ("no_slip", "noslip", &["boundary.walls.noslip", "did you mean `no_slip`?"]),
    ("area.linear", "area.liner", &["membrane.0.area.liner", "did you mean `linear`?"]),
    ("modulus", "lambda", &["membrane.0.area.linear.lambda", "valid keys here: modulus"]),
    ("step", "stop", &["time.stop", "did you mean `step`?"]),
    ("of = ", "off = ", &["output.probes.p.off", "did you mean `of`?"]),
    (
        "[output]",
        "[numerics]\nthikness = 1\n[output]",
        &["numerics.thikness", "did you mean `thickness`?"],
    ),
    // Kinds of values, and units.
    ("0.01", "\"0.01 Pa s\"", &["fluid.viscosity", "0.01 Pa s", "without quotes or units"]),
    ("end = 1", "end = 1 s", &["scene.toml:16:7", "1 s", "not valid TOML", "key = value"]),
    ("[20, 20]", "[20.5, 20]", &["mesh.rectangle.cells.0", "20.5", "whole number", "1 to 100000"]),
    ("no_slip = true", "no_slip = 1", &["boundary.walls.no_slip", "write true or false"]),
    ("no_slip = true", "no_slip = false", &["boundary.walls.no_slip", "can only be true"]),
    ("\"A membrane\"", "7", &["scene.toml:1:9", "title", "in \"quotes\""]),
    ("end = 1", "end = 2026-01-01", &["time.end", "a date", "without quotes"]),
    ("[[membrane]]", "[membrane]", &["membrane", "[[membrane]]"]),
    (
        "[[membrane]]",
        "[boundary]\nleft = \"wall\"\n[[membrane]]",
        &["scene.toml:13:8", "boundary.left", "a table", "[name]"],
    ),
    // Numbers out of range.
    ("0.01", "-0.01", &["scene.toml:7:13", "-0.01", "positive", "> 0"]),
    ("0.01", "0", &["fluid.viscosity", "positive", "> 0"]),
    ("0.01", "nan", &["fluid.viscosity", "nan", "finite"]),
    ("end = 1", "end = inf", &["time.end", "inf", "finite"]),
    ("end = 1", "end = 1e400", &["scene.toml:16:7", "1e400"]),
    ("step = 0.1", "step = 0", &["time.step", "positive", "> 0"]),
    ("step = 0.1", "step = 0.3", &["time.end", "not a multiple", "0.9 and 1.2"]),
    ("step = 0.1", "step = 0.1\norder = 4", &["time.order", "4", "from 1 to 3"]),
    ("[20, 20]", "[0, 20]", &["mesh.rectangle.cells.0", "0", "from 1"]),
    (
        "max = [2, 2]",
        "max = [2, 0]",
        &["mesh.rectangle.max", "[2, 0]", "larger than min", "exchange"],
    ),
    ("radius = 0.5", "radius = -1", &["shape.circle.radius", "-1", "> 0"]),
    ("modulus = 1", "modulus = -1", &["area.linear.modulus", "-1", ">= 0"]),
    ("[fluid]", "[fluid]\ndensity = -1", &["fluid.density", "-1", ">= 0"]),
    // Vectors.
    (
        "centre = [1, 1]",
        "centre = [1, 1, 1]",
        &["shape.circle.centre", "[1, 1, 1]", "3 components", "2"],
    ),
    ("\"sin(pi*x)\", 0", "0", &["boundary.top.velocity", "[0]", "1 component", "2"]),
    ("[fluid]", "[fluid]\ngravity = 9.81", &["fluid.gravity", "9.81", "brackets"]),
    // Exactly one of several.
    (
        "area.linear",
        "shape.polygon = { points = [[0, 0], [1, 0], [0, 1]] }\narea.linear",
        &["polygon", "keep exactly one"],
    ),
    (
        "shape.circle = { centre = [1, 1], radius = 0.5 }\n",
        "",
        &["`shape` is missing", "membrane.0", "shape.circle ="],
    ),
    ("area.linear = { modulus = 1 }\n", "", &["`area` is missing", "area.linear ="]),
    ("viscosity = 0.01\n", "", &["`viscosity` is missing", "fluid.viscosity", "viscosity = 0.01"]),
    (
        "no_slip = true",
        "sticky = true",
        &[
            "boundary.walls.sticky",
            "velocity, no_slip, slip, open, pressure, total_pressure, traction, periodic",
        ],
    ),
    (
        "no_slip = true",
        "no_slip = true\nopen = true",
        &["boundary.walls.open", "beside `no_slip`", "keep exactly one"],
    ),
    (
        "rectangle =",
        "file = \"a.msh\"\nrectangle =",
        &["mesh.rectangle", "beside `file`", "keep exactly one"],
    ),
    // Boundaries and names.
    (
        "velocity = [\"sin(pi*x)\", 0]",
        "periodic = \"top\"",
        &["boundary.top.periodic", "with itself", "pair"],
    ),
    (
        "[output]",
        "[[membrane]]\nshape.circle = { centre = [1, 1], radius = 0.5 }\narea.linear = \
         { modulus = 1 }\n[output]",
        &["two interfaces are named `membrane`", "name of its own"],
    ),
    ("probes.p", "probes.membrane", &["output.probes.membrane", "taken", "name of its own"]),
    ("\"pressure\"", "\"presure\"", &["output.probes.p.of", "presure", "did you mean `pressure`?"]),
    // Expressions.
    (
        "\"sin(pi*x)\"",
        "\"sin(pi*q)\"",
        &["scene.toml:11:21", "`q` is not known", "known names: x, y, z, t, pi, R"],
    ),
    ("\"sin(pi*x)\"", "\"sin(pi*x\"", &["scene.toml:11:17", "never closed", "add `)`"]),
    ("R = 0.5", "R = \"1/0\"", &["constants.R", "no finite value", "division by zero"]),
    // TOML itself.
    ("[time]", "[time", &["scene.toml:15:6", "not valid TOML"]),
];

/// Runs `immersa ARGUMENTS` in a folder; gives the exit code and the standard error.
fn immersa(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_immersa"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

fn assert_message(scene: &[u8], arguments: &[&str], code: i32, parts: &[&str]) {
    let folder = folder_with(scene);
    let (exit, message) = immersa(folder.path(), arguments);
    assert_eq!(exit, code, "{arguments:?}: {message}");
    for part in parts {
        assert!(message.contains(part), "{arguments:?}: `{part}` is missing in\n{message}");
    }
    assert!(message.starts_with("error: "), "{message}");
    assert!(!message.contains("defect") && !message.contains('\u{1b}'), "{message}");
}

#[test]
fn the_scene_that_the_others_break_is_good() {
    let folder = folder_with(GOOD.as_bytes());
    let (code, message) = immersa(folder.path(), &["explain", "scene.toml"]);
    assert_eq!((code, message.as_str()), (0, ""));
}

#[test]
fn broken_scenes_are_refused_with_place_value_and_remedy() {
    for (from, to, parts) in BROKEN {
        assert!(GOOD.contains(from), "{from}");
        let scene = GOOD.replacen(from, to, 1);
        assert_message(scene.as_bytes(), &["explain", "scene.toml"], 2, parts);
        assert_message(
            scene.as_bytes(),
            &["run", "scene.toml"],
            2,
            &["= at: scene.toml:", "= remedy: "],
        );
    }
}

/// What the semi-implicit coupling cannot do is told with the key that asks for it.
#[test]
fn the_semi_implicit_coupling_is_refused_at_order_2_and_without_inertia() {
    let scene = GOOD.replace("[output]", "[numerics]\ncoupling = \"semi-implicit\"\n[output]");
    let explain = ["explain", "scene.toml"];
    let place = "scene.toml:19:12, key numerics.coupling";
    let parts = [
        place,
        "(3.62)-(3.64) is of order 1",
        "order 2",
        "take time.order = 1, or coupling = \"implicit\"",
    ];
    assert_message(scene.as_bytes(), &explain, 2, &parts);
    let first = scene.replace("step = 0.1", "step = 0.1\norder = 1");
    let massless = first
        .replace("viscosity = 0.01", "viscosity = 0.01\ndensity = { inside = 0, outside = 1 }");
    let parts = ["numerics.coupling", "needs inertia", "density 0", "take densities above 0"];
    assert_message(massless.as_bytes(), &explain, 2, &parts);
    let sharp = first.replace("[[membrane]]", "[[membrane]]\nforce = \"sharp\"");
    let parts = [
        "numerics.coupling",
        "a sharp one has none",
        "force = \"smeared\"",
        "coupling = \"implicit\"",
    ];
    assert_message(sharp.as_bytes(), &explain, 2, &parts);
    // Without a membrane there is nothing to couple.
    let fluid = GOOD.split_once("[[membrane]]").zip(scene.split_once("[time]"));
    let fluid = fluid.map(|(head, tail)| format!("{}[time]{}", head.0, tail.1));
    let folder = folder_with(fluid.unwrap_or_default().as_bytes());
    assert_eq!(immersa(folder.path(), &explain), (0, String::new()));
    let folder = folder_with(first.as_bytes());
    assert_eq!(immersa(folder.path(), &explain), (0, String::new()));
}

#[test]
fn the_caret_stands_under_the_wrong_name_of_an_expression() {
    let folder = folder_with(GOOD.replace("sin(pi*x)", "1 + foo*x").as_bytes());
    let (_, message) = immersa(folder.path(), &["explain", "scene.toml"]);
    let lines: Vec<&str> = message.lines().collect();
    let line = lines.iter().position(|l| l.contains("velocity = ")).unwrap();
    let column = lines[line].find("foo").unwrap();
    assert_eq!(lines[line + 1].find("^^^"), Some(column), "{message}");
}

#[test]
fn files_that_are_no_scene_are_refused() {
    let explain = ["explain", "scene.toml"];
    assert_message(
        b"title = \"\xff\xfe\"",
        &explain,
        2,
        &["scene.toml:1:10", "byte 0xff", "UTF-8"],
    );
    assert_message(&[0, 159, 146, 150, 1, 2, 3], &explain, 2, &["UTF-8", "byte 0x9f"]);
    assert_message(
        b"\x00\x01\x02",
        &explain,
        2,
        &["scene.toml:1:4", "not valid TOML", "nothing is written"],
    );
    assert_message(b"", &explain, 2, &["`mesh` is missing", "write [mesh]"]);
    assert_message(b"", &["explain", "no.toml"], 2, &["cannot be read", "no.toml", "immersa new"]);
    assert_message(b"", &["explain", "."], 2, &["cannot be read", "value: .", "immersa new"]);
    let deep = format!("a = {}", "[".repeat(100_000));
    assert_message(deep.as_bytes(), &explain, 2, &["not valid TOML", "recurs"]);
}

#[test]
fn a_mesh_file_that_cannot_be_read_is_an_input_error() {
    let scene = GOOD.replace(
        "rectangle = { min = [0, 0], max = [2, 2], cells = [20, 20] }",
        "file = \"sub/box.msh\"",
    );
    let parts =
        ["scene.toml:5:8", "box.msh", "cannot be read", "relative to the folder of the scene"];
    for command in ["run", "explain"] {
        assert_message(scene.as_bytes(), &[command, "scene.toml"], 3, &parts);
    }
    let folder = scene.replace("sub/box.msh", ".");
    assert_message(folder.as_bytes(), &["run", "scene.toml"], 3, &["cannot be read", "mesh.file"]);
    assert_message(b"", &["render", "."], 2, &["`mesh` is missing"]);
    assert_message(b"", &["render", "nowhere"], 3, &["no scene.toml", "nowhere", "immersa run"]);
}

#[test]
fn wrong_overrides_are_named() {
    for (text, parts) in [
        ("time.step=-1", ["--set time.step=-1, key time.step", "> 0"]),
        ("time.stepp=1", ["--set time.stepp=1", "did you mean `step`?"]),
        ("time.step", ["--set time.step", "write --set key.sub=value"]),
        ("time.step=[1", ["--set time.step=[1", "not valid TOML"]),
        ("membrane.1.stretch=2", ["--set membrane.1.stretch=2", "has 1 entries"]),
        ("boundary.top.velocity=['1+','0']", ["--set boundary.top.velocity", "ends too early"]),
    ] {
        assert_message(GOOD.as_bytes(), &["explain", "scene.toml", "--set", text], 2, &parts);
    }
}

#[test]
fn wrong_command_lines_end_with_code_2() {
    for (arguments, part) in [
        (&["frobnicate"][..], "unrecognized subcommand"),
        (&["run"], "<SCENE>"),
        (&["run", "scene.toml", "--threads", "0"], "--threads"),
        (&["new", "whale"], "cavity, channel, obstacle, membrane"),
        (&["explain", "scene.toml", "--sett", "a=1"], "--set"),
    ] {
        assert_message(GOOD.as_bytes(), arguments, 2, &[part]);
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Scene::parse(&String::from_utf8_lossy(&bytes), Path::new("scene.toml"));
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        prop_assert!(Scene::load(file.path(), &[]).is_err());
    }
}
