//! What a level has gained for its work, to end it when it has little more to give.
//!
//! The work is counted in Newton iterations of accepted trials, not in seconds, so that an
//! interrupted design continues with the same steps.

use serde::{Deserialize, Serialize};

/// Last iterations whose gain is compared with that of the level.
const LAST: usize = 2;

/// Objective and work of a level, iteration by iteration.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LevelProgress {
    /// Objective after each iteration, the start first.
    objectives: Vec<f64>,
    /// Newton iterations up to there.
    work: Vec<usize>,
}

impl LevelProgress {
    /// Adds an iteration.
    pub fn push(&mut self, objective: f64, newton_iterations: usize) {
        let before = self.work.last().copied().unwrap_or(0);
        self.objectives.push(objective);
        self.work.push(before + newton_iterations);
    }

    /// Gain of the level so far, over its first objective; none before there is an iteration.
    pub fn gain(&self) -> Option<f64> {
        let [first, .., last] = self.objectives[..] else { return None };
        Some((first - last) / first.abs())
    }

    /// Gain per Newton iteration of the last two iterations, relative to that of all iterations
    /// of the level; none before there are more than two, or where nothing was gained.
    pub fn rate(&self) -> Option<f64> {
        let end = self.objectives.len().checked_sub(1)?;
        let since = |first: usize| {
            let work = (self.work[end] - self.work[first]).max(1);
            (self.objectives[first] - self.objectives[end]) / work as f64
        };
        let level = since(0);
        (end > LAST && level > 0.0).then(|| since(end - LAST) / level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10, then 2, 1 and 1 for five Newton iterations each: 0.2 at the end, where all of the level
    /// is 14/20 an iteration.
    #[test]
    fn rates_are_those_of_the_last_two_iterations_over_all() {
        let mut progress = LevelProgress::default();
        progress.push(20.0, 7);
        for objective in [10.0, 8.0] {
            progress.push(objective, 5);
            assert_eq!(progress.rate(), None);
        }
        progress.push(7.0, 5);
        progress.push(6.0, 5);
        assert!((progress.rate().unwrap_or(0.0) - 0.2 / 0.7).abs() < 1e-15);
    }
}
