use super::*;
use crate::base::Kind;
use crate::elastic::AreaLaw;
use crate::scene::schema::Contrast;
use crate::sim::Coupling;
use proptest::prelude::*;
use schema::*;

mod reference;
pub(crate) mod spring;

/// The membrane number `k` of a scene.
fn membrane(scene: &Scene, k: usize) -> &structures::Membrane {
    scene.structures()[k].as_any().downcast_ref().unwrap()
}

const MEMBRANE: &str = r#"
title = "Relaxing elliptical membrane"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [60, 60] }
[fluid]
viscosity = 0.01
[boundary.walls]
velocity = [0, 0]
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
stretch = 1.2625316
area.linear = { modulus = 10.0 }
chords = { horizontal = { through = [1, 1], direction = [1, 0] } }
[time]
end = 1
step = 5e-3
[output]
every = 0.02
"#;

/// A scene without defaults.
const FULL: &str = r#"
title = "All \"keys\""
units = "SI"
[constants]
R = 0.5
U = "2*R"
[mesh]
file = "meshes/a box.msh"
[fluid]
density = { inside = 0, outside = 2 }
viscosity = { inside = 0.5, outside = 1e-3 }
gravity = [0, -9.81]
force = ["sin(pi*x)*U", 0]
initial_velocity = ["y*(1-y)", 0.25]
[boundary.left]
velocity = ["U*y*(1 - y)*min(t, 1)", 0]
[boundary.right]
open = true
[boundary."top side"]
periodic = "bottom"
[boundary.walls]
no_slip = true
[boundary.cylinder]
slip = true
[[membrane]]
name = "cell"
shape.union = [
    { circle = { centre = [1, 1], radius = 0.5 } },
    { ellipse = { centre = [1, 1], semi_axes = [1, 2], angle = 30 } },
    { rounded_box = { centre = [1, 1], half_size = [1, 2], radius = 0.1, angle = -30 } },
    { polygon = { points = [[0, 0], [1, 0], [0, 1]] } },
    { expression = 'hypot(x, y) - R' },
]
stretch = 1.1
area.one_sided = { modulus = 3 }
mass = 0.125
chords.a = { through = [1, 1], direction = [1, 1] }
chords.b = { through = [1, 1], direction = [1, -1] }
[time]
end = 0.3
step = 0.1
order = 1
[numerics]
thickness = 0.1
grad_div = 1
transport = "nodal"
coupling = "explicit"
convection = false
quadrature = 5
[output]
every = 0.2
fields = false
pictures = 0.1
film = false
checkpoint = false
probes.p = { at = [1, 1], of = "level_set" }
profiles.line = { from = [0, 1], to = [2, 1], points = 11, of = "velocity", times = [0, 0.1] }
forces.drag = { boundary = "cylinder", about = [1, 0] }
forces.lift = { boundary = "cylinder" }
fluxes.out = { boundary = "right" }
picture = { field = "stretch", mesh = true, size = 300 }
"#;

fn parse(text: &str) -> Result<Scene> {
    Scene::parse(text, Path::new("case/scene.toml"))
}

fn with(overrides: &[&str]) -> Result<Scene> {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Scene::parse_with(MEMBRANE, Path::new("case/scene.toml"), &overrides)
}

#[test]
fn the_book_s_membrane_reads_with_its_defaults() {
    let s = parse(MEMBRANE).unwrap();
    assert_eq!(s.title, "Relaxing elliptical membrane");
    assert_eq!((s.dimension(), s.name().as_str()), (2, "case"));
    assert_eq!(s.fluid.density, Contrast::uniform(1.0));
    assert!(s.has_inertia() && !s.fluid.has_force());
    assert_eq!((s.time.steps(), s.time.order), (200, 2));
    let m = membrane(&s, 0);
    assert_eq!((m.name.as_str(), m.stretch, m.mass), ("membrane", 1.2625316, 0.0));
    assert_eq!(
        m.shape,
        Shape::Ellipse(Ellipse { centre: [1.0, 1.0], semi_axes: [0.75, 0.5], angle: 0.0 })
    );
    assert_eq!(m.area(), AreaLaw::Linear { modulus: 10.0 });
    assert_eq!(m.chords[0].direction, [1.0, 0.0]);
    assert_eq!((s.numerics.thickness, s.numerics.coupling), (None, Coupling::Implicit));
    assert_eq!((s.output.every, s.output.fields, s.output.film), (0.02, Some(0.1), true));
}

