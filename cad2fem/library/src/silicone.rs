//! Silicones and printed elastomers: data of their makers, and laws of elasticity fitted to tests of them.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::{Catalog, PrinterKind, Source};

/// A silicone one can buy, or another elastomer that is printed.
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
    /// How it is printed, if it is.
    pub printed: Option<Printed>,
    /// How much softer than its laws it may be, if known.
    pub softening: Option<Softening>,
    /// Laws by all sources that are known, the default first.
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

/// What is known of an elastomer that is printed.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Printed {
    /// What it is printed of.
    pub process: PrinterKind,
    /// Shore A hardness.
    pub hardness: f64,
    /// Elongation at break [%], if known.
    pub elongation: Option<f64>,
}

/// How much softer than its laws a silicone may be.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Softening {
    /// Key of the source.
    pub source: String,
    /// Part by which strain grows while a load is held [1], if known.
    pub creep: Option<f64>,
    /// Part by which stress falls once it has been stretched before (Mullins effect) [1], if known.
    pub mullins: Option<f64>,
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

/// A law of elasticity of a silicone by one source.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Fit {
    /// Key of the source of its numbers.
    pub source: String,
    /// Key of the source of how it stiffens, if that is another.
    pub stiffening: Option<String>,
    /// How the modulus was found.
    pub test: Test,
    /// Shear modulus at rest [Pa]. It is that of the law; a test of the solver, which knows
    /// the laws, compares them.
    pub shear_modulus: f64,
    /// 100 % modulus of the datasheet: nominal stress at stretch 2 [Pa].
    pub modulus_100: Option<f64>,
    /// Coefficient of determination of the fit, if known [1].
    pub r2: Option<f64>,
    /// `kind` of the law, its parameters and `stretch_range`, as in a table `[material]` of a
    /// scene. The solver builds the law of them.
    #[serde(flatten)]
    pub law: toml::Table,
}

/// How a modulus was found.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Tension, unless the strain is known to be that of the crosshead.
    Tension,
    /// Bending of a beam.
    Bending,
    /// Compression of a block.
    Compression,
    /// By the vendor: one stress, at stretch 2.
    Datasheet,
    /// Tension, with strain from the crosshead: the modulus comes out low.
    Crosshead,
    /// None: Young's modulus by Gent's relation to the hardness.
    Hardness,
    /// The source does not say.
    NotStated,
}

/// All silicones.
pub fn silicones() -> &'static Catalog<Silicone> {
    static CATALOG: LazyLock<Catalog<Silicone>> =
        LazyLock::new(|| Catalog::new("silicone", include_str!("../silicones.toml")));
    &CATALOG
}

/// All elastomers that are printed.
pub fn printed() -> &'static Catalog<Silicone> {
    static CATALOG: LazyLock<Catalog<Silicone>> =
        LazyLock::new(|| Catalog::new("printed elastomer", include_str!("../printed.toml")));
    &CATALOG
}

/// The source of a key, in one of both files.
fn source(key: &str) -> &'static Source {
    printed().known_source(key).unwrap_or_else(|| silicones().source(key))
}

impl Fit {
    /// Where its numbers come from, and their licence.
    pub fn source(&self) -> &'static Source {
        source(&self.source)
    }
}

impl Test {
    /// The test in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Bending => "bending",
            Self::Compression => "compression",
            Self::Datasheet => "100 % modulus",
            Self::Crosshead => "tension, crosshead strain",
            Self::Hardness => "Shore hardness alone",
            Self::NotStated => "test not stated",
        }
    }
}

impl Silicone {
    /// Smallest and largest shear modulus at rest of all sources [Pa].
    pub fn shear_moduli(&self) -> [f64; 2] {
        let moduli = self.fits.iter().map(|fit| fit.shear_modulus);
        moduli.fold([f64::INFINITY, 0.0], |[low, high], m| [m.min(low), m.max(high)])
    }

    /// The shear modulus of one of its fits, and what that is worth, in a line.
    pub fn modulus_in_words(&self, fit: &Fit) -> String {
        let Fit { source, test, shear_modulus, .. } = fit;
        let [low, high] = self.shear_moduli();
        let spread = if self.fits.iter().any(|other| other.source != *source) {
            format!("sources give {} to {} kPa", kilopascals(low), kilopascals(high))
        } else if *test == Test::Crosshead && self.printed.is_none() {
            let [least, most] = above_crosshead();
            format!(
                "no other source; other silicones have {least:.1} to {most:.1} times as much as such tests say"
            )
        } else {
            "no other source".to_owned()
        };
        format!(
            "shear modulus {} kPa ({source}, {}); {spread}",
            kilopascals(*shear_modulus),
            test.words()
        )
    }

    /// Elongation at break [%], if known.
    pub fn elongation(&self) -> Option<f64> {
        let cast = self.casting.as_ref().and_then(|casting| casting.elongation);
        cast.or_else(|| self.printed.as_ref()?.elongation)
    }

