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

use std::ops::Range;
use std::path::Path;

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Energies, Energy, Iterate, Owner, Slot, Term};
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

/// A body or volume with a law of its own.
pub struct Region {
    /// What messages call it.
    pub name: String,
    /// The body that it is, or is a volume of.
    pub body: String,
    /// Its tetrahedra.
    pub elements: Range<usize>,
}

/// A table of a room.
pub trait TermTable: Clone {
    /// Its list in `sim.toml`, which is the first word of the paths of its numbers and owns these.
    const LIST: &'static str;
    /// The paths of its numbers; words in capitals are names of the scene.
    const PATHS: &'static str;
    /// What these numbers are.
    const MEANING: &'static str;
    /// The energy that a table makes.
    type Energy: Energy;

    /// What paths of its numbers call it.
    fn name(&self) -> &str;

    /// What people are told of it before a run.
    fn in_words(&self) -> String;

    /// Refuses what no type can rule out and needs no body to be seen, beside the tags of cuts in planes of symmetry.
    fn check(all: &[Self], cuts: &[Vec<String>]) -> Result<()>;

    /// The energy of each table.
    fn build(all: &[Self], ground: &Ground) -> Result<Vec<Self::Energy>>;

    /// Its numbers by the keys of the slots of its energy. Angles are degrees here.
    fn numbers(&mut self) -> Vec<(Slot, &mut f64)>;

    /// What a user should know of it before a run.
    fn warnings(&self, _: &Body) -> Vec<String> {
        Vec::new()
    }

    /// Puts its section into a report of a state; there is one table or more.
    fn report(all: &[(&Self, &Self::Energy)], state: State, terms: &mut Terms);

    /// Fields of the cells of a state, for ParaView.
    fn fields(_: &Self::Energy, _: &Iterate) -> Vec<Field> {
        Vec::new()
    }
}

/// A state that is reported.
#[derive(Clone, Copy)]
pub struct State<'a> {
    /// All terms.
    pub energies: &'a Energies,
    /// Where they are.
    pub at: &'a Iterate<'a>,
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
    fn check(&self, cuts: &[Vec<String>]) -> Result<()>;
    /// The terms of the tables, which own their numbers.
    fn build(&self, ground: &Ground) -> Result<Vec<Term>>;
    /// All numbers.
    fn numbers(&self) -> Vec<RoomNumber>;
    /// The value of a number of a table by its key.
    fn value(&self, table: usize, key: &str) -> f64;
    /// Gives it another one.
    fn set(&mut self, table: usize, key: &str, value: f64);
    /// [`TermTable::warnings`] of all.
    fn warnings(&self, body: &Body) -> Vec<String>;
    /// [`TermTable::report`], where there are some.
    fn report(&self, state: State, terms: &mut Terms);
    /// [`TermTable::fields`] of all.
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
        self.iter().map(T::in_words).collect()
    }

    fn check(&self, cuts: &[Vec<String>]) -> Result<()> {
        T::check(self, cuts)
    }

    fn build(&self, ground: &Ground) -> Result<Vec<Term>> {
        let energies = T::build(self, ground)?.into_iter().enumerate();
        Ok(energies.map(|(place, own)| Term::of(Owner::new(T::LIST, place), own)).collect())
    }

    fn numbers(&self) -> Vec<RoomNumber> {
        let of = |(table, own): (usize, &T)| -> Vec<RoomNumber> {
            let mut own = own.clone();
            let name = own.name().to_owned();
            let slots = own.numbers().into_iter();
            slots.map(|(slot, _)| RoomNumber { table, name: name.clone(), slot }).collect()
        };
        self.iter().enumerate().flat_map(of).collect()
    }

    fn value(&self, table: usize, key: &str) -> f64 {
        *number(&mut self[table].clone(), key)
    }

    fn set(&mut self, table: usize, key: &str, value: f64) {
        *number(&mut self[table], key) = value;
    }

    fn warnings(&self, body: &Body) -> Vec<String> {
        self.iter().flat_map(|own| own.warnings(body)).collect()
    }

    fn report(&self, state: State, terms: &mut Terms) {
        let all: Vec<(&T, &T::Energy)> = self.iter().zip(state.energies.each()).collect();
        if !all.is_empty() {
            T::report(&all, state, terms);
        }
    }

    fn fields(&self, state: State) -> Vec<Field> {
        state.energies.each().flat_map(|own| T::fields(own, state.at)).collect()
    }
}

/// A number of a table by its key, which the table has.
fn number<'a, T: TermTable>(table: &'a mut T, key: &str) -> &'a mut f64 {
    let mut all = table.numbers().into_iter();
    all.find(|(slot, _)| slot.key == key).expect("the key of one of its numbers").1
}

/// A number, or those of one that changes along an axis, with what they are called.
fn along<'a>(
    key: &str,
    unit: &'static str,
    number: &'a mut profile::Along,
) -> impl Iterator<Item = (Slot, &'a mut f64)> {
    let count = number.profile().map(|profile| profile.values.len());
    Slot::along(key, unit, count).into_iter().zip(number.values_mut())
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
