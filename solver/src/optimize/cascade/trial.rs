//! A trial of a step, and how the next one follows from one that was not taken.

use crate::optimize::ending::Had;
use crate::optimize::vectors::along;
use crate::optimize::{Evaluation, Level, Rejected, Run, Start};

/// Length of a trial over that of the one before, at most ...
const LONGEST_RETRIAL: f64 = 0.5;
/// ... and at least.
const SHORTEST_RETRIAL: f64 = 0.1;

/// The evaluation at θ, if its merit with these penalties is at most `wanted`.
pub(super) fn lower(
    level: &mut Level,
    theta: &[f64],
    start: Start,
    (wanted, penalties): (f64, &[f64]),
) -> Result<Evaluation, Refused> {
    let evaluation = level.evaluate(theta, start)?;
    let objective = level.merit(&evaluation, penalties);
    // a barrier with a negative weight may be −∞
    if !(objective.is_finite() && objective <= wanted) {
        let reason = format!("objective {objective:.6e} is not low enough");
        return Err(Refused { reason, objective: Some(objective), is_mold: false });
    }
    Ok(evaluation)
}

/// A trial that was not taken.
pub(super) struct Refused {
    /// Why.
    pub reason: String,
    /// What it came to, where it had a value.
    objective: Option<f64>,
    /// It cannot be cast.
    is_mold: bool,
}

impl From<Rejected> for Refused {
    fn from(Rejected { why, .. }: Rejected) -> Self {
        Self { reason: why, objective: None, is_mold: false }
    }
}

impl Refused {
    /// What it had.
    pub fn had(&self) -> Had {
        match self.objective {
            _ if self.is_mold => Had::NoMold,
            Some(_) => Had::Value,
            None => Had::NoRun,
        }
    }

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

/// u + du of each scenario, or u without a prediction.
pub(super) fn ahead(at: &Evaluation, predicted: Option<&[Vec<f64>]>) -> Vec<Vec<f64>> {
    let one = |(i, run): (usize, &Run)| {
        let u = run.states.last();
        match predicted {
            None => u.into_owned(),
            Some(all) => along(&u, &all[i], 1.0),
        }
    };
    at.runs.iter().enumerate().map(one).collect()
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
