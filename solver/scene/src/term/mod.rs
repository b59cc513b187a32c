//! Rooms of the terms of the energy: what people write of one in a table of `sim.toml`, its energies on a body, its
//! numbers, and what a report says of it.
//!
//! [`SimConfig::rooms`](crate::config::SimConfig::rooms) lists the rooms. Formula and derivatives are those of
//! `mechanics::energy`.

pub mod line; // lines in space and directions
pub mod profile; // numbers that may change along an axis
pub mod direction; // fields of directions
pub mod values; // functions of time
pub mod material; // laws of bodies
pub mod membrane; // thin sheets on tags
pub mod fibre; // families of fibres in bodies and volumes
pub mod winding; // threads on tags
pub mod relaxation; // overstress of viscoelastic bodies
pub mod mullins; // softening after a first stretch
pub mod rigid; // parts that keep their shape
pub mod chamber; // gas behind tags
pub mod contact; // what happens where surfaces meet
pub mod dead_load; // gravity, forces on bodies and on tags

use std::path::Path;

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Energies, Energy, Iterate, Owner, ParameterGradients, Slot, Term};
use mechanics::forward::Method;
use mechanics::material::{LAWS, Law};
use mechanics::rigid::RigidSet;
use mechanics::schedule::{Written, WrittenField};
use mechanics::symmetry::{AXES, Plane, title};
use mesh::Vec3;
use mesh::io::vtu::Field;
use program::{KeyPath, misfit};
use reports::Terms;

use crate::meaning::cut;
use crate::supports::{Support, Supports};
use contact::ObstacleConfig;
use material::SceneLaw;
use values::Values;

/// What a check of a room may look at besides its tables.
pub struct Around<'a> {
    /// What functions of time stand for.
    pub values: Values<'a>,
    /// Tags of the cuts in planes of symmetry.
    pub cuts: Vec<Vec<String>>,
    /// How bodies go through time.
    pub method: Method,
    /// Whether there are time steps.
    pub in_time: bool,
    /// Acceleration by gravity [m/s²].
    pub gravity: &'a WrittenField,
    /// Names of the bodies, where there are several.
    pub bodies: Vec<&'a str>,
}

/// What the terms of a scene stand on.
pub struct Ground<'a> {
    /// The file of the scene, beside which those are that it names.
    pub path: &'a Path,
    /// The settings.
    pub around: Around<'a>,
    /// All rooms.
    pub rooms: Vec<&'a dyn Room>,
    /// Surfaces that bodies cannot pass.
    pub obstacles: &'a [ObstacleConfig],
    /// Names of all surfaces that may touch: bodies, then obstacles.
    pub surfaces: Vec<&'a str>,
    /// Vertices of the scene's own body [m]; a design has others.
    pub own_shape: &'a [Vec3],
    /// The body with its tags.
    pub body: &'a Body,
    /// Its elements.
    pub space: &'a FunctionSpace,
    /// Its fixed degrees of freedom.
    pub supports: &'a Supports,
    /// The laws of bodies and volumes, in the order of tetrahedra.
    pub laws: &'a [SceneLaw],
    /// Nodes that move together, in the order of the rigid parts.
    pub rigid: Vec<RigidSet>,
    /// Whether to prove of every step that no surfaces intersect.
    pub certify: bool,
    /// The terms of the same scene with other numbers, if there are any yet: what takes long to build is taken over.
    pub last: Option<&'a Energies>,
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
    /// The laws of bodies and volumes.
    pub laws: &'a [SceneLaw],
    /// All terms.
    pub energies: &'a Energies,
    /// The derivatives by their numbers.
    pub parameters: &'a ParameterGradients,
}

