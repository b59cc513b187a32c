//! `[[chamber]]`: a pressurised chamber, in scenes with its gas, in designs with what may
//! change of its pressure.

use std::borrow::Cow;

use anyhow::{Result, ensure};
use measure::written::Names;
use program::schema::add_keys;
use program::{KeyPath, Misfit, misfit, read_key};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::json;

use super::gas::{self, GasConfig};

/// A chamber of a scene: the tags of its wall, and the keys of one of the laws in
/// [`GAS_LAWS`](mechanics::energy::gas_law::GAS_LAWS).
#[derive(Clone, Debug)]
pub struct ChamberConfig {
    /// What paths and messages call it: the tag of its wall, if it has no other name.
    pub name: String,
    /// Tags of the wall. Hollows of several tags are one chamber: they share their gas, as on a manifold.
    pub on: Names,
    /// Whether plugs close what is open of it.
    pub plug: bool,
    /// What is behind it.
    pub gas: GasConfig,
}

impl ChamberConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        title_of(&self.name, &self.on)
    }

    /// Whether a tag is of its wall.
    pub fn is_on(&self, tag: &str) -> bool {
        self.on.all().iter().any(|own| own == tag)
    }

    fn read(mut keys: toml::Table) -> Result<Self, Misfit> {
        let on: Names = read_key(&keys, "on")?.ok_or_else(|| Misfit::missing_field("on"))?;
        let name = match (read_key(&keys, "name")?, &on) {
            (Some(name), _) => name,
            (None, Names::One(tag)) => tag.clone(),
            (None, Names::Several(tags)) => {
                return Err(misfit!(
                    KeyPath::of("on"),
                    ": {} tags; expected a `name`, by which paths call the chamber",
                    tags.len()
                ));
            }
        };
        let title = title_of(&name, &on);
        let plug =
            read_key(&keys, "plug").map_err(|what| what.titled(title.clone().key("plug")))?;
        keys.retain(|key, _| !["name", "on", "plug"].contains(&key));
        let gas = GasConfig::read(&keys).map_err(|what| what.titled(title))?;
        Ok(Self { name, on, plug: plug.unwrap_or(false), gas })
    }
}

fn title_of(name: &str, on: &Names) -> KeyPath {
    match on {
        Names::One(tag) if tag == name => title(tag),
        _ => KeyPath::list("chamber").named(name),
    }
}

fn title(on: &str) -> KeyPath {
    KeyPath::list("chamber").on(on)
}

impl Serialize for ChamberConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        if !matches!(&self.on, Names::One(tag) if *tag == self.name) {
            map.serialize_entry("name", &self.name)?;
        }
        map.serialize_entry("on", &self.on)?;
        if self.plug {
            map.serialize_entry("plug", &true)?;
        }
        for (key, value) in self.gas.written() {
            map.serialize_entry(&key, &value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for ChamberConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::read(toml::Table::deserialize(deserializer)?).map_err(Misfit::carried)
    }
}

impl JsonSchema for ChamberConfig {
    fn schema_name() -> Cow<'static, str> {
        "ChamberConfig".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = gas::schema(generator);
        let name = json!({ "type": "string", "description": "What paths and messages call it; if not given, the \
            tag of its wall." });
        let mut on = generator.subschema_for::<Names>().to_value();
        on["description"] =
            "Tag of its wall; or a list of those of several hollows that share their gas, as on a \
            manifold."
                .into();
        let plug = json!({ "type": "boolean", "default": false, "description": "Whether plugs, on which the gas \
            pushes and which move with it, close what is open of the wall, so that its rim need not be fixed." });
        add_keys(&mut schema, &[("name", name, false), ("on", on, true), ("plug", plug, false)]);
        schema
    }
}

/// A chamber of a design: its pressure in the scene follows slopes over time, one for each
/// time step.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChamberDesign {
    /// Name of the chamber in the scene, or the tag of its wall if it has none. The scene prescribes its pressure.
    pub on: String,
    /// Smallest and largest slope [Pa/s].
    pub slope: [f64; 2],
    /// Smallest and largest pressure at the ends of time steps [Pa].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[f64; 2]>,
    /// Largest change of a slope in one iteration [Pa/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change: Option<f64>,
}

impl ChamberDesign {
    /// Checks what can be checked without a scene.
    pub(super) fn check(&self) -> Result<()> {
        let title = title(&self.on);
        for (key, range, unit) in
            [("slope", Some(self.slope), "Pa/s"), ("bounds", self.bounds, "Pa")]
        {
            let Some([low, high]) = range else { continue };
            ensure!(
                low < high && low.is_finite() && high.is_finite(),
                misfit!(
                    title.clone().key(key),
                    " = [{low}, {high}] {unit}; expected two numbers, the smaller first"
                )
            );
        }
        ensure!(
            self.change.is_none_or(|c| c.is_finite() && c > 0.0),
            misfit!(
                title.key("change"),
                " = {:?} Pa/s must be positive",
                self.change.unwrap_or(f64::NAN)
            )
        );
        Ok(())
    }
}
