//! Every number of every file in TOML, replaced by one at the limits: of each program's own schema, and of sound
//! files. A program ends with a result or a message, without a panic and before long.

use std::process::{Command, Stdio};

use serde_json::{Map, Value, json};

use crate::workdir::{Workdir, program};

/// Numbers where powers, differences and counts leave what can be computed.
const NUMBERS: [&str; 14] = [
    "1e155",
    "-1e308",
    "1e308",
    "5e-324",
    "-0.0",
    "0",
    "-1",
    "1e30",
    "-1e30",
    "1e-30",
    "nan",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
];

/// Stands for the number; no file has it.
const PLACE: i64 = 424_242_424;

/// Deepest table of a file that is made from a schema.
const DEPTH: usize = 9;

/// A kind of file, and how a program is asked to use it.
pub struct Reader {
    program: &'static str,
    format: &'static str,
    arguments: &'static str,
    /// Sound files.
    sound: &'static [&'static str],
}

/// All kinds of files that people write for the stages, used on `body.msh` of [`crate::chamber::workdir`].
pub const READERS: &[Reader] = &[
    Reader {
        program: "tagger",
        format: "tags",
        arguments: "tag body.msh --config tags.toml -o out.msh",
        sound: &[
            "epsilon = 1e-4\n[[tag]]\nname = \"a\"\npoint = { at = [0.0, 0.02, 0.04], angle = 40 }\n\
                  [[tag]]\nname = \"b\"\nplane = { point = [0, 0, 0.04], normal = [0, 0, 1] }\n\
                  [[tag]]\nname = \"c\"\nbox = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }\n\
                  [[tag]]\nname = \"d\"\ncomponent = 0\n",
        ],
    },
    Reader {
        program: "cad2fem",
        format: "model",
        arguments: "model model.toml -o model",
        sound: &[
            include_str!("../../../pipelines/blank/model.toml"),
            include_str!("../../../pipelines/beam/model.toml"),
        ],
    },
    Reader {
        program: "cad2fem",
        format: "cad2fem",
        // without a mesher: what is computed before one is called
        arguments: "tetmesh target.stl --config cad2fem.toml -o out.msh",
        sound: &[include_str!("../../../pipelines/frog/cad2fem.toml")],
    },
    Reader {
        program: "solver",
        format: "sim",
        arguments: "simulate sim.toml -o run",
        sound: &[
            "mesh = \"body.msh\"\ndegree = 1\ngravity = [0, 0, -9.81]\n[material]\nkind = \"neo-hookean\"\n\
                  young = 1e5\npoisson = 0.4\ndensity = 1070\n[[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\n\
                  pressure = 1e3\n[solver]\nrelative_tolerance = 1e-8\nsmallest_load_step = 0.1\n\
                  [contact]\nactivation = 1e-4\nstiffness = 1e6\n[time]\nend = 0.01\nsteps = 2\n",
        ],
    },
    Reader {
        program: "solver",
        format: "design",
        arguments: "optimize design.toml -o run",
        sound: &[
            "scene = \"p1.toml\"\n[optimizer]\nfirst_step = 0.1\n[shape]\non = \"cavity\"\n[[shape.level]]\n\
                  handles = 1\niterations = 1\n[[objective]]\nkind = \"smoothness\"\nname = \"s\"\nweight = 1e-3\non = \"cavity\"\n\
                  [[objective]]\nkind = \"clearance\"\nname = \"c\"\nweight = 1.0\nactivation = 5e-5\n",
        ],
    },
    Reader {
        program: "fab",
        format: "mold",
        arguments: "plan body.msh --config mold.toml -o plan",
        sound: &[
            "chamber = \"cavity\"\nup = [1, 0, 0]\n[parting]\nkind = \"plane\"\npull = [0, 1, 0]\noffset = 0\n\
                  [casting]\nleak_test = 5e3\nleast_wall = 1.0\n",
        ],
    },
];

impl Reader {
    fn file(&self) -> String {
        format!("{}.toml", self.format)
    }

    /// Files with one number replaced.
    fn files(&self) -> Vec<String> {
        let output = Command::new(program(self.program)).args(["schema", self.format]).output();
        let schema: Value =
            serde_json::from_slice(&output.expect("it starts").stdout).expect("JSON");
        let mut found = Vec::new();
        leaves(&schema, &schema, 0, &|value| value, &mut found);
        for text in self.sound {
            let value: toml::Value = toml::from_str(text).expect("a sound file");
            places(&serde_json::to_value(value).expect("no dates"), &|value| value, &mut found);
        }
        let texts = found.iter().filter_map(|value| toml::to_string(value).ok());
        let with = |text: String| NUMBERS.map(|number| text.replace(&PLACE.to_string(), number));
        texts.flat_map(with).collect()
    }

