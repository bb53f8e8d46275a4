//! Refusals and warnings whose remedies are followed to the letter: what they were about is then
//! gone.

use super::program::*;

const BASE: &str = r#"[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
[fluid]
density = 1
viscosity = 0.1
[boundary.walls]
no_slip = true
[[membrane]]
name = "skin"
shape.circle = { centre = [1, 1], radius = 0.5 }
stretch = 1.2
area.linear = { modulus = 1 }
[time]
end = 1
step = 0.01
"#;

/// What stands between two words of a message.
fn between<'a>(message: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = message.split_once(from).unwrap_or_else(|| panic!("{from}\n{message}"));
    rest.split_once(to).unwrap_or_else(|| panic!("{to}\n{message}")).0
}

/// What a message asks for, as settings of the command line; `with` are those that stay.
type Follow = fn(&str) -> Vec<String>;

/// Changes of the base; words of the message; what it asks for.
const CASES: [(&[&str], &[&str], Follow); 23] = [
    (&["time.step=\"fast\""], &["is text, but must be a number"], |m| {
        vec![format!("time.step={}", between(m, "such as ", "\n"))]
    }),
    (&["fluid.viscosity=-1"], &["must be positive", "give a number > 0"], |_| {
        vec!["fluid.viscosity=1".into()]
    }),
    (
        &["boundary.walls={}", "boundary.top.no_slip=true"],
        &["velocity, no_slip, slip, open, pressure, total_pressure, traction, periodic"],
        |_| vec!["boundary.walls={ no_slip = true }".into()],
    ),
    (&["output.forces.f.boundary=\"lid\""], &["no boundary of this name"], |m| {
        let name = between(m, "names in this mesh: ", ",");
        vec![format!("output.forces.f.boundary=\"{name}\"")]
    }),
    (
        &["membrane.0.force=\"smeared\"", "numerics.thickness=0.05"],
        &["thinner than the mesh allows"],
        |m| vec![format!("numerics.thickness={}", between(m, "set thickness >= ", ","))],
    ),
    (&["membrane.0.force=\"smeared\"", "numerics.thickness=0.2"], &["barely resolved"], |m| {
        vec![format!("numerics.thickness={}", between(m, "set thickness >= ", ","))]
    }),
    (&["membrane.0.shape.circle.centre=[1.75, 1]"], &["does not lie inside the domain"], |m| {
        let by: f64 = between(m, "move or shrink the shape by ", ",").parse().unwrap();
        vec![format!("membrane.0.shape.circle.centre=[{}, 1]", 1.75 - 1.3 * by)]
    }),
    (&["time.step=0.03"], &["not a multiple of the step"], |m| {
        vec![format!("time.end={}", between(m, "the nearest ends are ", " and"))]
    }),
    (&["numerics.coupling=\"semi-implicit\""], &["of order 1 in time"], |m| {
        vec![format!("numerics.coupling={}", between(m, "or coupling = ", "\n"))]
    }),
    (&["numerics.coupling=\"fully-explicit\""], &["remark 1.12 is of order 1"], |m| {
        vec![format!("time.order={}", between(m, "take time.order = ", ","))]
    }),
    (
        &["numerics.coupling=\"explicit\"", "membrane.0.area.linear.modulus=1000"],
        &["of the elastic wave"],
        |m| {
            vec!["time.end=0.06".into(), format!("time.step={}", between(m, "time.step <= ", "\n"))]
        },
    ),
    (&["time.tolerance=1e-3", "time.order=1"], &["flow of order 2"], |m| {
        vec![format!("time.order={}", between(m, "take time.order = ", " "))]
    }),
    (
        &["numerics.solver=\"direct\"", "numerics.memory=1e-6"],
        &["do not fit into the memory"],
        |m| {
            let solver = between(m, "numerics.solver = ", " takes");
            vec![format!("numerics.solver={solver}"), "numerics.memory=1".into()]
        },
    ),
    (&["output.probes.p={ at = [3, 1], of = \"pressure\" }"], &["outside the mesh"], |m| {
        let corner = between(m, "which spans ", " to");
        vec![format!("output.probes.p.at={corner}")]
    }),
    (&["boundary.left.velocity=[1, 0]"], &["more fluid in than out"], |m| {
        assert!(m.contains("set open = true on an outlet"), "{m}");
        vec!["boundary.right.open=true".into()]
    }),
    (&["boundary.top.velocity=[\"sinn(x)\", 0]"], &["`sinn` is not known"], |m| {
        let name = between(m, "did you mean `", "`");
        vec![format!("boundary.top.velocity=[\"{name}(x)\", 0]")]
    }),
    (&["boundary.top.velocity=[\"1/t\", 0]"], &["has no finite value everywhere"], |m| {
        let guarded = between(m, "such as ", "\n").replace("...", "1/t");
        vec![format!("boundary.top.velocity=[\"{guarded}\", 0]")]
    }),
    (
        &["membrane.0.force=\"smeared\"", "numerics.redistance.method=\"exact\""],
        &["redistancing destroys it"],
        |m| vec![format!("membrane.0.force={}", between(m, "take force = ", ","))],
    ),
    (&["membrane.0.shear.linear.modulus=1"], &["shear is for surfaces in space"], |m| {
        vec![
            "membrane.0={ shape.circle = { centre = [1, 1], radius = 0.5 } }".into(),
            format!("membrane.0.{}", between(m, "length alone: ", "\n")),
        ]
    }),
    (&["output.picture.range=[1, 0]"], &["the range of the colours is empty"], |m| {
        vec![format!(
            "output.picture.{}",
            between(m, "lower value first: ", "\n").replace(" = ", "=")
        )]
    }),
    (&["output.picture.field=\"shear\""], &["shows the strain of a surface"], |_| {
        vec!["output.picture.field=\"speed\"".into()]
    }),
    (&["mesh.rectangle.cells=[100000, 100000]"], &["give fewer cells"], |_| {
        vec!["mesh.rectangle.cells=[10, 10]".into()]
    }),
    (&["boundary.left.periodic=\"top\""], &["translates of each other"], |_| {
        vec!["boundary.left.periodic=\"right\"".into()]
    }),
];

