//! Gas laws: how the pressure in a chamber follows its volume.
//!
//! A law is a potential Φ(V; V₀) [J] of the chamber's volume V and rest volume V₀,
//! with the gauge pressure P = −∂Φ/∂V; P > 0 inflates. One law per file, one row per
//! law in [`GAS_LAWS`].

mod ideal_gas;
mod isobaric;
mod prescribed_volume;

use std::fmt::Debug;

use anyhow::{Result, bail};
use program::schema::one_of;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Multiplier;
use crate::schedule::Schedule;

pub use ideal_gas::IdealGas;
pub use isobaric::Isobaric;
pub use prescribed_volume::PrescribedVolume;

/// The laws, in the order in which they are listed.
pub const GAS_LAWS: &[Row] = &[isobaric::ROW, ideal_gas::ROW, prescribed_volume::ROW];

/// A gas law: what to write, what it means, how to read it.
pub struct Row {
    /// Its name.
    pub name: &'static str,
    /// The potential Φ or the pressure P.
    pub formula: &'static str,
    /// Keys in `[[chamber]]` besides `on`.
    pub keys: &'static [Key],
    /// Where it comes from.
    pub source: &'static str,
    /// How its keys are read.
    form: Form,
}

/// The type that the keys of a law are read into.
struct Form {
    /// From a table of them.
    read: fn(toml::Table) -> Result<Box<dyn GasLaw>, toml::de::Error>,
    /// As a schema.
    schema: fn(&mut SchemaGenerator) -> Schema,
}

/// The form of the law `L`.
const fn form<L: GasLaw + DeserializeOwned + JsonSchema + 'static>() -> Form {
    Form { read: read_as::<L>, schema: L::json_schema }
}

/// `[[chamber]]` of one of the laws, without `on`.
#[must_use]
pub fn schema(generator: &mut SchemaGenerator) -> Schema {
    let mut forms = Vec::new();
    for law in GAS_LAWS {
        let schema = (law.form.schema)(generator);
        let several = schema.get("oneOf").and_then(|forms| forms.as_array()).cloned();
        let of_law = several.map_or_else(
            || vec![schema],
            |forms| forms.into_iter().filter_map(|form| form.try_into().ok()).collect(),
        );
        forms.extend(of_law.into_iter().map(|form| (law, form)));
    }
    one_of(forms.into_iter().map(|(law, mut schema): (&Row, Schema)| {
        schema.insert("title".into(), law.name.into());
        schema.insert(
            "description".into(),
            format!("{}. Source: {}.", law.formula, law.source).into(),
        );
        schema
    }))
}

/// A key of a gas law in `[[chamber]]`.
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Whether it selects the law: a chamber has exactly one such key.
    pub selects: bool,
}

/// A gas law with its numbers.
pub trait GasLaw: Debug + Send + Sync {
    /// Φ and its derivatives at volume `v` of a chamber with rest volume `rest` [m³], at
    /// a load; `multiplier` is that of a prescribed volume, and ignored by other laws.
    fn at(&self, v: f64, rest: f64, load: f64, multiplier: Multiplier) -> Potential;
    /// The one number that it follows over time, the parameter p: pressure, fill, change
    /// or factor.
    fn schedule(&self) -> &Schedule;
    /// The same, to be changed.
    fn schedule_mut(&mut self) -> &mut Schedule;
    /// Key of that number in `[[chamber]]`.
    fn key(&self) -> &'static str;
    /// Checks what can be checked without a body, at the moments of the scene [s].
    ///
    /// # Errors
    /// With what was found and what is needed.
    fn check(&self, _moments: &[f64]) -> Result<()> {
        Ok(())
    }
    /// The pressure, where the law prescribes it [Pa].
    fn pressure(&self) -> Option<&Schedule> {
        None
    }
    /// ∂P/∂p at a volume, where the law does not prescribe the volume.
    fn pressure_by_parameter(&self, v: f64, rest: f64) -> Option<f64>;
    /// V*, where the law prescribes it.
    fn wanted(&self, _rest: f64, _load: f64) -> Option<Wanted> {
        None
    }
    /// The keys of `[[chamber]]`, as they were read.
    fn table(&self) -> toml::Table;
    /// A copy.
    fn boxed(&self) -> Box<dyn GasLaw>;
}

