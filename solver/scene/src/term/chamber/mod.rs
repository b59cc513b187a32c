//! `[[chamber]]`: a pressurised chamber with its gas.

mod build; // walls and gas on a body
mod gas; // keys of gas laws

use std::borrow::Cow;

use anyhow::{Context, Result, ensure};
use mechanics::energy::{ChamberId, GasLaw, Slot, Term};
use program::schema::{add_table, take_keys};
use program::{KeyPath, Misfit, Names, misfit};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::values::Values;
use super::{
    About, Around, Ground, Known, Place, Room, RoomNumber, Scheduled, Stage, check_off_cuts, each,
};
pub(crate) use build::multipliers;
pub use gas::GasConfig;

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

    /// The law of its gas.
    pub fn law(&self, values: &Values) -> Box<dyn GasLaw> {
        self.gas.law(values.schedule(&self.gas.value))
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
        Names::One(tag) if tag == name => KeyPath::list("chamber").on(tag),
        _ => KeyPath::list("chamber").named(name),
    }
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

impl Room for Vec<ChamberConfig> {
    fn about(&self) -> About {
        About {
            list: "chamber",
            stage: Stage::Load,
            paths: "chamber.TAG.KEY",
            meaning: "what is added to the pressure, fill, volume_change, volume_factor or injected volume of a chamber",
            example: "",
        }
    }

    fn schedules(&self) -> Vec<Scheduled<'_>> {
        let key = |own: &ChamberConfig| own.title().key(own.gas.key());
        self.iter().map(|own| (key(own), false, &own.gas.value)).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        let moments = around.values.moments();
        for (i, chamber) in self.iter().enumerate() {
            chamber.law(&around.values).check(&moments).with_context(|| chamber.title())?;
            let earlier = &self[..i];
            for (k, tag) in chamber.on.all().iter().enumerate() {
                let taken = earlier.iter().any(|other| other.is_on(tag));
                ensure!(
                    !taken && !chamber.on.all()[..k].contains(tag),
                    chamber.title().told(format!(
                        "\"{tag}\" is the wall of two chambers: keep one [[chamber]] on it"
                    ))
                );
            }
            ensure!(
                earlier.iter().all(|other| other.name != chamber.name),
                chamber.title().told(format!("two [[chamber]] are called \"{}\"", chamber.name))
            );
            ensure!(!chamber.on.all().is_empty(), chamber.title().told("on = []: name a tag"));
        }
        check_off_cuts("chamber", |tag| self.iter().any(|own| own.is_on(tag)), &around.cuts)
    }

    fn stress(&self, _: f64, values: &Values) -> f64 {
        let pressures = self.iter().filter(|own| own.gas.is_pressure());
        pressures.map(|own| values.largest(&own.gas.value)).fold(0.0, f64::max)
    }

    fn build(&self, ground: &Ground, first: usize) -> Result<Vec<Term>> {
        build::terms(self, ground, first)
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |_, ChamberConfig { name, gas, .. }| {
            let slot = Slot::new(gas.key(), gas.unit());
            (name.clone(), vec![(slot, Place::AddedTo(&mut gas.value))])
        })
    }

    fn derivative(&self, table: usize, _: &str, Known { parameters, .. }: &Known) -> f64 {
        let by = |step: usize| parameters.sum(step, ChamberId::of(table).owner());
        (0..parameters.steps()).map(by).sum()
    }
}
