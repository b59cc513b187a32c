//! A JSON file of which every key is accounted for.
//!
//! A key that is looked up counts as read. All others, and those that are left out on purpose, are listed at the end with
//! the reason, so that none is dropped silently.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Error, Result, anyhow};
use serde_json::Value;

/// A JSON file, and which of its keys were read.
pub struct Document {
    /// Where it came from.
    pub path: PathBuf,
    /// Fingerprint of the file.
    pub sha256: String,
    root: Value,
    read: RefCell<BTreeSet<String>>,
    /// Keys that are left out, and why.
    left: RefCell<BTreeMap<String, String>>,
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
        let (read, left) = (RefCell::new([String::new()].into()), RefCell::default());
        let sha256 = program::sha256_file(path)?;
        Ok(Self { path: path.to_path_buf(), sha256, root, read, left })
    }

    /// The outermost object.
    pub fn root(&self) -> Key<'_> {
        Key { document: self, pointer: String::new(), value: &self.root }
    }

    /// Keys that have no part in our scene, in order, with the reason. Keys that were not read get that of the longest
    /// prefix in `reasons`, patterns of pointers in which `*` is any one word, or else count as unknown.
    pub fn left(&self, reasons: &[(&str, &str)]) -> BTreeMap<String, String> {
        let mut left = self.left.borrow().clone();
        self.collect("", &self.root, reasons, &mut left);
        left
    }

    fn collect(
        &self,
        pointer: &str,
        value: &Value,
        reasons: &[(&str, &str)],
        left: &mut BTreeMap<String, String>,
    ) {
        if left.contains_key(pointer) {
            return;
        }
        let known = || reasons.iter().filter(|(pattern, _)| agree(pattern, pointer));
        let is_read = self.read.borrow().contains(pointer);
        if is_read || known().next().is_some() {
            let below: Vec<(String, &Value)> = match value {
                Value::Object(members) => members.iter().map(|(k, v)| (k.clone(), v)).collect(),
                Value::Array(items) if items.iter().any(|v| v.is_object() || v.is_array()) => {
                    items.iter().enumerate().map(|(i, v)| (i.to_string(), v)).collect()
                }
                _ => Vec::new(),
            };
            for (name, value) in &below {
                self.collect(&format!("{pointer}/{name}"), value, reasons, left);
            }
            if is_read || !below.is_empty() {
                return;
            }
        }
        let above = known().filter(|(pattern, _)| depth(pattern) <= depth(pointer));
        let why = above.max_by_key(|(pattern, _)| pattern.len()).map_or("unknown key", |r| r.1);
        left.insert(pointer.to_owned(), why.to_owned());
    }
}

/// Whether a pattern and a pointer are the same as far as the shorter one goes.
fn agree(pattern: &str, pointer: &str) -> bool {
    pattern.split('/').zip(pointer.split('/')).all(|(own, word)| own == "*" || own == word)
}

fn depth(pointer: &str) -> usize {
    pointer.split('/').count()
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
    /// What is below it.
    fn below(&self, name: impl std::fmt::Display, value: &'a Value) -> Self {
        let pointer = format!("{}/{name}", self.pointer);
        self.document.read.borrow_mut().insert(pointer.clone());
        Key { document: self.document, pointer, value }
    }

    /// A member; none if it is absent or null.
    pub fn get(&self, name: &str) -> Option<Key<'a>> {
        let value = self.value.get(name).filter(|v| !v.is_null())?;
        Some(self.below(name, value))
    }

    /// The value of a member, if it is there.
    pub fn optional<T>(&self, name: &str, value: fn(&Self) -> Result<T>) -> Result<Option<T>> {
        self.get(name).as_ref().map(value).transpose()
    }

    /// A member that must be there.
    pub fn need(&self, name: &str, what: &str) -> Result<Key<'a>> {
        self.get(name).ok_or_else(|| self.wrong(&format!("there is no \"{name}\", {what}")))
    }

    /// The items of a list; of anything else, itself.
    pub fn items(&self) -> Vec<Key<'a>> {
        let Some(items) = self.value.as_array() else { return vec![self.clone()] };
        items.iter().enumerate().map(|(i, value)| self.below(i, value)).collect()
    }

    /// The items of a member; none if it is absent.
    pub fn items_of(&self, name: &str) -> Vec<Key<'a>> {
        self.get(name).map(|key| key.items()).unwrap_or_default()
    }

    /// Notes why it is left out, with everything below it.
    pub fn leave(&self, why: &str) {
        let mut left = self.document.left.borrow_mut();
        let below = format!("{}/", self.pointer);
        left.retain(|pointer, _| !pointer.starts_with(&below));
        left.insert(self.pointer.clone(), why.to_owned());
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
