//! Consistency of the reference of the scene format with reading and writing.

use super::*;
use crate::scene::keys::{Absent, Keys, Kind};
use crate::scene::structures::{KINDS, Registered};
use std::collections::BTreeSet;

/// Checks that `keys` describe the table `written`; records the path of each key with a stated
/// default that is written.
fn described(
    written: &toml::Table,
    keys: &'static Keys,
    path: &str,
    check_defaults: bool,
    seen: &mut BTreeSet<String>,
) {
    for (name, value) in written {
        let path = format!("{path}.{name}");
        let key = keys.get(name).unwrap_or_else(|| panic!("{path} is not in the reference"));
        let stated = match key.absent {
            Absent::Default(value) => Some(value),
            Absent::Auto => Some("\"auto\""),
            _ => None,
        };
        if let (Some(stated), true) = (stated, check_defaults) {
            let number = |text: &str| text.parse::<f64>().ok();
            let same = number(stated).is_some_and(|v| number(&value.to_string()) == Some(v));
            // A default vector of the plane is extended to space with its last component.
            let vector = stated
                .strip_suffix("]")
                .and_then(|v| Some(format!("{v}, {}]", v.rsplit_once(", ")?.1)));
            let same = same
                || value.to_string() == stated
                || vector.is_some_and(|v| v == value.to_string());
            assert!(same, "default of {path}: {value}, said to be {stated}");
            seen.insert(path.clone());
        }
        match (key.kind, value) {
            (Kind::Named(inner), toml::Value::Table(tables)) => {
                let tables = tables.values().map(|t| t.as_table().unwrap());
                tables.for_each(|t| described(t, inner, &path, check_defaults, seen));
            }
            (Kind::List(inner), toml::Value::Array(tables)) => {
                let tables = tables.iter().map(|t| t.as_table().unwrap());
                tables.for_each(|t| described(t, inner, &path, check_defaults, seen));
            }
            (Kind::Table(inner) | Kind::Either(_, _, inner), toml::Value::Table(table)) => {
                described(table, inner, &path, check_defaults, seen);
            }
            _ => (),
        }
    }
}

/// All keys in `keys` with a stated default.
fn stated(keys: &'static Keys, path: &str, all: &mut BTreeSet<String>) {
    for key in keys.keys {
        let path = format!("{path}.{}", key.name);
        if matches!(key.absent, Absent::Default(_) | Absent::Auto) {
            all.insert(path.clone());
        }
        if let Some(inner) = key.kind.keys() {
            stated(inner, &path, all);
        }
    }
}

/// Required keys only, so that all defaults are used.
const BARE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [60, 60] }
[fluid]
viscosity = 1
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
area.tension = { tension = 1 }
[[level_set]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
[time]
end = 1
step = 0.1
[output]
profiles.line = { from = [0, 1], to = [2, 1], of = "velocity" }
"#;

/// The same in space.
const SOLID: &str = r#"
[mesh]
box = { min = [0, 0, 0], max = [2, 2, 2], cells = [6, 6, 6] }
[fluid]
viscosity = 1
[[membrane]]
shape.ellipsoid = { centre = [1, 1, 1], semi_axes = [0.75, 0.5, 0.5] }
area.linear = { modulus = 1 }
shear.linear = { modulus = 1 }
rings.equator = { centre = [1, 1, 1], normal = [0, 0, 1] }
[[level_set]]
shape.ellipsoid = { centre = [1, 1, 1], semi_axes = [0.75, 0.5, 0.5] }
[time]
end = 1
step = 0.1
"#;

/// The same with an image, which is not read if there is a mesh.
const IMAGE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [60, 60] }
[image]
file = "image.png"
length = 1
[[level_set]]
shape.circle = { centre = [1, 1], radius = 0.5 }
[time]
end = 1
step = 0.1
"#;

/// A scene with a structure of another kind in place of its membrane.
fn with_kind(text: &str, kind: &Registered) -> String {
    let of_membranes = ["area.tension", "area.linear", "shear.linear"];
    let other = |line: &&str| {
        of_membranes.iter().any(|key| line.starts_with(key))
            || (line.starts_with("rings") && kind.keys.get("rings").is_none())
    };
    let kept = text.lines().filter(|line| !other(line)).collect::<Vec<_>>().join("\n");
    let example =
        (kind.example)(if text.contains("box = {") && !text.contains("rectangle") { 3 } else { 2 });
    kept.replacen("[[membrane]]\n", &format!("[[{}]]\n{example}\n", kind.list), 1)
}

