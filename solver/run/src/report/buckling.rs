//! The load at which a standing body buckles, foreseen where Newton's method crawls.
//!
//! The stiffness k of the softest mode falls about in proportion to the load up to the point where it vanishes: from k₀ at
//! rest and k at the load t, that is t k₀ / (k₀ − k) (linear buckling analysis, e.g. Bathe, "Finite Element Procedures",
//! section 6.8.2).

use mechanics::energy::Iterate;
use mechanics::forward::{Configuration, LoadStep, Problem, Stability, Workspace, solve_from};
use scene::Scene;

/// Newton iterations of a load step from which on the method crawls.
const CRAWLS: usize = 15;
/// Part of the load at which the stiffness is asked for where no state is known [1].
const SMALL: f64 = 0.01;
/// How many times as large as a load that was reached one may be that is foreseen from it.
const FAR: f64 = 2.0;

/// The load at which a stiffness that is one at rest and another at a load vanishes.
pub fn critical_load(load: f64, [at_rest, there]: [f64; 2]) -> Option<f64> {
    (at_rest > there && there > 0.0).then(|| load * at_rest / (at_rest - there))
}

/// What to say of a body that buckles about at a load.
pub fn in_words(scene: &Scene, load: f64) -> String {
    format!(
        "the body buckles at about {}: there the stiffness of its softest mode vanishes, and beyond it bends far under \
         little more load\n  \
         follow = \"arc-length\" in [solver] goes on through that point; or move a support instead of prescribing a \
         force, or lower the load",
        scene.progress(load)
    )
}

/// A warning after a load step of a static scene that took many iterations, where the body buckles near its load: `before`
/// is the state before it, at rest the first. Pressures and contact make the method slow in other ways. The factor in the
/// workspace stays.
pub fn foreseen(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    before: &Iterate,
    step: &LoadStep,
) -> Option<String> {
    let crawls = step.newton_iterations >= CRAWLS && scene.config.chamber.is_empty();
    if !crawls || scene.config.contact().is_some() || scene.path().is_some() {
        return None;
    }
    let kept = workspace.linear().share();
    let load = load_near(scene, problem, workspace, before, step.time);
    if let Some(kept) = kept {
        workspace.factor(|linear| linear.reuse(&kept));
    }
    load.filter(|load| *load < FAR * step.time).map(|load| in_words(scene, load))
}

fn load_near(
    scene: &Scene,
    problem: &Problem,
    workspace: &mut Workspace,
    before: &Iterate,
    reached: f64,
) -> Option<f64> {
    let zero = vec![0.0; problem.dofs()];
    let at_rest = Iterate { u: &zero, time: 0.0, ..*before };
    let stiffness = |workspace: &mut Workspace, at: &Iterate| {
        let found = Stability::of(problem, workspace, at)?;
        (found.negative == 0).then_some(found.stiffness)
    };
    let rest = stiffness(workspace, &at_rest)?;
    if before.time > 0.0 {
        let there = stiffness(workspace, before)?;
        return critical_load(before.time, [rest, there]);
    }
    let load = SMALL * reached;
    let start = Configuration::new(problem, before.rest, zero.clone(), load);
    let found = solve_from(problem, workspace, &start, &scene.stepping().newton).ok()?;
    let there = Iterate { u: &found.u, time: load, ..*before };
    critical_load(load, [rest, stiffness(workspace, &there)?])
}
