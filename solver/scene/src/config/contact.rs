//! `[contact]`: what happens where surfaces meet.

use measure::written::{DensitySchema, FormSchema};
use std::fmt;

use mechanics::contact::barrier::Form;
use mechanics::contact::density::Density;
use mechanics::contact::potential::Partners;
use program::table::{Range, Table};
use program::{KeyPath, Misfit, misfit};
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

program::table! {
    /// Contact and friction.
    #[derive(Clone, Debug)]
    pub struct ContactConfig {
        /// Which sum over pairs of features.
        #[schemars(with = "FormSchema")]
        form: Form = Form::default();
        /// The barrier as a function of distance: `"log"`, or `"log-squared"`, which is smoother and weaker
        /// where it begins.
        #[schemars(with = "DensitySchema")]
        barrier: Density = Density::default(), keeps_apart;
        /// Which features repel each other.
        pairs: Pairs = Pairs::default();
        /// Distance below which surfaces repel each other, beyond `thickness` [m].
        activation: Option<f64> = None
            => "the largest of 1, 2 or 5 × 10ⁿ m within half of the shortest edge of the collision surface",
            Range::POSITIVE.unit("m");
        /// Stiffness of the barrier [Pa]; in the plain form [J/m⁴], which needs it.
        stiffness: Option<f64> = None => "the largest shear modulus of the bodies", Range::POSITIVE.unit("Pa");
        /// Distance that surfaces never fall below [m].
        thickness: f64 = 0.0, Range::NOT_NEGATIVE.unit("m");
        /// Parts that each edge of the mesh is cut into on the collision surface.
        split: Option<usize> = None => "the degree of the displacement", Range::between(1.0, 8.0);
        /// Coefficient of friction [1].
        friction: f64 = 0.0, Range::NOT_NEGATIVE;
        /// Sliding speed from which friction is full [m/s].
        friction_speed: f64 = 1e-3, Range::POSITIVE.unit("m/s");
    }
}

fn keeps_apart(at: &KeyPath, barrier: &Density) -> Result<(), Misfit> {
    match barrier.is_barrier() {
        true => Ok(()),
        false => Err(misfit!(
            at.clone(),
            " = \"quadratic\" lets surfaces through each other: expected \"log\" or \"log-squared\""
        )),
    }
}

impl Table for ContactChoice {
    fn check_ranges(&self, at: &KeyPath) -> Result<(), Misfit> {
        let Self::Barrier(contact) = self else { return Ok(()) };
        contact.check_ranges(at)?;
        match contact.form == Form::Plain && contact.stiffness.is_none() {
            false => Ok(()),
            true => Err(misfit!(
                at.clone().key("form"),
                " = \"plain\" needs a stiffness [J/m⁴]: a modulus cannot tell it"
            )),
        }
    }
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
