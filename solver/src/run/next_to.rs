//! The equilibrium of a scene without time next to a known one.

use std::sync::Arc;

use mechanics::energy::Iterate;
use mechanics::forward::{
    Configuration, Failure, LoadStep, Problem, Workspace, solve_from, solve_multipliers,
};
use scene::Scene;

/// Whether an equilibrium does not depend on the way to it.
pub fn is_free_of_history(scene: &Scene) -> bool {
    let rubs = scene.config.contact().is_some_and(|contact| contact.friction > 0.0);
    !rubs && scene.config.time.is_none()
}

/// The equilibrium under the full load next to a displacement [m], in one load step. It is found to the same
/// residual as from rest.
pub fn next_to(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    u: &[f64],
) -> Result<LoadStep, Failure> {
    let (rest, end) = (&scene.body.mesh.vertices[..], scene.end());
    let step = Arc::new(scene.integrator(&scene.body, problem).step(0.0, end));
    let at = Iterate { step: Some(&step), ..problem.iterate(rest, u, end) };
    let multipliers = solve_multipliers(problem, workspace, &at);
    let start = Configuration { rest, time: end, step: Some(&step), u: u.to_vec(), multipliers };
    let newton = scene.stepping().newton;
    let mut steps = solve_from(problem, workspace, &start, &newton)?.steps;
    let found = steps.pop().expect("a solution has the step to it");
    Ok(LoadStep { ends_time_step: true, ..found })
}
