//! The numbers of a scene: what may be calibrated, uncertain, other in a scenario, and checked.
//!
//! One entry of [`KINDS`] for each kind of number: which ones a scene has, their value, how another
//! one is set, and the derivative of a result by it, from the adjoint sweep. Rooms of terms know their own. A number has a path,
//! such as `material.body.c1`, `chamber.left.pressure` or `contact.friction`. A [`Group`] has
//! numbers that change together, as all stresses by one factor do.

mod group;
mod laws;
mod loads;
mod room;
mod walls;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use anyhow::{Result, bail, ensure};
use mechanics::adjoint::Gradient;
use mechanics::energy::{Owner, ParameterGradients, Term};
use mechanics::forward::Problem;
use mechanics::schedule::Written;
use mechanics::symmetry::AXES;
use mesh::Vec3;
use program::{KeyPath, did_you_mean};

use crate::config::SimConfig;
use crate::model::Scene;
use crate::term::Place;
use laws::total;

pub use group::{Change, Group};
pub use loads::velocity_vjp;
pub use walls::Walls;

/// All kinds, in the order in which they are listed: rows, and rooms of terms.
pub static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    let laws = [laws::MATERIAL, laws::DENSITY].map(Kind::Row);
    let none = SimConfig::default();
    let rooms = none.rooms().into_iter().map(|room| Kind::Room(room.list(), room.explained()));
    let loads = [
        loads::CHAMBER,
        loads::FRICTION,
        loads::GRAVITY,
        loads::TRACTION,
        loads::VELOCITY,
        walls::WALL,
    ];
    laws.into_iter().chain(rooms).chain(loads.map(Kind::Row)).collect()
});

/// A kind of number.
pub enum Kind {
    /// By functions of its own.
    Row(Row),
    /// Those of a room of terms, by its list, with the paths and what they are.
    Room(&'static str, [&'static str; 2]),
}

/// A kind of number that is of no room.
pub struct Row {
    /// The path; words in capitals are names of the scene.
    path: &'static str,
    /// What it is.
    meaning: &'static str,
    /// The numbers of a scene that are of this kind: rest of the path, unit and place.
    list: fn(&Scene) -> Vec<Entry>,
    value: fn(&Scene, Indices) -> f64,
    set: Setting,
    /// Whether the scene admits the value that was set.
    check: fn(&Scene, Indices) -> Result<()>,
    derivative: fn(&Swept, Indices) -> f64,
    /// What changes of it are small against, where that is not its value.
    scale: Option<fn(&Scene, Indices) -> f64>,
}

impl Row {
    /// The first word of the paths.
    fn word(&self) -> &'static str {
        self.path.split(['.', ' ']).next().unwrap_or_default()
    }
}

/// How a number is given a value.
enum Setting {
    /// By a function.
    By(fn(&mut Scene, Option<&Walls>, Indices, f64) -> Result<()>),
    /// It is added to this function of time.
    AddedTo(fn(&mut SimConfig, Indices) -> &mut Written),
}

/// Where a number is among those of its kind: two indices, whose meaning is that of the kind.
type Indices = [usize; 2];

