//! How a chamber comes into a body: the methods, one file each with all that is its own. Everything else asks the row.

mod halves;
mod open_top;
mod pull_out;
mod solid;
mod soluble;

use std::ops::Deref;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a chamber comes into a body, in the order in which methods are preferred; what is for bodies without a chamber
/// comes first there.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A rigid core, pulled out through the inlet.
    PullOut,
    /// Two castings: the chamber, open to a plane, and the sheet that closes it.
    OpenTop,
    /// A core printed of what water dissolves.
    Soluble,
    /// Two halves, each cast on a half core, and glued.
    Halves,
    /// None: the body has no chamber.
    Solid,
}

/// What a method is.
pub struct Row {
    /// The name in files.
    pub name: &'static str,
    /// Bodies that it is for.
    pub bodies: Bodies,
    /// What decides whether it can be used.
    pub judged_by: JudgedBy,
    /// What is cast.
    pub castings: Castings,
    /// The cores of its molds.
    pub core: Core,
    /// What to do with the castings, in order, of a body with so many chambers.
    pub steps: fn(usize) -> &'static [&'static str],
}

/// Bodies that a method is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bodies {
    /// Those with chambers.
    WithChambers,
    /// Those without.
    Solid,
    /// Both.
    All,
}

/// What decides whether a method can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JudgedBy {
    /// That there is no chamber.
    NoChamber,
    /// Inlets that hold cores, and through which they leave.
    Inlets,
    /// These, and how far they have to stretch around the cores.
    Girth,
    /// How flat one wall of the chamber is.
    FlatWall,
    /// How halves come off their half cores.
    HalfCores,
}

/// What is cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Castings {
    /// The body in one piece.
    Body,
    /// Two halves.
    Halves,
    /// The chamber, open to a plane, and a sheet that closes it.
    ChamberAndSheet,
}

/// The cores of a method.
pub struct Core {
    /// What they are printed of, if that is another filament than that of the shells.
    pub filament: Option<Filament>,
    /// Whether they stand on stubs and have to stay where they are while silicone rises.
    pub stands_on_stub: bool,
    /// How they leave the body.
    pub leaves: fn(&Leaving) -> String,
}

impl Core {
    /// Whether they leave by themselves, whatever their shape: water that is led through them dissolves them.
    pub fn dissolves(&self) -> bool {
        self.filament.is_some()
    }
}

/// A filament that water dissolves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filament {
    /// What slicers call it.
    pub name: &'static str,
    /// Density [g/cm³].
    pub density: f64,
    /// What to buy.
    pub item: &'static str,
    /// What it is, in a sentence.
    pub words: &'static str,
}

/// Words for cores that leave a body.
pub struct Leaving<'a> {
    /// Their names.
    pub cores: &'a str,
    /// "it", or "them".
    pub them: &'a str,
    /// "the inlet", or "their inlets".
    pub inlets: &'a str,
}

impl Method {
    /// All methods, in the order in which they are preferred.
    pub const ALL: [Self; 5] =
        [Self::PullOut, Self::OpenTop, Self::Soluble, Self::Halves, Self::Solid];

    /// The name in files.
    pub fn name(self) -> &'static str {
        self.name
    }
}

impl Deref for Method {
    type Target = Row;

    fn deref(&self) -> &Row {
        match self {
            Self::PullOut => &pull_out::ROW,
            Self::OpenTop => &open_top::ROW,
            Self::Soluble => &soluble::ROW,
            Self::Halves => &halves::ROW,
            Self::Solid => &solid::ROW,
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}
