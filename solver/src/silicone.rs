//! Known silicones: the laws of the crate `library` by name.

use std::sync::LazyLock;

use anyhow::{Context, Result};
use library::silicones;

use crate::material::Specification;

/// A silicone one can buy, and its laws.
pub struct Silicone {
    /// Name in scenes, such as `ecoflex-00-30`.
    pub key: &'static str,
    /// Its entry in the library.
    pub entry: &'static library::Silicone,
    /// Fits, the default first.
    pub fits: Vec<Fit>,
}

/// A law fitted to tests of a silicone.
pub struct Fit {
    /// Law, parameters and range.
    pub specification: Specification,
    /// Coefficient of determination of the fit, if known [1].
    pub r2: Option<f64>,
    /// Where the numbers come from, and their licence.
    pub source: &'static library::Source,
}

impl Silicone {
    fn new(key: &'static str, entry: &'static library::Silicone) -> Result<Self> {
        let fit = |fit: &'static library::Fit| {
            let mut specification = Specification::read(&fit.law).context(key)?;
            specification.density = entry.density;
            Ok(Fit { specification, r2: fit.r2, source: fit.source() })
        };
        let fits = entry.fits.iter().map(fit).collect::<Result<_>>()?;
        Ok(Self { key, entry, fits })
    }
}

/// All silicones, by key.
///
/// # Panics
/// When a law of the library is wrong, which a test rules out.
#[must_use]
pub fn all() -> &'static [Silicone] {
    static ALL: LazyLock<Vec<Silicone>> = LazyLock::new(|| {
        let all = silicones().iter().map(|(key, entry)| Silicone::new(key, entry));
        all.collect::<Result<_>>().expect("a test builds the laws of all silicones")
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
        let unknown = silicones().find(key).err().unwrap_or_default();
        format!(
            "material = \"{name}\": {unknown}\n  `solver list --silicones` describes them; for \
             another one use a table [material], or `solver fit`"
        )
    })?;
    let of_law = |fit: &&Fit| law.is_none_or(|law| fit.specification.law.key == law);
    silicone.fits.iter().find(of_law).with_context(|| {
        let known: Vec<_> = silicone.fits.iter().map(|f| f.specification.law.key).collect();
        format!("material = \"{name}\": {key} has fits of {}", known.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::response::Mode;

    #[test]
    fn every_fit_is_soft_stable_and_has_the_stated_bulk_modulus() {
        let silicones = all();
        assert!(silicones.len() >= 16);
        for silicone in silicones {
            for fit in &silicone.fits {
                let (s, key) = (&fit.specification, silicone.key);
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