impl Clone for Box<dyn GasLaw> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Φ and its derivatives at one volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Potential {
    /// Φ [J]; infinite for V ≤ 0 of a fixed amount of gas.
    pub value: f64,
    /// Gauge pressure −Φ' [Pa].
    pub pressure: f64,
    /// Φ'' [Pa/m³].
    pub stiffness: f64,
    /// ∂P/∂V₀ [Pa/m³].
    pub pressure_by_rest: f64,
}

/// A volume V* that a chamber shall have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// V* [m³].
    pub volume: f64,
    /// ∂V*/∂V₀ [1].
    pub by_rest: f64,
    /// ∂V*/∂p.
    pub by_parameter: f64,
}

/// The law that the keys of a `[[chamber]]` select, `on` left out.
///
/// # Errors
/// When no key or several select a law, or a key is missing, unknown or of the wrong type.
pub fn read(keys: toml::Table) -> Result<Box<dyn GasLaw>> {
    let all = || GAS_LAWS.iter().flat_map(|row| row.keys);
    let selecting: Vec<&Key> = all().filter(|key| key.selects).collect();
    let found: Vec<&str> =
        selecting.iter().map(|key| key.name).filter(|name| keys.contains_key(*name)).collect();
    let known = |name: &String| all().any(|key| key.name == *name);
    if let Some(unknown) = keys.keys().find(|name| !known(name)) {
        let known: Vec<String> = all().map(|key| format!("`{}`", key.name)).collect();
        bail!("unknown field `{unknown}`, expected one of `on`, {}", known.join(", "));
    }
    let [one] = found[..] else {
        let needed: Vec<String> =
            selecting.iter().map(|key| format!("{} [{}]", key.name, key.unit)).collect();
        bail!(
            "expected exactly one of {}; found {}",
            needed.join(", "),
            if found.is_empty() { "none".to_owned() } else { found.join(" and ") }
        );
    };
    let law = GAS_LAWS.iter().find(|row| row.keys.iter().any(|key| key.name == one));
    let Some(law) = law else { bail!("no gas law has the key {one}") };
    let own = |name: &String| law.keys.iter().any(|key| key.name == *name);
    if let Some(other) = keys.keys().find(|name| !own(name)) {
        let names: Vec<&str> = law.keys.iter().map(|key| key.name).collect();
        bail!(
            "{other} cannot be combined with {one}; the {} law has {}",
            law.name,
            names.join(", ")
        );
    }
    (law.form.read)(keys.clone()).map_err(|e| anyhow::anyhow!(with_value(&e.to_string(), &keys)))
}

/// What is wrong with a key, after the key and its value: `toml` names the key last.
fn with_value(message: &str, keys: &toml::Table) -> String {
    let found = message.trim_end().rsplit_once("\nin `").and_then(|(what, key)| {
        let key = key.strip_suffix('`')?;
        Some((what, key, keys.get(key)?.to_string()))
    });
    let Some((what, key, value)) = found else { return message.trim_end().replace('\n', " ") };
    let what = what.strip_prefix(&format!("{value}: ")).unwrap_or(what).replace('\n', " ");
    format!("{key} = {value}: {what}")
}

/// Reads the law `L` from its keys.
fn read_as<L: GasLaw + DeserializeOwned + 'static>(
    keys: toml::Table,
) -> Result<Box<dyn GasLaw>, toml::de::Error> {
    Ok(Box::new(keys.try_into::<L>()?))
}

/// The keys of a law.
fn written(law: &impl Serialize) -> toml::Table {
    toml::Table::try_from(law).expect("numbers, texts and lists of numbers")
}

#[cfg(test)]
mod tests;
