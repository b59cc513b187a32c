//! `[contact]`: what happens where surfaces meet.

use measure::written::{DensitySchema, FormSchema};
use std::fmt;

use mechanics::contact::barrier::Form;
use mechanics::contact::density::Density;
use mechanics::contact::potential::Partners;
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Contact and friction, or that there shall be none.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ContactChoice {
    /// Surfaces may pass through each other.
    Ignored(Ignored),
    /// A table.
    Barrier(ContactConfig),
}

/// The word in place of a table.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ignored {
    /// Surfaces may pass through each other.
    Ignored,
}

/// Which features repel each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pairs {
    /// Those that are apart at rest: not both skins of a wall, and parts of one body that are
    /// closer than the activation only below the distance that they have at rest.
    #[default]
    ThroughAir,
    /// All, also through the solid of a body, and at rest: as PolyFEM has it.
    All,
}

impl Pairs {
    /// What the potential knows it as.
    pub fn partners(self) -> Partners {
        match self {
            Self::ThroughAir => Partners::ThroughAir,
            Self::All => Partners::All,
        }
    }
}

/// Contact and friction.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactConfig {
    /// Which sum over pairs of features.
    #[serde(default)]
    #[schemars(with = "FormSchema")]
    pub form: Form,
    /// The barrier as a function of distance: `"log"`, or `"log-squared"`, which is smoother and weaker
    /// where it begins.
    #[serde(default)]
    #[schemars(with = "DensitySchema")]
    pub barrier: Density,
    /// Which features repel each other.
    #[serde(default)]
    pub pairs: Pairs,
    /// Distance below which surfaces repel each other, beyond `thickness` [m]. If not given, the
    /// largest of 1, 2 or 5 × 10ⁿ m within half of the shortest edge of the collision surface.
    pub activation: Option<f64>,
    /// Stiffness of the barrier [Pa]; in the plain form [J/m⁴]. If not given, the largest shear
    /// modulus of the bodies; the plain form needs it.
    pub stiffness: Option<f64>,
    /// Distance that surfaces never fall below [m].
    #[serde(default)]
    pub thickness: f64,
    /// Parts that each edge of the mesh is cut into on the collision surface;
    /// the degree of the displacement if not given.
    pub split: Option<usize>,
    /// Coefficient of friction [1].
    #[serde(default)]
    pub friction: f64,
    /// Sliding speed from which friction is full [m/s].
    #[serde(default = "a_millimetre")]
    pub friction_speed: f64,
}

fn a_millimetre() -> f64 {
    1e-3
}

/// By hand, so that an unknown key of the table is named.
impl<'de> Deserialize<'de> for ContactChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choice;
        impl<'de> Visitor<'de> for Choice {
            type Value = ContactChoice;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("a table, or \"ignored\"")
            }
            fn visit_str<E: Error>(self, word: &str) -> Result<ContactChoice, E> {
                match word {
                    "ignored" => Ok(ContactChoice::Ignored(Ignored::Ignored)),
                    _ => Err(E::invalid_value(Unexpected::Str(word), &self)),
                }
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ContactChoice, A::Error> {
                ContactConfig::deserialize(MapAccessDeserializer::new(map))
                    .map(ContactChoice::Barrier)
            }
        }
        deserializer.deserialize_any(Choice)
    }
}
