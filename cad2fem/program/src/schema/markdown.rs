//! The keys of a file as tables in Markdown, from its schema.

use std::collections::BTreeSet;

use serde_json::Value;

use super::finish::{self, reference};
use crate::table::DEFAULT_IN_WORDS;

/// A table of keys for each table of a file, with type, default and meaning of each key; of a report
/// without defaults.
pub fn markdown(schema: &Value, is_report: bool) -> String {
    let mut schema = schema.clone();
    finish::clean(&mut schema);
    let schema = &schema;
    let mut chapter = Chapter { schema, is_report, text: String::new(), written: Vec::new() };
    let missing = schema["else"]["required"].as_array().cloned().unwrap_or_default();
    let needed: BTreeSet<&str> = missing.iter().filter_map(Value::as_str).collect();
    chapter.keys(schema, &needed);
    chapter.tables("", schema);
    chapter.text
}

struct Chapter<'a> {
    schema: &'a Value,
    /// Whether programs write it, and nobody else.
    is_report: bool,
    text: String,
    /// Tables that have a heading, with it.
    written: Vec<(*const Value, String)>,
}

impl<'a> Chapter<'a> {
    /// What a schema says, behind references and lists.
    fn resolve(&self, schema: &'a Value) -> &'a Value {
        let behind = reference(schema).and_then(|place| self.schema.pointer(place));
        behind.map_or(schema, |behind| self.resolve(behind))
    }

    /// The forms that a value may have.
    fn forms(&self, schema: &'a Value) -> Vec<&'a Value> {
        let schema = self.resolve(schema);
        let several = schema["oneOf"].as_array().or_else(|| schema["anyOf"].as_array());
        match several {
            Some(forms) => forms.iter().flat_map(|form| self.forms(form)).collect(),
            None => vec![schema],
        }
    }

    /// The tables that a value may be or list, and whether they are listed; of a value with a title
    /// that says it all none.
    fn own_tables(&self, schema: &'a Value) -> (Vec<&'a Value>, bool) {
        let says_it_all = |schema: &'a Value| self.resolve(schema)["title"].is_string();
        if says_it_all(schema) || self.resolve(schema).get("items").is_some_and(says_it_all) {
            return (Vec::new(), false);
        }
        let is_table = |form: &&Value| form["properties"].is_object();
        let forms = self.forms(schema);
        let items = match forms[..] {
            [list] => list.get("items").map(|items| self.forms(items)),
            _ => None,
        };
        let listed = items.is_some();
        // in a report each name of a table may stand for a table
        let named = |map: &&'a Value| {
            let each = map.get("additionalProperties").filter(|each| each.is_object());
            each.filter(|_| self.is_report && map["properties"].is_null())
        };
        let items = items.or_else(|| Some(self.forms(forms.first().and_then(named)?)));
        (items.unwrap_or(forms).into_iter().filter(is_table).collect(), listed)
    }

    /// A heading for each table in a table, and what is in it.
    fn tables(&mut self, above: &str, table: &'a Value) {
        for (key, value) in sorted(table, &BTreeSet::new()) {
            let (mut forms, listed) = self.own_tables(value);
            let name = format!("{above}{key}");
            // of forms that are one key each the tables behind these keys are meant
            let several = self.forms(value).len() > 1;
            let (chosen, own) =
                forms.into_iter().partition(|form| several && choice_of_one(form).is_some());
            forms = own;
            for form in Vec::from_iter::<Vec<&Value>>(chosen) {
                self.tables(&format!("{name}."), form);
            }
            if !forms.is_empty() {
                let about = value["description"].as_str().or(table["description"].as_str());
                let named = self.is_report && !listed && !self.has_keys(value);
                let name = if named { name + ".<name>" } else { name };
                let title = match (self.is_report, listed) {
                    (true, true) => format!("`{name}[]`"),
                    (true, false) => format!("`{name}`"),
                    (false, true) => format!("`[[{name}]]`"),
                    (false, false) => format!("`[{name}]`"),
                };
                self.text += &format!("## {title}\n\n{}", paragraph(about.unwrap_or_default()));
                self.table(key, &name, &title, &forms);
            }
        }
    }

    /// The forms of one table, if they were not written before.
    fn table(&mut self, key: &str, name: &str, title: &str, forms: &[&'a Value]) {
        let first = std::ptr::from_ref(forms[0]);
        if let Some((_, before)) = self.written.iter().find(|(form, _)| *form == first) {
            self.text += &format!("The keys are those of {before}.\n\n");
            return;
        }
        self.written.push((first, title.to_owned()));
        for form in forms {
            if forms.len() > 1 {
                let about = form["description"].as_str().unwrap_or_default();
                self.text += &format!("### {}\n\n{}", choice(form), paragraph(about));
            }
            let more = &self.schema["else"]["properties"][key]["required"];
            let needed = [&form["required"], more].into_iter().filter_map(Value::as_array);
            self.keys(form, &needed.flatten().filter_map(Value::as_str).collect());
            self.tables(&format!("{name}."), form);
        }
    }

    /// Whether a value is a table of known keys.
    fn has_keys(&self, value: &'a Value) -> bool {
        self.forms(value).iter().any(|form| form["properties"].is_object())
    }

    fn keys(&mut self, table: &'a Value, needed: &BTreeSet<&str>) {
        self.text += match self.is_report {
            true => "| key | value | meaning |\n|-|-|-|\n",
            false => "| key | value | default | meaning |\n|-|-|-|-|\n",
        };
        for (key, value) in sorted(table, needed) {
            let words = value[DEFAULT_IN_WORDS].as_str();
            let default = match &value["default"] {
                _ if needed.contains(key.as_str()) => "needed".to_owned(),
                Value::Null if words.is_some() => words.unwrap_or_default().to_owned(),
                Value::Null | Value::Object(_) => String::new(),
                Value::Array(items) if items.is_empty() => String::new(),
                default => format!("`{default}`"),
            };
            let meaning = self.meaning(value);
            let value = match self.own_tables(value) {
                (tables, _) if tables.is_empty() || tables.len() < self.forms(value).len() => {
                    self.words(value)
                }
                (_, true) => "list of tables".to_owned(),
                (_, false) => "table".to_owned(),
            };
            let cells = [format!("`{key}`"), value, default, meaning];
            let cells = cells.map(|cell| cell.replace('|', "\\|"));
            let shown = cells.iter().enumerate().filter(|(i, _)| !self.is_report || *i != 2);
            let shown: Vec<&str> = shown.map(|(_, cell)| &cell[..]).collect();
            self.text += &format!("| {} |\n", shown.join(" | "));
        }
        self.text += "\n";
    }

    /// What a key means, and the words that it may be.
    fn meaning(&self, value: &'a Value) -> String {
        let own = value["description"].as_str();
        let behind = self.resolve(value)["description"].as_str();
        let mut text = own.or(behind).unwrap_or_default().to_owned();
        for form in self.forms(value) {
            if let (Some(word), Some(meaning)) =
                (form["const"].as_str(), form["description"].as_str())
            {
                text += &format!(" `\"{word}\"`: {}.", meaning.trim_end_matches('.'));
            }
        }
        text
    }

    /// What may be written, in words.
    fn words(&self, value: &'a Value) -> String {
        let title = self.resolve(value)["title"].as_str().filter(|_| reference(value).is_some());
        if let Some(title) = title {
            return title.to_owned();
        }
        let mut words: Vec<String> = Vec::new();
        for form in self.forms(value) {
            let word = self.word(form);
            if !words.contains(&word) {
                words.push(word);
            }
        }
        words.join(" or ")
    }

    fn word(&self, form: &'a Value) -> String {
        if let (Some(title), true) = (form["title"].as_str(), form["enum"].is_array()) {
            return title.to_owned();
        }
        let quoted = |word: &Value| format!("`{word}`");
        if let Some(word) = form.get("const") {
            return quoted(word);
        }
        if let Some(words) = form["enum"].as_array() {
            return words.iter().map(quoted).collect::<Vec<_>>().join(" or ");
        }
        match form["type"].as_str() {
            Some("string") => "text".into(),
            Some("boolean") => "true or false".into(),
            Some("array") => {
                let count = form["minItems"].as_u64().filter(|n| form["maxItems"] == *n);
                let items = form.get("items").map_or_else(String::new, |items| self.words(items));
                let number = count.map_or_else(String::new, |count| format!("{count} × "));
                format!("list of {number}{items}").trim_end().to_owned()
            }
            Some("object") => match form["properties"].as_object() {
                Some(_) if form["properties"]["kind"].is_object() => "table with a kind".into(),
                Some(keys) => {
                    format!("{{ {} }}", keys.keys().cloned().collect::<Vec<_>>().join(", "))
                }
                None => {
                    let each = form.get("additionalProperties").filter(|each| each.is_object());
                    let each = each.map_or_else(|| "value".to_owned(), |each| self.words(each));
                    format!("table of name = {each}")
                }
            },
            Some(number) => number.into(),
            None => "value".into(),
        }
    }
}

/// The keys of a table, first those that say what it is and those that are needed.
fn sorted<'a>(table: &'a Value, needed: &BTreeSet<&str>) -> Vec<(&'a String, &'a Value)> {
    let rank = |key: &str| match key {
        "kind" => 0,
        "name" => 1,
        "on" => 2,
        key if needed.contains(key) => 3,
        "include" | "puffer" => 5,
        _ => 4,
    };
    let mut keys: Vec<_> = table["properties"].as_object().into_iter().flatten().collect();
    keys.sort_by_key(|(key, _)| rank(key));
    keys
}

/// The key of a form that has exactly one, such as a shape, if a table is behind it or a list.
fn choice_of_one(form: &Value) -> Option<&String> {
    let keys = form["properties"].as_object().filter(|keys| keys.len() == 1)?;
    let (key, _) = keys.iter().next()?;
    (form["required"] == serde_json::json!([key])).then_some(key)
}

/// What tells a form of a table from the others: its kind, its title or else the keys that it needs.
fn choice(form: &Value) -> String {
    if let Some(kind) = form["properties"]["kind"]["const"].as_str() {
        return format!("`kind = \"{kind}\"`");
    }
    let keys = form["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let keys = || keys.map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    form["title"].as_str().map_or_else(keys, str::to_owned)
}

fn paragraph(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("{text}\n\n") }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn tables_have_headings_and_keys_their_words() {
        let contact = json!({
            "description": "Contact.",
            "type": "object",
            "properties": {
                "friction": { "type": "number", "default": 0.5, "description": "Coefficient [1]." },
                "stiffness": { "type": "number" },
            },
            "required": ["stiffness"],
        });
        let schema = json!({
            "properties": {
                "contact": { "$ref": "#/definitions/Contact", "description": "Contact." },
                "mesh": { "type": "string", "description": "A file." },
                "at": { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 },
            },
            "definitions": { "Contact": contact },
            "else": { "required": ["mesh"] },
        });
        let text = markdown(&schema, false);
        for line in [
            "| `mesh` | text | needed | A file. |",
            "| `at` | list of 3 × number |  |  |",
            "## `[contact]`\n\nContact.\n\n| key",
            "| `friction` | number | `0.5` | Coefficient [1]. |",
            "| `stiffness` | number | needed |  |",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
    }
    /// In a report each name of a table may stand for a table.
    #[test]
    fn reports_have_tables_by_names() {
        let tag =
            json!({ "type": "object", "properties": { "area": { "type": ["number", "null"] } } });
        let tags =
            json!({ "type": "object", "additionalProperties": tag, "description": "By tag." });
        let text = markdown(&json!({ "properties": { "tags": tags } }), true);
        let table = "## `tags.<name>`\n\nBy tag.\n\n| key | value | meaning |\n|-|-|-|\n| `area` | number |  |\n";
        assert!(text.contains("| `tags` | table | By tag. |") && text.contains(table), "{text}");
    }
}
