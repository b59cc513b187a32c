//! Rooms of the terms of the energy: what people write of one in a table of `sim.toml`, its energies on a body, its
//! numbers, and what a report says of it.
//!
//! A table of a room is a [`TermTable`]; [`SimConfig::rooms`](crate::config::SimConfig::rooms) lists the rooms. Formula
//! and derivatives are those of `mechanics::energy`. Laws and loads, which one table of a scene has and others read, are
//! not rooms: they stand in [`model`](crate::model).

pub mod line; // lines in space and directions
pub mod profile; // numbers that may change along an axis
pub mod direction; // fields of directions
pub mod membrane; // thin sheets on tags
pub mod fibre; // families of fibres in bodies and volumes
pub mod winding; // threads on tags
pub mod relaxation; // overstress of viscoelastic bodies
pub mod mullins; // softening after a first stretch
pub mod rigid; // parts that keep their shape

use std::ops::Range;
use std::path::Path;

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Energies, Energy, Iterate, Owner, Slot, Term};
use mechanics::forward::Method;
use mechanics::schedule::{Written, WrittenField};
use mechanics::symmetry::Plane;
use mesh::Vec3;
use mesh::io::vtu::Field;
use program::{KeyPath, misfit};
use reports::Terms;

/// What the terms of a scene stand on.
pub struct Ground<'a> {
    /// The file of the scene, beside which those are that it names.
    pub path: &'a Path,
    /// The body with its tags.
    pub body: &'a Body,
    /// Its elements.
    pub space: &'a FunctionSpace,
    /// What has a law of its own, in the order of tetrahedra.
    pub regions: Vec<Region>,
}

/// A body or volume with a law of its own, in the order of laws.
pub struct Region {
    /// What messages call it.
    pub name: String,
    /// The body that it is, or is a volume of.
    pub body: String,
    /// Its tetrahedra.
    pub elements: Range<usize>,
}

impl Region {
    /// Whether a table is of it by the name of a body or volume, or of all without one.
    pub fn is_of(&self, on: Option<&str>) -> bool {
        on.is_none_or(|on| self.name == on || self.body == on)
    }
}

/// What a check of a room may look at besides its tables.
pub struct Around<'a> {
    /// Tags of the cuts in planes of symmetry.
    pub cuts: &'a [Vec<String>],
    /// How bodies go through time.
    pub method: Method,
    /// Whether there are time steps.
    pub in_time: bool,
    /// Whether anything has a weight.
    pub has_gravity: bool,
    /// Names of the bodies, where there are several.
    pub bodies: Vec<&'a str>,
}

/// A state that is reported.
#[derive(Clone, Copy)]
pub struct State<'a> {
    /// All terms.
    pub energies: &'a Energies,
    /// Where they are.
    pub at: &'a Iterate<'a>,
}

/// The derivatives of a result, as numbers of rooms need them.
pub struct Known<'a> {
    /// What has a law of its own.
    pub regions: &'a [Region],
    /// The derivative by a number of an owner, by its key.
    pub by: &'a dyn Fn(Owner, &str) -> f64,
}

/// Where a number of a table is.
pub enum Place<'a> {
    /// It is this one.
    Value(&'a mut f64),
    /// It is added to this function of time.
    AddedTo(&'a mut Written),
}

/// A number of a table: the slot that it has in an energy, and where it is. Angles are degrees here.
type TableNumber<'a> = (Slot, Place<'a>);

/// A table of a room.
pub trait TermTable: Clone {
    /// Its list in `sim.toml`, which is the first word of the paths of its numbers and owns these.
    const LIST: &'static str;
    /// The paths of its numbers; words in capitals are names of the scene.
    const PATHS: &'static str;
    /// What these numbers are.
    const MEANING: &'static str;

    /// What paths call one of all tables, counted from 0.
    fn name(&self, place: usize) -> String;

    /// What people are told of it before a run.
    fn in_words(&self) -> Option<String>;

    /// Refuses what no type can rule out and needs no body to be seen.
    fn check(all: &[Self], around: &Around) -> Result<()>;

    /// The terms of all tables, which own their numbers; none where they stand beside those of laws.
    fn build(_: &[Self], _: &Ground) -> Result<Vec<Term>> {
        Ok(Vec::new())
    }

    /// Its numbers.
    fn numbers(&mut self) -> Vec<TableNumber<'_>>;

    /// The derivative of a result by one of its numbers.
    fn derivative(_: &[Self], place: usize, key: &str, known: &Known) -> f64 {
        (known.by)(Owner::new(Self::LIST, place), key)
    }

    /// What a user should know of it before a run.
    fn warnings(&self, _: &Body) -> Vec<String> {
        Vec::new()
    }

    /// Puts its section into a report of a state; there is one table or more.
    fn report(_: &[Self], _: State, _: &mut Terms) {}

    /// Fields of the cells of a state, for ParaView.
    fn fields(_: State) -> Vec<Field> {
        Vec::new()
    }
}

/// Terms of energies, of which each owns its numbers.
fn owned<T: TermTable>(energies: impl IntoIterator<Item = impl Energy>) -> Vec<Term> {
    let own = energies.into_iter().enumerate();
    own.map(|(place, own)| Term::of(Owner::new(T::LIST, place), own)).collect()
}

/// A number of a room.
pub struct RoomNumber {
    /// Which of its tables has it.
    pub table: usize,
    /// What paths call that.
    pub name: String,
    /// What it is there; angles are degrees.
    pub slot: Slot,
}

