//! Derivatives of probes by all that a run depends on: one sweep of the adjoint for each probe. By
//! a [`number`](crate::number) of the scene, its row gives the derivative.

use anyhow::{Result, anyhow};
use measure::objective::Equilibrium;
use measure::probe::Probe;
use mechanics::adjoint::{self, Gradient};
use mechanics::energy::Iterate;
use mechanics::forward::{Problem, Trajectory, Workspace, solve_multipliers};
use scene::Scene;

/// The value of each probe at the end of time step n ≥ 1 of a run, and its derivatives.
///
/// # Errors
/// When the adjoint system has no accurate solution.
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
    let reaction = problem.gradient(&at).0;
    let linearization = (n == run.steps()).then(|| workspace.linearize(problem, &at));
    let (space, u, load) = (at.space, at.u, at.load);
    let here = Equilibrium { space, rest, u, load, contact: &contact, reaction: &reaction };
    let mut found = Vec::new();
    for probe in probes {
        let q = &probe.quantity;
        let partials = |_: &_, moment: usize, out: &mut adjoint::Partials| {
            if moment == n {
                q.add_du(&here, 1.0, &mut out.by_u);
                q.add_dcontact(&here, 1.0, &mut out.by_contact);
                q.add_dreaction(&here, 1.0, &mut out.by_reaction);
            }
        };
        let on = (rest, run);
        let mut swept = adjoint::sweep(problem, workspace, on, linearization.as_ref(), partials)
            .map_err(|e| anyhow!("derivatives of the probe \"{}\": {e}", probe.name))?;
        q.add_drest(&here, 1.0, &mut swept.rest);
        found.push((q.value(&here), swept));
    }
    Ok(found)
}