#[test]
fn the_reference_describes_what_is_written_and_states_the_defaults() {
    let mut seen = BTreeSet::new();
    let box_shape = "shape.rounded_box = { centre = [1, 1], half_size = [1, 2], radius = 0.1 }";
    let rounded =
        BARE.replace("shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }", box_shape);
    let file = BARE.replace(
        "rectangle = { min = [0, 0], max = [2, 2], cells = [60, 60] }",
        "file = \"box.msh\"",
    );
    let adapted = BARE.replace(
        "[fluid]",
        "[mesh.adapt]\nevery = 0.1\nedge = 0.01\nfields = [\"velocity\"]\n[fluid]",
    );
    let ellipsoid = "shape.ellipsoid = { centre = [1, 1, 1], semi_axes = [0.75, 0.5, 0.5] }";
    let ellipse = "shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }";
    let oval = "shape.oval = { centre = [1, 1], radius = 0.6, reduced_area = 0.9 }";
    let oval = BARE.replace(ellipse, oval);
    let spheroid = "shape.spheroid = { centre = [1, 1, 1], radius = 0.6, reduced_volume = 0.9 }";
    let spheroid = SOLID.replace(ellipsoid, spheroid);
    let torus =
        SOLID.replace(ellipsoid, "shape.torus = { centre = [1, 1, 1], major = 0.5, minor = 0.2 }");
    let block = SOLID.replace(
        ellipsoid,
        "shape.rounded_box = { centre = [1, 1, 1], half_size = [1, 2, 1], radius = 0.1 }",
    );
    let redistanced = format!("{BARE}[numerics.redistance]\nmethod = \"exact\"\n");
    // A key of the band gives a band.
    let banded = SOLID.replace("rings", "area_change = \"slope\"\nrings");
    let bare = [
        BARE,
        &oval,
        &rounded,
        &file,
        &adapted,
        &redistanced,
        SOLID,
        &spheroid,
        &banded,
        &torus,
        &block,
        IMAGE,
    ];
    let others = KINDS.iter().filter(|kind| {
        kind.keys.get("shape").is_some() && !["membrane", "level_set"].contains(&kind.list)
    });
    let shapes = [BARE, &oval, &rounded, SOLID, &spheroid, &torus, &block];
    let others: Vec<String> =
        others.flat_map(|kind| shapes.map(|text| with_kind(text, kind))).collect();
    let bare = bare.into_iter().chain(others.iter().map(String::as_str)).map(|text| (text, true));
    for (text, bare) in [(MEMBRANE, false), (FULL, false)].into_iter().chain(bare) {
        let written: toml::Table = parse(text).unwrap().to_toml().parse().unwrap();
        described(&written, &KEYS, "", bare, &mut seen);
    }
    let mut all = BTreeSet::new();
    stated(&KEYS, "", &mut all);
    assert_eq!(seen, all, "a default that no bare scene shows");
}

#[test]
fn the_reference_has_the_keys_that_reading_allows() {
    let written: toml::Table = parse(FULL).unwrap().to_toml().parse().unwrap();
    let mut tables = vec![(String::new(), &*KEYS, toml::Value::Table(written))];
    while let Some((path, keys, value)) = tables.pop() {
        let dot = if path.is_empty() { "" } else { "." };
        let e = Scene::parse_with(
            FULL,
            Path::new("case/scene.toml"),
            &[format!("{path}{dot}no_such_key=1")],
        )
        .unwrap_err();
        let names = keys.names().collect::<Vec<_>>().join(", ");
        assert!(e.advice().ends_with(&format!("alid keys here: {names}")), "{path}: {e}");
        for (name, value) in value.as_table().unwrap() {
            let path = format!("{path}{dot}{name}");
            match (keys.get(name).unwrap().kind, value) {
                (Kind::Table(inner) | Kind::Either(_, _, inner), toml::Value::Table(_)) => {
                    tables.push((path, inner, value.clone()));
                }
                (Kind::List(inner), toml::Value::Array(list)) => {
                    tables.push((format!("{path}.0"), inner, list[0].clone()))
                }
                (Kind::Named(inner), toml::Value::Table(named)) => {
                    let (name, value) = named.iter().next().unwrap();
                    // A name with a space cannot be given by an override.
                    let name = if name.contains(' ') { "left" } else { name };
                    tables.push((
                        format!("{path}.{name}"),
                        inner,
                        named.get(name).unwrap_or(value).clone(),
                    ));
                }
                _ => (),
            }
        }
    }
}
