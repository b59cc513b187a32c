//! How a level ends, and what was tried and not taken on the way.

use reports::{Ended, LevelEnd};
use serde::{Deserialize, Serialize};

use super::Rejected;

/// A fall of the objective in the last iteration above which it still falls [1].
const STILL_FALLING: f64 = 1e-3;

/// Length of a trial over that of the one before, at most ...
const LONGEST_RETRIAL: f64 = 0.5;
/// ... and at least.
const SHORTEST_RETRIAL: f64 = 0.1;

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

/// A trial that was not taken.
pub struct Refused {
    /// Why.
    pub reason: String,
    /// What it came to, where it had a value.
    pub objective: Option<f64>,
    /// It cannot be cast.
    pub is_mold: bool,
}

impl From<Rejected> for Refused {
    fn from(Rejected { why, .. }: Rejected) -> Self {
        Self { reason: why, objective: None, is_mold: false }
    }
}

impl Refused {
    /// A shape that `fab plan` refuses.
    pub fn mold(refused: &str) -> Self {
        let reason = format!("fab plan: it cannot be cast: {refused}");
        Self { reason, objective: None, is_mold: true }
    }

    /// Length of the next trial over that of this one, along which the objective had a slope at its start: where a
    /// parabola through what is known has its minimum, or a half (Nocedal and Wright, section 3.5).
    pub fn shorter(&self, before: f64, slope: f64) -> f64 {
        let objective = self.objective.filter(|objective| objective.is_finite());
        let Some(objective) = objective else { return LONGEST_RETRIAL };
        let part = -0.5 * slope / (objective - before - slope);
        part.clamp(SHORTEST_RETRIAL, LONGEST_RETRIAL)
    }
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
    /// Counts a trial that was not taken.
    pub fn add(&mut self, refused: &Refused) {
        let count = match refused {
            Refused { is_mold: true, .. } => &mut self.mold,
            Refused { objective: Some(_), .. } => &mut self.high,
            Refused { objective: None, .. } => &mut self.run,
        };
        *count += 1;
        self.last.clone_from(&refused.reason);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// J = −α + 5 α²/2 has its minimum at α = 1/5; after 1 ≤ α, J − J₀ = 3/2.
    #[test]
    fn the_next_trial_is_where_the_parabola_has_its_minimum() {
        let refused = |objective| Refused { reason: String::new(), objective, is_mold: false };
        assert!((refused(Some(8.5)).shorter(7.0, -1.0) - 0.2).abs() < 1e-15);
        assert_eq!(refused(Some(1e9)).shorter(7.0, -1.0), SHORTEST_RETRIAL);
        for without_a_minimum in [None, Some(f64::NAN), Some(f64::NEG_INFINITY), Some(7.0)] {
            assert_eq!(refused(without_a_minimum).shorter(7.0, -1.0), LONGEST_RETRIAL);
        }
    }
}
