//! How a level ends, and what was tried and not taken on the way.

use std::collections::BTreeMap;

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

/// Why a trial was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Cause {
    /// The shape has flat elements.
    Flat,
    /// The shape is not valid otherwise, or does not keep a constraint.
    Shape,
    /// A run has no equilibrium.
    Run,
    /// The shape cannot be cast.
    Mold,
    /// The objective is not low enough.
    High,
}

impl Cause {
    /// What trials are with it.
    fn in_words(self) -> &'static str {
        match self {
            Self::Flat => "with flat elements",
            Self::Shape => "not valid as shapes",
            Self::Run => "without an equilibrium",
            Self::Mold => "not to be cast",
            Self::High => "with a higher objective",
        }
    }
}

/// A trial that was not taken.
pub struct Refused {
    pub cause: Cause,
    /// The cause in words.
    pub why: String,
    /// What it came to, where it had a value.
    pub objective: Option<f64>,
}

impl From<Rejected> for Refused {
    fn from(Rejected { why, .. }: Rejected) -> Self {
        Self { cause: Cause::Run, why, objective: None }
    }
}

impl Refused {
    /// A shape that `fab plan` refuses.
    pub fn mold(refused: &str) -> Self {
        let why = format!("fab plan: it cannot be cast: {refused}");
        Self { cause: Cause::Mold, why, objective: None }
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

/// What was tried and not taken.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Rejections {
    counts: BTreeMap<Cause, usize>,
    /// The last reason.
    pub last: String,
}

impl Rejections {
    /// How many trials a cause has had.
    pub fn count(&self, cause: Cause) -> usize {
        self.counts.get(&cause).copied().unwrap_or(0)
    }

    /// Counts a trial that was not taken.
    pub fn add(&mut self, cause: Cause, why: &str) {
        *self.counts.entry(cause).or_default() += 1;
        why.clone_into(&mut self.last);
    }

    /// Adds those of another iteration.
    pub fn merge(&mut self, other: Self) {
        for (cause, count) in other.counts {
            *self.counts.entry(cause).or_default() += count;
        }
        if !other.last.is_empty() {
            self.last = other.last;
        }
    }

    /// In words; none where nothing was rejected.
    pub fn describe(&self) -> Option<String> {
        let one = |(cause, count): (&Cause, &usize)| format!("{count} {}", cause.in_words());
        let said: Vec<String> = self.counts.iter().map(one).collect();
        (!said.is_empty()).then(|| format!("rejected trials: {}", said.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J = −α + 5 α²/2 has its minimum at α = 1/5; after 1 ≤ α, J − J₀ = 3/2.
    #[test]
    fn the_next_trial_is_where_the_parabola_has_its_minimum() {
        let refused = |objective| Refused { cause: Cause::High, why: String::new(), objective };
        assert!((refused(Some(8.5)).shorter(7.0, -1.0) - 0.2).abs() < 1e-15);
        assert_eq!(refused(Some(1e9)).shorter(7.0, -1.0), SHORTEST_RETRIAL);
        for without_a_minimum in [None, Some(f64::NAN), Some(f64::NEG_INFINITY), Some(7.0)] {
            assert_eq!(refused(without_a_minimum).shorter(7.0, -1.0), LONGEST_RETRIAL);
        }
    }
}
