//! How a level ends, and what was tried and not taken on the way.

use reports::{Ended, LevelEnd};
use serde::{Deserialize, Serialize};

use super::Rejected;

/// A fall of the objective in the last iteration above which it still falls [1].
const STILL_FALLING: f64 = 1e-3;

/// The end of a level in words.
pub fn in_words(end: &LevelEnd) -> String {
    format!("level {} {}: {}", end.level, end.ending.in_words(), end.why)
}

/// The end of a level that took all of its iterations, whose last one lowered the objective by a part of it.
pub fn at_the_last(level: usize, last_fall: f64) -> LevelEnd {
    let is_falling = last_fall > STILL_FALLING;
    let ending = if is_falling { Ended::StillFalling } else { Ended::IterationLimit };
    let why = format!("the last iteration lowered it by {:.2} %", 100.0 * last_fall);
    LevelEnd { level, ending, why }
}

/// Why there is no step.
pub struct End {
    pub ending: Ended,
    pub why: String,
    pub rejections: Rejections,
}

impl End {
    pub fn converged(why: &str) -> Self {
        let rejections = Rejections::default();
        Self { ending: Ended::Converged, why: why.to_owned(), rejections }
    }

    pub fn jammed(why: String, rejections: Rejections) -> Self {
        Self { ending: Ended::Jammed, why, rejections }
    }
}

/// What a rejected trial had.
#[derive(Clone, Copy)]
pub enum Had {
    /// An equilibrium and a value of the objective.
    Value,
    /// A value, and no way to cast it.
    NoMold,
    /// No equilibrium, or none that is usable.
    NoRun,
}

/// What was tried and not taken, by its reason.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Rejections {
    /// Shapes with flat elements.
    pub flat: usize,
    /// Other shapes that are not valid, or keep a constraint not.
    pub shape: usize,
    /// Runs without an equilibrium.
    pub run: usize,
    /// Shapes that cannot be cast.
    #[serde(default)]
    pub mold: usize,
    /// Runs that did not lower the objective enough.
    pub high: usize,
    /// The last reason.
    pub last: String,
}

impl Rejections {
    /// Counts a trial that had a value, a run, or a shape that cannot be cast.
    pub fn add(&mut self, had: Had, why: &str) {
        let count = match had {
            Had::Value => &mut self.high,
            Had::NoMold => &mut self.mold,
            Had::NoRun => &mut self.run,
        };
        *count += 1;
        why.clone_into(&mut self.last);
    }

    /// Counts a shape that was not simulated.
    pub fn add_shape(&mut self, flat: bool, Rejected { why, .. }: &Rejected) {
        *if flat { &mut self.flat } else { &mut self.shape } += 1;
        self.last.clone_from(why);
        log::debug!("a shape is not tried: {why}");
    }

    /// Adds those of another iteration.
    pub fn merge(&mut self, other: Self) {
        self.flat += other.flat;
        self.shape += other.shape;
        self.run += other.run;
        self.mold += other.mold;
        self.high += other.high;
        if !other.last.is_empty() {
            self.last = other.last;
        }
    }

    /// In words; none where nothing was rejected.
    pub fn describe(&self) -> Option<String> {
        let all = self.flat + self.shape + self.run + self.mold + self.high;
        let kinds = [
            (self.flat, "with flat elements"),
            (self.shape, "not valid as shapes"),
            (self.run, "without an equilibrium"),
            (self.mold, "not to be cast"),
            (self.high, "with a higher objective"),
        ];
        let said: Vec<String> = kinds
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        (all > 0).then(|| format!("rejected trials: {}", said.join(", ")))
    }
}
