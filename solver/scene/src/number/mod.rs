//! The numbers of a scene: what may be calibrated, uncertain, other in a scenario, and checked.
//!
//! One entry of [`KINDS`] for each kind of number: which ones a scene has and where they are, and the derivative of a
//! result by one, from the adjoint sweep. Rooms of terms know their own. A number has a path,
//! such as `material.body.c1`, `chamber.left.pressure` or `contact.friction`. A [`Group`] has
//! numbers that change together, as all stresses by one factor do.

mod group;
mod laws;
mod start;
mod walls;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use anyhow::{Result, bail, ensure};
use mechanics::adjoint::Gradient;
use mechanics::body::Body;
use mechanics::energy::ParameterGradients;
use mechanics::forward::Problem;
use mechanics::symmetry::AXES;
use mesh::Vec3;
use program::{KeyPath, did_you_mean};

use crate::config::SimConfig;
use crate::model::{Scene, ScenePart};
use crate::term::material::SceneLaw;
use crate::term::{About, Known, Place, RoomNumber};

pub use group::{Change, Group};
pub use walls::Walls;

/// All kinds, in the order in which they are listed.
pub static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    let none = SimConfig::default();
    let rooms = none.rooms().into_iter().map(|room| room.about());
    let rooms = rooms.filter(|about| !about.paths.is_empty());
    let of_room = |About { list: word, paths, meaning, .. }| Kind {
        word,
        paths,
        meaning,
        numbers: in_room,
        derivative: by_room,
    };
    let laws = [laws::MATERIAL, laws::DENSITY].into_iter();
    laws.chain(rooms.map(of_room)).chain([start::VELOCITY, walls::WALL]).collect()
});

/// A kind of number.
pub struct Kind {
    /// The first word of the paths.
    pub word: &'static str,
    /// The paths; words in capitals are names of the scene.
    pub paths: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// The numbers of a scene that are of this kind, with its word.
    numbers: for<'a> fn(&str, Owners<'a>) -> Vec<RoomNumber<'a>>,
    derivative: fn(&Swept, &Number) -> f64,
}

/// What the numbers of a scene are in, to be changed.
struct Owners<'a> {
    config: &'a mut SimConfig,
    laws: &'a mut [SceneLaw],
    parts: &'a mut [ScenePart],
    body: &'a Body,
}

impl<'a> Owners<'a> {
    fn of(scene: &'a mut Scene) -> Self {
        let Scene { config, laws, parts, body, .. } = scene;
        Self { config, laws, parts, body }
    }

    /// Looks at copies of them.
    fn looked_at<T>(scene: &Scene, look: impl FnOnce(Owners) -> T) -> T {
        let (mut laws, mut parts) = (scene.laws.clone(), scene.parts.clone());
        let (config, body) = (&mut scene.config.clone(), &scene.body);
        look(Owners { config, laws: &mut laws, parts: &mut parts, body })
    }
}

/// The numbers in the room of a list.
fn in_room<'a>(list: &str, Owners { config, .. }: Owners<'a>) -> Vec<RoomNumber<'a>> {
    let mut rooms = config.rooms_mut().into_iter();
    let room = rooms.find(|room| room.about().list == list);
    room.map_or_else(Vec::new, |room| room.numbers())
}

/// The derivative of a result by a number of a room, in whose unit angles are degrees.
fn by_room(swept: &Swept, number: &Number) -> f64 {
    let mut rooms = swept.scene.config.rooms().into_iter();
    let room = rooms.find(|room| room.about().list == number.word());
    let by = room.map_or(0.0, |room| room.derivative(number.owner(), &number.key, &swept.known));
    if number.unit == "°" { by.to_radians() } else { by }
}

/// The derivatives of a result by all that a run depends on.
pub struct Swept<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    by: &'a Gradient,
    /// By the numbers of terms.
    known: Known<'a>,
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
        let (energies, parameters) = (&problem.energies, &by.parameters);
        let known = Known { laws: &scene.laws, energies, parameters };
        Self { scene, problem, by, known, by_walls }
    }

    /// Derivatives by the numbers that the energies are made with.
    pub fn parameters(&self) -> &ParameterGradients {
        self.known.parameters
    }
}

/// A number of a scene.
#[derive(Clone)]
pub struct Number {
    /// What people call it.
    pub path: String,
    /// SI unit.
    pub unit: &'static str,
    /// Its key in its table, as the last part of the path; empty where it has none.
    pub key: String,
    kind: &'static Kind,
    /// Which of the scene's bodies, sheets or tables it belongs to.
    table: usize,
}

