//! A JSON file of which every key is accounted for.
//!
//! Code that reads a key records what becomes of it; keys that were not read are listed
//! at the end, so that none is dropped silently.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Error, Result, anyhow};
use serde_json::Value;

/// What became of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// What of our scene it became.
    Translated(String),
    /// Why it has no part in our scene.
    Left(String),
}

/// A JSON file and what became of its keys.
pub struct Document {
    /// Where it came from.
    pub path: PathBuf,
    /// Fingerprint of the file.
    pub sha256: String,
    root: Value,
    fates: RefCell<BTreeMap<String, Fate>>,
    /// Keys that were looked into.
    entered: RefCell<BTreeSet<String>>,
}

impl Document {
    /// Reads a JSON file.
    pub fn read(path: &Path) -> Result<Self> {
        let text = mesh::io::read_text(path)?;
        let root: Value = serde_json::from_str(&text)
            .map_err(|e| anyhow!("{}: not JSON: {e}", path.display()))?;
        if !root.is_object() {
            return Err(anyhow!("{}: a list or a value; expected {{...}}", path.display()));
        }
        let (fates, entered) = Default::default();
        let sha256 = program::sha256_file(path)?;
        Ok(Self { path: path.to_path_buf(), sha256, root, fates, entered })
    }

    /// The outermost object.
    pub fn root(&self) -> Key<'_> {
        Key { document: self, pointer: String::new(), value: &self.root }
    }

    /// Keys in order, with what became of them. Keys that were not read get
    /// the reason of the longest prefix in `reasons`, patterns of pointers in
    /// which `*` is any one word, or else count as unknown.
    pub fn fates(&self, reasons: &[(&str, &str)]) -> BTreeMap<String, Fate> {
        let mut fates = self.fates.borrow().clone();
        self.collect("", &self.root, reasons, &mut fates);
        fates
    }

    fn collect(
        &self,
        pointer: &str,
        value: &Value,
        reasons: &[(&str, &str)],
        fates: &mut BTreeMap<String, Fate>,
    ) {
        if fates.contains_key(pointer) {
            return;
        }
        let reason = reasons.iter().filter(|r| matches(r.0, pointer)).max_by_key(|r| r.0.len());
        let entered = self.entered.borrow().contains(pointer);
        let empty = value.as_object().is_some_and(serde_json::Map::is_empty)
            || value.as_array().is_some_and(Vec::is_empty);
        if entered && empty {
            return;
        }
        let known = entered || reason.is_some();
        let expected = reasons.iter().any(|r| matches_start(r.0, pointer));
        if pointer.is_empty() || known || expected {
            match value {
                Value::Object(members) if !members.is_empty() => {
                    for (key, value) in members {
                        self.collect(&format!("{pointer}/{key}"), value, reasons, fates);
                    }
                    return;
                }
                Value::Array(items)
                    if items.iter().any(|v| v.is_object() || v.is_array())
                        || fates.contains_key(&format!("{pointer}/0")) =>
                {
                    for (i, value) in items.iter().enumerate() {
                        self.collect(&format!("{pointer}/{i}"), value, reasons, fates);
                    }
                    return;
                }
                _ => {}
            }
        }
        let why = reason.map_or("unknown key", |r| r.1);
        fates.insert(pointer.to_owned(), Fate::Left(why.to_owned()));
    }
}

/// Whether a pattern is a pointer or the start of it.
fn matches(pattern: &str, pointer: &str) -> bool {
    let mut words = pointer.split('/');
    pattern.split('/').all(|p| words.next().is_some_and(|w| p == "*" || p == w))
}

/// Whether a pointer is the start of a pattern.
fn matches_start(pattern: &str, pointer: &str) -> bool {
    let mut words = pattern.split('/');
    pointer.split('/').all(|w| words.next().is_some_and(|p| p == "*" || p == w))
}

/// A value with its place in the document.
#[derive(Clone)]
pub struct Key<'a> {
    /// The file.
    pub document: &'a Document,
    /// The place, such as `/contact/dhat`.
    pub pointer: String,
    /// The value.
    pub value: &'a Value,
}