/// A number in the list of its kind: what its path has after the word of the kind, SI unit, place.
type Entry = (String, &'static str, Indices);

/// The derivatives of a result by all that a run depends on.
pub struct Swept<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    by: &'a Gradient,
    /// By the moves of surface vertices, where walls may move.
    by_walls: Option<(&'a Walls, Vec<Vec3>)>,
}

impl<'a> Swept<'a> {
    /// Derivatives for a scene that ran, and the problem that was solved.
    pub fn new(
        scene: &'a Scene,
        problem: &'a Problem,
        walls: Option<&'a Walls>,
        by: &'a Gradient,
    ) -> Self {
        let by_walls = walls.map(|walls| (walls, walls.vjp(&by.rest)));
        Self { scene, problem, by, by_walls }
    }

    /// The derivative by a number of an owner, by its key; 0 where no term has it.
    fn by(&self, owner: Owner, key: &str) -> f64 {
        let own = |term: &&Term| term.owners.last().is_some_and(|(last, _)| *last == owner);
        let place = |term: &Term| term.energy.slots().iter().position(|slot| slot.key == key);
        let place = self.problem.energies.terms().find(own).and_then(place);
        place.map_or(0.0, |k| total(self, owner, k))
    }

    /// Derivatives by the numbers that the energies are made with.
    pub fn parameters(&self) -> &ParameterGradients {
        &self.by.parameters
    }
}

/// A number of a scene.
#[derive(Clone)]
pub struct Number {
    /// What people call it.
    pub path: String,
    /// SI unit.
    pub unit: &'static str,
    /// Its key in its table, as the last part of the path, where it is of a room; empty of others.
    pub key: String,
    kind: &'static Kind,
    place: Indices,
}

impl Kind {
    /// The path; words in capitals are names of the scene.
    pub fn path(&self) -> &'static str {
        match self {
            Self::Row(row) => row.path,
            Self::Room(_, [paths, _]) => paths,
        }
    }

    /// What it is.
    pub fn meaning(&self) -> &'static str {
        match self {
            Self::Row(row) => row.meaning,
            Self::Room(_, [_, meaning]) => meaning,
        }
    }

    /// The first word of the paths.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Row(row) => row.word(),
            Self::Room(list, _) => list,
        }
    }

    /// The numbers in a scene.
    pub fn numbers(&'static self, scene: &Scene) -> Vec<Number> {
        let row = match self {
            Self::Row(row) => row,
            Self::Room(list, _) => return room::numbers(self, list, scene),
        };
        let number = |(name, unit, place): Entry| {
            let path = [self.word(), &name].map(str::to_owned);
            let path = path.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
            Number { path: path.join("."), unit, key: String::new(), kind: self, place }
        };
        (row.list)(scene).into_iter().map(number).collect()
    }
}

impl Number {
    /// All numbers of a scene.
    pub fn all(scene: &Scene) -> Vec<Self> {
        KINDS.iter().flat_map(|kind| kind.numbers(scene)).collect()
    }

    /// The number with a path.
    pub fn find(scene: &Scene, path: &str) -> Result<Self> {
        let all = Self::all(scene);
        if let Some(found) = all.iter().find(|number| number.path == path) {
            return Ok(found.clone());
        }
        let known: Vec<&str> = all.iter().map(|number| number.path.as_str()).collect();
        bail!(KeyPath::word(path).told(format!(
            "{path}: the scene has no such number{}; there are: {}",
            did_you_mean(path, known.iter().copied()),
            known.join(", ")
        )))
    }

    /// Whether it is how far a wall stands off, which is added to where the wall is.
    pub fn is_wall(&self) -> bool {
        self.word() == walls::WALL.word()
    }

    /// Whether it is a stress, as moduli are.
    pub fn is_stress(&self) -> bool {
        self.unit == PA
    }

    /// Whether it is that of a chamber, by its name.
    pub fn is_of_chamber(&self, name: &str, scene: &Scene) -> bool {
        self.word() == loads::CHAMBER.word() && scene.config.chamber[self.owner()].name == name
    }

    /// The vector that it is a component of, by its key, where it is one of a room.
    pub fn vector(&self) -> Option<&str> {
        let (vector, axis) = self.key.rsplit_once('.')?;
        AXES.contains(&axis).then_some(vector)
    }

