//! `[contact]` and `[[obstacle]]`: what happens where surfaces meet.

mod apart; // bodies that lie in each other
mod build; // the barrier between the surfaces of a body, and friction
mod obstacle; // the whole of an obstacle of a part

use std::path::PathBuf;

use anyhow::Result;
use measure::written::{DensitySchema, FieldSchema, FormSchema};
use mechanics::contact::barrier::Form;
use mechanics::contact::density::Density;
use mechanics::contact::potential::Partners;
use mechanics::energy::{Friction, Term};
use mechanics::schedule::WrittenField;
use program::table::{Range, Table};
use program::{KeyPath, Misfit, misfit, read_table};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use toml::Value;

use super::{About, Ground, Known, Room, RoomNumber, Stage, each, value};

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

program::table! {
    /// A rigid surface, open or closed.
    #[derive(Clone, Debug)]
    pub struct ObstacleConfig {
        /// What reports call it.
        name: String;
        /// Triangle surface, a file in metres.
        surface: PathBuf;
        /// How far it has moved [m].
        #[schemars(with = "FieldSchema")]
        displacement: WrittenField = WrittenField::default();
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
        match Value::deserialize(deserializer)? {
            Value::Table(table) => read_table(&table).map(Self::Barrier).map_err(Misfit::carried),
            Value::String(word) if word == "ignored" => Ok(Self::Ignored(Ignored::Ignored)),
            other => Err(D::Error::custom(format!(
                "invalid value: {other}, expected a table, or \"ignored\""
            ))),
        }
    }
}

impl Room for Option<ContactChoice> {
    fn about(&self) -> About {
        About {
            list: "contact",
            stage: Stage::Load,
            paths: "contact.friction",
            meaning: "the coefficient of friction, where there is some",
            example: "",
        }
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        match self {
            Some(ContactChoice::Barrier(contact)) => build::terms(contact, ground),
            Some(ContactChoice::Ignored(_)) => Ok(Vec::new()),
            None => apart::check(ground).map(|()| Vec::new()),
        }
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        let Some(ContactChoice::Barrier(contact)) = self else { return Vec::new() };
        let rubs = usize::from(contact.friction > 0.0);
        each(&mut std::slice::from_mut(contact)[..rubs], |_, own| {
            (String::new(), vec![value("friction", "1", &mut own.friction)])
        })
    }

    fn derivative(&self, _: usize, _: &str, known: &Known) -> f64 {
        known.total(Friction::OWNER, 0)
    }
}