#[test]
fn remedies_work_when_they_are_followed() {
    let folder = folder_with(BASE);
    let told = |settings: &[String]| {
        let sets = settings.iter().flat_map(|s| ["--set", s]);
        let arguments: Vec<&str> = ["explain", "scene.toml"].into_iter().chain(sets).collect();
        let ended = immersa(folder.path(), &arguments);
        (ended.code, format!("{}\n{}\n", ended.stderr, ended.stdout))
    };
    for (changes, words, follow) in CASES {
        let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
        let (_, message) = told(&changes);
        assert!(words.iter().all(|w| message.contains(w)), "{changes:?}: {words:?}\n{message}");
        let (code, after) = told(&[changes.clone(), follow(&message)].concat());
        assert_eq!(code, 0, "{changes:?} with {:?}\n{after}", follow(&message));
        assert!(!after.contains(words[0]), "{changes:?}: {words:?}\n{after}");
    }
}

/// Remedies that ask for another text.
#[test]
fn misspelled_keys_and_signs_are_put_right_as_the_message_says() {
    let told = |text: &str| immersa(folder_with(text).path(), &["explain", "scene.toml"]);
    for (right, wrong) in [("viscosity", "viscosty"), ("radius", "raduis"), ("stretch", "strech")] {
        let text = BASE.replace(right, wrong);
        let message = told(&text).stderr;
        let meant = between(&message, "did you mean `", "`");
        told(&text.replace(wrong, meant)).expect(0, &[]);
    }
    let circle = "shape.circle = { centre = [1, 1], radius = 0.5 }";
    let inside_out = BASE.replace(circle, "shape.expression = \"0.5 - hypot(x-1, y-1)\"");
    told(&inside_out).expect(2, &["inside out", "change the sign of shape.expression"]);
    told(&inside_out.replace("\"0.5 - hypot(x-1, y-1)\"", "\"-(0.5 - hypot(x-1, y-1))\""))
        .expect(0, &[]);
    let bare = BASE.replace("[boundary.walls]", "[boundary.top]");
    let told_of_rest = told(&bare);
    told_of_rest.expect(2, &["has no condition", "[boundary.walls] no_slip = true"]);
    told(&format!("{bare}[boundary.walls]\nno_slip = true\n")).expect(0, &[]);
}
