//! Runs that take longer: more steps, other formulas, bodies of many elements.

use super::*;

#[test]
#[ignore = "half a minute: runs in make test-all; one element with each formula stays"]
fn a_chamber_of_many_elements_has_its_gradient_with_any_formula() {
    let case = |method, steps, body, inside| {
        let (degree, dt) = (1, 0.02);
        check(&Case { method, degree, steps, dt, body, inside }, false);
    };
    case(Method::GeneralizedAlpha, 3, Shape::Hollow, Inside::Gas);
    case(Method::Newmark, 3, Shape::Hollow, Inside::Factor);
    for inside in [Inside::Pressure, Inside::Gas, Inside::Factor, Inside::Supply] {
        case(Method::EnergyMomentum, 3, Shape::Hollow, inside);
    }
    case(Method::ImplicitEuler, 2, Shape::Hollow, Inside::Factor);
    case(Method::Bdf2, 2, Shape::Hollow, Inside::Gas);
    case(Method::Bdf2, 4, Shape::Hollow, Inside::Supply);
    case(Method::GeneralizedAlpha, 3, Shape::Hollow, Inside::Supply);
}

#[test]
#[ignore = "runs in make test-all; fewer steps of the same bodies stay"]
fn longer_runs_and_other_formulas_have_their_gradient() {
    let case = |method, degree, steps| {
        let (dt, body, inside) = (2e-3, Shape::Blocks, Inside::Pressure);
        check(&Case { method, degree, steps, dt, body, inside }, true);
    };
    case(Method::ImplicitEuler, 1, 5);
    case(Method::ImplicitEuler, 1, 10);
    case(Method::Newmark, 1, 4);
    case(Method::GeneralizedAlpha, 1, 3);
    case(Method::EnergyMomentum, 1, 4);
    case(Method::ImplicitEuler, 2, 3);
    case(Method::Bdf2, 2, 4);
}