#[test]
fn a_scene_without_boundaries_has_walls_that_hold_the_fluid() {
    let s = with(&["boundary.walls={no_slip=true}"]).unwrap();
    let text = MEMBRANE.replace("[boundary.walls]\nvelocity = [0, 0]\n", "");
    assert_ne!(text, MEMBRANE);
    assert_eq!(parse(&text).unwrap().boundaries, s.boundaries);
}

#[test]
fn a_resolved_scene_reads_as_the_same_scene_from_anywhere() {
    for text in [MEMBRANE, FULL] {
        let scene = parse(text).unwrap();
        let written = scene.to_toml();
        let again = Scene::parse(&written, Path::new("runs/x/scene.toml"))
            .unwrap_or_else(|e| panic!("{e}\n{written}"));
        assert_eq!(again, scene, "{written}");
        assert_eq!(again.to_toml(), written);
    }
}

#[test]
fn a_resolved_scene_names_every_key() {
    let written = parse(MEMBRANE).unwrap().to_toml();
    for line in FULL.lines().filter(|l| !l.trim_start().starts_with('{')) {
        let Some((key, _)) = line.split_once(" = ") else { continue };
        let optional = ["file", "R", "U", "slip", "open", "periodic", "no_slip"].contains(&key);
        if !optional && !key.contains('.') {
            assert!(
                written.lines().any(|l| l.starts_with(&format!("{key} = "))),
                "{key} is missing in\n{written}"
            );
        }
    }
}

#[test]
fn everything_written_is_read() {
    let s = parse(FULL).unwrap();
    assert_eq!(s.title, "All \"keys\"");
    assert_eq!(s.constants["U"], 1.0);
    assert_eq!(s.fluid.density, Contrast { inside: 0.0, outside: 2.0 });
    assert_eq!(s.fluid.force[0].eval([0.5, 0.0, 0.0], 0.0), 1.0);
    assert_eq!(s.boundaries[2].condition, Condition::Periodic("bottom".into()));
    assert!(matches!(&membrane(&s, 0).shape, Shape::Union(parts) if parts.len() == 5));
    assert!(
        matches!(&s.mesh, MeshSource::File { path: p, .. } if p.is_absolute() && p.ends_with("case/meshes/a box.msh"))
    );
    assert_eq!(s.output.profiles[0].times, [0.0, 0.1]);
    assert_eq!(s.output.forces[0].about.as_deref(), Some(&[1.0, 0.0][..]));
    assert_eq!((s.numerics.convection, s.numerics.quadrature), (Some(None), Some(5)));
    assert_eq!(s.check_files().unwrap_err().kind(), Kind::Input);
}

#[test]
fn a_box_makes_vectors_of_three_components() {
    let text = "[mesh]\nbox = { min = [0, 0, 0], max = [1, 1, 2], cells = [2, 2, 4] }\n\
                [fluid]\nviscosity = 1\ngravity = [0, 0, -1]\n[time]\nend = 1\nstep = 1\n";
    let s = parse(text).unwrap();
    assert_eq!((s.dimension(), s.fluid.initial_velocity.len()), (3, 3));
    assert_eq!(parse(&s.to_toml()).unwrap(), s);
    assert!(parse(&text.replace("[0, 0, -1]", "[0, -1]")).unwrap_err().what().contains("needs 3"));
}

