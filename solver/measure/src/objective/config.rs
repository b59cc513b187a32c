//! `[[objective]]`: a term of the objective function of a design. Its kinds are rows of
//! [`KINDS`](super::KINDS).

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use program::schema::{add_keys, one_of};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::json;
use toml::Table;

use crate::objective::{Builder, COMMON_KEYS, KINDS, Kind, Specification, TimeIntegral};

/// A weighted term of the objective.
#[derive(Clone, Debug)]
pub struct ObjectiveConfig {
    common: Common,
    kind: &'static Kind,
    /// The keys of its kind ...
    own: Arc<dyn Specification>,
    /// ... and the same with all defaults written.
    keys: Table,
}

/// How much a term counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// Factor of its value, in the inverse of its unit.
    Factor(f64),
    /// The part of the objective that it is at the start, negative where it is maximised [1].
    Share(f64),
}

/// The keys of every kind, [`COMMON_KEYS`].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
struct Common {
    name: String,
    weight: Option<f64>,
    share: Option<f64>,
    #[serde(default)]
    over: TimeIntegral,
}

impl ObjectiveConfig {
    /// The user's name for the term.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.common.name
    }

    /// How much it counts.
    #[must_use]
    pub fn weight(&self) -> Weight {
        match (self.common.share, self.common.weight) {
            (Some(share), _) => Weight::Share(share),
            (None, weight) => Weight::Factor(weight.unwrap_or_default()),
        }
    }

    /// What it is summed over.
    #[must_use]
    pub fn over(&self) -> &TimeIntegral {
        &self.common.over
    }

    /// Its row of the table.
    #[must_use]
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The probe that it looks at, and the number that it wants of it, in the unit of the probe, if it names one.
    #[must_use]
    pub fn probe(&self) -> Option<(&str, Option<f64>)> {
        let number =
            |value: &toml::Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        let name = self.keys.get("probe")?.as_str()?;
        Some((name, self.keys.get("target").and_then(number)))
    }

    /// Whether it is made with the stress of the law at each point.
    #[must_use]
    pub fn reads_stress(&self) -> bool {
        self.own.reads_stress()
    }

    /// The files that it names, from the folder of the design.
    #[must_use]
    pub fn files(&self) -> Vec<&Path> {
        self.own.files()
    }

    /// Reads its files, from the folder of the design.
    ///
    /// # Errors
    /// When one cannot be read, or does not fit.
    pub fn prepare(&self, folder: &Path) -> Result<Builder> {
        self.own.prepare(folder)
    }

    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    pub fn check(&self) -> Result<()> {
        let own = format!("objective \"{}\"", self.name());
        let (key, value) = match self.weight() {
            Weight::Factor(weight) => ("weight", weight),
            Weight::Share(share) => ("share", share),
        };
        ensure!(value.is_finite(), "{own}: {key} = {value}: must be a finite number");
        ensure!(
            value >= 0.0 || self.kind.may_be_maximised && self.own.may_be_maximised(),
            "{own}: {key} = {value}: a negative {key} maximises a term, which makes sense for \
             {} only",
            maximised()
        );
        ensure!(
            key == "weight" || value != 0.0 && value.abs() <= 1.0,
            "{own}: {key} = {value}: must be a part of the objective, up to 1"
        );
        self.own.check().map_err(|what| anyhow::anyhow!("{own}: {what}"))
    }

    fn read(mut keys: Table) -> Result<Self> {
        let kind = keys.remove("kind").context("missing field `kind`")?;
        let kind = Kind::find(kind.as_str().with_context(|| format!("kind = {kind}: a name"))?)?;
        let is_common = |key: &String| COMMON_KEYS.iter().any(|(common, _)| common == key);
        let (common, own): (Table, Table) = keys.into_iter().partition(|(key, _)| is_common(key));
        let (own, keys) = kind.read(own)?;
        let common: Common = common.try_into()?;
        ensure!(
            common.weight.is_some() != common.share.is_some(),
            "expected one of weight = ... and share = ..."
        );
        Ok(Self { common, kind, own, keys })
    }
}

impl Serialize for ObjectiveConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("kind", self.kind.key)?;
        map.serialize_entry("name", &self.common.name)?;
        match self.weight() {
            Weight::Factor(factor) => map.serialize_entry("weight", &factor)?,
            Weight::Share(share) => map.serialize_entry("share", &share)?,
        }
        map.serialize_entry("over", &self.common.over)?;
        for (key, value) in &self.keys {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for ObjectiveConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = Table::deserialize(deserializer)?;
        let name = keys.get("name").and_then(|name| name.as_str()).map(str::to_owned);
        Self::read(keys).map_err(|what| {
            let title = name.map_or_else(String::new, |name| format!("objective \"{name}\": "));
            D::Error::custom(format!("{title}{}", format!("{what:#}").trim_end()))
        })
    }
}

impl JsonSchema for ObjectiveConfig {
    fn schema_name() -> Cow<'static, str> {
        "ObjectiveConfig".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let common = Common::json_schema(generator).to_value();
        one_of(KINDS.iter().map(|kind| {
            let mut schema = kind.schema(generator);
            let meanings = COMMON_KEYS.map(|(key, meaning)| {
                let mut value = common["properties"][key].clone();
                value["description"] = meaning.into();
                (key, value, key == "name")
            });
            add_keys(&mut schema, &meanings);
            let needs = |key: &str| json!({ "required": [key] });
            schema.insert("if".into(), needs("share"));
            schema.insert("then".into(), json!({ "not": needs("weight") }));
            schema.insert("else".into(), needs("weight"));
            schema
        }))
    }
}

/// Checks that the shares of some objectives leave what the weights of the others need.
///
/// # Errors
/// When they do not.
pub fn check_shares(objectives: &[ObjectiveConfig]) -> Result<()> {
    let (mut sum, mut shares, mut weighted) = (0.0, false, false);
    for objective in objectives {
        match objective.weight() {
            Weight::Share(share) => (sum, shares) = (sum + share.abs(), true),
            Weight::Factor(factor) => weighted |= factor != 0.0,
        }
    }
    ensure!(
        !shares || !weighted || sum < 1.0,
        "[[objective]]: the shares come to {sum:.3}, which leaves nothing for the objectives with a \
         weight: they must be less than 1 in all"
    );
    ensure!(
        !shares || weighted || (sum - 1.0).abs() < 1e-9,
        "[[objective]]: the shares come to {sum:.3}: they must be 1 in all where no objective has a weight"
    );
    Ok(())
}

/// Kinds whose weight may be negative, for messages.
fn maximised() -> String {
    let kinds = KINDS.iter().filter(|kind| kind.may_be_maximised).map(|kind| kind.key);
    kinds.collect::<Vec<_>>().join(", ") + " (without a wanted one)"
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