/// The tables of a room in a scene.
pub trait Room {
    /// [`TermTable::LIST`].
    fn list(&self) -> &'static str;
    /// [`TermTable::PATHS`] and [`TermTable::MEANING`].
    fn explained(&self) -> [&'static str; 2];
    /// Whether the scene has none.
    fn is_empty(&self) -> bool;
    /// [`TermTable::in_words`] of each.
    fn in_words(&self) -> Vec<String>;
    /// [`TermTable::check`]
    fn check(&self, around: &Around) -> Result<()>;
    /// [`TermTable::build`]
    fn build(&self, ground: &Ground) -> Result<Vec<Term>>;
    /// All numbers.
    fn numbers(&self) -> Vec<RoomNumber>;
    /// What is written of a number of a table by its key, and whether numbers are added to that.
    fn written(&self, table: usize, key: &str) -> (Written, bool);
    /// Where that is.
    fn number(&mut self, table: usize, key: &str) -> Place<'_>;
    /// [`TermTable::derivative`]
    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64;
    /// [`TermTable::warnings`] of all.
    fn warnings(&self, body: &Body) -> Vec<String>;
    /// [`TermTable::report`], where there are some.
    fn report(&self, state: State, terms: &mut Terms);
    /// [`TermTable::fields`]
    fn fields(&self, state: State) -> Vec<Field>;
}

impl<T: TermTable> Room for Vec<T> {
    fn list(&self) -> &'static str {
        T::LIST
    }

    fn explained(&self) -> [&'static str; 2] {
        [T::PATHS, T::MEANING]
    }

    fn is_empty(&self) -> bool {
        Vec::is_empty(self)
    }

    fn in_words(&self) -> Vec<String> {
        self.iter().filter_map(T::in_words).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        T::check(self, around)
    }

    fn build(&self, ground: &Ground) -> Result<Vec<Term>> {
        T::build(self, ground)
    }

    fn numbers(&self) -> Vec<RoomNumber> {
        let of = |(table, own): (usize, &T)| -> Vec<RoomNumber> {
            let name = own.name(table);
            let mut own = own.clone();
            let slots = own.numbers().into_iter();
            slots.map(|(slot, _)| RoomNumber { table, name: name.clone(), slot }).collect()
        };
        self.iter().enumerate().flat_map(of).collect()
    }

    fn written(&self, table: usize, key: &str) -> (Written, bool) {
        match number(&mut self[table].clone(), key) {
            Place::Value(value) => ((*value).into(), false),
            Place::AddedTo(written) => (written.clone(), true),
        }
    }

    fn number(&mut self, table: usize, key: &str) -> Place<'_> {
        number(&mut self[table], key)
    }

    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        T::derivative(self, table, key, known)
    }

    fn warnings(&self, body: &Body) -> Vec<String> {
        self.iter().flat_map(|own| own.warnings(body)).collect()
    }

    fn report(&self, state: State, terms: &mut Terms) {
        if !self.is_empty() {
            T::report(self, state, terms);
        }
    }

    fn fields(&self, state: State) -> Vec<Field> {
        T::fields(state)
    }
}

/// A number of a table by its key, which the table has.
fn number<'a, T: TermTable>(table: &'a mut T, key: &str) -> Place<'a> {
    let mut all = table.numbers().into_iter();
    all.find(|(slot, _)| slot.key == key).expect("the key of one of its numbers").1
}

/// A number that is a value.
fn value<'a>(key: &str, unit: &'static str, value: &'a mut f64) -> TableNumber<'a> {
    (Slot::new(key, unit), Place::Value(value))
}

/// The components of a vector that are functions of time.
fn components<'a>(
    key: &str,
    unit: &'static str,
    vector: &'a mut WrittenField,
) -> impl Iterator<Item = TableNumber<'a>> {
    let slots = Slot::components(key, unit).into_iter();
    slots.zip(&mut vector.0).map(|(slot, written)| (slot, Place::AddedTo(written)))
}

/// A number, or those of one that changes along an axis, with what they are called.
fn along<'a>(
    key: &str,
    unit: &'static str,
    number: &'a mut profile::Along,
) -> impl Iterator<Item = TableNumber<'a>> {
    let count = number.profile().map(|profile| profile.values.len());
    let slots = Slot::along(key, unit, count).into_iter().zip(number.values_mut());
    slots.map(|(slot, value)| (slot, Place::Value(value)))
}

/// Refuses names that are empty, given twice, or would split the path of a number.
fn check_names<'a>(list: &str, names: impl Iterator<Item = &'a String>) -> Result<()> {
    let mut known: Vec<&String> = Vec::new();
    for name in names {
        let key = KeyPath::list(list).named(name).key("name");
        ensure!(
            !name.is_empty() && !name.contains('.'),
            misfit!(key, " = \"{name}\": a name has one letter or more, and no dot")
        );
        ensure!(!known.contains(&name), misfit!(key, ": two [[{list}]] are called \"{name}\""));
        known.push(name);
    }
    Ok(())
}

/// Sine of the angle between directions that are mirror images of each other, at most, and relative difference of
/// numbers that are.
const PARALLEL: f64 = 1e-6;

/// The mirror image of a point.
fn image(plane: &Plane, x: Vec3) -> Vec3 {
    let mut place = x;
    place[plane.axis] = 2.0 * plane.level - x[plane.axis];
    place
}