impl Known<'_> {
    /// The derivative by a number of an owner, by its key; 0 where no term has it.
    pub fn by(&self, owner: Owner, key: &str) -> f64 {
        let own = |term: &&Term| term.owners.last().is_some_and(|(last, _)| *last == owner);
        let place = |term: &Term| term.energy.slots().iter().position(|slot| slot.key == key);
        let place = self.energies.terms().find(own).and_then(place);
        place.map_or(0.0, |k| self.total(owner, k))
    }

    /// The derivative by what all terms have that know a key.
    pub fn by_all(&self, key: &str) -> f64 {
        let has = |term: &&Term| term.energy.slots().iter().any(|slot| slot.key == key);
        let owners = self.energies.terms().filter(has).filter_map(|term| term.owners.last());
        owners.map(|(owner, _)| self.by(*owner, key)).sum()
    }

    /// The derivative by the k-th number of an owner; 0 where no term has it.
    pub fn total(&self, owner: Owner, k: usize) -> f64 {
        self.parameters.total(owner).get(k).copied().unwrap_or(0.0)
    }
}

/// Where a number of a table is.
pub enum Place<'a> {
    /// It is this one.
    Value(&'a mut f64),
    /// It is added to this function of time.
    AddedTo(&'a mut Written),
    /// It is how far a wall of the body is off.
    Wall,
}

/// A number of a table: the slot that it has in an energy, and where it is. Angles are degrees here.
pub type TableNumber<'a> = (Slot, Place<'a>);

/// A number of a room.
pub struct RoomNumber<'a> {
    /// Which of its tables has it.
    pub table: usize,
    /// What paths call that; nothing where there is only one.
    pub name: String,
    /// What it is there; angles are degrees.
    pub slot: Slot,
    /// Where it is.
    pub place: Place<'a>,
}

/// What is known of a room without a scene.
#[derive(Clone, Copy)]
pub struct About {
    /// Its key in `sim.toml`, which is the first word of the paths of its numbers and owns these.
    pub list: &'static str,
    /// Where its terms stand.
    pub stage: Stage,
    /// The paths of its numbers; words in capitals are names of the scene. Nothing where it has no numbers.
    pub paths: &'static str,
    /// What these numbers are.
    pub meaning: &'static str,
    /// A table that tests give a cube with the tag `top`, to test the derivatives by its numbers; empty where these
    /// need another body or other loads.
    pub example: &'static str,
}

/// Where the terms of a room stand among those of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Before inertia.
    Body,
    /// Behind it.
    Load,
    /// Behind all others.
    Part,
}

/// A function of time: what messages call it, whether it may depend on the position, and what is written.
pub type Scheduled<'a> = (KeyPath, bool, &'a Written);

/// The tables of a term in a scene.
pub trait Room {
    /// What is known of it without a scene.
    fn about(&self) -> About;

    /// What people are told of the tables before a run.
    fn in_words(&self) -> Vec<String> {
        Vec::new()
    }

    /// All values that may change with time.
    fn schedules(&self) -> Vec<Scheduled<'_>> {
        Vec::new()
    }

    /// Refuses what no type can rule out and needs no body to be seen.
    fn check(&self, _: &Around) -> Result<()> {
        Ok(())
    }

    /// Refuses what laws cannot have.
    fn check_laws(&self, _: &[SceneLaw]) -> Result<()> {
        Ok(())
    }

    /// What it fixes on a body.
    fn supports(&self, _: &Body) -> Vec<Support> {
        Vec::new()
    }

    /// Largest stress in a part of a size [m] that it makes [Pa].
    fn stress(&self, _size: f64, _: &Values) -> f64 {
        0.0
    }

    /// The term that stands beside the one of a law, by the place of that; `first` internal variables are of the terms before.
    fn beside(&self, _law: usize, _: &Ground, _first: usize) -> Result<Option<Term>> {
        Ok(None)
    }

    /// The terms of all tables, which own their numbers; `first` internal variables are of the terms before.
    fn build(&self, _: &Ground, _first: usize) -> Result<Vec<Term>> {
        Ok(Vec::new())
    }

    /// All numbers.
    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        Vec::new()
    }

    /// The derivative of a result by a number of a table.
    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        known.by(Owner::new(self.about().list, table), key)
    }

    /// What a user should know of it before a run.
    fn warnings(&self, _: &Body) -> Vec<String> {
        Vec::new()
    }

    /// Puts its section into a report of a state, where there is a table or more.
    fn report(&self, _: State, _: &mut Terms) {}

    /// Fields of the cells of a state, for ParaView.
    fn fields(&self, _: State) -> Vec<Field> {
        Vec::new()
    }
}

