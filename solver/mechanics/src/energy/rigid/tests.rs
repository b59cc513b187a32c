//! Derivatives of the terms of a rigid part, and that it costs nothing to turn it.

use mesh::Vec3;
use nalgebra::Rotation3;

use super::*;
use crate::element::FunctionSpace;
use crate::energy::{FreeFlight, TimeStep};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::sparse::Pattern;
use crate::rigid::Moves;
use crate::testing::{check_gradient, cube};

/// A block with one face that is rigid, or all of it.
struct Case {
    space: FunctionSpace,
    rest: Vec<Vec3>,
    part: RigidSet,
}

impl Case {
    fn new(whole: bool) -> Self {
        let mesh = cube(2, 0.1);
        let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets);
        let positions = space.node_positions(&mesh.vertices);
        let inside = |&n: &usize| whole || (positions[n].z - 1.0).abs() < 1e-9;
        let nodes: Vec<usize> = (0..space.node_count()).filter(inside).collect();
        let part = RigidSet::new(&nodes, &positions, Moves::Freely).expect("nodes");
        Self { space, rest: mesh.vertices, part }
    }

    fn positions(&self) -> Vec<Vec3> {
        self.space.node_positions(&self.rest)
    }

    fn at<'a>(&'a self, u: &'a [f64], step: Option<&'a TimeStep>) -> Iterate<'a> {
        Iterate { step, ..Iterate::new(&self.space, &self.rest, u, 0.7) }
    }

    /// Turned and shifted, with some noise.
    fn moved(&self, noise: f64) -> Vec<f64> {
        let turn = Rotation3::from_euler_angles(0.7, -0.4, 1.9);
        let mut random = Random::new(3);
        let place = |x: Vec3| turn * x - x + Vec3::new(0.1, 0.5, -0.3) + noise * random.vector();
        self.positions().into_iter().map(place).flat_map(<[f64; 3]>::from).collect()
    }

    fn gradient(&self, term: &dyn Energy, at: &Iterate) -> Vec<f64> {
        let mut gradient = vec![0.0; 3 * self.space.node_count()];
        term.add_gradient(at, &mut gradient);
        gradient
    }

    fn times_hessian(&self, term: &dyn Energy, at: &Iterate, kind: Hessian, q: &[f64]) -> Vec<f64> {
        let (nodes, each) = (self.space.element_nodes(), self.space.nodes_per_element());
        let couplings = term.couplings(at, 1.0);
        let pattern = Pattern::new(self.space.node_count(), nodes, each, &couplings);
        let mut matrix = BlockMatrix::zeros(&pattern);
        term.add_hessian(at, kind, &mut matrix);
        matrix.multiply(q)
    }

    fn check(&self, term: &dyn Energy, u: &[f64], step: Option<&TimeStep>) {
        let gradient = self.gradient(term, &self.at(u, step));
        check_gradient(u, &gradient, 1e-4, |u| term.value(&self.at(u, step)));
        let q = Random::new(4).numbers(u.len());
        let product = self.times_hessian(term, &self.at(u, step), Hessian::Exact, &q);
        check_gradient(u, &product, 1e-4, |u| dot(&self.gradient(term, &self.at(u, step)), &q));
    }
}

