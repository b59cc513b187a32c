//! Runs of bodies with mean dilatation: their gradients.

use super::*;

#[test]
fn runs_with_mean_dilatation_have_their_gradients() {
    for (method, steps, body, inside) in [
        (Method::Quasistatic, 1, Shape::Tet, Inside::Pressure),
        (Method::Quasistatic, 1, Shape::Bar, Inside::Pressure),
        (Method::ImplicitEuler, 2, Shape::Tet, Inside::Gas),
    ] {
        let case = Case { method, degree: 2, steps, dt: 0.02, body, inside };
        // a hundred shear moduli
        let firm = Numbers { law: [55e3, 5e3, 1.7e3, 6e6], ..NUMBERS };
        let problem = |p: &[f64]| {
            let law = std::array::from_fn(|k| p[k] * firm.law[k]);
            let (mut problem, _, _) = case.problem(&Numbers { law, ..firm });
            problem.energies.change(|_, own: &Elastic| {
                own.clone().with_mean_dilatation().expect("a law in invariants")
            });
            let workspace = Workspace::new(&problem);
            (problem, workspace)
        };
        // steps of a hundredth: those of a thousandth end at the residual of Newton's method
        let by = |g: &Gradient| vec![by_factors(g, Elastic::owner(0), &firm.law)];
        let run = |problem: &Problem, workspace: &mut Workspace, rest: &[Vec3]| {
            case.run(problem, workspace, rest, case.start(problem, rest))
        };
        let (rest, forces) = (case.bodies().0.vertices, false);
        Runs { problem: &problem, run: &run, forces }.check(&rest, &[1e-2], by);
    }
}
