//! What TOML and our programs make different from a schema of a Rust type.

use serde_json::{Map, Value, json};

/// The schema without nulls, which TOML lacks, and with the keys `include` and `puffer`. A file that includes
/// others may leave out what those have.
pub fn finish(mut schema: Value) -> Value {
    clean(&mut schema);
    let needed = take_needed(&mut schema);
    if let Some(properties) = schema["properties"].as_object_mut() {
        properties.insert("include".into(), include());
        properties.insert("puffer".into(), version());
    }
    if needed.as_object().is_some_and(|needed| !needed.is_empty()) {
        schema["if"] = json!({ "required": ["include"] });
        schema["then"] = json!(true);
        schema["else"] = needed;
    }
    schema
}

fn include() -> Value {
    json!({
        "description": "Files that this one lies over: what it gives stands in place of theirs.",
        "anyOf": [
            { "type": "string" },
            { "type": "array", "items": { "type": "string" } },
        ],
    })
}

fn version() -> Value {
    json!({
        "description": "Version that the file was written for, as \"0.1\"; a later one is refused.",
        "type": "string",
    })
}

/// Cleans a schema and all in it of what Rust alone has, and of nulls.
pub fn clean(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.values_mut().for_each(clean);
            clean_one(object);
        }
        Value::Array(items) => items.iter_mut().for_each(clean),
        _ => {}
    }
}

fn clean_one(object: &mut Map<String, Value>) {
    if object.get("default").is_some_and(Value::is_null) {
        object.remove("default");
    }
    // of Rust: double, uint, uint32
    if object.get("format").is_some_and(Value::is_string) {
        object.remove("format");
    }
    if let Some(Value::Array(types)) = object.get_mut("type") {
        types.retain(|name| name != "null");
        if let [one] = &types[..] {
            let one = one.clone();
            object.insert("type".into(), one);
        }
    }
    if let Some(Value::Array(words)) = object.get_mut("enum") {
        words.retain(|word| !word.is_null());
    }
    if let Some(Value::Array(forms)) = object.get_mut("anyOf") {
        forms.retain(|form| form["type"] != "null");
        if forms.len() == 1 {
            let only = object.remove("anyOf").unwrap_or_default();
            // beside a $ref nothing counts in draft 7
            object.insert("allOf".into(), only);
        }
    }
    if let Some(Value::String(text)) = object.get_mut("description") {
        *text = plain(text);
    }
}

/// A documentation comment as a paragraph, without links to items of the source.
fn plain(text: &str) -> String {
    let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut plain = String::new();
    let mut rest = joined.as_str();
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((name, behind)) = after.split_once("`]") else { break };
        plain += &format!("{before}`{name}`");
        rest = match behind.strip_prefix('(').and_then(|link| link.split_once(')')) {
            Some((_, behind)) => behind,
            None => behind,
        };
    }
    plain + rest
}

/// Takes from the schema which keys a file must have, at its top and in tables that occur once.
fn take_needed(schema: &mut Value) -> Value {
    let mut needed = Map::new();
    if let Some(required) = schema.as_object_mut().and_then(|s| s.remove("required")) {
        needed.insert("required".into(), required);
    }
    let text = schema.to_string();
    let places: Vec<(String, String)> = schema["properties"]
        .as_object()
        .into_iter()
        .flatten()
        .filter_map(|(key, value)| Some((key.clone(), table_of(value, schema)?.to_owned())))
        .filter(|(_, place)| text.matches(&format!("\"#{place}\"")).count() == 1)
        .collect();
    let mut tables = Map::new();
    for (key, place) in places {
        let table = schema.pointer_mut(&place).and_then(Value::as_object_mut);
        if let Some(required) = table.and_then(|table| table.remove("required")) {
            tables.insert(key, json!({ "required": required }));
        }
    }
    if !tables.is_empty() {
        needed.insert("properties".into(), tables.into());
    }
    needed.into()
}

/// Where the table is defined that a value is, or is in one of its forms.
fn table_of<'a>(value: &'a Value, root: &'a Value) -> Option<&'a str> {
    let place = reference(value)?;
    let forms = root.pointer(place)?["anyOf"].as_array();
    let is_table = |place: &&str| root.pointer(place).is_some_and(|s| s["properties"].is_object());
    let tables = || forms.into_iter().flatten().filter_map(reference).filter(is_table);
    if tables().count() == 1 { tables().next() } else { Some(place) }
}

/// Where a schema says that it is defined, as a pointer.
pub fn reference(schema: &Value) -> Option<&str> {
    let direct = schema["$ref"].as_str();
    let wrapped = || schema["allOf"].as_array().filter(|all| all.len() == 1)?[0]["$ref"].as_str();
    direct.or_else(wrapped)?.strip_prefix('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nulls_and_links_go() {
        let mut schema = json!({
            "description": "As [`Kind`](crate::kind) and\n[`Row`] say [m].",
            "default": null,
            "anyOf": [{ "$ref": "#/definitions/A" }, { "type": "null" }],
            "properties": { "x": { "type": ["number", "null"], "format": "double" } },
        });
        clean(&mut schema);
        let wanted = json!({
            "description": "As `Kind` and `Row` say [m].",
            "allOf": [{ "$ref": "#/definitions/A" }],
            "properties": { "x": { "type": "number" } },
        });
        assert_eq!(schema, wanted);
    }

    #[test]
    fn a_word_in_place_of_a_table_is_no_part() {
        let schema = finish(json!({
            "properties": { "contact": { "$ref": "#/definitions/Choice" } },
            "definitions": {
                "Choice": { "anyOf": [{ "const": "ignored" }, { "$ref": "#/definitions/Contact" }] },
                "Contact": { "properties": { "friction": {} }, "required": ["stiffness"] },
            },
        }));
        assert_eq!(schema["definitions"]["Contact"], json!({ "properties": { "friction": {} } }));
        let needed = json!({ "properties": { "contact": { "required": ["stiffness"] } } });
        assert_eq!(schema["else"], needed);
    }

    #[test]
    fn a_file_that_includes_others_needs_nothing() {
        let schema = finish(json!({
            "properties": {
                "mesh": { "type": "string" },
                "contact": { "$ref": "#/definitions/Contact" },
            },
            "required": ["mesh"],
            "definitions": { "Contact": { "type": "object", "required": ["stiffness"] } },
        }));
        assert_eq!(schema["definitions"]["Contact"], json!({ "type": "object" }));
        let needed = json!({
            "required": ["mesh"],
            "properties": { "contact": { "required": ["stiffness"] } },
        });
        assert_eq!(schema["else"], needed);
        assert_eq!(schema["if"], json!({ "required": ["include"] }));
        assert!(schema["properties"]["puffer"].is_object());
    }
}
