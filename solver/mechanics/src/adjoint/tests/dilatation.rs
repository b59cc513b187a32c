//! Runs of bodies with mean dilatation: their gradients.

use super::*;

fn problem(case: &Case, numbers: &Numbers) -> (Problem, Workspace, Vec<Vec3>) {
    let (mut problem, _, rest) = case.problem(numbers);
    let own = &mut problem.energies.bodies[0];
    own.elastic = own.elastic.clone().with_mean_dilatation().expect("a law in invariants");
    let workspace = Workspace::new(&problem);
    (problem, workspace, rest)
}

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
        let (own, mut workspace, rest) = problem(&case, &firm);
        let start = case.start(&own, &rest);
        let run = case.run(&own, &mut workspace, &rest, start.clone());
        let probe = Probe::new(own.dofs(), false);
        let gradient = probe.gradient(&own, &mut workspace, &rest, &run);
        let value = |numbers: &Numbers, rest: &[Vec3]| {
            let (problem, mut workspace, _) = problem(&case, numbers);
            let run = case.run(&problem, &mut workspace, rest, start.clone());
            probe.value(&problem, rest, &run)
        };
        check_gradient(&flat(&rest), &gradient.rest, 2e-6, |x| value(&firm, &points(x)));
        let by = gradient.parameters.total(ParameterId::Material(0));
        let by: Vec<f64> = by.iter().zip(firm.law).map(|(g, c)| g * c).collect();
        // steps of a hundredth: those of a thousandth end at the residual of Newton's method
        check_gradient(&[1.0; 4], &by, 1e-2, |p| {
            let law = std::array::from_fn(|k| p[k] * firm.law[k]);
            value(&Numbers { law, ..firm }, &rest)
        });
    }
}
