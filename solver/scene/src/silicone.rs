//! Known silicones: the laws of the crate `library` by name.

use crate::law_table;
use std::sync::LazyLock;

use anyhow::{Context, Result};
use library::{printed, silicones};
use mechanics::material::response::Mode;
use mechanics::material::{Softening, Specification};
use program::{KeyPath, unknown};
use serde_json::{Value, json};

/// A silicone one can buy or an elastomer that is printed, and its laws.
pub struct Silicone {
    /// Name in scenes, such as `ecoflex-00-30`.
    pub key: &'static str,
    /// The entry in the library.
    pub entry: &'static library::Silicone,
    /// Laws by all sources, the default first.
    pub fits: Vec<Fit>,
}

/// A law of a silicone by one source.
pub struct Fit {
    /// Law, parameters and range.
    pub specification: Specification,
    /// The entry in the library.
    pub entry: &'static library::Fit,
}

/// What a scene names: a silicone, and one of its laws.
#[derive(Clone, Copy)]
pub struct Named {
    /// The silicone.
    pub silicone: &'static Silicone,
    /// The law.
    pub fit: &'static Fit,
}

impl Silicone {
    fn new(key: &'static str, entry: &'static library::Silicone) -> Result<Self> {
        let fit = |fit: &'static library::Fit| {
            let mut specification = law_table::volume(&fit.law).context(key)?;
            specification.density = entry.density;
            specification.modes = modes(fit);
            specification.stretch_at_break =
                entry.elongation().map(|percent| 1.0 + percent / 100.0);
            if let Some(softening) = &entry.softening {
                let library::Softening { creep, mullins, .. } = *softening;
                specification.softening = Softening { creep, mullins };
            }
            Ok(Fit { specification, entry: fit })
        };
        let fits = entry.fits.iter().map(fit).collect::<Result<_>>()?;
        Ok(Self { key, entry, fits })
    }

    /// What selects a fit after the name of the silicone and a slash: its source, or its law
    /// where it is not the first of that source.
    pub fn selector(&self, fit: &Fit) -> &'static str {
        let first = self.fits.iter().find(|other| other.entry.source == fit.entry.source);
        match first.is_some_and(|first| std::ptr::eq(first, fit)) {
            true => &fit.entry.source,
            false => fit.specification.law.key,
        }
    }
}

impl Fit {
    /// Where the numbers come from, and their licence.
    pub fn source(&self) -> &'static library::Source {
        self.entry.source()
    }
}

impl Named {
    /// The shear modulus, and what that is worth, in a line.
    pub fn in_words(&self) -> String {
        let words = self.silicone.entry.modulus_in_words(self.fit.entry);
        format!("{}: {words}", self.silicone.key)
    }

    /// For a report: name, source and test; shear modulus, and range of all sources [Pa].
    pub fn report(&self) -> Value {
        let fit = self.fit.entry;
        json!({
            "name": self.silicone.key,
            "source": fit.source,
            "test": fit.test,
            "shear_modulus": fit.shear_modulus,
            "shear_modulus_range": self.silicone.entry.shear_moduli(),
        })
    }
}

/// All silicones, by key, and behind them all printed elastomers.
///
/// # Panics
/// When a law of the library is wrong, which a test rules out.
pub fn all() -> &'static [Silicone] {
    static ALL: LazyLock<Vec<Silicone>> = LazyLock::new(|| {
        let all = silicones().iter().chain(printed().iter());
        let all = all.map(|(key, entry)| Silicone::new(key, entry));
        all.collect::<Result<_>>().expect("a test builds the laws of all silicones")
    });
    &ALL
}

/// The modes of the tests behind a law, as far as they are known. Compression is biaxial tension across it.
fn modes(fit: &library::Fit) -> Vec<Mode> {
    use library::Test;
    let stiffening = fit.stiffening.iter().map(|_| Mode::Uniaxial);
    let own = match fit.test {
        Test::Tension | Test::Bending | Test::Datasheet | Test::Crosshead => Some(Mode::Uniaxial),
        Test::Compression => Some(Mode::Biaxial),
        Test::Hardness | Test::NotStated => None,
    };
    let mut modes: Vec<Mode> = own.into_iter().chain(stiffening).collect();
    modes.dedup();
    modes
}