#[test]
fn a_ball_in_a_box_is_read_and_made() {
    let text = "[mesh]\nball_in_box = \
        { min = [-1, -1, -1], max = [1, 1, 1], cells = [2, 2, 2], centre = [0, 0, 0], radius = 0.5, band = 0.1, edge = 0.5 }\n[fluid]\nviscosity = 1\n[time]\nend = 1\nstep = 1\n";
    let s = parse(text).unwrap();
    assert_eq!((s.dimension(), parse(&s.to_toml()).unwrap()), (3, s.clone()));
    let mesh = s.mesh.generated().unwrap().unwrap();
    assert!((49..384).contains(&mesh.cell_count()) && mesh.boundary("front").is_ok());
    for (key, part) in
        [("edge = 0.5", ".edge`"), ("radius = 0.5", ".radius`"), ("band = 0.1", ".band`")]
    {
        let name = key.split(' ').next().unwrap();
        assert!(
            parse(&text.replace(key, &format!("{name} = 0")))
                .unwrap_err()
                .to_string()
                .contains(part),
            "{key}"
        );
    }
}

#[test]
fn overrides_replace_add_and_reach_into_lists() {
    let s = with(&[
        "membrane.0.stretch=1.1",
        "mesh.rectangle.cells=[8, 9]",
        "output.probes.p={ at = [1, 1], of = 'pressure' }",
        "numerics.coupling = explicit",
        "title=a short one",
        "fluid.initial_velocity=['-x', 0]",
        "fluid.initial_velocity.0=x^2",
    ])
    .unwrap();
    assert_eq!(membrane(&s, 0).stretch, 1.1);
    assert!(matches!(s.mesh, MeshSource::Rectangle(Rectangle { cells: [8, 9], .. })));
    assert_eq!((s.numerics.coupling, s.title.as_str()), (Coupling::Explicit, "a short one"));
    assert_eq!(s.output.probes[0].of, Quantity::Pressure);
    assert_eq!(s.fluid.initial_velocity[0].eval([3.0, 0.0, 0.0], 0.0), 9.0);
}

#[test]
fn a_wrong_override_is_named() {
    for (text, part) in [
        ("time.step", "needs a key and a value"),
        ("=1", "is empty"),
        ("time..step=1", "is empty"),
        ("time.step=", "has no value"),
        ("time.step=[1", "not valid TOML"),
        ("time.step=-1", "must be positive"),
        ("time.stop=1", "did you mean `step`?"),
        ("time.step=0.1s", "is text, but must be a number"),
        ("membrane.3.stretch=1", "has 1 entries"),
        ("title.x=1", "inside text"),
        ("fluid.viscosity={inside=1, outsid=2}", "did you mean `outside`?"),
    ] {
        let e = with(&[text]).unwrap_err();
        let shown = e.to_string();
        assert!(
            shown.contains(part) && shown.contains(&format!("--set {text}")),
            "{text}: {shown}"
        );
        assert_eq!(e.kind(), Kind::Scene);
    }
}

/// The underlined part of the source in an error.
fn underlined(e: &Error) -> &str {
    let s = e.source_snippet().unwrap();
    &s.source[s.span.clone()]
}

#[test]
fn errors_underline_what_is_wrong() {
    for (from, to, mark) in [
        ("viscosity = 0.01", "viscosity = -1", "-1"),
        ("viscosity = 0.01", "viscosty = 1", "viscosty"),
        ("viscosity = 0.01", "density = 1", "fluid"),
        ("velocity = [0, 0]", "velocity = [0, \"sin(q)\"]", "q"),
        ("velocity = [0, 0]", "velocity = [0, \"1 + \\u0071\"]", "\"1 + \\u0071\""),
        ("velocity = [0, 0]", "velocity = [0, '''\n1 + q''']", "q"),
        ("velocity = [0, 0]", "", "walls"),
        ("velocity = [0, 0]", "slip = true\nopen = true", "open"),
        ("area.linear = { modulus = 10.0 }", "", "[[membrane]]"),
        ("area.linear = { modulus = 10.0 }", "area.linear = { modulos = 1 }", "modulos"),
        ("area.linear = { modulus = 10.0 }", "area.linear = {}", "linear"),
        ("semi_axes = [0.75, 0.5]", "semi_axes = [0.75, nan]", "nan"),
        ("semi_axes = [0.75, 0.5]", "semi_axes = [0.75]", "[0.75]"),
        ("[time]", "[tme]", "tme"),
    ] {
        let text = MEMBRANE.replacen(from, to, 1);
        assert_ne!(text, MEMBRANE);
        let e = parse(&text).unwrap_err();
        assert_eq!(underlined(&e), mark, "{e}");
        assert!(
            !e.place().is_empty() && !e.wrong_value().is_empty() && !e.advice().is_empty(),
            "{e}"
        );
    }
}

