//! Numbers that change together.

use crate::model::Scene;
use anyhow::Result;

use super::{KINDS, Number, Swept, Walls};

/// How the numbers of a group change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Each has the value.
    Value,
    /// All are multiplied by one factor, 1 at first.
    Factor,
    /// One number is added to all, 0 at first.
    Offset,
}

/// Numbers that change together by one.
#[derive(Clone)]
pub struct Group {
    /// Numbers of a scene.
    pub numbers: Vec<Number>,
    /// How.
    pub change: Change,
}

impl Group {
    /// All parameters that are stresses, of all laws or of those of a body or volume, by one factor.
    pub fn modulus(scene: &Scene, on: Option<&str>) -> Self {
        Self::of(scene, "material", Change::Factor, |number| {
            number.is_stress() && scene.laws[number.owner()].is_of(on)
        })
    }

    /// The density of all bodies, or of a body or volume, by one factor.
    pub fn density(scene: &Scene, on: Option<&str>) -> Self {
        Self::of(scene, "density", Change::Factor, |number| scene.laws[number.owner()].is_of(on))
    }

    /// The thickness of all sheets, or of those on a tag, by one factor: their forces are in
    /// proportion to it as they are to their modulus.
    pub fn membrane(scene: &Scene, on: Option<&str>) -> Self {
        Self::of(scene, "membrane", Change::Factor, |number| {
            let own = on.is_none_or(|on| scene.config.membrane[number.owner()].on == on);
            own && number.key == "thickness"
        })
    }

    /// All parameters of one of the laws that are stresses, by one factor.
    pub fn modulus_of(scene: &Scene, law: usize) -> Self {
        let own = |number: &Number| number.is_stress() && number.owner() == law;
        Self::of(scene, "material", Change::Factor, own)
    }

    /// The coefficient of friction, by a factor.
    pub fn friction(scene: &Scene) -> Self {
        Self::of(scene, "contact", Change::Factor, |_| true)
    }

    /// The pressure or fill of all chambers, or of that with a tag, by one offset.
    pub fn pressure(scene: &Scene, on: Option<&str>) -> Self {
        let chamber = |number: &Number| &scene.config.chamber[number.owner()];
        Self::of(scene, "chamber", Change::Offset, |number| {
            let own = chamber(number);
            own.gas.is_pressure() && on.is_none_or(|on| own.name == on)
        })
    }

    /// The number with a path; nothing where the scene does not have it.
    pub fn of_path(scene: &Scene, path: &str) -> Self {
        let word = path.split('.').next().unwrap_or_default();
        Self::of(scene, word, Change::Value, |number| number.path == path)
    }

    /// Those numbers of a kind that are wanted.
    fn of(scene: &Scene, word: &str, change: Change, wanted: impl Fn(&Number) -> bool) -> Self {
        let kinds = KINDS.iter().filter(|kind| kind.word == word);
        let numbers = kinds.flat_map(|kind| kind.numbers(scene)).filter(wanted).collect();
        Self { numbers, change }
    }

    /// Unit of what they change by, and what it is in the scene as it was read.
    pub fn start(&self, scene: &Scene) -> Option<(&'static str, f64)> {
        let first = self.numbers.first()?;
        Some(match self.change {
            Change::Value => (first.unit, first.value(scene)),
            Change::Factor => ("1", 1.0),
            Change::Offset => (first.unit, 0.0),
        })
    }

    /// What they become in a scene as it was read.
    pub fn values(&self, scene: &Scene, by: f64) -> Vec<(&Number, f64)> {
        let value = |number: &Number| match self.change {
            Change::Value => by,
            Change::Factor => by * number.value(scene),
            Change::Offset => number.value(scene) + by,
        };
        self.numbers.iter().map(|number| (number, value(number))).collect()
    }

    /// Changes them in a scene as it was read.
    pub fn apply(&self, scene: &mut Scene, walls: Option<&Walls>, by: f64) -> Result<()> {
        for (number, value) in self.values(scene, by) {
            number.set(scene, walls, value)?;
        }
        self.numbers.iter().try_for_each(|number| number.check(scene))
    }

    /// The derivative of a result by what they change by, in a scene where it is `by`.
    pub fn derivative(&self, swept: &Swept, by: f64) -> f64 {
        let each = self.numbers.iter();
        match self.change {
            Change::Value | Change::Offset => each.map(|n| n.derivative(swept)).sum(),
            Change::Factor => {
                each.map(|n| n.value(swept.scene) * n.derivative(swept)).sum::<f64>() / by
            }
        }
    }
}

impl From<Number> for Group {
    /// The number alone, with its value.
    fn from(number: Number) -> Self {
        Self { numbers: vec![number], change: Change::Value }
    }
}
