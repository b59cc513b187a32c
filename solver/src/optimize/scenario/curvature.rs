//! Curvature of the objective along first-order changes of a run.

use std::sync::Arc;

use measure::quantity::Partials;
use mechanics::forward::{Varied, neighbours};
use mechanics::math::linear::dot;
use nalgebra::DMatrix;

use super::terms::{Forces, add_partials};
use super::{Rejected, Run, Scenario};

impl Scenario {
    /// A small change of the designed shape and of the variables of the loads.
    ///
    /// # Errors
    /// When the scene does not admit the loads.
    pub fn varied(&self, loads: &[f64], designed: &[mesh::Vec3]) -> Result<Varied, Rejected> {
        Ok(Varied { problem: self.under(loads)?, rest: self.rest(designed) })
    }

    /// dᵢᵀ ∇²J dⱼ of each two first-order changes d of what the terms of the objective J look at, from a run to its
    /// neighbours. It is the matrix of Gauss and Newton, with the curvature of the terms themselves. None where the
    /// run has no usable tangent.
    pub fn curvature(&mut self, run: &Run, varied: &[Varied]) -> Option<DMatrix<f64>> {
        let linearization = run.linearized(self.linearization.as_ref());
        let of = (&run.rest[..], &*run.states);
        let begin = (&self.start, self.state_memory / varied.len() as f64);
        let all = neighbours(&run.problem, &mut self.workspace, of, linearization, varied, begin)?;
        let as_run = |(varied, states): (&Varied, _)| Run {
            problem: Arc::clone(&varied.problem),
            rest: varied.rest.clone(),
            states: Arc::new(states),
            ..run.clone()
        };
        let all: Vec<Run> = varied.iter().zip(all).map(as_run).collect();
        let mut curvature = DMatrix::zeros(all.len(), all.len());
        for n in 0..=run.states.steps() {
            if self.terms.iter().all(|term| term.weight * term.factor * term.factors[n] == 0.0) {
                continue;
            }
            let (here, slope) = self.seen(run, n);
            let seen: Vec<_> = all.iter().map(|run| self.seen(run, n)).collect();
            let changes: Vec<_> = seen.iter().map(|(there, _)| difference(there, &here)).collect();
            for (i, (_, there)) in seen.iter().enumerate() {
                let bend = difference(there, &slope);
                changes.iter().enumerate().for_each(|(j, d)| curvature[(i, j)] += dot(&bend, d));
            }
        }
        Some(0.5 * (&curvature + curvature.transpose()))
    }

    /// What terms look at in a moment of a run, (u, X, f, r) one after the other, and their derivatives by it.
    fn seen(&mut self, run: &Run, n: usize) -> (Vec<f64>, Vec<f64>) {
        let forces = self.forces(run, n);
        let Forces { contact, reaction } = &forces;
        let rest: Vec<f64> = run.rest.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
        let all = [&run.states.state(n).u[..], &rest, contact, reaction].concat();
        let mut slope = vec![0.0; all.len()];
        let (u, others) = slope.split_at_mut(run.problem.dofs());
        let (rest, others) = others.split_at_mut(rest.len());
        let (contact, reaction) = others.split_at_mut(contact.len());
        let mut out = Partials { u, rest, contact, reaction };
        add_partials(self.terms.iter(), run, n, &forces, 1.0, &mut out);
        (all, slope)
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
