//! Silicones: data of their makers, and laws of elasticity fitted to tests of them.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::{Catalog, Source};

/// A silicone one can buy.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Silicone {
    /// Name on the bottle.
    pub name: String,
    /// Who sells it.
    pub vendor: String,
    /// Key of the source of all numbers but the fits, if there are any.
    pub source: Option<String>,
    /// Density when mixed [kg/m³], if known.
    pub density: Option<f64>,
    /// Parts by weight, such as `1A:1B`, if known.
    pub mix: Option<String>,
    /// Time to pour after mixing [min], if known.
    pub pot_life_min: Option<f64>,
    /// Time to demold at 23 °C [h], if known.
    pub cure_h: Option<f64>,
    /// What else casting needs, if known.
    pub casting: Option<Casting>,
    /// Laws fitted to tests, the default first.
    #[serde(rename = "fit")]
    pub fits: Vec<Fit>,
}

/// What only casting needs to know.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Casting {
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

/// A law of elasticity fitted to tests of a silicone.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Fit {
    /// Key of the source of its numbers.
    pub source: String,
    /// Coefficient of determination of the fit, if known [1].
    pub r2: Option<f64>,
    /// `kind` of the law, its parameters and `stretch_range`, as in a table `[material]` of a
    /// scene. The solver builds the law of them.
    #[serde(flatten)]
    pub law: toml::Table,
}

/// All silicones.
#[must_use]
pub fn silicones() -> &'static Catalog<Silicone> {
    static CATALOG: LazyLock<Catalog<Silicone>> =
        LazyLock::new(|| Catalog::new("silicone", include_str!("../silicones.toml")));
    &CATALOG
}

impl Fit {
    /// Where its numbers come from, and their licence.
    #[must_use]
    pub fn source(&self) -> &'static Source {
        silicones().source(&self.source)
    }
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

    /// Where its numbers come from, if it has any but the fits.
    #[must_use]
    pub fn citation(&self) -> Option<&'static str> {
        let source = silicones().source(self.source.as_ref()?);
        Some(&source.citation)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn facts_are_complete_and_have_a_source() {
        let known = silicones().iter().filter(|(_, s)| s.casting.is_some());
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
        assert_eq!(silicones().find("dragon-skin-20").unwrap().shares(), Some([0.5, 0.5]));
        assert_eq!(silicones().find("elastosil-m4601").unwrap().shares(), Some([0.9, 0.1]));
        let message = silicones().find("rubber").unwrap_err();
        assert!(message.contains("ecoflex-00-30"), "{message}");
    }
}
