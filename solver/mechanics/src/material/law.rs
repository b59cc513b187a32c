//! A row of the table of laws.

use super::Material;

/// The unit of stress-like parameters.
pub(super) const PA: &str = "Pa";

/// Bulk over shear modulus at rest, where nothing is known: Poisson's ratio
/// 0.4975. Real silicone has some 10⁴, which locks elements of pure
/// displacement; the chapter "Materials" of the book has measurements.
pub const BULK_RATIO: f64 = 200.0;

/// A parameter of a law.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in `[material]`.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Whether it is a list with one number per term.
    pub list: bool,
}

impl Parameter {
    /// One number.
    pub(super) const fn one(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, unit, meaning, list: false }
    }

    /// One number per term.
    pub(super) const fn list(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
    ) -> Self {
        Self { name, unit, meaning, list: true }
    }
}

/// Moduli at rest.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Moduli {
    /// Shear modulus [Pa].
    pub shear: f64,
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

impl Moduli {
    /// Poisson's ratio [1].
    pub fn poisson(&self) -> f64 {
        (3.0 * self.bulk - 2.0 * self.shear) / (2.0 * (3.0 * self.bulk + self.shear))
    }

    /// Whether the material at rest resists every strain.
    pub fn positive(&self) -> bool {
        let good = |m: f64| m.is_finite() && m > 0.0;
        good(self.shear) && good(self.bulk)
    }
}

/// A constitutive law: what to write, what it means, how to build it.
///
/// Parameters are numbers in one row, lists one after the other in the order of
/// `parameters`. `M` is what it builds: a law of a volume, or one of a sheet.
pub struct Law<M: ?Sized = dyn Material> {
    /// `kind` in `[material]`.
    pub key: &'static str,
    /// Energy density.
    pub formula: &'static str,
    /// The parameters.
    pub parameters: &'static [Parameter],
    /// Shear modulus at rest, as a formula.
    pub shear: &'static str,
    /// Bulk modulus at rest, as a formula.
    pub bulk: &'static str,
    /// Where the law comes from.
    pub source: &'static str,
    /// Where it should not be used; empty if nothing needs to be said.
    pub limits: &'static str,
    /// Whether a rotation leaves its energy alone.
    pub objective: bool,
    /// Moduli at rest of parameters with which the law exists.
    pub moduli: fn(&[f64]) -> Moduli,
    /// The law with parameters.
    pub build: fn(&[f64]) -> Box<M>,
    /// Why the law does not exist with parameters, with what was found and what is needed; none where it exists.
    pub refuses: fn(&[f64]) -> Option<String>,
    /// Odd but admissible parameters, for tests.
    pub sample: &'static [f64],
}

/// Parameters of which a material does not resist every strain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotPositive {
    /// The law does not exist with them.
    #[error("{law}: {why}")]
    Undefined {
        /// Key of the law.
        law: &'static str,
        /// What was found and what is needed.
        why: String,
    },
    /// The moduli at rest are not all positive.
    #[error(
        "{law}: the moduli at rest must be positive, but shear = {shear} = {} Pa and bulk = {bulk} = {} Pa",
        moduli.shear, moduli.bulk
    )]
    Moduli {
        /// Key of the law.
        law: &'static str,
        /// Formula of the shear modulus.
        shear: &'static str,
        /// Formula of the bulk modulus.
        bulk: &'static str,
        /// Their values.
        moduli: Moduli,
    },
}

impl<M: ?Sized + 'static> Law<M> {
    /// Refuses parameters with which the law does not exist, or whose moduli at rest are not positive.
    pub fn check(&self, values: &[f64]) -> Result<(), NotPositive> {
        if let Some(why) = (self.refuses)(values) {
            return Err(NotPositive::Undefined { law: self.key, why });
        }
        let moduli = (self.moduli)(values);
        if moduli.positive() {
            return Ok(());
        }
        let Self { key: law, shear, bulk, .. } = *self;
        Err(NotPositive::Moduli { law, shear, bulk, moduli })
    }

    /// The values of `numbers` under the names of the parameters.
    ///
    /// # Panics
    /// When `numbers` does not have the length of a list of parameters.
    pub fn named(&self, numbers: &[f64]) -> Vec<(&'static Parameter, Vec<f64>)> {
        let lists = self.parameters.iter().filter(|p| p.list).count();
        let terms = (numbers.len() + lists - self.parameters.len()).checked_div(lists).unwrap_or(0);
        let mut rest = numbers;
        let mut take = |p: &'static Parameter| {
            let (own, others) = rest.split_at(if p.list { terms } else { 1 });
            rest = others;
            (p, own.to_vec())
        };
        self.parameters.iter().map(&mut take).collect()
    }
}
