//! Runs of viscoelastic bodies: their gradients, and closed forms of relaxation.

use std::ops::Range;

use super::*;
use crate::energy::{Branch, Energy, Mullins, Viscous};
use crate::material::{Isochoric, Material, OgdenRoxburgh};

const BRANCHES: [Branch; 2] =
    [Branch { overstress: 0.6, time: 0.03 }, Branch { overstress: 0.3, time: 0.4 }];

/// Gradients of the runs of a case with a term that remembers, by the numbers of its law and of the term, with first steps
/// of both.
fn check_with<T: Energy>(
    case: &Case,
    (owner, numbers): (Owner, &[f64]),
    steps: [f64; 2],
    term: impl Fn(Isochoric, &[f64], Range<usize>) -> T,
) {
    let problem = |p: &[f64]| {
        let law: [f64; 4] = std::array::from_fn(|k| p[k] * NUMBERS.law[k]);
        let own: Vec<f64> = p[4..].iter().zip(numbers).map(|(p, number)| p * number).collect();
        let (mut problem, ..) = case.problem(&Numbers { law, ..NUMBERS });
        let [c1, c2, c3, d1] = law;
        let law = MooneyRivlin { c1, c2, c3, d1 }.isochoric().expect("in invariants");
        let own = term(law, &own, 0..problem.space.tets().len());
        problem.energies.extend([Term::of_both((Elastic::owner(0), 4), owner, own)]);
        let workspace = Workspace::new(&problem);
        (problem, workspace)
    };
    let run = |problem: &Problem, workspace: &mut Workspace, rest: &[Vec3]| {
        case.run(problem, workspace, rest, case.start(problem, rest))
    };
    let by = |gradient: &Gradient| {
        let own = by_factors(gradient, owner, numbers);
        assert!(own.iter().all(|by| *by != 0.0), "{own:?}");
        vec![by_factors(gradient, Elastic::owner(0), &NUMBERS.law), own]
    };
    let rest = case.bodies().0.vertices;
    let runs = Runs { problem: &problem, run: &run, forces: case.hits(), moves: |_| true };
    runs.check(&rest, 2e-6, &steps, by);
}

#[test]
fn viscous_runs_have_their_gradients_with_any_formula() {
    for (method, degree, steps, body, inside) in [
        (Method::Quasistatic, 1, 3, Shape::Tet, Inside::Pressure),
        (Method::ImplicitEuler, 1, 3, Shape::Tet, Inside::Gas),
        (Method::ImplicitEuler, 2, 3, Shape::Tet, Inside::Volume),
        (Method::Bdf2, 1, 4, Shape::Tet, Inside::Pressure),
        (Method::Bdf3, 1, 5, Shape::Tet, Inside::Pressure),
        (Method::Newmark, 1, 4, Shape::Tet, Inside::Pressure),
        (Method::GeneralizedAlpha, 1, 4, Shape::Tet, Inside::Pressure),
    ] {
        let case = Case { method, degree, steps, dt: 0.02, body, inside };
        let numbers: Vec<f64> = BRANCHES.iter().flat_map(|b| [b.overstress, b.time]).collect();
        check_with(
            &case,
            (Viscous::owner(0), &numbers[..]),
            [1e-3; 2],
            |law, numbers, elements| {
                let branches = numbers.chunks_exact(2);
                let branches = branches.map(|b| Branch { overstress: b[0], time: b[1] });
                Viscous::new(law, branches.collect(), elements, 0)
            },
        );
    }
}

/// A tetrahedron that swings sideways in three milliseconds, so that it is softened on its way back.
#[test]
fn softened_runs_have_their_gradients() {
    let (method, body, inside) = (Method::Bdf2, Shape::Tet, Inside::Pressure);
    let case = Case { method, degree: 1, steps: 10, dt: 4e-4, body, inside };
    let numbers = (Mullins::owner(0), &[2.0, 2.0, 0.1][..]);
    check_with(&case, numbers, [1e-3, 1e-2], |law, numbers, elements| {
        let softening = OgdenRoxburgh { r: numbers[0], m: numbers[1], beta: numbers[2] };
        Mullins::new(law, softening, elements, 0)
    });
}

/// A unit cube sheared by a given displacement of all its nodes: forces of its law and overstress.
#[test]
fn stress_relaxes_as_the_formula_says() {
    let mesh = cube(1, 0.0);
    let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets.clone());
    let law = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 0.0, d1: 1e6 };
    let count = mesh.tets.len();
    let elastic = Elastic::whole(Box::new(law));
    let energies = Energies::bodies([elastic]);
    let isochoric = law.isochoric().expect("in invariants");
    let energies = energies.with(Viscous::new(isochoric, BRANCHES.to_vec(), 0..count, 0));
    let problem = Problem::new(space, energies, &[true; 3 * 27]);
    let rest = &mesh.vertices;
    let nodes = problem.space.node_positions(rest);
    let shear: Vec<f64> = nodes.iter().flat_map(|x| [0.3 * x.y, 0.0, 0.0]).collect();
    let top: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i].y == 1.0).collect();
    // in simple shear the stress xy is isochoric: μ γ, with μ = 2 (c₁ + c₂)
    let elastic = 2.0 * 60e3 * 0.3;
    let over = |of: &dyn Fn(f64) -> f64| -> f64 {
        BRANCHES.iter().map(|b| b.overstress * of(b.time)).sum()
    };
    // strain jumps at t = 0; force at 0.1 s
    let force = |method: Method, steps: usize| -> f64 {
        let dt = 0.1 / steps as f64;
        let zero = vec![0.0; problem.dofs()];
        let mut integrator = Integrator::new(method, State::new(zero.clone(), zero));
        let mut force = 0.0;
        for n in 1..=steps {
            let step = integrator.step(0.0, dt);
            let at = problem.iterate(rest, &shear, dt * n as f64);
            let at = Iterate { step: Some(&step), ..at };
            let (gradient, _) = problem.gradient(&at);
            force = top.iter().map(|&i| gradient[3 * i]).sum();
            integrator.accept(&step, &shear, problem.energies.internal(&at));
        }
        force
    };
    let exact = elastic * (1.0 + over(&|time| (-0.1 / time).exp()));
    for steps in [1, 7, 80] {
        let dt = 0.1 / f64::from(steps);
        let euler = elastic * (1.0 + over(&|time| (1.0 + dt / time).powi(-steps)));
        let off = (force(Method::Quasistatic, steps as usize) / euler - 1.0).abs();
        assert!(off < 1e-12, "{steps} steps: {off:.1e}");
    }
    let error = |method, steps| (force(method, steps) / exact - 1.0).abs();
    let slope = (error(Method::Quasistatic, 80) / error(Method::Quasistatic, 160)).log2();
    assert!((slope - 1.0).abs() < 0.1, "{slope}");
    let (euler, bdf2) = (error(Method::Quasistatic, 80), error(Method::Bdf2, 80));
    assert!(bdf2 < 0.25 * euler, "{bdf2:.1e} and {euler:.1e}");
}
