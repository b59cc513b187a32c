//! The equilibrium next to a known one.

use std::sync::Arc;

use mechanics::energy::Iterate;
use mechanics::forward::{
    Configuration, Failure, Integrator, LoadStep, Newton, Problem, Trajectory, Workspace,
    solve_from, solve_multipliers,
};
use mesh::Vec3;
use scene::Scene;

/// Whether an equilibrium does not depend on the way to it.
pub fn is_free_of_history(scene: &Scene) -> bool {
    let rubs = scene.config.contact().is_some_and(|contact| contact.friction > 0.0);
    !rubs && scene.config.time.is_none()
}

/// The equilibrium at a time next to a displacement [m], in one load step from the start of the bodies.
pub fn next_to(
    start: &Integrator,
    (problem, workspace): (&Problem, &mut Workspace),
    (rest, time): (&[Vec3], f64),
    u: &[f64],
    newton: &Newton,
) -> Result<LoadStep, Failure> {
    let step = Arc::new(Trajectory::begin(start, 0.0).next_step(problem, rest, time));
    let at = Iterate { step: Some(&step), ..problem.iterate(rest, u, time) };
    let multipliers = solve_multipliers(problem, workspace, &at);
    let near = Configuration {
        rest,
        time,
        step: Some(&step),
        u: u.to_vec(),
        multipliers,
        balanced_at: None,
    };
    solve_from(problem, workspace, &near, newton)
}