#[test]
fn stiffness_and_inertia_have_their_derivatives() {
    for whole in [true, false] {
        let case = Case::new(whole);
        let rigid = Rigid::new(&case.part, &case.positions(), 2.0);
        let u = case.moved(0.2);
        case.check(&rigid, &u, None);
        let q = Random::new(9).numbers(u.len());
        let at = case.at(&u, None);
        let curvature = dot(&q, &case.times_hessian(&rigid, &at, Hessian::Projected, &q));
        assert!(curvature > 0.0);
        let share = |x: Vec3| MassPoint {
            share: 0.25,
            weights: case.part.weights_at(x).expect("on the part"),
        };
        let points: Vec<_> =
            case.part.masters().iter().map(|&m| share(case.positions()[m])).collect();
        let mass = RigidMass::new(&case.part, 3.0, &points);
        let flight = FreeFlight { at: case.moved(0.1), square: 0.04 };
        let step = TimeStep { free_flight: Some(flight), ..TimeStep::default() };
        let gradient = case.gradient(&mass, &case.at(&u, Some(&step)));
        check_gradient(&u, &gradient, 1e-4, |u| mass.value(&case.at(u, Some(&step))));
        // its gradient is linear
        let moved: Vec<f64> = u.iter().zip(&q).map(|(u, q)| u + q).collect();
        let change = case.gradient(&mass, &case.at(&moved, Some(&step)));
        let product = case.times_hessian(&mass, &case.at(&u, Some(&step)), Hessian::Exact, &q);
        for ((after, before), product) in change.iter().zip(&gradient).zip(product) {
            assert!((after - before - product).abs() < 1e-9);
        }
    }
}

#[test]
fn the_rotation_of_a_part_is_known() {
    for whole in [true, false] {
        let case = Case::new(whole);
        let rigid = Rigid::new(&case.part, &case.positions(), 2.0);
        let expected = Rotation3::from_euler_angles(0.7, -0.4, 1.9).scaled_axis();
        assert!((rigid.rotation(&case.moved(0.0)) - expected).norm() < 1e-9);
    }
}

/// A turned part has no energy; one that is stretched by d about ½ k d².
#[test]
fn only_strains_cost_energy() {
    for whole in [true, false] {
        let case = Case::new(whole);
        let rigid = Rigid::new(&case.part, &case.positions(), 2.0);
        let turned = rigid.value(&case.at(&case.moved(0.0), None));
        let stretched: Vec<f64> =
            case.positions().into_iter().flat_map(|x| [0.01 * x.x, 0.0, 0.0]).collect();
        let stretched = rigid.value(&case.at(&stretched, None));
        assert!(turned < 1e-9 * stretched, "{turned} {stretched}");
        let extent = case.part.extents().iter().copied().fold(0.0, f64::max);
        let (k, d) = (STIFFNESS * 2.0 * extent, 0.01 * extent);
        let ratio = stretched / (0.5 * k * d * d);
        assert!((0.5..2.5).contains(&ratio), "{ratio}");
    }
}

/// A moment has its derivatives, and works by the angle where the part turns about its axis.
#[test]
fn a_moment_works_by_the_angle() {
    for whole in [true, false] {
        let case = Case::new(whole);
        let moment = Field([0.3, -0.2, 0.5].map(Schedule::held));
        let term = RigidMoment::new(&case.part, &case.positions(), moment).expect("levers");
        case.check(&term, &case.moved(0.05), None);
        for (axis, share) in [0.3, -0.2, 0.5].into_iter().enumerate() {
            let unit = nalgebra::Unit::new_unchecked(Vec3::ith(axis, 1.0));
            let turn = Rotation3::from_axis_angle(&unit, 1.3);
            let u: Vec<f64> =
                case.positions().iter().flat_map(|x| <[f64; 3]>::from(turn * x - x)).collect();
            let work = -term.value(&case.at(&u, None));
            assert!((work - share * 1.3).abs() < 1e-12, "{axis}: {work}");
        }
    }
}

/// A straight part has no extent across its own axis.
#[test]
fn a_line_cannot_be_turned_about_itself() {
    let points: Vec<Vec3> = (0..5).map(|i| Vec3::new(0.0, 0.0, f64::from(i))).collect();
    let part = RigidSet::new(&[0, 1, 2, 3, 4], &points, Moves::Freely).expect("nodes");
    let about = |axis: usize| {
        let mut moment = Field([0.0; 3].map(Schedule::from));
        moment.0[axis] = Schedule::from(1.0);
        RigidMoment::new(&part, &points, moment)
    };
    assert!(about(0).is_ok());
    assert_eq!(about(2).err(), Some(NoLever { axis: 2 }));
}