/// What a name stands for: `silicone`, `silicone/source` or `silicone/law`; the first that fits.
pub fn find(name: &str) -> Result<Named> {
    let (key, which) = name.split_once('/').map_or((name, None), |(key, which)| (key, Some(which)));
    let silicone = all().iter().find(|s| s.key == key).ok_or_else(|| {
        let known = || all().iter().map(|s| s.key);
        // part of a name, as "tpu" or "ninjaflex"
        let like: Vec<&str> =
            known().filter(|known| !key.is_empty() && known.contains(key)).collect();
        let before = format!("\"{key}\" is no known material");
        let unknown = match &like[..] {
            [] => {
                let all = known().collect::<Vec<_>>().join(", ");
                unknown(&before, key, known(), ';', &format!("known are {all}"))
            }
            like => format!("{before}; those with it in their name are {}", like.join(", ")),
        };
        KeyPath::word(name).told(format!(
            "material = \"{name}\": {unknown}\n  `solver list --silicones` describes them; for \
             another one use a table [material], or `solver fit`"
        ))
    })?;
    let is_meant = |fit: &&Fit| {
        which.is_none_or(|which| fit.specification.law.key == which || fit.entry.source == which)
    };
    let fit = silicone.fits.iter().find(is_meant).ok_or_else(|| {
        let mut known: Vec<&str> = Vec::new();
        for fit in &silicone.fits {
            known.extend([fit.entry.source.as_str(), fit.specification.law.key]);
        }
        known.sort_unstable();
        known.dedup();
        KeyPath::word(name).told(format!(
            "material = \"{name}\": {key} has the sources and laws {}",
            known.join(", ")
        ))
    })?;
    Ok(Named { silicone, fit })
}

#[cfg(test)]
mod tests {
    use mechanics::material::BULK_RATIO;
    use mechanics::material::response::Mode;

    use super::*;

