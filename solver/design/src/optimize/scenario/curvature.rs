//! Curvature of the objective along first-order changes of a run.

use std::sync::Arc;

use anyhow::Result;
use measure::quantity::{Forces, Partials};
use mechanics::forward::{Trajectory, Varied, neighbours};
use mechanics::math::linear::dot;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::terms::add_partials;
use super::{Rejected, Run, Scenario};
use crate::optimize::vectors::difference;

/// Numbers of a vector in a piece.
const PIECE: usize = 1024;

impl Scenario {
    /// A small change of the designed shape and of the variables of the loads.
    pub fn varied(&self, loads: &[f64], designed: &[mesh::Vec3]) -> Result<Varied, Rejected> {
        Ok(Varied { problem: self.under(loads)?, rest: self.rest(designed) })
    }

    /// dᵢᵀ ∇²J dⱼ of each two first-order changes d of what the terms of the objective J look at, from a run to its
    /// neighbours. It is the matrix of Gauss and Newton, with the curvature of the terms themselves. The states of the
    /// neighbours come with it. None where the run has no usable tangent.
    pub fn curvature(
        &self,
        run: &Run,
        varied: &[Varied],
    ) -> Option<(DMatrix<f64>, Vec<Arc<Trajectory>>)> {
        let of = (&run.rest[..], &*run.states);
        let begin = (&self.start, self.state_memory / varied.len() as f64);
        let all = neighbours(
            &run.problem,
            &mut self.workspaces().equilibrium,
            of,
            &run.tangents,
            varied,
            begin,
        )?;
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
            let (mut changes, mut bends) = (Vec::new(), Vec::new());
            for other in &all {
                let (there, other_slope) = self.seen(other, n);
                changes.push(difference(&there, &here));
                bends.push(difference(&other_slope, &slope));
            }
            curvature += products(&bends, &changes);
        }
        let states = all.into_iter().map(|run| run.states).collect();
        Some((0.5 * (&curvature + curvature.transpose()), states))
    }

    /// The run at other loads and another shape, foreseen by the states of neighbours: for each of them, with how much
    /// of its difference from the run is added.
    pub fn foreseen(
        &self,
        run: &Run,
        neighbours: &[(f64, &Trajectory)],
        loads: &[f64],
        designed: &[mesh::Vec3],
    ) -> Result<Trajectory> {
        let displacement = |n: usize| {
            let here = run.states.state(n);
            let mut u = here.u.clone();
            for (part, states) in neighbours {
                let there = states.state(n);
                let pairs = u.iter_mut().zip(&here.u).zip(&there.u);
                pairs.for_each(|((u, here), there)| *u += part * (there - here));
            }
            u
        };
        let all = (1..=run.states.steps()).map(|n| (run.states.times[n], Ok(displacement(n))));
        self.states::<anyhow::Error>(loads, designed, all)
    }

    /// What terms look at in a moment of a run, (u, X, f, r) one after the other, and their derivatives by it.
    fn seen(&self, run: &Run, n: usize) -> (Vec<f64>, Vec<f64>) {
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

/// aᵢ · bⱼ, by pieces of all vectors that stay in the cache.
fn products(a: &[Vec<f64>], b: &[Vec<f64>]) -> DMatrix<f64> {
    let length = a.first().map_or(0, Vec::len);
    let starts: Vec<usize> = (0..length).step_by(PIECE).collect();
    let of_piece = |&start: &usize| {
        let piece = start..length.min(start + PIECE);
        DMatrix::from_fn(a.len(), b.len(), |i, j| dot(&a[i][piece.clone()], &b[j][piece.clone()]))
    };
    // a constant order of the sums gives the same bits for any number of threads
    let parts: Vec<DMatrix<f64>> = starts.par_iter().map(of_piece).collect();
    parts.into_iter().fold(DMatrix::zeros(a.len(), b.len()), |sum, part| sum + part)
}
