//! `[[probe]]`: a number that is measured at every reported step. Its kinds are rows of
//! [`KINDS`](super::KINDS).

use std::borrow::Cow;
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, ensure};
use program::schema::{add_keys, one_of};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::json;
use toml::Table;

use crate::objective::Objective;
use crate::probe::{COMMON_KEYS, KINDS, Kind, Site, Specification};

/// A probe of a scene.
#[derive(Clone, Debug)]
pub struct ProbeConfig {
    name: String,
    kind: &'static Kind,
    /// The keys of its kind ...
    own: Arc<dyn Specification>,
    /// ... and the same with all defaults written.
    keys: Table,
}

impl ProbeConfig {
    /// Its column in results.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its row of the table.
    #[must_use]
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// What messages call it.
    #[must_use]
    pub fn title(&self) -> String {
        format!("[[probe]] \"{}\"", self.name)
    }

    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    pub fn check(&self) -> Result<()> {
        // `solver plot` separates columns by commas and factors by stars
        let sound = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
        ensure!(
            !self.name.is_empty() && self.name.chars().all(sound),
            "{}: a name has letters, digits, _ and -, and one of them or more",
            self.title()
        );
        self.own.check().with_context(|| self.title())
    }

    /// What it measures on a body.
    ///
    /// # Errors
    /// When a tag is missing, or a point lies where it must not.
    pub fn build(&self, site: &Site) -> Result<Arc<dyn Objective>> {
        self.own.build(&self.name, site).with_context(|| self.title())
    }

    fn read(mut keys: Table) -> Result<Self> {
        let mut text = |key: &str| -> Result<String> {
            let value = keys.remove(key).with_context(|| format!("missing field `{key}`"))?;
            value.try_into().map_err(|e| anyhow!("{key}: {e}"))
        };
        let (name, kind) = (text("name")?, text("kind")?);
        let kind = Kind::find(&kind)?;
        let (own, keys) = kind.read(keys)?;
        Ok(Self { name, kind, own, keys })
    }
}

impl Serialize for ProbeConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", &self.name)?;
        map.serialize_entry("kind", self.kind.key)?;
        for (key, value) in &self.keys {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for ProbeConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = Table::deserialize(deserializer)?;
        let name = keys.get("name").and_then(|name| name.as_str()).map(str::to_owned);
        Self::read(keys).map_err(|what| {
            let title = name.map_or_else(String::new, |name| format!(" \"{name}\""));
            D::Error::custom(format!("[[probe]]{title}: {}", format!("{what:#}").trim_end()))
        })
    }
}

impl JsonSchema for ProbeConfig {
    fn schema_name() -> Cow<'static, str> {
        "ProbeConfig".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        one_of(KINDS.iter().map(|kind| {
            let mut schema = kind.schema(generator);
            for (key, meaning) in COMMON_KEYS {
                let value = json!({ "type": "string", "description": meaning });
                add_keys(&mut schema, &[(key, value, true)]);
            }
            schema
        }))
    }
}
