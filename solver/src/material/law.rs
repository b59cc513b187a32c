//! A row of the table of laws.

use anyhow::{Context, Result, bail, ensure};
use program::schema::{add_keys, add_kind};
use schemars::Schema;
use serde_json::json;
use toml::Value;

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
    #[must_use]
    pub fn poisson(&self) -> f64 {
        (3.0 * self.bulk - 2.0 * self.shear) / (2.0 * (3.0 * self.bulk + self.shear))
    }

    /// Whether the material at rest resists every strain.
    #[must_use]
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
    /// Moduli at rest of parameters; not finite where the law does not exist.
    pub moduli: fn(&[f64]) -> Moduli,
    /// The law with parameters.
    pub build: fn(&[f64]) -> Box<M>,
    /// Odd but admissible parameters, for tests.
    pub sample: &'static [f64],
}

impl Law {
    /// The law of a `kind`.
    ///
    /// # Errors
    /// When there is none; the message lists those there are.
    pub fn find(kind: &str) -> Result<&'static Self> {
        Self::find_in(super::LAWS, kind, "solver list")
    }
}

impl<M: ?Sized + 'static> Law<M> {
    /// The law of a `kind` in a table, which a `command` lists.
    ///
    /// # Errors
    /// When there is none; the message lists those there are.
    pub fn find_in(laws: &'static [Self], kind: &str, command: &str) -> Result<&'static Self> {
        laws.iter().find(|law| law.key == kind).with_context(|| {
            let known: Vec<_> = laws.iter().map(|law| law.key).collect();
            format!(
                "unknown kind \"{kind}\"; known are {}\n  `{command}` explains them",
                known.join(", ")
            )
        })
    }

    /// The parameters in a table, which must hold nothing else.
    ///
    /// # Errors
    /// When one is missing, unknown, not a number or not finite, when lists
    /// differ in length, or when a modulus at rest is not positive.
    pub fn read(&self, table: &toml::Table) -> Result<Vec<f64>> {
        let is_known = |name: &String| self.parameters.iter().any(|p| p.name == *name);
        if let Some(unknown) = table.keys().find(|name| !is_known(name)) {
            bail!("{}: unknown parameter \"{unknown}\"; expected {}", self.key, self.needs());
        }
        let mut values = Vec::new();
        let mut terms = None;
        for parameter in self.parameters {
            let value = table.get(parameter.name).with_context(|| {
                format!("{}: no \"{}\"; expected {}", self.key, parameter.name, self.needs())
            })?;
            let numbers = parameter.numbers(value).with_context(|| self.key.to_owned())?;
            if parameter.list {
                let (first, length) = *terms.get_or_insert((parameter.name, numbers.len()));
                ensure!(
                    numbers.len() == length,
                    "{}: {first} has {length} numbers, {} has {}; one of each per term is needed",
                    self.key,
                    parameter.name,
                    numbers.len()
                );
            }
            values.extend(numbers);
        }
        self.check(&values)?;
        Ok(values)
    }

    /// Refuses parameters whose moduli at rest are not positive.
    ///
    /// # Errors
    /// With the moduli.
    pub fn check(&self, values: &[f64]) -> Result<()> {
        let moduli = (self.moduli)(values);
        ensure!(
            moduli.positive(),
            "{}: the moduli at rest must be positive, but shear = {} = {} Pa and bulk = {} = {} Pa",
            self.key,
            self.shear,
            moduli.shear,
            self.bulk,
            moduli.bulk
        );
        Ok(())
    }

    /// The table of `kind` and parameters.
    #[must_use]
    pub fn schema(&self) -> Schema {
        let limits = if self.limits.is_empty() { "" } else { ". Limits: " };
        let about = format!(
            "{}. Shear modulus at rest {}, bulk modulus {}{limits}{}. Source: {}.",
            self.formula, self.shear, self.bulk, self.limits, self.source
        );
        let mut schema =
            schemars::json_schema!({ "type": "object", "additionalProperties": false });
        add_kind(&mut schema, self.key, &about, &[]);
        for parameter in self.parameters {
            let mut value = json!({ "type": "number" });
            if parameter.list {
                value = json!({ "type": "array", "items": value, "minItems": 1 });
            }
            value["description"] = format!("{} [{}]", parameter.meaning, parameter.unit).into();
            add_keys(&mut schema, &[(parameter.name, value, true)]);
        }
        schema
    }

    /// Names and units of the parameters.
    fn needs(&self) -> String {
        let one = |p: &Parameter| {
            format!("{}{} [{}]", p.name, if p.list { " (a list)" } else { "" }, p.unit)
        };
        self.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// The values of `numbers` as a `[material]` table has them, without `kind`.
    ///
    /// # Panics
    /// As [`Law::named`].
    #[must_use]
    pub fn table(&self, numbers: &[f64]) -> toml::Table {
        let value = |(p, values): (&Parameter, Vec<f64>)| {
            let mut items: Vec<_> = values.into_iter().map(Value::Float).collect();
            let value = if p.list { Value::Array(items) } else { items.remove(0) };
            (p.name.to_owned(), value)
        };
        self.named(numbers).into_iter().map(value).collect()
    }

    /// The values of `numbers` under the names of the parameters.
    ///
    /// # Panics
    /// When `numbers` does not have the length of a list of parameters.
    #[must_use]
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

impl Parameter {
    fn numbers(&self, value: &Value) -> Result<Vec<f64>> {
        let single = std::slice::from_ref(value);
        let items = match (self.list, value) {
            (true, Value::Array(items)) if !items.is_empty() => items.as_slice(),
            (true, _) => {
                bail!("{} = {value}: expected a list of numbers [{}]", self.name, self.unit)
            }
            (false, _) => single,
        };
        items.iter().map(|item| self.number(item)).collect()
    }

    fn number(&self, value: &Value) -> Result<f64> {
        let number = match value {
            Value::Float(number) => *number,
            Value::Integer(number) => *number as f64,
            other => bail!("{} = {other}: expected a number [{}]", self.name, self.unit),
        };
        ensure!(number.is_finite(), "{} = {number} [{}]: must be finite", self.name, self.unit);
        Ok(number)
    }
}
