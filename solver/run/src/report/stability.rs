//! What reports say of the stability of a state, and of its place on a path that is followed by its arc length.

use mechanics::energy::Iterate;
use mechanics::forward::{
    self, ArcPoint, LoadStep, Problem, SingularPoint, Singularity, Workspace,
};
use mesh::io::vtu;
use reports::{PassedPoint, PathState, PointKind, Stability};
use scene::Scene;

/// The stability of the last state of a run beside that of the body at rest, with its softest mode over all degrees of
/// freedom: that of a path is known, that of another one is computed where the scene asks for it, by two factors. None
/// where a tangent is singular.
pub fn at_end(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    end: &Iterate,
    last: Option<&LoadStep>,
) -> Option<(Stability, Vec<f64>)> {
    if let Some(point) = last.and_then(|step| step.path.as_deref()) {
        return Some((path_state(point).stability, point.stability.mode.clone()));
    }
    if !scene.config.solver.stability {
        return None;
    }
    let zero = vec![0.0; problem.dofs()];
    let rest = Iterate { u: &zero, time: 0.0, ..*end };
    let mut of = |at: &Iterate| forward::Stability::of(problem, workspace, at);
    let Some((rest, found)) = of(&rest).and_then(|rest| Some((rest, of(end)?))) else {
        log::warn!("no stability: the tangent stiffness is singular");
        return None;
    };
    Some((report(&found, rest.stiffness), found.mode))
}

fn report(found: &forward::Stability, rest_stiffness: f64) -> Stability {
    let kind = kind_of(found.kind());
    Stability {
        negative_eigenvalues: found.negative,
        stiffness_over_rest: found.stiffness / rest_stiffness,
        mode_along_path: found.along_path,
        kind,
    }
}

/// What becomes of a path, as reports have it.
pub fn kind_of(kind: Singularity) -> PointKind {
    match kind {
        Singularity::LimitPoint => PointKind::LimitPoint,
        Singularity::Bifurcation => PointKind::Bifurcation,
    }
}

/// A state of a path, as reports have it.
pub fn path_state(point: &ArcPoint) -> PathState {
    let passed =
        |passed: &SingularPoint| PassedPoint { kind: kind_of(passed.kind), loads: passed.loads };
    PathState {
        arc_length: point.arc,
        load_rate: point.load_rate,
        stability: report(&point.stability, point.rest_stiffness),
        passed: point.passed.iter().map(passed).collect(),
    }
}

/// A mode as a field of pictures.
pub fn field(mode: &[f64]) -> vtu::Field {
    vtu::Field::new("softest_mode", "1", 3, mode.to_vec())
}

/// What lies between the state before and this one of a path, for people.
pub fn in_words(step: &LoadStep) -> Vec<String> {
    let one = |&SingularPoint { kind, loads: [from, to] }: &SingularPoint| match kind {
        Singularity::LimitPoint => {
            format!("limit point passed between load {from:.4} and {to:.4}: the load turns")
        }
        Singularity::Bifurcation => format!(
            "bifurcation between load {from:.4} and {to:.4}: another branch leaves, and this one is followed"
        ),
    };
    step.path.iter().flat_map(|path| &path.passed).map(one).collect()
}

/// Why a path ends at a state before it comes to the full load, if it does: the number of states that were made, or
/// the volume of a chamber.
pub fn ends_path(scene: &Scene, states: usize, at: &Iterate, problem: &Problem) -> Option<String> {
    let solver = &scene.config.solver;
    if !solver.follow.is_load() && states >= most_states(scene) {
        return Some(format!("after {states} states ([solver] path_states)"));
    }
    let factor = solver.path_volume_factor?;
    let beyond = problem.energies.chambers().find_map(|(_, chamber)| {
        let found = chamber.state(at).0 / chamber.rest_volume(at);
        (found > factor).then_some((&chamber.name, found))
    });
    let (name, found) = beyond?;
    Some(format!("as {name} has {found:.2} times its volume ([solver] path_volume_factor)"))
}

/// What a path that ended after so many states did not come to, where the scene asks for the full load: the end in
/// words.
pub fn missed(scene: &Scene, states: usize, last: Option<&LoadStep>) -> Option<String> {
    let solver = &scene.config.solver;
    let last = last.filter(|step| !step.ends_time_step && !solver.path_only)?;
    let negative = last.path.as_ref().map_or(0, |path| path.stability.negative);
    let stable = match negative {
        0 => "a stable state".to_owned(),
        1 => "an unstable state (1 negative eigenvalue)".to_owned(),
        count => format!("an unstable state ({count} negative eigenvalues)"),
    };
    (states >= most_states(scene)).then(|| {
        format!(
            "the full load was not reached: the path ends at {}, in {stable}, after {states} states\n  \
             raise [solver] path_states, lower the load, or write path_only = true if the path is what you want",
            scene.progress(last.time)
        )
    })
}

fn most_states(scene: &Scene) -> usize {
    scene.config.solver.path_states.unwrap_or(PATH_STATES)
}

/// States of a path where the scene gives no number.
const PATH_STATES: usize = 200;
