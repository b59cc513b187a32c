//! Runs next to another one, to first order, against the adjoint.

use std::sync::Arc;

use super::*;
use crate::forward::{Linearizations, Varied, neighbours};

impl Case {
    /// The derivative of the number of the chamber by the pressure that it stands for.
    pub(super) fn by_pressure(&self) -> f64 {
        match self.inside {
            Inside::Pressure | Inside::Gas | Inside::Supply | Inside::CheckedSupply => 1.0,
            Inside::Volume => CHANGE,
            Inside::Factor => FACTOR,
        }
    }
}

/// The change of an objective from a run to a neighbour, over the size of what differs, and what the adjoint says of it: of the rest shape, and of the
/// law with the pressure, where there is a chamber.
fn both_ways(case: &Case, size: f64) -> [[f64; 2]; 3] {
    let (problem, mut workspace, rest) = case.problem(&NUMBERS);
    let start = case.start(&problem, &rest);
    let run = case.run(&problem, &mut workspace, &rest, start.clone());
    let probe = Probe::new(problem.dofs(), case.hits());
    let gradient = probe.gradient(&problem, &mut workspace, &rest, &run);

    let motion = points(&Random::new(5).numbers(3 * rest.len()));
    let moved: Vec<_> = rest.iter().zip(&motion).map(|(x, d)| x + 0.02 * size * d).collect();
    let mut numbers = NUMBERS;
    numbers.law[0] *= 1.0 + size;
    numbers.pressure *= 1.0 + size;
    let (other, ..) = case.problem(&numbers);
    let other = Arc::new(other);
    // three go side by side
    let varied = [
        Varied { problem: Arc::new(problem.clone()), rest: moved.clone() },
        Varied { problem: Arc::clone(&other), rest: rest.clone() },
        Varied { problem: other, rest: moved },
    ];
    let begin = Integrator::new(case.method, start);
    let of = (&rest[..], &run);
    let all = neighbours(
        &problem,
        &mut workspace,
        of,
        &Linearizations::default(),
        &varied,
        (&begin, f64::INFINITY),
    );
    let here = probe.value(&problem, &rest, &run);
    let change = |i: usize, run: &Trajectory| {
        (probe.value(&varied[i].problem, &varied[i].rest, run) - here) / size
    };
    let all = all.expect("the tangents are regular");
    let chamber = problem.energies.chambers().map(|(id, _)| id.owner()).next();
    let by_pressure = chamber.map_or(0.0, |id| gradient.parameters.total(id)[0]);
    let by_law = gradient.parameters.total(Elastic::owner(0))[0] * NUMBERS.law[0];
    let by_rest = 0.02 * dot(&gradient.rest, &flat(&motion));
    let by_numbers = by_law + by_pressure * case.by_pressure() * NUMBERS.pressure;
    [
        [change(0, &all[0]), by_rest],
        [change(1, &all[1]), by_numbers],
        [change(2, &all[2]), by_rest + by_numbers],
    ]
}

#[test]
fn neighbours_of_a_run_are_those_that_the_adjoint_sees_to_first_order() {
    let dt = 2e-3;
    for (method, degree, steps, body, inside) in [
        (Method::ImplicitEuler, 1, 3, Shape::Blocks, Inside::Pressure),
        (Method::Bdf2, 1, 4, Shape::Blocks, Inside::Pressure),
        (Method::Quasistatic, 2, 2, Shape::Blocks, Inside::Pressure),
        (Method::Quasistatic, 1, 2, Shape::Hollow, Inside::Volume),
        (Method::Bdf3, 1, 5, Shape::Hollow, Inside::Gas),
        (Method::Newmark, 1, 4, Shape::Blocks, Inside::Pressure),
        (Method::GeneralizedAlpha, 1, 4, Shape::Blocks, Inside::Pressure),
    ] {
        let case = Case { method, degree, steps, dt, body, inside };
        let off = |size: f64| {
            both_ways(&case, size).map(|[changed, expected]| (changed / expected - 1.0).abs())
        };
        let ([coarse, ..], [fine, law, both]) = (off(1e-5), off(1e-6));
        let slope = 1.0 + (coarse / fine).log10();
        assert!((slope - 2.0).abs() < 0.1, "{method:?} P{degree}: the remainder has slope {slope}");
        assert!(fine < 1e-2, "{method:?} P{degree}: {fine:.1e} apart");
        assert!(law < 1e-4, "{method:?} P{degree}: {law:.1e} apart");
        assert!(both < 1e-2, "{method:?} P{degree}: both, {both:.1e} apart");
    }
}
