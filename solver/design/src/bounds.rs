//! The bounds of runs in a step, and what it costs to violate them.
//!
//! φ = J + Σ ν max(0, −c − tolerance)
//!
//! A bound that is kept is an inequality of the quadratic program, c + a·d ≥ 0. One that is violated is a term −ν a·d of
//! its slope, up to where it is kept. Steps lower the merit φ: with ν above its multiplier the minimum of φ is that of J
//! under the bounds (exact penalty; Nocedal and Wright 2006, chapters 17.2 and 18.5).

use std::collections::BTreeMap;

use mechanics::adjoint::Wanted;
use serde::{Deserialize, Serialize};
use variables::step::Row;

use super::scenario::Bound;
use super::{Evaluation, Level, Rejected, Run};

/// What the first violation of a bound by its size costs, over the objective.
const FIRST: f64 = 10.0;
/// ν over its multiplier, at least.
const ABOVE: f64 = 2.0;

/// A bound at an accepted run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BoundRow {
    /// Index of the bound.
    bound: usize,
    /// c.
    c: f64,
    /// The derivatives of c by the variables.
    a: Vec<f64>,
}

/// By how much a bound is violated beyond its tolerance.
fn lack(bound: &Bound, c: f64) -> f64 {
    (-c - bound.tolerance()).max(0.0)
}

impl Level {
    /// What the runs keep, the same in all scenarios.
    pub fn bounds(&self) -> &[Bound] {
        &self.scenarios[0].bounds
    }

    /// Each bound at the run of each scenario, with the derivatives, of a linearised evaluation.
    pub fn bound_rows(&self, at: &Evaluation) -> Result<Vec<BoundRow>, Rejected> {
        let loads = self.map.load_variables(&at.theta);
        let mut rows = Vec::new();
        for (scenario, run) in self.runs(at) {
            for (bound, Bound { name, .. }) in scenario.bounds.iter().enumerate() {
                let of = (Some(name.as_str()), 1.0);
                let by = scenario.sweep(run, &at.rest, Wanted::All, of)?;
                let mut a = self.map.vjp(&at.theta, &by.rest);
                a.extend(scenario.by_loads(loads, &by));
                rows.push(BoundRow { bound, c: run.kept[bound], a });
            }
        }
        Ok(rows)
    }

    /// The terms of the objective, and the mean c of each bound, by name.
    pub fn numbers(&self, at: &Evaluation) -> BTreeMap<String, f64> {
        let mean = |k: usize| {
            let each = at.runs.iter().zip(&self.robust.weights);
            each.map(|(run, weight)| weight * run.kept[k]).sum()
        };
        let bounds =
            self.bounds().iter().enumerate().map(|(k, bound)| (bound.name.clone(), mean(k)));
        at.terms.iter().map(|(name, value)| (name.clone(), *value)).chain(bounds).collect()
    }

    /// φ of an evaluation.
    pub fn merit(&self, at: &Evaluation, penalties: &[f64]) -> f64 {
        let of_run = |run: &Run| -> f64 {
            let each = self.bounds().iter().zip(&run.kept).zip(penalties);
            each.map(|((bound, c), penalty)| penalty * lack(bound, *c)).sum()
        };
        at.objective + at.runs.iter().map(of_run).sum::<f64>()
    }

    /// ν of each bound at the start of a design.
    pub fn first_penalties(&self, at: &Evaluation, gradient_norm: f64) -> Vec<f64> {
        let unit = FIRST * at.objective.abs().max(gradient_norm * self.map.mean_edge);
        self.bounds().iter().map(|bound| unit / bound.size()).collect()
    }

    /// The inequalities of bounds that are kept; the slope of the merit gets those that are not. Their constraints come
    /// after those of the rest shape.
    pub fn bounded(&self, rows: &[BoundRow], penalties: &[f64], slope: &mut [f64]) -> Vec<Row> {
        let first = self.constraints.len();
        let one = |row: &BoundRow| {
            let bound = &self.bounds()[row.bound];
            let sparse = |sign: f64| row.a.iter().map(|a| sign * a).enumerate().collect();
            if lack(bound, row.c) == 0.0 {
                return Row { a: sparse(1.0), c: row.c, of: Some(first + row.bound) };
            }
            slope.iter_mut().zip(&row.a).for_each(|(s, a)| *s -= penalties[row.bound] * a);
            Row { a: sparse(-1.0), c: -row.c, of: None }
        };
        rows.iter().map(one).collect()
    }

    /// The bounds that an evaluation violates beyond their tolerances, in words; none where it keeps all.
    pub fn violated(&self, at: &Evaluation) -> Option<String> {
        let said = self.bounds().iter().enumerate().filter_map(|(k, bound)| {
            let worst = at.runs.iter().map(|run| run.kept[k]).fold(f64::INFINITY, f64::min);
            let (side, unit) = (if bound.is_least { "least" } else { "most" }, bound.unit);
            (lack(bound, worst) > 0.0).then(|| {
                let (found, value) = (bound.number(worst), bound.value);
                format!(
                    "{}: {found:.4e} {unit}, and at {side} {value:.4e} {unit} is to be kept",
                    bound.title()
                )
            })
        });
        Some(said.collect::<Vec<_>>().join("; ")).filter(|said| !said.is_empty())
    }
}

/// ν that are above the multipliers of their bounds.
pub fn raise(penalties: &mut [f64], multipliers: &[f64]) {
    penalties.iter_mut().zip(multipliers).for_each(|(own, m)| *own = own.max(ABOVE * m));
}
