//! Results whose every text would run as part of a page, if the page took it for markup.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::chromium::Chromium;

/// Objects whose keys are names that people give, or parts of a program.
const NAMED: [&str; 11] = [
    "probes",
    "chambers",
    "tags",
    "error_bars",
    "mean_displacement",
    "reactions",
    "terms",
    "terms_before",
    "terms_after",
    "energies",
    "set",
];

/// Texts that are replaced, with the number by which each is known.
#[derive(Debug, Default)]
pub struct Hostile {
    numbers: BTreeMap<String, usize>,
    /// Texts that stay, such as hashes, with what stands for them now.
    pub kept: BTreeMap<String, String>,
    /// Keys whose texts stay.
    places: Vec<&'static str>,
}

impl Hostile {
    /// Replaces all texts but those of the keys `places`, which say where files are.
    pub fn but(places: Vec<&'static str>) -> Self {
        Self { places, ..Self::default() }
    }

    /// How many texts were replaced.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }

    fn number(&mut self, text: &str) -> usize {
        let next = self.numbers.len() + 1;
        *self.numbers.entry(text.to_owned()).or_insert(next)
    }

    /// What stands for a text: it ends or begins whatever it may stand in, and then runs.
    pub fn text(&mut self, text: &str) -> String {
        if let Some(kept) = self.kept.get(text) {
            return kept.clone();
        }
        let n = self.number(text);
        let run = format!("window.hit={n}");
        format!(
            "#{n};\"'>--></script></style></title><script>{run}</script><img src=x onerror={run}>\
             <svg onload=\"{run}\"></svg><script src=\"data:text/javascript,{run}\"></script>\
             <iframe srcdoc=\"<script>parent.{run}</script>\"></iframe><a href='javascript:{run}'>x</a>\
             <link rel=stylesheet href='data:text/css,*{{display:none}}'><style>body{{display:none}}</style>\
             `${{{run}}}` {{{{{run}}}}} ]]>&lt;b&gt; javascript:{run}"
        )
    }

    /// The same for names of files and tags: no quotes, slashes and ends of lines.
    pub fn name(&mut self, text: &str) -> String {
        let n = self.number(text);
        format!("#{n};<img src=x onerror=window.hit={n}><svg onload=window.hit={n}><b>")
    }

    /// A value of JSON with all its texts, and keys that are names, replaced.
    pub fn json(&mut self, value: &Value) -> Value {
        self.json_at("", value)
    }

    fn json_at(&mut self, key: &str, value: &Value) -> Value {
        match value {
            Value::String(text) if self.places.contains(&key) => json!(text),
            Value::String(text) => json!(self.text(text)),
            Value::Array(list) => list.iter().map(|item| self.json_at(key, item)).collect(),
            Value::Object(map) => {
                let named = NAMED.contains(&key);
                let mut changed = Map::new();
                for (name, below) in map {
                    let under = if named { "" } else { name };
                    let below = self.json_at(under, below);
                    changed.insert(if named { self.text(name) } else { name.clone() }, below);
                }
                changed.into()
            }
            other => other.clone(),
        }
    }

    /// Replaces the texts of a file of JSON, a value in all or in each line.
    pub fn json_file(&mut self, path: &Path) {
        let text = fs::read_to_string(path).expect("a file of the test");
        let parsed = |text: &str| serde_json::from_str::<Value>(text).expect("JSON");
        let changed = match path.extension().is_some_and(|e| e == "jsonl") {
            true => text.lines().map(|line| self.json(&parsed(line)).to_string() + "\n").collect(),
            false => self.json(&parsed(&text)).to_string(),
        };
        fs::write(path, changed).expect("a file of the test");
    }
}

/// All files below a folder.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the test").flatten() {
            let path = entry.path();
            if path.is_dir() { folders.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// Whether nothing of the texts became part of the open page: nothing has run, nothing was
/// asked for, there are no elements and attributes that ours has not.
pub fn assert_text_alone(browser: &mut Chromium) {
    assert_eq!(browser.evaluate("window.hit ?? null"), Value::Null, "a text has run");
    let foreign = "iframe, object, embed, base, a:not([href^=\"./\"]), b, [srcdoc], [src]:not([src^=\"data:image/\"]), main script, \
                   header script, main style, link:not([rel=icon])";
    let all = format!(
        "[...document.querySelectorAll({foreign:?})].map((e) => e.outerHTML.slice(0, 300))"
    );
    assert_eq!(browser.evaluate(&all), json!([]), "elements of a text");
    let handlers = "[...document.querySelectorAll('*')].flatMap((e) => e.getAttributeNames())\
                    .filter((name) => name.startsWith('on') || !/^[\\w:-]+$/.test(name))";
    assert_eq!(browser.evaluate(handlers), json!([]), "attributes of a text");
    assert_eq!(browser.complaints(), [""; 0]);
    let page = |url: &String| url.starts_with("file://") && url.ends_with(".html");
    assert!(browser.requests().iter().all(page), "{:?}", browser.requests());
}

/// How many of the texts are shown.
pub fn shown(browser: &mut Chromium) -> u64 {
    let ids = "new Set(document.body.textContent.match(/#\\d+;/g)).size";
    browser.evaluate(ids).as_u64().expect("a number")
}

/// The page without its policy, which might hide what is not escaped.
pub fn without_policy(page: &Path) -> PathBuf {
    let text = fs::read_to_string(page).expect("a page");
    let policy = "http-equiv=\"Content-Security-Policy\"";
    assert_eq!(text.matches(policy).count(), 1);
    let bare = page.with_extension("bare.html");
    fs::write(&bare, text.replace(policy, "name=\"none\"")).expect("writable");
    bare
}
