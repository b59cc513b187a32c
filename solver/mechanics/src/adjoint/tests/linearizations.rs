//! Tangents that are factored once for all that is asked of a run.

use super::*;
use crate::forward::{Varied, neighbours};

const CASE: Case = Case {
    method: Method::Bdf2,
    degree: 2,
    steps: 3,
    dt: 2e-3,
    body: Shape::Hollow,
    inside: Inside::Gas,
};

/// A sum of displacements at the ends of all time steps, by the rest shape.
fn by_rest(
    on: (&Problem, &mut Workspace),
    (rest, run): (&[Vec3], &Trajectory),
    known: &Linearizations,
) -> Vec<f64> {
    let by_u = Random::new(3).numbers(on.0.dofs());
    let partials = |_: &_, _, out: &mut Partials| out.by_u.clone_from(&by_u);
    sweep(on.0, on.1, (rest, run), known, Wanted::All, partials).expect("regular").rest
}

#[test]
fn what_is_asked_of_a_run_needs_no_factor_where_all_are_kept() {
    let (problem, mut workspace, rest) = CASE.problem(&NUMBERS);
    let start = CASE.start(&problem, &rest);
    let run = CASE.run(&problem, &mut workspace, &rest, start.clone());
    let expected = by_rest((&problem, &mut workspace), (&rest, &run), &Linearizations::default());

    let one = workspace.memory_of_factor() as f64;
    let [all, last] = [4.5 * one, 1.5 * one]
        .map(|memory| Linearizations::of(&problem, &mut workspace, &rest, &run, memory));
    assert!(last.step(2).is_none() && last.step(3).is_some(), "{last:?}");

    let before = workspace.timings.factor;
    let found = by_rest((&problem, &mut workspace), (&rest, &run), &all);
    assert_eq!(found, expected);
    let moved = rest.iter().map(|x| 1.001 * x).collect();
    let varied = [Varied { problem: Arc::new(problem.clone()), rest: moved }];
    let begin = (&Integrator::new(CASE.method, start), f64::INFINITY);
    let of = (&rest[..], &run);
    assert!(neighbours(&problem, &mut workspace, of, &all, &varied, begin).is_some());
    assert_eq!(workspace.timings.factor, before, "something was factored");

    let found = by_rest((&problem, &mut workspace), (&rest, &run), &last);
    assert_eq!(found, expected);
    assert_ne!(workspace.timings.factor, before, "two steps had no factor");
}

#[test]
fn a_run_that_begins_its_steps_with_the_factors_of_another_factors_less() {
    let (problem, mut workspace, rest) = CASE.problem(&NUMBERS);
    let start = CASE.start(&problem, &rest);
    let run = CASE.run(&problem, &mut workspace, &rest, start.clone());
    let known = Linearizations::of(&problem, &mut workspace, &rest, &run, f64::INFINITY);
    let times = &run.times[1..];
    let moved: Vec<_> = rest.iter().map(|x| 1.001 * x).collect();
    let mut again = |known: Linearizations| {
        let before = workspace.timings.factorizations;
        let stepper = TimeStepper::new(TIGHT, Integrator::new(CASE.method, start.clone()));
        let mut stepper = stepper.with_factors(Arc::new(known));
        let run = stepper.run(&problem, &mut workspace, &moved, times, f64::INFINITY, |_| ());
        (run.expect("an equilibrium"), workspace.timings.factorizations - before)
    };
    let ((blind, many), (with, few)) = (again(Linearizations::default()), again(known));
    assert!(few < many, "{few} factorisations in place of {many}");
    for n in 1..=3 {
        let (a, b) = (blind.state(n), with.state(n));
        let off = a.u.iter().zip(&b.u).map(|(a, b)| a - b).collect::<Vec<_>>();
        assert!(norm(&off) < 1e-9 * norm(&a.u), "step {n} is {:.1e} apart", norm(&off));
    }
}
