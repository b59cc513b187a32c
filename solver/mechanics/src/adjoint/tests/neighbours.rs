//! Runs next to another one, to first order, against the adjoint.

use std::sync::Arc;

use super::*;
use crate::forward::{Varied, neighbours};

/// Size of a change: a first-order change is off by as much, relatively.
const CHANGE_BY: f64 = 1e-6;

/// The change of an objective from a run to a neighbour, and what the adjoint says of it: of the rest shape, and
/// of the pressure.
fn both_ways(case: &Case) -> [[f64; 2]; 2] {
    let (problem, mut workspace, rest) = case.problem(&NUMBERS);
    let start = case.start(&problem, &rest);
    let run = case.run(&problem, &mut workspace, &rest, start.clone());
    let probe = Probe::new(problem.dofs(), case.hits());
    let gradient = probe.gradient(&problem, &mut workspace, &rest, &run);

    let motion = points(&Random::new(5).numbers(3 * rest.len()));
    let moved = rest.iter().zip(&motion).map(|(x, d)| x + 0.02 * CHANGE_BY * d).collect();
    let pressure = NUMBERS.pressure * (1.0 + CHANGE_BY);
    let (blown, ..) = case.problem(&Numbers { pressure, ..NUMBERS });
    let varied = [
        Varied { problem: Arc::new(problem.clone()), rest: moved },
        Varied { problem: Arc::new(blown), rest: rest.clone() },
    ];
    let begin = Integrator::new(case.method, start);
    let of = (&rest[..], &run);
    let all = neighbours(&problem, &mut workspace, of, None, &varied, (&begin, f64::INFINITY));
    let here = probe.value(&problem, &rest, &run);
    let change = |i: usize, run: &Trajectory| {
        (probe.value(&varied[i].problem, &varied[i].rest, run) - here) / CHANGE_BY
    };
    let all = all.expect("the tangents are regular");
    let chamber = problem.energies.chambers().map(|(id, _)| ParameterId::Chamber(id)).next();
    let by_pressure = gradient.parameters.total(chamber.expect("there is one"))[0];
    [
        [change(0, &all[0]), 0.02 * dot(&gradient.rest, &flat(&motion))],
        [change(1, &all[1]), by_pressure * case.by_pressure() * NUMBERS.pressure],
    ]
}

#[test]
fn neighbours_of_a_run_are_those_that_the_adjoint_sees() {
    let dt = 2e-3;
    for (method, degree, steps, body, inside) in [
        (Method::ImplicitEuler, 1, 3, Shape::Blocks, Inside::Pressure),
        (Method::Bdf2, 1, 4, Shape::Blocks, Inside::Pressure),
        (Method::Quasistatic, 2, 2, Shape::Blocks, Inside::Pressure),
        (Method::Quasistatic, 1, 2, Shape::Hollow, Inside::Volume),
        (Method::Bdf3, 1, 5, Shape::Hollow, Inside::Gas),
        (Method::Newmark, 1, 4, Shape::Blocks, Inside::Pressure),
    ] {
        let case = Case { method, degree, steps, dt, body, inside };
        for [changed, expected] in both_ways(&case) {
            let off = (changed / expected - 1.0).abs();
            assert!(off < 1e-3, "{method:?} P{degree}: {changed} and {expected}, {off:.1e} apart");
        }
    }
}
