//! Fibres in a cube: derivatives, lanes, and what does not depend on them.

use super::*;
use crate::energy::elements::tests::{Case, check_lanes};
use crate::energy::{Energy, Hessian};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::testing::{check_gradient, cube};

/// A cube of a degree with random displacements, in two cells a side.
fn case(degree: usize, size: f64) -> Case {
    Case::new(cube(2, 0.2), degree, &mut Random::new(41), size)
}

impl Case {
    /// Families of all kinds in all but the first elements. The slack is wide, so that its curvature is
    /// seen by steps of the Taylor test.
    fn families(&self) -> Vec<Fibres> {
        let axis =
            Axis { point: Vec3::new(-0.4, 1.3, 0.2), along: Vec3::new(2.0, -1.0, 2.0) / 3.0 };
        let law = Fibre { k1: 2e5, k2: 3.0, dispersion: 0.1, slack: Some(0.2) };
        let elements = 5..self.space.tets().len();
        let along = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let new = |law: Fibre, direction| {
            Fibres::new(law, Directions::Formula(direction), elements.clone())
        };
        let turned = |e: usize| Direction::Helical(axis, 0.1 * e as f64).at(Vec3::zeros());
        let by_element = elements.clone().map(turned).collect();
        vec![
            new(law, Direction::Constant(along)),
            new(Fibre { slack: None, ..law }, Direction::Helical(axis, 0.6)),
            new(Fibre { k2: 0.0, dispersion: 0.0, ..law }, Direction::Helical(axis, -1.0)),
            new(Fibre { dispersion: 0.25, ..law }, Direction::Radial(axis)),
            Fibres::new(law, Directions::Elements(by_element), elements.clone()),
        ]
    }
}

#[test]
fn derivatives_pass_the_taylor_test() {
    for degree in [1, 2, 3] {
        let case = case(degree, 0.03);
        case.families().iter().for_each(|family| case.check_derivatives(family, 3e-4));
    }
}

#[test]
fn parameters_have_their_derivatives() {
    let case = case(2, 0.03);
    let (u, rest, weights) = (&case.u, &case.rest, case.weights());
    for family in case.families() {
        let mut by = family.parameter_vjp(&case.at(u, rest), &weights);
        by[0] *= family.law.k1;
        let with = |x: &[f64]| {
            let Fibre { k1, k2, dispersion, slack } = family.law;
            let law = Fibre {
                k1: k1 * (1.0 + x[0]),
                k2: k2 + x[1],
                dispersion: dispersion + x[2],
                slack,
            };
            let direction = match &family.directions {
                Directions::Formula(Direction::Helical(axis, angle)) => {
                    Direction::Helical(*axis, angle + x[3]).into()
                }
                other => other.clone(),
            };
            Fibres::new(law, direction, family.elements())
        };
        check_gradient(&[0.0; 4], &by, 1e-2, |x| dot(&weights, &case.gradient(&with(x), u, rest)));
        let turns = matches!(family.directions, Directions::Formula(Direction::Helical(..)));
        assert_eq!(by[3] != 0.0, turns, "{by:?}");
    }
}

#[test]
fn projected_hessians_are_positive_semidefinite() {
    // some fibres are so compressed that the exact Hessian is not
    let case = case(2, 0.06);
    let mut indefinite = 0;
    for family in case.families() {
        let exact = case.smallest(&family, Hessian::Exact);
        assert!(exact > -1e-12 || family.law.slack.is_none(), "{exact}");
        indefinite += usize::from(exact < -1e-6);
        let projected = case.smallest(&family, Hessian::Projected);
        assert!(projected > -1e-12, "{projected}");
    }
    assert_eq!(indefinite, 1, "the family that carries compression");
}

#[test]
fn bits_are_the_same_for_any_number_of_lanes() {
    let case = case(2, 0.05);
    for fibres in &case.families() {
        check_lanes(fibres, &case.at(&case.u, &case.rest));
    }
}

/// At κ = 1/3 no direction is preferred, and a rotation changes nothing.
#[test]
fn energy_is_objective_and_of_full_dispersion_isotropic() {
    let case = case(2, 0.03);
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let places = case.space.node_positions(&case.rest);
    let turned = places.iter().enumerate().flat_map(|(i, x)| {
        let u: Vec3 = turn * (x + at(&case.u, i)) - x;
        [u.x, u.y, u.z]
    });
    let turned: Vec<f64> = turned.collect();
    for mut family in case.families() {
        let value = family.value(&case.at(&case.u, &case.rest));
        let other = family.value(&case.at(&turned, &case.rest));
        assert!((other / value - 1.0).abs() < 1e-11, "{value} {other}");
        family.law.dispersion = 1.0 / 3.0;
        let value = family.value(&case.at(&case.u, &case.rest));
        family.directions = Direction::Constant(Vec3::z()).into();
        let other = family.value(&case.at(&case.u, &case.rest));
        assert!((other / value - 1.0).abs() < 1e-12, "{value} {other}");
    }
}

/// Stretched by λ along x, fibres along it are stretched as much, and pull by 2 k₁ (λ² − 1) λ.
#[test]
fn measures_are_those_of_a_homogeneous_stretch() {
    let mut case = case(2, 0.0);
    let places = case.space.node_positions(&case.rest);
    case.u = places.iter().flat_map(|x| [0.1 * x.x, -0.2 * x.y, 0.0]).collect();
    let iterate = case.at(&case.u, &case.rest);
    let law = Fibre { k1: 1e5, k2: 0.0, dispersion: 0.0, slack: Some(1e-3) };
    let all = 0..case.space.tets().len();
    let along = |axis: Vec3| Fibres::new(law, Direction::Constant(axis), all.clone());
    let found = along(Vec3::x()).summary(&iterate);
    let strain = 1.21 - 1.0;
    assert!((found.volume - 1.0).abs() < 1e-12 && found.taut == 1.0, "{found:?}");
    assert!((found.stretch[0] - 1.1).abs() < 1e-12 && (found.stretch[1] - 1.1).abs() < 1e-12);
    assert!((found.stress / (2.0 * 1e5 * strain * 1.1) - 1.0).abs() < 1e-12, "{found:?}");
    let energy = 0.5 * 1e5 * (strain * strain - 0.3e-6);
    assert!((found.energy / energy - 1.0).abs() < 1e-12, "{found:?}");
    let mean = along(Vec3::x()).means(&iterate)[3];
    assert!((mean.direction - Vec3::x()).norm() < 1e-12 && (mean.stretch - 1.1).abs() < 1e-12);
    let slack = along(Vec3::y()).summary(&iterate);
    assert_eq!((slack.energy, slack.stress, slack.taut), (0.0, 0.0, 0.0));
    assert!((slack.stretch[0] - 0.8).abs() < 1e-12, "{slack:?}");
}
