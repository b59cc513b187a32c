//! How a chamber comes into a body: the methods, one file each with all that is its own. Everything else asks the row.

mod halves;
mod open_top;
mod pull_out;
mod solid;
mod soluble;
mod wax;

use std::borrow::Cow;
use std::ops::Deref;
use std::sync::LazyLock;

use program::schema::one_of_these;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// All methods, in the order in which they are preferred; what is for bodies without a chamber comes first there.
static METHODS: &[&Row] =
    &[&pull_out::ROW, &open_top::ROW, &soluble::ROW, &halves::ROW, &wax::ROW, &solid::ROW];

/// What a method is.
pub struct Row {
    /// The name in files.
    pub name: &'static str,
    /// Bodies that it is for.
    pub bodies: Bodies,
    /// What decides whether it can be used.
    pub judged_by: JudgedBy,
    /// Whether it is taken without being asked for, if it can be used.
    pub is_automatic: bool,
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
    /// How they are made.
    pub made: Made,
    /// Whether they stand on stubs and have to stay where they are while silicone rises.
    pub stands_on_stub: bool,
    /// Whether water is led through them.
    pub is_bored: bool,
    /// Whether they leave by themselves, whatever their shape.
    pub vanishes: bool,
    /// How they leave the body.
    pub leaves: fn(&Leaving) -> String,
}

/// How cores are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Made {
    /// Printed of what shells are printed of.
    Printed,
    /// Printed of another filament.
    Of(Filament),
    /// Cast in molds of their own.
    Cast,
}

/// A filament that cores are printed of.
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

/// One of the methods.
#[derive(Clone, Copy)]
pub struct Method(&'static Row);

impl Method {
    /// All methods, in the order in which they are preferred.
    pub fn all() -> Vec<Self> {
        METHODS.iter().copied().map(Self).collect()
    }

    /// The method with a name.
    pub fn named(name: &str) -> Option<Self> {
        METHODS.iter().copied().find(|row| row.name == name).map(Self)
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        self.0.name
    }
}

impl Core {
    /// The filament that they are printed of, if it is another one than that of the shells.
    pub fn filament(&self) -> Option<Filament> {
        match self.made {
            Made::Of(filament) => Some(filament),
            Made::Printed | Made::Cast => None,
        }
    }

    /// Whether they are cast.
    pub fn is_cast(&self) -> bool {
        self.made == Made::Cast
    }
}

impl Deref for Method {
    type Target = Row;

    fn deref(&self) -> &Row {
        self.0
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Method {}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// The method that is asked for; none for `"auto"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodChoice(pub Option<Method>);

/// The word for none.
const AUTO: &str = "auto";

impl Serialize for MethodChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.map_or(AUTO, Method::name))
    }
}

impl JsonSchema for MethodChoice {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "MethodChoice".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        one_of_these([AUTO].into_iter().chain(METHODS.iter().map(|row| row.name)))
    }
}

impl<'de> Deserialize<'de> for MethodChoice {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| {
            [AUTO].into_iter().chain(METHODS.iter().map(|row| row.name)).collect()
        });
        let name = Cow::<str>::deserialize(input)?;
        match Method::named(&name) {
            None if name != AUTO => Err(D::Error::unknown_variant(&name, &NAMES)),
            found => Ok(Self(found)),
        }
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

impl JsonSchema for Method {
    fn schema_name() -> Cow<'static, str> {
        "Method".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        one_of_these(METHODS.iter().map(|row| row.name))
    }
}

impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| METHODS.iter().map(|row| row.name).collect());
        let name = Cow::<str>::deserialize(input)?;
        Self::named(&name).ok_or_else(|| D::Error::unknown_variant(&name, &NAMES))
    }
}
