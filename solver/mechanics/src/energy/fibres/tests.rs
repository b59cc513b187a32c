//! Fibres in a cube: derivatives, lanes, and what does not depend on them.

use super::*;
use crate::element::FunctionSpace;
use crate::math::lanes::{Scalar, WithSimd};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::sparse::Pattern;
use crate::testing::{check_gradient, cube, flat, points};

/// A cube of a degree with random displacements, in two cells a side.
struct Case {
    space: FunctionSpace,
    rest: Vec<Vec3>,
    u: Vec<f64>,
}

impl Case {
    fn new(degree: usize, size: f64) -> Self {
        let mesh = cube(2, 0.2);
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let numbers = Random::new(41).numbers(3 * space.node_count());
        Self { space, rest: mesh.vertices, u: numbers.iter().map(|x| size * x).collect() }
    }

    fn at<'a>(&'a self, u: &'a [f64], rest: &'a [Vec3]) -> Iterate<'a> {
        Iterate { space: &self.space, rest, u, time: 1.0, multipliers: &[], step: None }
    }

    fn gradient(&self, energy: &dyn Energy, u: &[f64], rest: &[Vec3]) -> Vec<f64> {
        let mut gradient = vec![0.0; u.len()];
        energy.add_gradient(&self.at(u, rest), &mut gradient);
        gradient
    }

    /// The Hessian times vectors.
    fn products<'a>(
        &self,
        energy: &dyn Energy,
        kind: Hessian,
        by: impl Iterator<Item = &'a [f64]>,
    ) -> Vec<Vec<f64>> {
        let n = self.space.nodes_per_element();
        let pattern = Pattern::new(self.space.node_count(), self.space.element_nodes(), n, &[]);
        let mut hessian = BlockMatrix::zeros(&pattern);
        energy.add_hessian(&self.at(&self.u, &self.rest), kind, &mut hessian);
        by.map(|by| hessian.multiply(by)).collect()
    }

    fn weights(&self) -> Vec<f64> {
        Random::new(33).numbers(self.u.len())
    }

    /// Families of all kinds in all but the first elements. The slack is wide, so that its curvature is
    /// seen by steps of the Taylor test.
    fn families(&self) -> Vec<Fibres> {
        let axis =
            Axis { point: Vec3::new(-0.4, 1.3, 0.2), along: Vec3::new(2.0, -1.0, 2.0) / 3.0 };
        let law = Fibre { k1: 2e5, k2: 3.0, dispersion: 0.1, slack: Some(0.2) };
        let elements = 5..self.space.tets().len();
        let along = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let new = |law: Fibre, direction: Direction| Fibres::new(law, direction, elements.clone());
        vec![
            new(law, Direction::Constant(along)),
            new(Fibre { slack: None, ..law }, Direction::Helical(axis, 0.6)),
            new(Fibre { k2: 0.0, dispersion: 0.0, ..law }, Direction::Helical(axis, -1.0)),
            new(Fibre { dispersion: 0.25, ..law }, Direction::Radial(axis)),
        ]
    }
}

#[test]
fn derivatives_pass_the_taylor_test() {
    for degree in [1, 2, 3] {
        let case = Case::new(degree, 0.03);
        let (u, rest, weights) = (&case.u, &case.rest, case.weights());
        for family in case.families() {
            let gradient = case.gradient(&family, u, rest);
            check_gradient(u, &gradient, 3e-4, |u| family.value(&case.at(u, rest)));
            let by = [&weights[..]].into_iter();
            let product = case.products(&family, Hessian::Exact, by).remove(0);
            let weighed =
                |u: &[f64], rest: &[Vec3]| dot(&weights, &case.gradient(&family, u, rest));
            check_gradient(u, &product, 3e-4, |u| weighed(u, rest));
            let mut mixed = vec![0.0; 3 * rest.len()];
            family.add_mixed_vjp(&case.at(u, rest), &weights, &mut mixed);
            check_gradient(&flat(rest), &mixed, 3e-4, |x| weighed(u, &points(x)));
        }
    }
}

#[test]
fn parameters_have_their_derivatives() {
    let case = Case::new(2, 0.03);
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
            let direction = match family.direction {
                Direction::Helical(axis, angle) => Direction::Helical(axis, angle + x[3]),
                other => other,
            };
            Fibres::new(law, direction, family.elements())
        };
        check_gradient(&[0.0; 4], &by, 1e-2, |x| dot(&weights, &case.gradient(&with(x), u, rest)));
        let turns = matches!(family.direction, Direction::Helical(..));
        assert_eq!(by[3] != 0.0, turns, "{by:?}");
    }
}

#[test]
fn projected_hessians_are_positive_semidefinite() {
    // some fibres are so compressed that the exact Hessian is not
    let case = Case::new(2, 0.06);
    let mut indefinite = 0;
    for family in case.families() {
        let smallest = |kind: Hessian| {
            let unit = nalgebra::DMatrix::<f64>::identity(case.u.len(), case.u.len());
            let units = unit.as_slice().chunks_exact(case.u.len());
            let columns = case.products(&family, kind, units).into_iter();
            let columns = columns.map(nalgebra::DVector::from_vec);
            let dense = nalgebra::DMatrix::from_columns(&columns.collect::<Vec<_>>());
            let eigenvalues = dense.symmetric_eigenvalues();
            eigenvalues.min() / eigenvalues.amax()
        };
        let exact = smallest(Hessian::Exact);
        assert!(exact > -1e-12 || family.law.slack.is_none(), "{exact}");
        indefinite += usize::from(exact < -1e-6);
        let projected = smallest(Hessian::Projected);
        assert!(projected > -1e-12, "{projected}");
    }
    assert_eq!(indefinite, 1, "the family that carries compression");
}

#[test]
fn bits_are_the_same_for_any_number_of_lanes() {
    let case = Case::new(2, 0.05);
    let iterate = &case.at(&case.u, &case.rest);
    for fibres in &case.families() {
        let elements = fibres.elements();
        let values = || Values::<10> { fibres, iterate, elements: elements.clone() };
        assert_eq!(values().with_simd(Scalar).to_bits(), widest(values()).to_bits());
        let hessians = |wide: bool| {
            let mut blocks = vec![[0.0; 9]; elements.len() * pair_count(10)];
            let (kind, out) = (Hessian::Exact, &mut blocks);
            let elements = elements.clone();
            let work = Hessians::<10> { fibres, iterate, kind, elements, blocks: out };
            if wide {
                widest(work)
            } else {
                work.with_simd(Scalar)
            }
            blocks
        };
        assert_eq!(hessians(false), hessians(true));
        let gradients = |wide: bool| {
            let mut out = vec![Vec3::zeros(); elements.len() * 10];
            let elements = elements.clone();
            let work = Gradients::<10> { fibres, iterate, elements, out: &mut out };
            if wide {
                widest(work)
            } else {
                work.with_simd(Scalar)
            }
            out
        };
        assert_eq!(gradients(false), gradients(true));
    }
}

/// At κ = 1/3 no direction is preferred, and a rotation changes nothing.
#[test]
fn energy_is_objective_and_of_full_dispersion_isotropic() {
    let case = Case::new(2, 0.03);
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
        family.direction = Direction::Constant(Vec3::z());
        let other = family.value(&case.at(&case.u, &case.rest));
        assert!((other / value - 1.0).abs() < 1e-12, "{value} {other}");
    }
}

/// Stretched by λ along x, fibres along it are stretched as much, and pull by 2 k₁ (λ² − 1) λ.
#[test]
fn measures_are_those_of_a_homogeneous_stretch() {
    let mut case = Case::new(2, 0.0);
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