impl Kind {
    /// The numbers in a scene.
    pub fn numbers(&'static self, scene: &Scene) -> Vec<Number> {
        let one = |RoomNumber { table, name, slot, .. }: RoomNumber| {
            let words = [self.word, &name, &slot.key].into_iter().filter(|word| !word.is_empty());
            let path = words.collect::<Vec<_>>().join(".");
            Number { path, unit: slot.unit, key: slot.key, kind: self, table }
        };
        Owners::looked_at(scene, |owners| {
            (self.numbers)(self.word, owners).into_iter().map(one).collect()
        })
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
        self.word() == walls::WALL.word
    }

    /// Whether it is a stress, as moduli are.
    pub fn is_stress(&self) -> bool {
        self.unit == PA
    }

    /// Whether it is that of a chamber, by its name.
    pub fn is_of_chamber(&self, name: &str, scene: &Scene) -> bool {
        self.word() == "chamber" && scene.config.chamber[self.owner()].name == name
    }

    /// The vector that it is a component of, by its key, where it is one of a room.
    pub fn vector(&self) -> Option<&str> {
        let (vector, axis) = self.key.rsplit_once('.')?;
        AXES.contains(&axis).then_some(vector)
    }

    /// The word of its kind.
    pub fn word(&self) -> &'static str {
        self.kind.word
    }

    /// Which of the scene's bodies, sheets or tables it belongs to.
    pub fn owner(&self) -> usize {
        self.table
    }

    fn is(&self, other: &RoomNumber) -> bool {
        other.table == self.table && other.slot.key == self.key
    }

    /// Where it is.
    fn place<'a>(&self, owners: Owners<'a>) -> Option<Place<'a>> {
        let mut all = (self.kind.numbers)(self.kind.word, owners).into_iter();
        all.find(|other| self.is(other)).map(|found| found.place)
    }

    /// The value in a scene, in its unit; of what may be a function of time, or of a position,
    /// what is added to it: 0.
    pub fn value(&self, scene: &Scene) -> f64 {
        Owners::looked_at(scene, |owners| match self.place(owners) {
            Some(Place::Value(value)) => *value,
            _ => 0.0,
        })
    }

    /// Gives it a value. Several numbers may have to change before a scene admits them:
    /// [`Self::check`] says whether it does.
    pub fn set(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        match self.place(Owners::of(scene)) {
            Some(Place::AddedTo(written)) => return Ok(written.add(value)?),
            Some(Place::Value(number)) => *number = value,
            Some(Place::Wall) => walls::set(scene, walls, self.table, value)?,
            None => bail!("{} is no number of the scene any more", self.path),
        }
        let given = scene.given.entry(self.path.clone()).or_default();
        *given = if self.is_wall() { *given + value } else { value };
        Ok(())
    }

    /// What it is in a scene, where it is no function of time or of the position.
    pub fn constant(&self, scene: &Scene) -> Option<f64> {
        Owners::looked_at(scene, |owners| match self.place(owners) {
            Some(Place::AddedTo(written)) => written.number(),
            Some(Place::Value(value)) => Some(*value),
            _ => Some(0.0),
        })
    }

    /// Gives it a value in place of the constant that the scene has; what [`Self::set`] would add to that.
    pub fn replace(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        ensure!(value.is_finite(), "{} = {value}: must be finite", self.path);
        let Some(Place::AddedTo(schedule)) = self.place(Owners::of(scene)) else {
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
        if self.is_wall() {
            return Ok(());
        }
        scene.laws.iter().try_for_each(SceneLaw::check)?;
        scene.config.check()
    }

    /// What changes of it are small against, in its unit, where that is not its value: of a component of a vector that
    /// is a function of time the largest of all at the ends of time steps.
    pub fn scale(&self, scene: &Scene) -> Option<f64> {
        let vector = |key: &str| key.rsplit_once('.').map(|(vector, _)| vector.to_owned());
        let largest = |other: &RoomNumber| {
            let Place::AddedTo(written) = &other.place else { return 0.0 };
            let schedule = scene.config.schedule(written);
            scene.times().iter().map(|&t| schedule.at(t).abs()).fold(0.0, f64::max)
        };
        let beside = |other: &&RoomNumber| {
            other.table == self.table && vector(&other.slot.key) == vector(&self.key)
        };
        Owners::looked_at(scene, |owners| {
            let all = (self.kind.numbers)(self.kind.word, owners);
            match (&all.iter().find(|other| self.is(other))?.place, self.unit) {
                (Place::AddedTo(_), _) => {
                    Some(all.iter().filter(beside).map(largest).fold(0.0, f64::max))
                }
                (Place::Value(_), "°") => Some(RADIAN),
                (Place::Value(_), "m/s") => Some(1.0),
                _ => None,
            }
        })
    }

    /// The derivative of a result by it.
    pub fn derivative(&self, swept: &Swept) -> f64 {
        (self.kind.derivative)(swept, self)
    }
}

/// A radian [°].
const RADIAN: f64 = 180.0 / std::f64::consts::PI;

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
