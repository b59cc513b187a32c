//! `[[chamber]]`: a pressurised chamber, in scenes with its gas, in designs with what may
//! change of its pressure.

use std::borrow::Cow;

use program::schema::{add_table, take_keys};
use program::table::Range;
use program::{KeyPath, Misfit, Names, misfit};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::gas::{self, GasConfig};
use super::parameter::rising;

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

program::table! {
    /// Keys of a chamber beside those of its gas law.
    #[derive(Clone, Debug)]
    struct BesideGas {
        /// What paths and messages call it.
        name: Option<String> = None => "the tag of its wall";
        /// Tag of its wall; or a list of those of several hollows that share their gas, as on a manifold.
        on: Names;
        /// Whether plugs, on which the gas pushes and which move with it, close what is open of the wall, so that its rim
        /// need not be fixed.
        plug: bool = false;
    }
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
        let BesideGas { name, on, plug } = take_keys(&mut keys)?;
        let name = match (name, &on) {
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
        let gas = GasConfig::read(&keys).map_err(|what| what.titled(title_of(&name, &on)))?;
        Ok(Self { name, on, plug, gas })
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
        let Self { name, on, plug, gas } = self.clone();
        let name = (on != Names::One(name.clone())).then_some(name);
        let mut table = gas.written();
        table
            .extend(toml::Table::try_from(BesideGas { name, on, plug }).map_err(S::Error::custom)?);
        table.serialize(serializer)
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
        add_table::<BesideGas>(&mut schema, generator);
        schema
    }
}

program::table! {
    /// A chamber of a design: its pressure in the scene follows slopes over time, one for each
    /// time step.
    #[derive(Clone, Debug)]
    pub struct ChamberDesign {
        /// Name of the chamber in the scene, or the tag of its wall if it has none. The scene prescribes its pressure.
        on: String;
        /// Smallest and largest slope [Pa/s].
        slope: [f64; 2], rising::<[f64; 2]>(" Pa/s");
        /// Smallest and largest pressure at the ends of time steps [Pa].
        bounds: Option<[f64; 2]> = None, rising::<Option<[f64; 2]>>(" Pa");
        /// Largest change of a slope in one iteration [Pa/s].
        change: Option<f64> = None, Range::POSITIVE.unit("Pa/s");
    }
}

impl ChamberDesign {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        title(&self.on)
    }
}
