//! The scene format as a JSON Schema, by which editors complete, explain and check scenes. It is
//! made of the declarations from which scenes are read.

use super::keys::{Absent, Form, Key, Keys, Kind};
use super::reference::{Section, sections};
use serde_json::{Map, Value, json};

/// A scene with all its tables as a JSON Schema of draft 7, the one that editors read.
///
/// It knows the keys and the form of their values, not the rules between several keys: a scene that
/// it accepts may still be refused.
pub fn json_schema() -> String {
    let sections = sections();
    let mut schema = Map::from_iter([
        ("$schema".to_string(), json!("http://json-schema.org/draft-07/schema#")),
        ("title".to_string(), json!("A scene of immersa")),
        (
            "$comment".to_string(),
            json!(concat!("Written by `immersa schema`, version ", env!("CARGO_PKG_VERSION"))),
        ),
    ]);
    let mut definitions = Map::new();
    for section in &sections {
        match section.paths[0].as_str() {
            "" => schema.extend(table(section.keys, &sections)),
            path => {
                definitions.insert(path.to_string(), table(section.keys, &sections).into());
            }
        }
    }
    schema.insert("definitions".to_string(), definitions.into());
    format!("{:#}\n", Value::from(schema))
}

/// A table with its keys.
fn table(keys: &'static Keys, sections: &[Section]) -> Map<String, Value> {
    let properties: Map<String, Value> =
        keys.keys.iter().map(|key| (key.name.to_string(), property(key, sections))).collect();
    let with = |absent| keys.keys.iter().filter(move |key| key.absent == absent).map(|k| k.name);
    let required: Vec<&str> = with(Absent::Required).collect();
    let one_of: Vec<Value> = with(Absent::OneOf).map(|key| json!({ "required": [key] })).collect();
    let only_one_of = one_of.len() == keys.keys.len();
    let mut table = Map::from_iter([
        ("type".to_string(), json!("object")),
        ("description".to_string(), json!(keys.about)),
        ("properties".to_string(), properties.into()),
        ("additionalProperties".to_string(), json!(false)),
    ]);
    if !required.is_empty() {
        table.insert("required".to_string(), json!(required));
    }
    if only_one_of {
        // Said in numbers, since editors answer a `oneOf` with every key that is not there.
        table.extend(["minProperties", "maxProperties"].map(|bound| (bound.to_string(), json!(1))));
    } else if !one_of.is_empty() {
        table.insert("oneOf".to_string(), one_of.into());
    }
    table
}

/// A key with its values, its meaning and its default.
fn property(key: &Key, sections: &[Section]) -> Value {
    let values = match (key.absent, values(key.kind, sections)) {
        (Absent::Auto, values) => json!({ "anyOf": [values, { "const": "auto" }] }),
        // Draft 7 ignores what stands beside a reference.
        (_, values) if values.get("$ref").is_some() => json!({ "allOf": [values] }),
        (_, values) => values,
    };
    let mut property = match values {
        Value::Object(values) => values,
        other => return other,
    };
    let unit = if key.unit.is_empty() { String::new() } else { format!(" Unit: {}.", key.unit) };
    let default = match key.absent {
        Absent::Derived(what) => format!(" Default: {what}."),
        _ => String::new(),
    };
    property.insert("description".to_string(), json!(format!("{}{unit}{default}", key.doc)));
    if let Some(default) = default_value(key) {
        property.insert("default".to_string(), default);
    }
    property.into()
}

/// The value of an absent key.
fn default_value(key: &Key) -> Option<Value> {
    match key.absent {
        Absent::Auto => Some(json!("auto")),
        Absent::Default(text) => {
            let table: toml::Table = toml::from_str(&format!("default = {text}")).ok()?;
            serde_json::to_value(table.get("default")?).ok()
        }
        _ => None,
    }
}

/// The values that a key can have.
fn values(kind: Kind, sections: &[Section]) -> Value {
    let list = |item: Form, n: usize| list(of_form(item, sections), [n, n]);
    let table = |keys: &'static Keys| reference(|s| std::ptr::eq(s.keys, keys), sections);
    match kind {
        Kind::Value(_, form) => of_form(form, sections),
        Kind::OrFalse(_, form) => {
            json!({ "anyOf": [of_form(form, sections), { "const": false }] })
        }
        Kind::Numbers(n) => list(Form::NUMBER, n),
        Kind::Lengths(n) => list(Form::POSITIVE, n),
        Kind::Count(range) => of_form(Form::Whole(range), sections),
        Kind::Counts(n, range) => list(Form::Whole(range), n),
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::ChoiceOrFalse(words) => {
            json!({ "anyOf": [{ "enum": words }, { "const": false }] })
        }
        Kind::Set(words) => {
            json!({ "type": "array", "items": { "enum": words }, "uniqueItems": true })
        }
        Kind::Table(keys) => table(keys),
        Kind::List(keys) => json!({ "type": "array", "items": table(keys) }),
        Kind::Named(keys) => json!({ "type": "object", "additionalProperties": table(keys) }),
        Kind::Either(_, form, keys) => {
            json!({ "anyOf": [of_form(form, sections), table(keys)] })
        }
    }
}

