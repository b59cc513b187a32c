//! Derivatives of probes by all that a run depends on: one sweep of the adjoint for each probe. By
//! a [`number`](scene::number) of the scene, its row gives the derivative.

use anyhow::{Result, anyhow};
use measure::probe::Probe;
use measure::quantity::{Equilibrium, Forces, Partials};
use mechanics::adjoint::{self, Gradient};
use mechanics::energy::Iterate;
use mechanics::forward::{Linearizations, Problem, Trajectory, Workspace, solve_multipliers};
use scene::Scene;

/// The value of each probe at the end of time step n ≥ 1 of a run, and its derivatives.
pub fn sensitivities(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    (probes, run, n): (&[&Probe], &Trajectory, usize),
) -> Result<Vec<(f64, Gradient)>> {
    let rest = &scene.body.mesh.vertices[..];
    let (state, step) = (run.state(n), run.step(problem, rest, n));
    let at = problem.iterate(rest, &state.u, run.times[n]);
    let at = Iterate { step: Some(&step), ..at };
    let multipliers = solve_multipliers(problem, workspace, &at);
    let at = Iterate { multipliers: &multipliers, ..at };
    let contact = problem.energies.contact_forces(&at);
    let forces = Forces { contact, reaction: problem.gradient(&at).0 };
    let known = Linearizations::at_step(n, workspace.linearize(problem, &at));
    let here = Equilibrium::new(problem, &at, &forces);
    let mut found = Vec::new();
    for probe in probes {
        let (q, mut by_rest) = (&probe.quantity, vec![0.0; 3 * rest.len()]);
        let partials = |_: &_, moment: usize, out: &mut adjoint::Partials| {
            if moment == n {
                let adjoint::Partials { by_u: u, by_contact: contact, by_reaction: reaction } = out;
                let mut out = Partials { u, rest: &mut by_rest, contact, reaction };
                q.add_partials(&here, 1.0, &mut out);
            }
        };
        let (on, all) = ((rest, run), adjoint::Wanted::All);
        let mut swept = adjoint::sweep(problem, workspace, on, &known, all, partials)
            .map_err(|e| anyhow!("derivatives of the probe \"{}\": {e}", probe.name))?;
        swept.rest.iter_mut().zip(&by_rest).for_each(|(g, b)| *g += b);
        for (id, by) in q.by_parameters(&here, 1.0) {
            swept.parameters.add(n - 1, id, by);
        }
        found.push((q.value(&here), swept));
    }
    Ok(found)
}