#[test]
fn an_end_that_no_step_meets_names_the_nearest_ones() {
    let e = with(&["time.step=0.3"]).unwrap_err();
    assert!(e.advice().contains("0.9 and 1.2"), "{e}");
    assert_eq!(with(&["time.step=0.1"]).unwrap().time.steps(), 10);
    assert!(with(&["time.step=1e-12"]).unwrap_err().what().contains("too many"));
}

#[test]
fn a_later_error_can_be_placed_in_the_scene() {
    let s = parse(MEMBRANE).unwrap();
    let e = s.blame(&["boundary", "walls"], Error::scene("no such boundary").value("walls"));
    assert_eq!((underlined(&e), e.place()), ("walls", "case/scene.toml:7:11, key boundary.walls"));
    let e = s.blame(&["membrane", "0", "stretch"], Error::scene("x"));
    assert_eq!(underlined(&e), "1.2625316");
    assert_eq!(underlined(&s.blame(&["numerics", "thickness"], Error::scene("x"))), "");
}

#[test]
fn steps_are_found_from_times() {
    let t = Time { end: 0.3, step: 0.1, order: 2, tolerance: None, step_min: None, step_max: None };
    assert_eq!([0.0, 0.1, 0.15, 0.1 + 0.2, 0.3].map(|x| t.step_at(x)), [0, 1, 2, 3, 3]);
}

proptest! {
    #[test]
    fn arbitrary_text_never_panics(text in ".*") {
        let _ = parse(&text);
        let _ = with(&[&text]);
    }

    /// Cut, doubled and swapped parts of a valid scene reach deeper into the reader than random
    /// text.
    #[test]
    fn shuffled_scenes_never_panic(cuts in prop::collection::vec((0..FULL.len(), 1..40usize, 0..FULL.len()), 1..6)) {
        let mut text = FULL.to_string();
        for (from, length, to) in cuts {
            let part: String = FULL.chars().skip(from).take(length).collect();
            let at = to.min(text.len());
            let end = (at + length / 2).min(text.len());
            text.replace_range(at..end, &part);
        }
        if let Err(e) = parse(&text) {
            let s = e.source_snippet().unwrap();
            prop_assert!(s.source.get(s.span.clone()).is_some());
            prop_assert!(!e.advice().is_empty() && !e.place().is_empty());
        }
    }

    #[test]
    fn a_scene_reads_back_whatever_its_numbers(v in prop::collection::vec(1e-9..1e9f64, 4), name in "[a-zA-Z\"\\\\ é\n]*") {
        let text = format!(
            "title = {}\n[mesh]\ndisc = {{ centre = [{:?}, {:?}], radius = {:?}, cells = 3 \
                }}\n[fluid]\nviscosity = {:?}\n\
             [boundary.{}]\nslip = true\n[time]\nend = 1\nstep = 1\n",
            toml::Value::from(name.as_str()), v[0], v[1], v[2], v[3],
            serde_json::Value::from(name.as_str()),
        );
        let scene = parse(&text).unwrap();
        prop_assert_eq!(&scene.title, &name);
        prop_assert_eq!(parse(&scene.to_toml()).unwrap(), scene);
    }
}
