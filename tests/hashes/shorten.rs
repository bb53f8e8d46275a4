//! A scene that takes a moment: few steps on a coarse mesh, with a row and fields at their end.

use std::path::Path;
use toml::{Table, Value};

/// Steps of a shortened run, at most, in the plane and in space.
const STEPS: [f64; 2] = [4.0, 2.0];
/// Cells along an edge of a domain, at most: with fewer, bands would no longer fit into it.
const CELLS: [(&str, i64); 3] = [("rectangle", 30), ("box", 12), ("ball_in_box", 6)];

/// The scene shortened, files being looked for from `folder`; a text that is no TOML stays as it
/// is.
pub fn shortened(text: &str, folder: &Path) -> String {
    let Ok(mut scene) = text.parse::<Table>() else { return text.to_owned() };
    let most = STEPS[usize::from(in_space(&scene))];
    let step = shorten_time(&mut scene, most);
    for (table, key) in [("mesh", "file"), ("image", "file"), ("image", "mask")] {
        if let Some(Value::String(name)) = inner(&mut scene, table).and_then(|t| t.get_mut(key)) {
            *name = found(name, folder);
        }
    }
    coarsen(&mut scene);
    if let Some([step, end]) = step {
        let adapt = inner(&mut scene, "mesh").and_then(|mesh| inner(mesh, "adapt"));
        if let Some(every) = adapt.and_then(|t| t.get_mut("every")) {
            *every = Value::Float(2.0 * step);
        }
        write_at(&mut scene, step, end);
    }
    if let Some(Value::Integer(every)) = inner(&mut scene, "numerics")
        .and_then(|t| inner(t, "redistance"))
        .and_then(|t| t.get_mut("every"))
    {
        *every = (*every).min(2);
    }
    toml::to_string(&scene).unwrap_or_else(|_| text.to_owned())
}

/// Has a mesh of boxes.
pub fn in_space(scene: &Table) -> bool {
    scene
        .get("mesh")
        .is_some_and(|mesh| ["box", "ball_in_box"].iter().any(|key| mesh.get(key).is_some()))
}

fn inner<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Table> {
    table.get_mut(key).and_then(Value::as_table_mut)
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|k| k as f64))
}

/// Ends the run after a few steps; the step and the end.
fn shorten_time(scene: &mut Table, most: f64) -> Option<[f64; 2]> {
    let time = inner(scene, "time")?;
    let (step, end) = (number(time.get("step")?)?, number(time.get("end")?)?);
    let steps = (end / step).round();
    // Wrong ones stay wrong.
    if !(step > 0.0 && steps >= 1.0 && (end / step - steps).abs() < 1e-6) {
        return None;
    }
    let end = if steps > most { most * step } else { end };
    time.insert("end".into(), Value::Float(end));
    Some([step, end])
}

/// Rows at each step, fields and a small picture at the end, profiles at the end.
fn write_at(scene: &mut Table, step: f64, end: f64) {
    let output = scene.entry("output").or_insert_with(|| Value::Table(Table::new()));
    let Some(output) = output.as_table_mut() else { return };
    for (key, interval) in [("every", step), ("fields", end), ("pictures", end)] {
        let value = output.entry(key).or_insert(Value::Float(interval));
        if number(value).is_some_and(|given| given > 0.0) {
            *value = Value::Float(interval);
        }
    }
    if output.get("pictures").is_some_and(|p| number(p).is_some()) {
        let picture = output.entry("picture").or_insert_with(|| Value::Table(Table::new()));
        if let Some(picture) = picture.as_table_mut() {
            picture.insert("size".into(), Value::Integer(64));
        }
    }
    for (_, profile) in inner(output, "profiles").into_iter().flatten() {
        if let Some(times) = profile.get_mut("times") {
            *times = Value::Array(vec![Value::Float(end)]);
        }
    }
}

/// Fewer cells; edges that the scene asks for, and bands that are made for them, grow with the
/// cells.
fn coarsen(scene: &mut Table) -> Option<()> {
    let mesh = inner(scene, "mesh")?;
    let (domain, limit) = CELLS.into_iter().find(|(key, _)| mesh.contains_key(*key))?;
    let domain = inner(mesh, domain)?;
    let cells = domain.get_mut("cells")?.as_array_mut()?;
    let most = cells.iter().filter_map(Value::as_integer).max()?;
    if most <= limit {
        return None;
    }
    for cells in &mut *cells {
        *cells = Value::Integer((cells.as_integer()? * limit / most).max(1));
    }
    let factor = most as f64 / limit as f64;
    for key in ["edge", "band"] {
        grow(domain, key, factor);
    }
    if let Some(adapt) = inner(mesh, "adapt") {
        for key in ["edge", "along", "width"] {
            grow(adapt, key, factor);
        }
    }
    grow(inner(scene, "numerics")?, "thickness", factor);
    Some(())
}

fn grow(table: &mut Table, key: &str, factor: f64) {
    if let Some(value) = table.get_mut(key)
        && let Some(x) = number(value)
    {
        *value = Value::Float(factor * x);
    }
}

/// The path of a file beside the scene, or of a mesh or an image of the repository.
fn found(name: &str, folder: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders =
        [folder.to_path_buf(), root.join("meshes"), root.join("examples/active-contours")];
    let path = folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file());
    path.map_or_else(|| name.to_owned(), |path| path.display().to_string())
}