/// Terms of energies, of which each owns its numbers.
fn owned(list: &'static str, energies: impl IntoIterator<Item = impl Energy>) -> Vec<Term> {
    let own = energies.into_iter().enumerate();
    own.map(|(place, own)| Term::of(Owner::new(list, place), own)).collect()
}

/// The numbers of some tables, each of which has a name in paths and these.
pub(crate) fn each<'a, T>(
    tables: &'a mut [T],
    numbers: impl Fn(usize, &'a mut T) -> (String, Vec<TableNumber<'a>>),
) -> Vec<RoomNumber<'a>> {
    let mut all = Vec::new();
    for (table, own) in tables.iter_mut().enumerate() {
        let (name, numbers) = numbers(table, own);
        let number = |(slot, place)| RoomNumber { table, name: name.clone(), slot, place };
        all.extend(numbers.into_iter().map(number));
    }
    all
}

/// A number that is a value.
pub(crate) fn value<'a>(key: &str, unit: &'static str, value: &'a mut f64) -> TableNumber<'a> {
    (Slot::new(key, unit), Place::Value(value))
}

/// The components of a vector that are functions of time, which may be that of a table without a key.
fn components<'a>(
    key: &str,
    unit: &'static str,
    vector: &'a mut WrittenField,
) -> impl Iterator<Item = TableNumber<'a>> {
    let alone = || AXES.map(|axis| Slot::new(axis, unit));
    let slots = if key.is_empty() { alone() } else { Slot::components(key, unit) };
    slots.into_iter().zip(&mut vector.0).map(|(slot, written)| (slot, Place::AddedTo(written)))
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

/// Refuses loads on tags of a cut.
fn check_off_cuts(list: &str, is_on: impl Fn(&str) -> bool, cuts: &[Vec<String>]) -> Result<()> {
    for tags in cuts {
        ensure!(
            !tags.iter().any(|tag| is_on(tag)),
            cut(tags).told(format!(
                "{}: [[{list}]] is on the same tag, but there is no surface where the whole body is cut; expected a \
                 tag of its own for each",
                title(tags)
            ))
        );
    }
    Ok(())
}

/// The laws that a table of a list is of, by their places; all of them without a name. Refused are those that have no
/// isochoric part.
fn isochoric(list: &str, on: Option<&str>, laws: &[SceneLaw]) -> Result<Vec<usize>> {
    let own: Vec<usize> = (0..laws.len()).filter(|&i| laws[i].is_of(on)).collect();
    let names: Vec<&str> = laws.iter().map(|law| &*law.name).collect();
    ensure!(
        !own.is_empty(),
        misfit!(
            KeyPath::list(list).on(on.unwrap_or_default()),
            ": no body or volume has this name; there are: {}",
            names.join(", ")
        )
    );
    for SceneLaw { material, name, .. } in own.iter().map(|&i| &laws[i]) {
        let has = |law: &&Law| (law.build)(law.sample).isochoric().is_some();
        let known = || LAWS.iter().filter(has).map(|law| law.key).collect::<Vec<_>>().join(", ");
        ensure!(
            material.build().isochoric().is_some(),
            misfit!(
                KeyPath::list(list),
                ": the law {} of \"{name}\" has no isochoric part in Ī₁ and Ī₂; expected one of: {}",
                material.law.key,
                known()
            )
        );
    }
    Ok(own)
}

/// Nodes of one of the bodies, ascending.
pub fn nodes_of(body: &Body, part: usize, space: &FunctionSpace) -> Vec<usize> {
    let (tets, n) = (&body.parts[part].tets, space.nodes_per_element());
    let mut nodes = space.element_nodes()[n * tets.start..n * tets.end].to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
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
