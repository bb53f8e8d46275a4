//! What a run may change when it goes on: its end and its output, and not what is computed.

use crate::base::{Error, Result, fnv1a};
use crate::scene::Scene;
use std::path::Path;
use toml::{Table, Value};

/// Keys of `[output]` that change files, and not their columns.
const OF_OUTPUT: [&str; 8] =
    ["every", "fields", "store", "vtkhdf", "pictures", "film", "checkpoint", "picture"];

/// The scene without what may change.
fn physics(scene: &Scene) -> Result<Table> {
    let mut all: Table = scene
        .to_toml()
        .parse()
        .map_err(|e| Error::internal("a resolved scene is not TOML").value(e))?;
    all.remove("title");
    // Files are known by hashes of what matters in them: they may be elsewhere.
    // Of the run at the start the flow was kept, and its name is compared.
    for (table, key) in
        [("mesh", "file"), ("image", "file"), ("image", "mask"), ("initial", "from")]
    {
        let table = all.get_mut(table).and_then(Value::as_table_mut);
        let Some(file) = table.and_then(|table| table.get_mut(key)) else { continue };
        let name = file.as_str().and_then(|path| Path::new(path).file_name());
        let name = name.map(|name| name.to_string_lossy().into_owned());
        *file = name.filter(|_| key == "from").unwrap_or_default().into();
    }
    if let Some(time) = all.get_mut("time").and_then(Value::as_table_mut) {
        let end = time.remove("end");
        // The default of the longest step.
        if time.get("step_max") == end.as_ref() {
            time.remove("step_max");
        }
    }
    if let Some(output) = all.get_mut("output").and_then(Value::as_table_mut) {
        OF_OUTPUT.iter().for_each(|key| drop(output.remove(*key)));
        let profiles = output.get_mut("profiles").and_then(Value::as_table_mut);
        let each = profiles.into_iter().flat_map(|table| table.iter_mut());
        each.filter_map(|(_, profile)| profile.as_table_mut()).for_each(|profile| {
            profile.remove("times");
        });
    }
    Ok(all)
}

/// Identifies what a scene computes: a checkpoint fits only a scene with the same tag.
pub(super) fn tag(scene: &Scene) -> Result<u64> {
    Ok(fnv1a(physics(scene)?.to_string().as_bytes()))
}

/// What two scenes compute differently, `key: value became value`, in the order of the keys.
pub(super) fn differences(before: &Scene, now: &Scene) -> Result<Vec<String>> {
    let mut found = Vec::new();
    let [before, now] = [physics(before)?, physics(now)?].map(Value::Table);
    compare("", Some(&before), Some(&now), &mut found);
    Ok(found)
}

fn compare(key: &str, before: Option<&Value>, now: Option<&Value>, found: &mut Vec<String>) {
    let inner = |name: &str| if key.is_empty() { name.into() } else { format!("{key}.{name}") };
    match (before, now) {
        (a, b) if a == b => {}
        (Some(Value::Table(a)), Some(Value::Table(b))) => {
            let added = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(added) {
                compare(&inner(name), a.get(name), b.get(name), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) if a.iter().all(Value::is_table) => {
            for k in 0..a.len().max(b.len()) {
                compare(&inner(&k.to_string()), a.get(k), b.get(k), found);
            }
        }
        (Some(a), Some(b)) => found.push(format!("{key}: {a} became {b}")),
        (Some(a), None) => found.push(format!("{key}: {a} is gone")),
        (None, Some(b)) => found.push(format!("{key}: {b} is new")),
        (None, None) => {}
    }
}
