//! Tubes that may be named in mold.toml: those of `fittings.toml`, with sources.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

/// A tube. Lengths are millimetres.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Fitting {
    /// What to ask for.
    pub name: String,
    /// Diameter of what is pushed into the silicone [mm].
    pub outer: f64,
    /// Diameter of the way for the air [mm].
    pub inner: f64,
    /// Key of the source of its numbers.
    pub source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Library {
    source: BTreeMap<String, Source>,
    fitting: BTreeMap<String, Fitting>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Source {
    citation: String,
}

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    toml::from_str(include_str!("../../fittings.toml")).expect("fittings.toml is checked by a test")
});

/// The tube of a name such as `tube-4x2.5`, or the names there are.
///
/// # Errors
/// If there is none of that name.
pub fn find(key: &str) -> Result<&'static Fitting, String> {
    LIBRARY.fitting.get(key).ok_or_else(|| {
        let known: Vec<&str> = LIBRARY.fitting.keys().map(String::as_str).collect();
        format!(
            "{key:?} is no known tube; known are {}; or give outer and inner instead",
            known.join(", ")
        )
    })
}

impl Fitting {
    /// Where its numbers come from.
    #[must_use]
    pub fn citation(&self) -> &'static str {
        LIBRARY.source.get(&self.source).map_or("", |source| &source.citation)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tubes_can_be_and_have_a_source() {
        for (key, tube) in &LIBRARY.fitting {
            assert!(!tube.citation().is_empty(), "{key}");
            assert!(0.5 < tube.inner && tube.inner < tube.outer && tube.outer < 20.0, "{key}");
        }
        assert!(find("hose").unwrap_err().contains("tube-6x4"));
    }
}
