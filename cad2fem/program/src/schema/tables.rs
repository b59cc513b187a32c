//! Schemas of tables that are read by hand: what they have is put together here.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value, json};

/// Adds keys to a table, or to each of its forms; needed are those that are marked so.
pub fn add_keys(schema: &mut Schema, keys: &[(&str, Value, bool)]) {
    add_to(schema.ensure_object(), keys);
}

/// Adds the keys of a `T` to a table, or to each of its forms.
pub fn add_table<T: JsonSchema>(schema: &mut Schema, generator: &mut SchemaGenerator) {
    let own = T::json_schema(generator).to_value();
    let needed = own["required"].as_array().cloned().unwrap_or_default();
    let properties = own["properties"].as_object().into_iter().flatten();
    for (key, value) in properties {
        let is_needed = needed.contains(&key.as_str().into());
        add_keys(schema, &[(key, value.clone(), is_needed)]);
    }
}

fn add_to(table: &mut Map<String, Value>, keys: &[(&str, Value, bool)]) {
    for forms in ["oneOf", "anyOf"] {
        if let Some(Value::Array(forms)) = table.get_mut(forms) {
            forms.iter_mut().filter_map(Value::as_object_mut).for_each(|form| add_to(form, keys));
            return;
        }
    }
    for (key, value, needed) in keys {
        let properties = table.entry("properties").or_insert_with(|| json!({}));
        properties[*key] = value.clone();
        if *needed {
            let required = table.entry("required").or_insert_with(|| json!([]));
            required.as_array_mut().into_iter().for_each(|keys| keys.push((*key).into()));
        }
    }
}

/// Makes a table of the kind that its key `kind` says.
pub fn add_kind(schema: &mut Schema, kind: &str, about: &str) {
    schema.insert("title".into(), kind.into());
    schema.insert("description".into(), about.into());
    add_keys(schema, &[("kind", json!({ "const": kind, "type": "string" }), true)]);
}

/// Exactly one of several forms.
pub fn one_of(forms: impl IntoIterator<Item = Schema>) -> Schema {
    let forms: Vec<Value> = forms.into_iter().map(Schema::to_value).collect();
    schemars::json_schema!({ "oneOf": forms })
}

/// One of several words.
pub fn one_of_these<'a>(words: impl IntoIterator<Item = &'a str>) -> Schema {
    let words: Vec<&str> = words.into_iter().collect();
    schemars::json_schema!({ "type": "string", "enum": words })
}

/// One of several words, or nothing.
pub fn one_of_these_or_none<'a>(words: impl IntoIterator<Item = &'a str>) -> Schema {
    let words: Vec<Option<&str>> = words.into_iter().map(Some).chain([None]).collect();
    schemars::json_schema!({ "type": ["string", "null"], "enum": words })
}

/// `schema` for a table that may have any part of the keys, all definitions written out.
pub fn partial(schema: &Schema, definitions: &Map<String, Value>) -> Schema {
    let mut value = schema.clone().to_value();
    loosen(&mut value, definitions);
    Schema::try_from(value).unwrap_or_default()
}

fn loosen(value: &mut Value, definitions: &Map<String, Value>) {
    if let Some(name) = value["$ref"].as_str().and_then(|place| place.rsplit('/').next()) {
        *value = definitions.get(name).cloned().unwrap_or(true.into());
    }
    match value {
        Value::Object(object) => {
            object.remove("required");
            // without what is needed forms are no longer told apart
            if let Some(forms) = object.remove("oneOf") {
                object.insert("anyOf".into(), forms);
            }
            object.values_mut().for_each(|value| loosen(value, definitions));
        }
        Value::Array(items) => items.iter_mut().for_each(|item| loosen(item, definitions)),
        _ => {}
    }
}