    /// What is wrong with what the program does with a file.
    fn failure(&self, dir: &Workdir, text: &str) -> Option<String> {
        dir.write(&self.file(), text);
        let said = std::fs::File::create(dir.path("said")).expect("writable");
        // what does not end when it is asked to is killed
        let mut command = Command::new("timeout");
        command.args(["-s", "INT", "-k", "10", "20"]).arg(program(self.program));
        command.args(self.arguments.split(' ')).current_dir(dir.path(""));
        command.env("PUFFER_PYTHON", "/bin/false").stdout(Stdio::null()).stderr(said);
        let status = command.status().expect("it starts");
        for left in ["run", "model", "plan"] {
            let _ = std::fs::remove_dir_all(dir.path(left));
        }
        let said = dir.text("said");
        let short = said.len() < 20_000;
        match status.code() {
            Some(0..=3 | 124) if !said.contains("panicked") && short => None,
            code => Some(format!("ends with {code:?}: {said}")),
        }
    }
}

/// Tries one in so many of all files, from the `seed`-th on; what is wrong with which.
pub fn campaign(dir: &Workdir, one_in: usize, seed: usize) -> Vec<String> {
    let mut failures = Vec::new();
    for reader in READERS {
        let files = reader.files();
        let mut tried = 0;
        for text in files.iter().skip(seed % one_in).step_by(one_in) {
            let failure = reader.failure(dir, text);
            failures.extend(failure.map(|what| format!("{} {what}\n{text}", reader.file())));
            tried += 1;
        }
        eprintln!(
            "{:<14} {tried} of {} files with a number at the limits",
            reader.file(),
            files.len()
        );
    }
    failures
}

/// The value with each of its numbers replaced in turn, in what `whole` makes of it.
fn places(value: &Value, whole: &dyn Fn(Value) -> Value, found: &mut Vec<Value>) {
    match value {
        Value::Number(_) => found.push(whole(json!(PLACE))),
        Value::Array(list) => {
            for (i, item) in list.iter().enumerate() {
                places(item, &|below| whole(replaced(list, i, below)), found);
            }
        }
        Value::Object(map) => {
            for (key, item) in map {
                places(item, &|below| whole(with(map, key, below)), found);
            }
        }
        _ => {}
    }
}

fn replaced(list: &[Value], i: usize, item: Value) -> Value {
    let mut changed = list.to_vec();
    changed[i] = item;
    changed.into()
}

fn with(map: &Map<String, Value>, key: &str, value: Value) -> Value {
    let mut changed = map.clone();
    changed.insert(key.to_owned(), value);
    changed.into()
}

/// Files of a schema, each with what is needed and one of its numbers.
fn leaves(
    root: &Value,
    schema: &Value,
    depth: usize,
    whole: &dyn Fn(Value) -> Value,
    found: &mut Vec<Value>,
) {
    let schema = resolved(root, schema);
    if depth > DEPTH {
        return;
    }
    let is = |kind: &str| {
        schema["type"] == kind
            || schema["type"].as_array().is_some_and(|t| t.contains(&json!(kind)))
    };
    if is("number") || is("integer") {
        found.push(whole(json!(PLACE)));
    }
    let own = least(root, schema, depth);
    for (key, below) in schema["properties"].as_object().into_iter().flatten() {
        let map = own.as_object().cloned().unwrap_or_default();
        leaves(root, below, depth + 1, &|value| whole(with(&map, key, value)), found);
    }
    if let Some(below) = schema.get("additionalProperties").filter(|below| below.is_object()) {
        leaves(root, below, depth + 1, &|value| whole(json!({ "x": value })), found);
    }
    if let Some(items) = schema.get("items").filter(|items| items.is_object()) {
        let list = own.as_array().filter(|list| !list.is_empty()).cloned();
        let list = list.unwrap_or_else(|| vec![Value::Null]);
        leaves(root, items, depth + 1, &|value| whole(replaced(&list, 0, value)), found);
    }
    for choice in ["oneOf", "anyOf", "allOf"] {
        for below in schema[choice].as_array().into_iter().flatten() {
            leaves(root, below, depth + 1, whole, found);
        }
    }
}

/// The least value that fits a schema, but for what it says of numbers and texts.
fn least(root: &Value, schema: &Value, depth: usize) -> Value {
    let schema = resolved(root, schema);
    if let Some(value) = schema.get("const") {
        return value.clone();
    }
    if let Some(first) = schema["enum"].as_array().and_then(|all| all.first()) {
        return first.clone();
    }
    let choice =
        ["oneOf", "anyOf", "allOf"].iter().find_map(|choice| schema[*choice].as_array()?.first());
    if let (Some(first), true) = (choice, depth <= DEPTH) {
        return least(root, first, depth + 1);
    }
    let kind = schema["type"].as_str().or_else(|| schema["type"][0].as_str()).unwrap_or_default();
    match kind {
        "object" => {
            let needed =
                schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let entry =
                |key: &str| (key.to_owned(), least(root, &schema["properties"][key], depth + 1));
            if depth > DEPTH { json!({}) } else { Value::Object(needed.map(entry).collect()) }
        }
        "array" => {
            let count = schema["minItems"].as_u64().unwrap_or(0).min(16);
            (0..count).map(|_| least(root, &schema["items"], depth + 1)).collect()
        }
        "number" | "integer" => json!(1),
        "boolean" => json!(false),
        _ => json!("cavity"),
    }
}

/// What a `$ref` stands for.
fn resolved<'s>(root: &'s Value, schema: &'s Value) -> &'s Value {
    let link = schema["$ref"].as_str().and_then(|link| link.strip_prefix('#'));
    link.and_then(|link| root.pointer(link)).unwrap_or(schema)
}
