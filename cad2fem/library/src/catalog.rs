//! The form that the library files have in common.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Names at least as similar as this are proposed for an unknown one; 1 is equality
/// (normalised Damerau–Levenshtein similarity).
const SIMILAR: f64 = 0.5;

/// Entries of one kind by key, and the sources of their numbers.
pub struct Catalog<T> {
    kind: &'static str,
    sources: BTreeMap<String, Source>,
    entries: BTreeMap<String, T>,
}

/// Where numbers come from.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Document, and how its numbers were obtained from it.
    pub citation: String,
    /// Licence of the numbers.
    pub licence: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File<T> {
    source: BTreeMap<String, Source>,
    #[serde(alias = "silicone", alias = "printed", alias = "printer", alias = "tube")]
    entry: BTreeMap<String, T>,
}

impl<T: DeserializeOwned> Catalog<T> {
    /// Reads a library file; `kind` names an entry in messages.
    ///
    /// # Panics
    /// If the text does not fit. It is compiled in, and tests read it.
    pub(crate) fn new(kind: &'static str, text: &str) -> Self {
        let File { source, entry } = toml::from_str(text).expect("tests read the library files");
        Self { kind, sources: source, entries: entry }
    }
}

impl<T> Catalog<T> {
    /// The entry of a key.
    pub fn find(&self, key: &str) -> Result<&T, String> {
        self.entries.get(key).ok_or_else(|| {
            let similar = self
                .nearest(key)
                .map_or(String::new(), |nearest| format!("; did you mean {nearest:?}?"));
            let known: Vec<&str> = self.entries.keys().map(String::as_str).collect();
            let separator = if similar.is_empty() { ";" } else { "" };
            format!(
                "{key:?} is no known {}{similar}{separator} known are {}",
                self.kind,
                known.join(", ")
            )
        })
    }

    /// All entries in the order of their keys.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &T)> {
        self.entries.iter().map(|(key, entry)| (key.as_str(), entry))
    }

    /// The source of a key.
    ///
    /// # Panics
    /// If an entry names a source that the file does not have; tests check all entries.
    pub fn source(&self, key: &str) -> &Source {
        self.known_source(key).expect("tests look up the sources of all entries")
    }

    /// The source of a key, if the file has it.
    pub(crate) fn known_source(&self, key: &str) -> Option<&Source> {
        self.sources.get(key)
    }

    fn nearest(&self, key: &str) -> Option<&str> {
        let similarity = |known: &str| strsim::normalized_damerau_levenshtein(key, known);
        let rated = self.entries.keys().map(|known| (similarity(known), known.as_str()));
        let (best, known) = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best >= SIMILAR).then_some(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers() -> Catalog<f64> {
        Catalog::new("number", "entry = { one = 1.0, three = 3.0 }\n[source]")
    }

    #[test]
    fn a_similar_key_is_proposed_and_all_are_listed() {
        assert_eq!(numbers().find("three"), Ok(&3.0));
        let message = numbers().find("tree").expect_err("misspelt");
        assert_eq!(
            message,
            "\"tree\" is no known number; did you mean \"three\"? known are one, three"
        );
        let message = numbers().find("x").expect_err("nothing like it");
        assert_eq!(message, "\"x\" is no known number; known are one, three");
    }
}