    /// Parts A and B by weight, which add up to 1.
    pub fn shares(&self) -> Option<[f64; 2]> {
        let (a, b) = self.mix.as_ref()?.split_once(':')?;
        let part = |text: &str, letter| text.strip_suffix(letter)?.parse::<f64>().ok();
        let (a, b) = (part(a, 'A')?, part(b, 'B')?);
        Some([a / (a + b), b / (a + b)])
    }

    /// Where its numbers come from, if it has any but the fits.
    pub fn citation(&self) -> Option<&'static str> {
        Some(&source(self.source.as_ref()?).citation)
    }
}

/// Three digits of a modulus in kPa.
pub fn kilopascals(modulus: f64) -> String {
    let value = 1e-3 * modulus;
    match value {
        ..10.0 => format!("{value:.2}"),
        ..100.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}

/// Smallest and largest ratio of the default to the first fit to crosshead strain, of all silicones that
/// have another default [1].
fn above_crosshead() -> [f64; 2] {
    let ratio = |(_, silicone): (&str, &Silicone)| {
        let default = silicone.fits.first().filter(|fit| fit.test != Test::Crosshead)?;
        let crosshead = silicone.fits.iter().find(|fit| fit.test == Test::Crosshead)?;
        Some(default.shear_modulus / crosshead.shear_modulus)
    };
    let ratios = silicones().iter().filter_map(ratio);
    ratios.fold([f64::INFINITY, 0.0], |[low, high], r| [r.min(low), r.max(high)])
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
    fn printed_elastomers_have_their_sources_and_hardness() {
        for (key, elastomer) in printed().iter() {
            let Some(of_printing) = &elastomer.printed else { panic!("{key}") };
            assert!((20.0..=95.0).contains(&of_printing.hardness), "{key}");
            // the number of the name is the hardness
            assert!(key.contains(&format!("{:.0}", of_printing.hardness)), "{key}");
            assert!(elastomer.casting.is_none() && elastomer.mix.is_none(), "{key}");
            let facts = elastomer.density.or(elastomer.elongation());
            assert_eq!(facts.is_some(), elastomer.citation().is_some(), "{key}");
            for fit in elastomer.fits.iter().filter(|fit| fit.test == Test::Hardness) {
                // Gent's relation [MPa]
                let shore = of_printing.hardness;
                let young =
                    0.0981 * (56.0 + 7.62336 * shore) / (0.137_505 * (254.0 - 2.54 * shore));
                let shear = young * 1e6 / (2.0 * 1.497_504);
                assert!((fit.shear_modulus / shear - 1.0).abs() < 1e-3, "{key}: {shear}");
            }
        }
        assert!(silicones().iter().all(|(_, silicone)| silicone.printed.is_none()));
    }

    #[test]
    fn every_range_holds_its_default_and_says_what_it_is_worth() {
        for (key, silicone) in silicones().iter().chain(printed().iter()) {
            let ([low, high], default) = (silicone.shear_moduli(), &silicone.fits[0]);
            assert!(
                low > 0.0 && low <= default.shear_modulus && default.shear_modulus <= high,
                "{key}"
            );
            for fit in &silicone.fits {
                assert!(!fit.source().citation.is_empty(), "{key}");
                if let Some(stiffening) = &fit.stiffening {
                    assert!(!silicones().source(stiffening).citation.is_empty(), "{key}");
                }
            }
            if let Some(softening) = &silicone.softening {
                assert!(!silicones().source(&softening.source).citation.is_empty(), "{key}");
                assert!(softening.creep.is_none_or(|creep| creep > 0.0), "{key}");
                assert!(softening.mullins.is_none_or(|m| m > 0.0 && m < 1.0), "{key}");
            }
            // a fit to crosshead strain is a default only where there is nothing else
            let only = silicone.fits.iter().all(|fit| fit.test == Test::Crosshead);
            assert_eq!(only, default.test == Test::Crosshead, "{key}");
        }
        let line = |key: &str| {
            let silicone = silicones().find(key).unwrap();
            silicone.modulus_in_words(&silicone.fits[0])
        };
        assert_eq!(
            line("ecoflex-00-30"),
            "shear modulus 31.7 kPa (campbell-2025, tension); sources give 14.4 to 39.4 kPa"
        );
        assert!(line("rebound-25").ends_with("1.3 to 3.1 times as much as such tests say"));
        assert!(line("elastosil-m4601").ends_with("test not stated); no other source"));
    }

    #[test]
    fn shares_are_those_of_the_bottle() {
        assert_eq!(silicones().find("dragon-skin-20").unwrap().shares(), Some([0.5, 0.5]));
        assert_eq!(silicones().find("elastosil-m4601").unwrap().shares(), Some([0.9, 0.1]));
        let message = silicones().find("rubber").unwrap_err();
        assert!(message.contains("ecoflex-00-30"), "{message}");
    }
}