impl<'a> Key<'a> {
    /// A member; none if it is absent or null.
    pub fn get(&self, name: &str) -> Option<Key<'a>> {
        self.enter();
        let value = self.value.get(name).filter(|v| !v.is_null())?;
        let pointer = format!("{}/{name}", self.pointer);
        Some(Key { document: self.document, pointer, value })
    }

    /// A member that must be there.
    pub fn need(&self, name: &str, what: &str) -> Result<Key<'a>> {
        self.get(name).ok_or_else(|| self.wrong(&format!("there is no \"{name}\", {what}")))
    }

    /// The items of a list; of anything else, itself.
    pub fn items(&self) -> Vec<Key<'a>> {
        self.enter();
        let Some(items) = self.value.as_array() else { return vec![self.clone()] };
        let item = |(i, value): (usize, &'a Value)| Key {
            document: self.document,
            pointer: format!("{}/{i}", self.pointer),
            value,
        };
        items.iter().enumerate().map(item).collect()
    }

    fn enter(&self) {
        self.document.entered.borrow_mut().insert(self.pointer.clone());
    }

    /// Notes what it becomes; everything below it counts as translated, too.
    pub fn becomes(self, what: &str) -> Self {
        self.note(Fate::Translated(what.to_owned()));
        self
    }

    /// Notes why it is left out, with everything below it.
    pub fn leave(&self, why: &str) {
        self.note(Fate::Left(why.to_owned()));
    }

    fn note(&self, fate: Fate) {
        let mut fates = self.document.fates.borrow_mut();
        if matches!(fate, Fate::Left(_)) {
            let below = format!("{}/", self.pointer);
            fates.retain(|pointer, _| !pointer.starts_with(&below));
        }
        fates.insert(self.pointer.clone(), fate);
    }

    /// An error at this place.
    pub fn wrong(&self, what: &str) -> Error {
        let place = if self.pointer.is_empty() { "/" } else { &self.pointer };
        anyhow!("{}: {place}: {what}", self.document.path.display())
    }

    /// The error that it should have been something else.
    fn instead(&self, needed: &str) -> Error {
        let mut found = self.value.to_string();
        if found.len() > 60 {
            found = found.chars().take(60).collect::<String>() + "…";
        }
        self.wrong(&format!("found {found}, expected {needed}"))
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64> {
        self.value.as_f64().filter(|n| n.is_finite()).ok_or_else(|| self.instead("a number"))
    }

    /// A positive number.
    pub fn positive(&self) -> Result<f64> {
        self.number()
            .ok()
            .filter(|&n| n > 0.0)
            .ok_or_else(|| self.instead("a number greater than 0"))
    }

    /// A whole number that is not negative.
    pub fn count(&self) -> Result<usize> {
        let count = self.value.as_u64().and_then(|n| usize::try_from(n).ok());
        count.ok_or_else(|| self.instead("a whole number, 0 or more"))
    }

    /// The id of a selection or of a volume.
    pub fn id(&self) -> Result<i64> {
        self.value.as_i64().ok_or_else(|| self.instead("a whole number"))
    }

    /// Ids, one or a list.
    pub fn ids(&self) -> Result<Vec<i64>> {
        self.items().iter().map(Key::id).collect()
    }

    /// A text.
    pub fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.instead("a text in quotes"))
    }

    /// Yes or no.
    pub fn flag(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.instead("true or false"))
    }

    /// `dimension` numbers.
    pub fn numbers(&self, dimension: usize) -> Result<Vec<f64>> {
        let items = self.value.as_array().filter(|items| items.len() == dimension);
        let numbers = items.and_then(|items| items.iter().map(Value::as_f64).collect());
        numbers.ok_or_else(|| self.instead(&format!("a list of {dimension} numbers")))
    }

    /// A file name as seen from the folder of the document.
    pub fn file(&self) -> Result<PathBuf> {
        Ok(::scene::config::beside(&self.document.path, Path::new(self.text()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(text: &str) -> Document {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.json");
        std::fs::write(&path, text).expect("writable");
        Document::read(&path).expect("sound")
    }

    #[test]
    fn every_key_has_a_fate_and_strangers_are_named_once() {
        let text = r#"{"a": {"b": 1, "c": [1, 2], "d": {"e": 5, "f": 6}}, "g": {"h": {"i": 1}},
            "list": [{"id": 1, "x": 2}, {"id": 2}], "out": {"log": 1, "deep": {"er": 2}}, "e": {}}"#;
        let document = document(text);
        let a = document.root().get("a").expect("there");
        assert_eq!(a.get("b").expect("there").becomes("ours").number().expect("one"), 1.0);
        a.get("c").expect("there").leave("why");
        for item in document.root().get("list").expect("there").items() {
            let _ = item.get("id").expect("there").becomes("tag");
        }
        let reasons = [("/out", "own files"), ("/list/*/x", "no x"), ("/a/d/e", "no e")];
        let fates = document.fates(&reasons);
        let left = |why: &str| Fate::Left(why.to_owned());
        let expected = [
            ("/a/b", Fate::Translated("ours".to_owned())),
            ("/a/c", left("why")),
            ("/a/d/e", left("no e")),
            ("/a/d/f", left("unknown key")),
            ("/e", left("unknown key")),
            ("/g", left("unknown key")),
            ("/list/0/id", Fate::Translated("tag".to_owned())),
            ("/list/0/x", left("no x")),
            ("/list/1/id", Fate::Translated("tag".to_owned())),
            ("/out/deep/er", left("own files")),
            ("/out/log", left("own files")),
        ];
        assert_eq!(fates, expected.map(|(k, f)| (k.to_owned(), f)).into());
    }

    #[test]
    fn what_does_not_fit_is_reported_with_its_place() {
        let document = document(r#"{"a": {"b": [1, "x"], "n": 1.5}, "c": true}"#);
        let root = document.root();
        let a = root.get("a").expect("there");
        let refused = |e: Error, words: &str| {
            let message = e.to_string();
            assert!(message.contains("scene.json: ") && message.contains(words), "{message}");
        };
        let b = a.get("b").expect("there");
        refused(
            b.numbers(2).expect_err("x"),
            "/a/b: found [1,\"x\"], expected a list of 2 numbers",
        );
        refused(b.items()[1].number().expect_err("x"), "/a/b/1: found \"x\", expected a number");
        refused(a.get("n").expect("there").id().expect_err("1.5"), "found 1.5, expected a whole");
        refused(
            root.need("z", "the last letter").err().expect("absent"),
            "/: there is no \"z\", the",
        );
        refused(
            root.get("c").expect("there").text().expect_err("true"),
            "/c: found true, expected",
        );
    }

    #[test]
    fn what_is_no_json_object_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (text, words) in [("{", "not JSON"), ("[1]", "a list or a value")] {
            let path = folder.path().join("scene.json");
            std::fs::write(&path, text).expect("writable");
            let message = Document::read(&path).err().expect(text).to_string();
            assert!(message.contains("scene.json") && message.contains(words), "{message}");
        }
    }
}
