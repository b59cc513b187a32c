//! Tubes that carry the air into a body.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::Catalog;

/// A tube. Lengths are millimetres.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Tube {
    /// What to ask for.
    pub name: String,
    /// Diameter of what is pushed into the silicone [mm].
    pub outer: f64,
    /// Diameter of the air channel [mm].
    pub inner: f64,
    /// Key of the source of its numbers.
    pub source: String,
}

/// All tubes.
pub fn tubes() -> &'static Catalog<Tube> {
    static CATALOG: LazyLock<Catalog<Tube>> =
        LazyLock::new(|| Catalog::new("tube", include_str!("../tubes.toml")));
    &CATALOG
}

impl Tube {
    /// Where its numbers come from.
    pub fn citation(&self) -> &'static str {
        &tubes().source(&self.source).citation
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tubes_can_be_and_have_a_source() {
        for (key, tube) in tubes().iter() {
            assert!(!tube.citation().is_empty(), "{key}");
            assert!(0.5 < tube.inner && tube.inner < tube.outer && tube.outer < 20.0, "{key}");
        }
        assert!(tubes().find("hose").unwrap_err().contains("tube-6x4"));
    }
}
