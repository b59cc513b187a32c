//! Fibres in a cube: derivatives, lanes, and what does not depend on them.

use super::*;
use crate::element::at;
use crate::energy::elements::tests::check_lanes;
use crate::energy::tests::{Case, Sample};
use crate::energy::{Energy, Hessian};
use crate::math::random::Random;
use crate::testing::cube;

fn profile(axis: Axis, heights: [f64; 2], values: &[f64]) -> Profile {
    Profile::new(axis, heights, values.to_vec()).expect("it is good")
}

/// A cube of a degree with random displacements, in two cells a side.
fn case(degree: usize, size: f64) -> Case {
    Case::new(cube(2, 0.2), degree, &mut Random::new(41), size)
}

/// The numbers of a family in the order of its derivatives by them.
fn numbers(family: &Fibres) -> Vec<f64> {
    let Fibre { k1, k2, dispersion, .. } = family.law;
    let mut numbers = family.stiffness.as_ref().map_or(vec![k1], |k1| k1.values().to_vec());
    numbers.extend([k2, dispersion]);
    match &family.directions {
        Directions::Formula(Direction::Helical(_, angle)) => numbers.push(*angle),
        Directions::Twisting(angle) => numbers.extend(angle.values()),
        _ => numbers.resize(numbers.len() + family.counts()[1], 0.0),
    }
    numbers
}

/// A family with other numbers.
fn with_numbers(family: &Fibres, numbers: &[f64]) -> Fibres {
    let along = |of: &Profile, values: &[f64]| profile(*of.axis(), of.heights(), values);
    let (k1, others) = numbers.split_at(family.counts()[0]);
    let law = Fibre { k1: k1[0], k2: others[0], dispersion: others[1], ..family.law };
    let directions = match &family.directions {
        Directions::Formula(Direction::Helical(axis, _)) => {
            Direction::Helical(*axis, others[2]).into()
        }
        Directions::Twisting(angle) => Directions::Twisting(along(angle, &others[2..])),
        other => other.clone(),
    };
    let stiffness = family.stiffness.as_ref().map(|of| along(of, k1));
    Fibres::new(law, directions, family.elements()).with_stiffness(stiffness)
}

/// Families of all kinds in elements of all degrees.
pub fn samples() -> Vec<Sample> {
    let mut samples = Vec::new();
    for degree in [1, 2, 3] {
        let case = Arc::new(case(degree, 0.03));
        for (kind, family) in case.families().into_iter().enumerate() {
            samples.push(Sample {
                name: format!("fibres {kind} P{degree}"),
                case: Arc::clone(&case),
                sizes: [3e-4; 2],
                numbers: numbers(&family),
                term: Box::new(move |numbers| Box::new(with_numbers(&family, numbers))),
            });
        }
    }
    samples
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
        // both reach beyond the cube, so that no point passes an end where the slope jumps
        let stiffness = profile(axis, [-0.5, 2.5], &[2e5, 3e5, 1e5, 4e5, 2e5]);
        let angle = profile(axis, [0.0, 2.2], &[0.6, -0.2, 1.0]);
        let turned = |e: usize| Direction::Helical(axis, 0.1 * e as f64).at(Vec3::zeros());
        let by_element: Arc<[Vec3]> = elements.clone().map(turned).collect();
        vec![
            new(law, Direction::Constant(along)),
            new(Fibre { slack: None, ..law }, Direction::Helical(axis, 0.6)),
            new(Fibre { k2: 0.0, dispersion: 0.0, ..law }, Direction::Helical(axis, -1.0)),
            new(Fibre { dispersion: 0.25, ..law }, Direction::Radial(axis)),
            Fibres::new(law, Directions::Elements(Arc::clone(&by_element)), elements.clone()),
            Fibres::new(law, Directions::Twisting(angle), elements.clone())
                .with_stiffness(Some(stiffness.clone())),
            Fibres::new(law, Directions::Elements(by_element), elements.clone())
                .with_stiffness(Some(stiffness)),
        ]
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
        (family.law.dispersion, family.stiffness) = (1.0 / 3.0, None);
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

/// Along the axis of a slab of the depth 1, stretched by λ, fibres have the energy ∫ ½ k₁(z) (λ² − 1)² dz. Of degree 3
/// the integral of a B-spline over all of its range is the mean of its values, each with a quarter of its knots;
/// here of one piece, where all count alike. Threshold, set before: 1e-12, as quadrature is exact.
#[test]
fn energy_of_a_stiffness_along_an_axis_is_its_integral() {
    for degree in [1, 2] {
        let mut case = case(degree, 0.0);
        let places = case.space.node_positions(&case.rest);
        case.u = places.iter().flat_map(|x| [0.0, 0.0, 0.1 * x.z]).collect();
        let iterate = case.at(&case.u, &case.rest);
        let axis = Axis { point: Vec3::new(0.3, 0.4, 0.0), along: Vec3::z() };
        let law = Fibre { k1: 1.0, k2: 0.0, dispersion: 0.0, slack: None };
        let all = 0..case.space.tets().len();
        let family = Fibres::new(law, Direction::Constant(Vec3::z()), all);
        let values = [1e5, 3e5, 8e5, 2e5];
        let family = family.with_stiffness(Some(profile(axis, [0.0, 1.0], &values)));
        let mean = values.iter().sum::<f64>() / 4.0;
        let exact = 0.5 * mean * 0.21_f64.powi(2);
        assert!((family.value(&iterate) / exact - 1.0).abs() < 1e-12);
    }
}