    fn law(name: &str) -> &'static Specification {
        &find(name).expect("known").fit.specification
    }

    fn stress_at_2(specification: &Specification) -> f64 {
        Mode::Uniaxial.nominal_stress(specification.build().as_ref(), 2.0)
    }

    #[test]
    fn every_fit_is_soft_stable_and_has_the_stated_moduli() {
        let silicones = all();
        assert!(silicones.len() >= 16);
        for silicone in silicones {
            for fit in &silicone.fits {
                let (s, key) = (&fit.specification, silicone.key);
                let moduli = s.moduli();
                // units: silicones have 1 kPa to 5 MPa, plastics for printing up to 20 MPa
                let hardest = if silicone.entry.printed.is_some() { 20e6 } else { 5e6 };
                assert!((1e3..hardest).contains(&moduli.shear), "{key}: {moduli:?}");
                // four digits in the library
                let stated = fit.entry.shear_modulus / moduli.shear - 1.0;
                assert!(stated.abs() < 6e-4, "{key}: {moduli:?} is not {:?}", fit.entry);
                if silicone.key != "gjoka-2024" {
                    let ratio = moduli.bulk / moduli.shear;
                    assert!((ratio / BULK_RATIO - 1.0).abs() < 1e-3, "{key}: {ratio}");
                }
                if let Some([low, high]) = s.stretch_range {
                    // plastics of 95A have a knee
                    let least = if silicone.entry.printed.is_some() { 0.98 } else { 0.99 };
                    assert!(low == 1.0 && fit.entry.r2.is_none_or(|r2| r2 > least), "{key}");
                    for mode in Mode::ALL {
                        let end = mode.stable_up_to(s.build().as_ref(), high);
                        assert!(end >= high, "{key}: {mode:?} ends at {end}");
                    }
                }
            }
        }
    }

    #[test]
    fn laws_of_datasheets_have_the_hundred_percent_modulus() {
        let mut count = 0;
        for silicone in all() {
            for fit in &silicone.fits {
                let is_datasheet = fit.entry.test == library::Test::Datasheet;
                assert_eq!(is_datasheet, fit.entry.modulus_100.is_some(), "{}", silicone.key);
                let Some(modulus) = fit.entry.modulus_100 else { continue };
                count += 1;
                // four digits each of modulus, shear modulus and limit
                let stress = stress_at_2(&fit.specification);
                assert!((stress / modulus - 1.0).abs() < 2e-3, "{}: {stress}", silicone.key);
                if fit.specification.law.key == "neo-hookean" {
                    // μ (λ − λ⁻²) at λ = 2
                    let shear = modulus / 1.75;
                    assert!((fit.entry.shear_modulus / shear - 1.0).abs() < 1e-3);
                }
            }
        }
        assert_eq!(count, 10);
    }

    /// Gent's law has the stiffening of the fit that its entry names: the same ratio of the
    /// stresses at stretch 4 and 2.
    #[test]
    fn stiffening_is_that_of_the_stated_source() {
        let mut count = 0;
        for silicone in all() {
            for fit in &silicone.fits {
                let Some(source) = &fit.entry.stiffening else { continue };
                count += 1;
                assert_eq!(fit.specification.law.key, "gent", "{}", silicone.key);
                let of = |specification: &Specification| {
                    let law = specification.build();
                    Mode::Uniaxial.nominal_stress(law.as_ref(), 4.0) / stress_at_2(specification)
                };
                let ratio = of(&fit.specification) / of(law(&format!("{}/{source}", silicone.key)));
                assert!((ratio - 1.0).abs() < 1e-3, "{}: {ratio}", silicone.key);
            }
        }
        assert_eq!(count, 6);
    }

    /// Other fits than to crosshead strain, where strain is known best, in the order of the
    /// comment of the library.
    #[test]
    fn defaults_are_those_of_the_rule() {
        for (name, source, shear) in [
            ("ecoflex-00-10", "dawood-2026", 54.21e3 / 3.0),
            ("ecoflex-00-30", "campbell-2025", 31.7e3),
            ("ecoflex-00-50", "dawood-2026", 152.7e3 / 3.0),
            ("dragon-skin-10-medium", "dubied-2022", 263.8e3 / 3.0),
        ] {
            let named = find(name).expect("known");
            assert_eq!(named.fit.entry.source, source);
            assert!((named.fit.entry.shear_modulus / shear - 1.0).abs() < 1e-3, "{name}");
        }
        for name in ["dragon-skin-20", "dragon-skin-30"] {
            assert_eq!(find(name).expect("known").fit.entry.source, "datasheet");
        }
        assert_eq!(law("ecoflex-00-30").values[1], 39.6);
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
            for kind in ["ogden", "yeoh"] {
                let stress = stress_at_2(law(&format!("{name}/{kind}")));
                assert!((stress / measured - 1.0).abs() < 0.15, "{name}/{kind}: {stress}");
            }
        }
    }

    #[test]
    fn every_fit_is_found_by_its_selector_and_old_names_stand_for_what_they_did() {
        for silicone in all() {
            for fit in &silicone.fits {
                let name = format!("{}/{}", silicone.key, silicone.selector(fit));
                let found = find(&name).expect("a name that is listed").fit;
                assert!(std::ptr::eq(found, fit), "{name}");
            }
        }
        for kind in ["ogden", "yeoh"] {
            for silicone in all().iter().filter(|s| s.entry.fits.len() > 1) {
                let named = find(&format!("{}/{kind}", silicone.key)).expect("known");
                assert_eq!(named.fit.entry.source, "marechal-2021", "{}", silicone.key);
            }
        }
    }

    #[test]
    fn names_are_found_or_listed() {
        assert_eq!(law("ecoflex-00-30").law.key, "gent");
        assert_eq!(law("rtv615").law.key, "yeoh");
        assert_eq!(law("ecoflex-00-30/yeoh").law.key, "yeoh");
        assert_eq!(law("ecoflex-00-30/marechal-2021").law.key, "ogden");
        let message = find("ecoflex").err().expect("unknown").to_string();
        assert!(message.contains("ecoflex-00-30") && !message.contains("elastosil"), "{message}");
        let message = find("tpu").err().expect("unknown").to_string();
        assert!(
            message.contains("in their name are tpu-60a-filaflex, tpu-70a-filaflex"),
            "{message}"
        );
        assert!(!message.contains("tpe") && !message.contains("ecoflex"), "{message}");
        let message = find("rubber").err().expect("unknown").to_string();
        assert!(
            message.contains("elastosil-m4601") && message.contains("resin-elastic-50a"),
            "{message}"
        );
        assert_eq!(law("tpu-85a-ninjaflex").modes, [Mode::Uniaxial]);
        assert_eq!(law("resin-elastic-50a").stretch_at_break, Some(2.6));
        let message = find("ecoflex-00-30/neo").err().expect("unknown").to_string();
        assert!(message.contains("campbell-2025, datasheet, dawood-2026, gent"), "{message}");
    }
}
