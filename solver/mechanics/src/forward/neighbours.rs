//! First-order changes of a run: the tangent, or forward, mode of what the adjoint method does backwards.
//!
//! Step n of a run solves G(u_n; X, past_n, p) = 0 on the free degrees of freedom. Of a neighbour, whose
//! rest shape X, past and parameters p differ by a small δ, it is to first order
//!
//! H δu_n = −(G(u_n; X + δX, past_n + δpast_n, p + δp) − G(u_n; X, past_n, p))
//!
//! with the exact Hessian H, one factorisation a step for all neighbours. The difference takes the whole residual, so
//! that no term has to know its own derivatives by the past. Where the pressure of a prescribed volume V is unknown, too,
//! H δu + G δp = −δG with Gᵀ δu = −δV.
//!
//! Source: the forward mode of equation 5 of Gjoka et al. 2024; for trajectories see Griewank and Walther 2008,
//! "Evaluating Derivatives", section 3.1.

use std::sync::Arc;

use mesh::Vec3;

use super::{
    HeldVolumes, Integrator, Linearizations, Problem, Trajectory, Workspace, solve_multipliers,
};
use crate::energy::{Contact, Iterate, Multiplier, TimeStep};
use crate::math::linear::SYSTEMS;

/// Relative residual of the changes.
const TOLERANCE: f64 = 1e-7;

/// A problem and a rest shape [m] that differ little from those of a run.
pub struct Varied {
    /// What it solves.
    pub problem: Arc<Problem>,
    /// Rest vertices [m].
    pub rest: Vec<Vec3>,
}

/// The runs of varied problems, to first order, from a start and with memory for the states of each [B]. None where
/// some tangent has no usable factor. Each linearisation whose factor is at hand saves one factorisation.
pub fn neighbours(
    problem: &Problem,
    workspace: &mut Workspace,
    (rest, run): (&[Vec3], &Trajectory),
    linearizations: &Linearizations,
    varied: &[Varied],
    (start, memory): (&Integrator, f64),
) -> Option<Vec<Trajectory>> {
    let begin = |_: &Varied| Trajectory::begin(start, memory);
    let mut runs: Vec<Trajectory> = varied.iter().map(begin).collect();
    for n in 1..=run.steps() {
        let (state, time, step) = (run.state(n), run.times[n], run.step(problem, rest, n));
        let at = Iterate { step: Some(&step), ..problem.iterate(rest, &state.u, time) };
        let multipliers = solve_multipliers(problem, workspace, &at);
        let at = Iterate { multipliers: &multipliers, ..at };
        if !linearizations.step(n).is_some_and(|known| workspace.has_factor_of(known, &at)) {
            workspace.linearize(problem, &at);
        }
        let (residual, _) = workspace.gradient(problem, &at);
        let constraints = problem.constraints(&at);
        let across: Vec<_> = constraints.iter().map(|c| problem.restrict(&c.gradient)).collect();
        let mut solved = across.clone();
        workspace.linear().last()?.solve_all_to(&mut solved, TOLERANCE);
        let volumes = HeldVolumes::new(across, solved);
        // to look for close pairs in each neighbour took half of the time of a design with contact
        let _held = problem.energies.contact().map(Contact::hold);
        for (varied, runs) in varied.chunks(SYSTEMS).zip(runs.chunks_mut(SYSTEMS)) {
            let there: Vec<There> = varied
                .iter()
                .zip(&*runs)
                .map(|(varied, run)| There::new(problem, varied, run, &state.u, time))
                .collect();
            let side = |there: &There| {
                let (changed, _) = workspace.gradient(there.problem, &there.at(&multipliers));
                let change: Vec<f64> = residual.iter().zip(&changed).map(|(a, b)| a - b).collect();
                problem.restrict(&change)
            };
            let mut changes: Vec<Vec<f64>> = there.iter().map(side).collect();
            workspace.linear().last()?.solve_all_to(&mut changes, TOLERANCE);
            for ((there, mut du), run) in there.iter().zip(changes).zip(runs) {
                let constraints = there.problem.constraints(&there.at(&multipliers));
                volumes.hold(&mut du, |i| constraints[i].wanted - constraints[i].volume)?;
                let du = problem.prolong(&du);
                let u: Vec<f64> = there.u.iter().zip(&du).map(|(u, du)| u + du).collect();
                run.push_displacement(there.problem, there.rest, time, &u);
            }
        }
    }
    Some(runs)
}

/// Where the step of a neighbour is looked at: its past, and the displacement of the run.
struct There<'a> {
    problem: &'a Problem,
    rest: &'a [Vec3],
    u: Vec<f64>,
    time: f64,
    step: TimeStep,
}

impl<'a> There<'a> {
    fn new(of: &Problem, varied: &'a Varied, past: &Trajectory, u: &[f64], time: f64) -> Self {
        let Varied { problem, rest } = varied;
        let u = moved_supports(of, problem, u, time);
        let step = past.next_step(problem, rest, time);
        Self { problem, rest, u, time, step }
    }

    fn at<'b>(&'b self, multipliers: &'b [Multiplier]) -> Iterate<'b> {
        let Self { problem, rest, u, time, step } = self;
        Iterate { step: Some(step), multipliers, ..problem.iterate(rest, u, *time) }
    }
}

/// A displacement with the supports where another problem holds them [m].
fn moved_supports(problem: &Problem, other: &Problem, u: &[f64], time: f64) -> Vec<f64> {
    if !other.dirichlet.moves() {
        return u.to_vec();
    }
    let (from, to) = (problem.dirichlet.displacement(time), other.dirichlet.displacement(time));
    let mut moved = u.to_vec();
    problem.dirichlet.supports().iter().for_each(|&dof| moved[dof] += to[dof] - from[dof]);
    moved
}
