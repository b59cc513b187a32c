//! Functions of time: what they stand for in a scene, and when they are looked at.

use std::collections::BTreeMap;

use anyhow::Result;
use mechanics::schedule::{Field, Malformed, Schedule, Written, WrittenField};
use mesh::Vec3;
use program::{KeyPath, misfit};

use super::Scheduled;

/// Times at which schedules are checked in each time step, for load steps
/// may end in between.
const MOMENTS: usize = 8;

/// What functions of time stand for.
#[derive(Clone)]
pub struct Values<'a> {
    /// Numbers that expressions may name.
    pub parameters: &'a BTreeMap<String, f64>,
    /// Ends of the time steps [s].
    pub times: Vec<f64>,
}

impl Values<'_> {
    /// What is written of a number, if its names are known.
    pub fn known(&self, written: &Written) -> Result<Schedule, Malformed> {
        written.schedule(self.parameters, self.times[0])
    }

    /// What is written of a number.
    pub fn schedule(&self, written: &Written) -> Schedule {
        self.known(written).expect("names that were checked as the scene was read")
    }

    /// What is written of a vector.
    pub fn field(&self, written: &WrittenField) -> Field {
        Field(written.0.each_ref().map(|component| self.schedule(component)))
    }

    /// Moments at which schedules are checked: t = 0, the ends of time steps, and some in between [s].
    pub fn moments(&self) -> Vec<f64> {
        let mut moments = vec![0.0];
        for &end in &self.times {
            let begin = moments[moments.len() - 1];
            let part = |i: usize| begin + (end - begin) * (i as f64 / MOMENTS as f64);
            moments.extend((1..MOMENTS).map(part));
            moments.push(end);
        }
        moments
    }

    /// The largest of a number at these moments, without sign.
    pub fn largest(&self, written: &Written) -> f64 {
        let schedule = self.schedule(written);
        self.moments().iter().map(|t| schedule.at(*t).abs()).fold(0.0, f64::max)
    }

    /// Length of a vector of the largest of each component.
    pub fn length(&self, vector: &WrittenField) -> f64 {
        vector.0.iter().map(|own| self.largest(own)).map(|f| f * f).sum::<f64>().sqrt()
    }

    /// The vector with this key, if it is defined at all these positions, at the ends of all time steps.
    pub fn defined(&self, key: &KeyPath, written: &WrittenField, at: &[Vec3]) -> Result<Field> {
        let times: Vec<f64> = [0.0].into_iter().chain(self.times.iter().copied()).collect();
        let field = self.field(written);
        for schedule in field.0.iter().filter(|s| s.uses_position()) {
            schedule.check(&times, at).map_err(|what| misfit!(key.clone(), ": {what}"))?;
        }
        Ok(field)
    }
}

/// The components of a vector, with their keys.
pub fn components(
    key: KeyPath,
    may_use_position: bool,
    field: &WrittenField,
) -> Vec<Scheduled<'_>> {
    let components = field.0.iter().enumerate();
    components.map(|(axis, value)| (key.clone().along(axis), may_use_position, value)).collect()
}
