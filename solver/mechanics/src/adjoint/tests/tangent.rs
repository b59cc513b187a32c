//! The adjoint against the tangent: the same derivative, computed forwards.

use super::*;
use crate::adjoint;

/// Change of a run when its rest shape moves by `motion` [m], state by state from the
/// linearised equations: the sweep the other way round, and without its operators.
struct Tangent<'a> {
    rest: &'a [Vec3],
    motion: &'a [Vec3],
    run: &'a Trajectory,
}

impl Tangent<'_> {
    /// Step of the differences of fourth order: contacts that come or go within it cost
    /// digits, as does rounding.
    const STEP: f64 = 1e-6;

    fn rest(&self, e: f64) -> Vec<Vec3> {
        self.rest.iter().zip(self.motion).map(|(x, d)| x + e * d).collect()
    }

    /// The run, its first states moved by e times their change.
    fn run(&self, changes: &[State], e: f64) -> Trajectory {
        let add = |to: &mut [f64], by: &[f64]| to.iter_mut().zip(by).for_each(|(x, d)| *x += e * d);
        let moved = |n: usize| {
            let mut state = self.run.state(n).into_owned();
            if let Some(change) = changes.get(n) {
                add(&mut state.u, &change.u);
                add(&mut state.v, &change.v);
                add(&mut state.a, &change.a);
            }
            state
        };
        let mut run = Trajectory::begin(&Integrator::new(self.run.method, moved(0)), f64::INFINITY);
        (1..=self.run.steps()).for_each(|n| run.push(self.run.times[n], moved(n)));
        run
    }

    fn slope(mut f: impl FnMut(f64) -> Vec<f64>) -> Vec<f64> {
        let h = Self::STEP;
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(&mut f);
        (0..a.len()).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)).collect()
    }

    fn states(&self, problem: &Problem, workspace: &mut Workspace) -> Vec<State> {
        let mut changes = vec![zeros(problem.dofs())];
        for n in 1..=self.run.steps() {
            let (state, end) = (self.run.state(n), self.run.times[n]);
            let u = &state.u[..];
            let force = Self::slope(|e| {
                let rest = self.rest(e);
                let step = self.run(&changes, e).step(problem, &rest, n);
                let at = Iterate { step: Some(&step), ..problem.iterate(&rest, u, end) };
                problem.gradient(&at).0
            });
            let step = self.run.step(problem, self.rest, n);
            let at = Iterate { step: Some(&step), ..problem.iterate(self.rest, u, end) };
            workspace.linearize(problem, &at);
            let rhs: Vec<f64> = problem.restrict(&force).iter().map(|f| -f).collect();
            let du = adjoint::solve(workspace, rhs).expect("regular");
            let du = problem.prolong(&du);
            // what the integrator makes of the state and of the states before it
            let end_state = |of: fn(&State) -> &Vec<f64>| {
                Self::slope(|e| {
                    let mut past = self.run(&changes, e).past(n);
                    let step = past.step(self.run.times[n - 1], end);
                    let moved: Vec<f64> = u.iter().zip(&du).map(|(u, du)| u + e * du).collect();
                    past.accept(&step, &moved, Vec::new());
                    of(past.last()).clone()
                })
            };
            let (v, a) = (end_state(|s| &s.v), end_state(|s| &s.a));
            changes.push(State { a, ..State::new(du.clone(), v) });
        }
        changes
    }
}

/// dJ along a motion of the rest shape by the adjoint and by the tangent.
fn both_ways(case: &Case, forces: bool) -> [f64; 2] {
    let (problem, mut workspace, rest) = case.problem(&NUMBERS);
    let start = case.start(&problem, &rest);
    let run = case.run(&problem, &mut workspace, &rest, start);
    let probe = Probe::new(problem.dofs(), forces);
    let gradient = probe.gradient(&problem, &mut workspace, &rest, &run);
    let motion = points(&Random::new(5).numbers(3 * rest.len()));
    let motion: Vec<Vec3> = motion.iter().map(|d| 0.02 * d).collect();
    let tangent = Tangent { rest: &rest, motion: &motion, run: &run };
    let changes = tangent.states(&problem, &mut workspace);
    let along = Tangent::slope(|e| {
        vec![probe.value(&problem, &tangent.rest(e), &tangent.run(&changes, e))]
    });
    [dot(&gradient.rest, &flat(&motion)), along[0]]
}

#[test]
fn the_adjoint_is_the_tangent_the_other_way_round() {
    let dt = 2e-3;
    for (method, degree, steps, body, inside) in [
        (Method::ImplicitEuler, 1, 3, Shape::Blocks, Inside::Pressure),
        (Method::Bdf2, 1, 4, Shape::Blocks, Inside::Pressure),
        (Method::Quasistatic, 2, 2, Shape::Blocks, Inside::Pressure),
        (Method::ImplicitEuler, 2, 2, Shape::Tet, Inside::Pressure),
        (Method::Bdf3, 1, 5, Shape::Hollow, Inside::Gas),
        (Method::Newmark, 1, 4, Shape::Blocks, Inside::Pressure),
        (Method::GeneralizedAlpha, 1, 4, Shape::Blocks, Inside::Pressure),
    ] {
        let case = Case { method, degree, steps, dt, body, inside };
        let [adjoint, tangent] = both_ways(&case, case.hits());
        let off = (adjoint / tangent - 1.0).abs();
        assert!(off < 1e-8, "{method:?} P{degree}: {adjoint} and {tangent}, {off:.1e} apart");
    }
}
