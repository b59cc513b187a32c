//! Known silicones: the fits of `silicones.toml` by name.
//!
//! That file says where its numbers come from, what they are worth and under
//! which licence they are.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::material::Specification;

/// A silicone one can buy.
pub struct Silicone {
    /// Name in scenes, such as `ecoflex-00-30`.
    pub key: String,
    /// Name on the bottle.
    pub name: String,
    /// Who sells it.
    pub vendor: String,
    /// Density [kg/m³], if known.
    pub density: Option<f64>,
    /// Parts to mix, if known.
    pub mix: Option<String>,
    /// Time to pour after mixing [min], if known.
    pub pot_life_min: Option<f64>,
    /// Time to demold at room temperature [h], if known.
    pub cure_h: Option<f64>,
    /// Fits, the default first.
    pub fits: Vec<Fit>,
}

/// A law fitted to tests of a silicone.
pub struct Fit {
    /// Law, parameters and range.
    pub specification: Specification,
    /// Coefficient of determination of the fit, if known [1].
    pub r2: Option<f64>,
    /// Where the numbers come from.
    pub citation: String,
    /// Licence of the numbers.
    pub licence: String,
}

/// All silicones, by key.
///
/// # Panics
/// When the built-in file is wrong, which a test rules out.
#[must_use]
pub fn all() -> &'static [Silicone] {
    static ALL: LazyLock<Vec<Silicone>> = LazyLock::new(|| {
        parse(include_str!("../silicones.toml")).expect("silicones.toml is checked by a test")
    });
    &ALL
}

/// The fit of a name: `silicone`, or `silicone/law`.
///
/// # Errors
/// When there is none; the message lists those there are.
pub fn find(name: &str) -> Result<&'static Fit> {
    let (key, law) = name.split_once('/').map_or((name, None), |(key, law)| (key, Some(law)));
    let silicone = all().iter().find(|s| s.key == key).with_context(|| {
        let known: Vec<_> = all().iter().map(|s| s.key.as_str()).collect();
        format!(
            "material = \"{name}\": no such silicone; known are {}\n  `solver list --silicones` \
             tells more; for another one use a table [material], or `solver fit`",
            known.join(", ")
        )
    })?;
    let of_law = |fit: &&Fit| law.is_none_or(|law| fit.specification.law.key == law);
    silicone.fits.iter().find(of_law).with_context(|| {
        let known: Vec<_> = silicone.fits.iter().map(|f| f.specification.law.key).collect();
        format!("material = \"{name}\": {key} has fits of {}", known.join(", "))
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    source: BTreeMap<String, Source>,
    silicone: BTreeMap<String, Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Source {
    citation: String,
    licence: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    vendor: String,
    density: Option<f64>,
    mix: Option<String>,
    pot_life_min: Option<f64>,
    cure_h: Option<f64>,
    /// For `fab`.
    #[serde(rename = "casting")]
    _casting: Option<toml::Table>,
    fit: Vec<toml::Table>,
}

fn parse(text: &str) -> Result<Vec<Silicone>> {
    let file: File = toml::from_str(text)?;
    let one = |(key, entry): (String, Entry)| {
        let read = |table| read_fit(table, entry.density, &file.source).context(key.clone());
        let fits = entry.fit.into_iter().map(read).collect::<Result<Vec<_>>>()?;
        let Entry { name, vendor, density, mix, pot_life_min, cure_h, .. } = entry;
        Ok(Silicone { key, name, vendor, density, mix, pot_life_min, cure_h, fits })
    };
    file.silicone.into_iter().map(one).collect()
}

fn read_fit(
    mut table: toml::Table,
    density: Option<f64>,
    sources: &BTreeMap<String, Source>,
) -> Result<Fit> {
    let Some(toml::Value::String(key)) = table.remove("source") else { bail!("no source") };
    let source = sources.get(&key).with_context(|| format!("unknown source {key}"))?;
    let r2 = table.remove("r2").and_then(|v| v.as_float());
    let mut specification = Specification::read(&table)?;
    specification.density = density;
    let (citation, licence) = (source.citation.clone(), source.licence.clone());
    Ok(Fit { specification, r2, citation, licence })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::response::Mode;

    #[test]
    fn every_fit_is_soft_stable_and_has_the_stated_bulk_modulus() {
        let silicones = parse(include_str!("../silicones.toml")).expect("the built-in file");
        assert!(silicones.len() >= 16);
        for silicone in &silicones {
            for fit in &silicone.fits {
                let (s, key) = (&fit.specification, &silicone.key);
                let moduli = s.moduli();
                // units: silicones have 1 kPa to 5 MPa
                assert!((1e3..5e6).contains(&moduli.shear), "{key}: {moduli:?}");
                if silicone.key != "gjoka-2024" {
                    let ratio = moduli.bulk / moduli.shear;
                    assert!(
                        (ratio / crate::material::BULK_RATIO - 1.0).abs() < 1e-3,
                        "{key}: {ratio}"
                    );
                }
                if let Some([low, high]) = s.stretch_range {
                    assert!(low == 1.0 && fit.r2.is_some_and(|r2| r2 > 0.99), "{key}");
                    for mode in Mode::ALL {
                        let end = mode.stable_up_to(s.build().as_ref(), high);
                        assert!(end >= high, "{key}: {mode:?} turns down at {end}");
                    }
                }
            }
        }
    }

    #[test]
    fn fits_give_the_stress_at_twice_the_length_that_was_measured() {
        // nominal stress at 100 % strain in the data the fits were made to
        // [Pa]; fits up to 300 % miss it by some percent
        for (name, measured) in [
            ("ecoflex-00-30", 29.5e3),
            ("ecoflex-00-50", 41.0e3),
            ("dragon-skin-10-medium", 113e3),
            ("dragon-skin-20", 318e3),
            ("dragon-skin-30", 437e3),
            ("mold-star-16-fast", 186e3),
            ("sorta-clear-40", 564e3),
            ("rtv615", 801e3),
        ] {
            for law in ["ogden", "yeoh"] {
                let fit = find(&format!("{name}/{law}")).expect("both laws are there");
                let stress = Mode::Uniaxial.nominal_stress(fit.specification.build().as_ref(), 2.0);
                assert!((stress / measured - 1.0).abs() < 0.15, "{name}/{law}: {stress}");
            }
        }
    }

    #[test]
    fn names_are_found_or_listed() {
        assert_eq!(find("ecoflex-00-30").expect("known").specification.law.key, "ogden");
        assert_eq!(find("rtv615").expect("known").specification.law.key, "yeoh");
        assert_eq!(find("ecoflex-00-30/yeoh").expect("known").specification.law.key, "yeoh");
        let message = find("ecoflex").err().expect("unknown").to_string();
        assert!(message.contains("ecoflex-00-50, elastosil-m4601"), "{message}");
        let message = find("ecoflex-00-30/neo").err().expect("unknown").to_string();
        assert!(message.contains("has fits of ogden, yeoh"), "{message}");
    }
}