    /// The word of its kind.
    pub fn word(&self) -> &'static str {
        self.kind.word()
    }

    /// Which of the scene's bodies, sheets or tables it belongs to.
    pub fn owner(&self) -> usize {
        self.place[0]
    }

    /// The value in a scene, in its unit; of what may be a function of time, or of a position,
    /// what is added to it: 0.
    pub fn value(&self, scene: &Scene) -> f64 {
        match self.kind {
            Kind::Row(row) => (row.value)(scene, self.place),
            Kind::Room(list, _) => match room::written(self, list, scene) {
                (_, true) => 0.0,
                (value, false) => value.number().unwrap_or_default(),
            },
        }
    }

    /// The function of time to which it is added.
    fn added_to<'a>(&self, config: &'a mut SimConfig) -> Option<&'a mut Written> {
        match self.kind {
            Kind::Row(Row { set: Setting::AddedTo(of), .. }) => Some(of(config, self.place)),
            Kind::Row(_) => None,
            Kind::Room(list, _) => match room::place(self, list, config) {
                Place::AddedTo(written) => Some(written),
                Place::Value(_) => None,
            },
        }
    }

    /// Gives it a value. Several numbers may have to change before a scene admits them:
    /// [`Self::check`] says whether it does.
    pub fn set(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        match self.kind {
            Kind::Row(Row { set: Setting::AddedTo(of), .. }) => {
                return Ok(of(&mut scene.config, self.place).add(value)?);
            }
            Kind::Row(Row { set: Setting::By(set), .. }) => set(scene, walls, self.place, value)?,
            Kind::Room(list, _) => match room::place(self, list, &mut scene.config) {
                Place::AddedTo(written) => return Ok(written.add(value)?),
                Place::Value(number) => *number = value,
            },
        }
        let given = scene.given.entry(self.path.clone()).or_default();
        *given = if self.is_wall() { *given + value } else { value };
        Ok(())
    }

    /// What it is in a scene, where it is no function of time or of the position.
    pub fn constant(&self, scene: &Scene) -> Option<f64> {
        match self.kind {
            Kind::Row(Row { set: Setting::AddedTo(of), .. }) => {
                of(&mut scene.config.clone(), self.place).number()
            }
            Kind::Row(row) => Some((row.value)(scene, self.place)),
            Kind::Room(list, _) => room::written(self, list, scene).0.number(),
        }
    }

    /// Gives it a value in place of the constant that the scene has; what [`Self::set`] would add to that.
    pub fn replace(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        ensure!(value.is_finite(), "{} = {value}: must be finite", self.path);
        let Some(schedule) = self.added_to(&mut scene.config) else {
            return self.set(scene, walls, value);
        };
        ensure!(
            schedule.number().is_some(),
            "{} is {schedule}, a function of time or of the position; expected a constant",
            self.path
        );
        *schedule = value.into();
        Ok(())
    }

    /// Whether the scene admits its value.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        match self.kind {
            Kind::Row(row) => (row.check)(scene, self.place),
            Kind::Room(..) => scene.config.check(),
        }
    }

    /// What changes of it are small against, in its unit, where that is not its value.
    pub fn scale(&self, scene: &Scene) -> Option<f64> {
        match self.kind {
            Kind::Row(row) => row.scale.map(|scale| scale(scene, self.place)),
            Kind::Room(list, _) => room::scale(self, list, scene),
        }
    }

    /// The derivative of a result by it.
    pub fn derivative(&self, swept: &Swept) -> f64 {
        match self.kind {
            Kind::Row(row) => (row.derivative)(swept, self.place),
            Kind::Room(list, _) => room::derivative(self, list, swept),
        }
    }
}

/// Gives numbers of a scene values by their paths.
pub fn set(scene: &mut Scene, values: &BTreeMap<String, f64>) -> Result<()> {
    let find = |(path, value): (&String, &f64)| Ok((Number::find(scene, path)?, *value));
    let numbers = values.iter().map(find).collect::<Result<Vec<_>>>()?;
    let walls = Walls::of(numbers.iter().map(|(number, _)| number), scene)?;
    for (number, value) in &numbers {
        ensure!(value.is_finite(), "{} = {value}: must be finite", number.path);
        number.set(scene, walls.as_ref(), *value)?;
    }
    numbers.iter().try_for_each(|(number, _)| number.check(scene))
}

/// The unit of stresses.
const PA: &str = "Pa";

/// Every value is admitted.
fn any(_: &Scene, _: Indices) -> Result<()> {
    Ok(())
}

/// What may be a function of time or of a position is changed by adding to it.
fn nothing_added(_: &Scene, _: Indices) -> f64 {
    0.0
}
