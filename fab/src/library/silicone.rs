//! Silicones that can be cast: the facts of the solver's `silicones.toml`.
//!
//! That file says where its numbers come from and what they are worth. Here only what
//! casting needs is read; the laws of elasticity in it are the solver's.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

/// A silicone one can buy.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Silicone {
    /// Name on the bottle.
    pub name: String,
    /// Who sells it.
    pub vendor: String,
    /// Density when mixed [kg/m³], if known.
    pub density: Option<f64>,
    /// Parts by weight, such as `1A:1B`, if known.
    pub mix: Option<String>,
    /// Time to pour after mixing [min], if known.
    pub pot_life_min: Option<f64>,
    /// Time to demold at 23 °C [h], if known.
    pub cure_h: Option<f64>,
    /// What else casting needs, if known.
    pub casting: Option<Facts>,
}

/// What only those who cast need to know.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Key of the source of all of the silicone's numbers but its fits.
    pub source: String,
    /// How it cures.
    pub chemistry: Chemistry,
    /// Elongation at break [%], if known.
    pub elongation: Option<f64>,
    /// Linear shrinkage, at most [%], if known.
    pub shrinkage: Option<f64>,
    /// Viscosity after mixing [Pa s], if known.
    pub viscosity: Option<f64>,
}

/// How a silicone cures.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Chemistry {
    /// By addition with platinum: does not shrink, but sulphur, tin, latex and uncured resin inhibit it.
    Platinum,
    /// By condensation with tin: shrinks.
    Tin,
}

#[derive(Deserialize)]
struct Library {
    source: BTreeMap<String, Source>,
    silicone: BTreeMap<String, Silicone>,
}

#[derive(Deserialize)]
struct Source {
    citation: String,
}

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let text = include_str!("../../../solver/silicones.toml");
    toml::from_str(text).expect("silicones.toml is checked by a test")
});

/// The silicone of a name such as `dragon-skin-20`, or the names there are.
///
/// # Errors
/// If there is none of that name.
pub fn find(key: &str) -> Result<&'static Silicone, String> {
    LIBRARY.silicone.get(key).ok_or_else(|| {
        let known: Vec<&str> = LIBRARY.silicone.keys().map(String::as_str).collect();
        format!("{key:?} is no known silicone; known are {}", known.join(", "))
    })
}

impl Silicone {
    /// Parts A and B by weight, which add up to 1.
    #[must_use]
    pub fn shares(&self) -> Option<[f64; 2]> {
        let (a, b) = self.mix.as_ref()?.split_once(':')?;
        let part = |text: &str, letter| text.strip_suffix(letter)?.parse::<f64>().ok();
        let (a, b) = (part(a, 'A')?, part(b, 'B')?);
        Some([a / (a + b), b / (a + b)])
    }

    /// Where its numbers come from, if that is known.
    #[must_use]
    pub fn citation(&self) -> Option<&'static str> {
        let source = LIBRARY.source.get(&self.casting.as_ref()?.source)?;
        Some(&source.citation)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn facts_are_complete_and_have_a_source() {
        let known = LIBRARY.silicone.iter().filter(|(_, s)| s.casting.is_some());
        let known: Vec<_> = known.collect();
        assert!(known.len() >= 6);
        for (key, silicone) in known {
            assert!(silicone.citation().is_some(), "{key}");
            let [a, b] = silicone.shares().unwrap();
            assert!((a + b - 1.0).abs() < 1e-15 && a >= b && b > 0.0, "{key}");
            // Rubbers without heavy fillers; a pot life ends before demolding.
            assert!(silicone.density.is_none_or(|d| (950.0..1300.0).contains(&d)), "{key}");
            let cure = silicone.cure_h.unwrap();
            assert!(silicone.pot_life_min.is_none_or(|m| m / 60.0 < cure), "{key}");
        }
    }

    #[test]
    fn shares_are_those_of_the_bottle() {
        assert_eq!(find("dragon-skin-20").unwrap().shares(), Some([0.5, 0.5]));
        assert_eq!(find("elastosil-m4601").unwrap().shares(), Some([0.9, 0.1]));
        let message = find("rubber").unwrap_err();
        assert!(message.contains("ecoflex-00-30"), "{message}");
    }
}