/// The values of a form.
fn of_form(form: Form, sections: &[Section]) -> Value {
    match form {
        Form::Text => json!({ "type": "string" }),
        Form::Flag => json!({ "type": "boolean" }),
        Form::True => json!({ "const": true }),
        Form::TrueOr(word) => json!({ "enum": [true, word] }),
        Form::Number { least, most, open } => {
            let mut number = json!({ "type": "number" });
            if least.is_finite() {
                number[if open { "exclusiveMinimum" } else { "minimum" }] = json!(least);
            }
            if most.is_finite() {
                number["maximum"] = json!(most);
            }
            number
        }
        Form::Whole([least, most]) => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        Form::Expression => json!({ "type": ["number", "string"] }),
        Form::List(item, range) => list(of_form(*item, sections), range),
        Form::Names(of) => {
            json!({ "type": "object", "additionalProperties": of_form(*of, sections) })
        }
        Form::Like(path) => reference(|s| s.paths.iter().any(|p| p == path), sections),
    }
}

/// A list of so many items.
fn list(item: Value, [least, most]: [usize; 2]) -> Value {
    let mut list = json!({ "type": "array", "items": item, "minItems": least });
    if most < usize::MAX {
        list["maxItems"] = json!(most);
    }
    list
}

/// A reference to the definition of a table.
fn reference(is: impl Fn(&Section) -> bool, sections: &[Section]) -> Value {
    let section = sections.iter().find(|s| is(s));
    json!({ "$ref": format!("#/definitions/{}", section.map_or("", |s| s.paths[0].as_str())) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn schema() -> Value {
        serde_json::from_str(&json_schema()).unwrap()
    }

    /// The definition of the table at a path, or the scene.
    fn definition<'a>(schema: &'a Value, path: &str) -> &'a Value {
        if path.is_empty() { schema } else { &schema["definitions"][path] }
    }

    #[test]
    fn every_key_of_the_reference_stands_in_the_schema_and_no_other() {
        let schema = schema();
        for section in sections() {
            let table = definition(&schema, &section.paths[0]);
            let properties = table["properties"].as_object().unwrap();
            let names: BTreeSet<&str> = properties.keys().map(String::as_str).collect();
            assert_eq!(names, section.keys.names().collect(), "{}", section.paths[0]);
            assert_eq!(table["additionalProperties"], false);
            for key in section.keys.keys {
                let property = &properties[key.name];
                assert!(property["description"].as_str().unwrap().starts_with(key.doc));
                if let Absent::Default(text) = key.absent {
                    assert!(property.get("default").is_some(), "{} = {text}", key.name);
                }
                let required = key.absent == Absent::Required;
                let listed = table["required"].as_array();
                assert_eq!(
                    listed.is_some_and(|r| r.contains(&json!(key.name))),
                    required,
                    "{}",
                    key.name
                );
            }
        }
    }

    #[test]
    fn every_reference_leads_to_a_definition() {
        fn check(value: &Value, definitions: &Map<String, Value>) -> usize {
            let inner = match value {
                Value::Object(map) => map.values().map(|v| check(v, definitions)).sum(),
                Value::Array(list) => list.iter().map(|v| check(v, definitions)).sum(),
                _ => 0,
            };
            let Some(to) = value.get("$ref").and_then(Value::as_str) else { return inner };
            assert!(definitions.contains_key(to.strip_prefix("#/definitions/").unwrap()), "{to}");
            inner + 1
        }
        let schema = schema();
        assert!(check(&schema, schema["definitions"].as_object().unwrap()) > 30);
    }

    #[test]
    fn a_kind_of_value_becomes_a_schema() {
        let schema = schema();
        let of = |path: &str, key: &str| definition(&schema, path)["properties"][key].clone();
        assert_eq!(
            of("mesh.rectangle", "cells")["items"],
            json!({ "type": "integer", "minimum": 1, "maximum": 100_000 })
        );
        assert_eq!(of("time", "step")["exclusiveMinimum"], 0.0);
        assert_eq!(of("membrane", "stretch")["type"], "number");
        assert_eq!(of("boundary", "no_slip")["const"], true);
        assert_eq!(of("numerics", "thickness")["anyOf"][1], json!({ "const": "auto" }));
        assert_eq!(of("output", "fields")["anyOf"][1], json!({ "const": false }));
        assert_eq!(
            of("membrane.shape", "union")["items"],
            json!({ "$ref": "#/definitions/membrane.shape" })
        );
        let boundary = definition(&schema, "boundary");
        assert_eq!(
            (&boundary["minProperties"], &boundary["maxProperties"]),
            (&json!(1), &json!(1))
        );
        let sides = &of("fluid", "viscosity")["anyOf"];
        assert_eq!(sides[1], json!({ "$ref": "#/definitions/fluid.density" }));
        assert_eq!(
            definition(&schema, "fluid")["oneOf"],
            json!([{ "required": ["viscosity"] }, { "required": ["prescribed_velocity"] }])
        );
    }
}
