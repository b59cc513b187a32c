//! Derivatives of the terms of a rigid part, and that it costs nothing to turn it.

use std::sync::Arc;

use mesh::Vec3;
use nalgebra::Rotation3;

use super::*;
use crate::energy::tests::{Case, Sample};
use crate::energy::{FreeFlight, TimeStep};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::rigid::Moves;
use crate::schedule::Schedule;
use crate::testing::cube;

/// A block with one face that is rigid, or all of it.
struct Block {
    case: Case,
    part: RigidSet,
}

impl Block {
    /// Turned and shifted, with some noise.
    fn new(whole: bool, noise: f64) -> Self {
        let mut case = Case::new(cube(2, 0.1), 2, &mut Random::new(3), 0.0);
        let positions = case.space.node_positions(&case.rest);
        let inside = |&n: &usize| whole || (positions[n].z - 1.0).abs() < 1e-9;
        let nodes: Vec<usize> = (0..case.space.node_count()).filter(inside).collect();
        let part = RigidSet::new(&nodes, &positions, Moves::Freely).expect("nodes");
        case.u = moved(&positions, noise);
        let flight = FreeFlight { at: moved(&positions, 0.1), square: 0.04 };
        case.step = Some(TimeStep { free_flight: Some(flight), ..TimeStep::default() });
        Self { case, part }
    }

    fn positions(&self) -> Vec<Vec3> {
        self.case.space.node_positions(&self.case.rest)
    }

    fn stiffness(&self) -> Rigid {
        Rigid::new(&self.part, &self.positions(), 2.0)
    }

    fn mass(&self) -> RigidMass {
        let positions = self.positions();
        let point = |&m: &usize| MassPoint {
            share: 0.25,
            weights: self.part.weights_at(positions[m]).expect("on the part"),
        };
        let points: Vec<_> = self.part.masters().iter().map(point).collect();
        RigidMass::new(&self.part, 3.0, &points)
    }

    fn moment(&self) -> RigidMoment {
        let moment = Field([0.3, -0.2, 0.5].map(Schedule::held));
        RigidMoment::new(&self.part, &self.positions(), moment).expect("levers")
    }

    fn at<'a>(&'a self, u: &'a [f64]) -> Iterate<'a> {
        self.case.at(u, &self.case.rest)
    }
}

fn moved(positions: &[Vec3], noise: f64) -> Vec<f64> {
    let turn = Rotation3::from_euler_angles(0.7, -0.4, 1.9);
    let mut random = Random::new(3);
    let mut place = |x: &Vec3| turn * x - x + Vec3::new(0.1, 0.5, -0.3) + noise * random.vector();
    positions.iter().flat_map(|x| <[f64; 3]>::from(place(x))).collect()
}

/// Stiffness, mass and moment of a part and of a whole body.
pub fn samples() -> Vec<Sample> {
    let mut samples = Vec::new();
    for whole in [true, false] {
        let block = Block::new(whole, 0.2);
        let (stiffness, mass, moment) = (block.stiffness(), block.mass(), block.moment());
        let near = Arc::new(Block::new(whole, 0.05).case);
        let far = Arc::new(block.case);
        let mut add = |name: &str, case: &Arc<Case>, term: Box<dyn Fn() -> Box<dyn Energy>>| {
            samples.push(Sample {
                name: format!("{name}, whole: {whole}"),
                case: Arc::clone(case),
                sizes: [1e-4; 2],
                numbers: Vec::new(),
                term: Box::new(move |_| term()),
            });
        };
        add("stiffness", &far, Box::new(move || Box::new(stiffness.clone())));
        add("mass", &far, Box::new(move || Box::new(mass.clone())));
        add("moment", &near, Box::new(move || Box::new(moment.clone())));
    }
    samples
}

#[test]
fn the_projected_hessian_is_positive() {
    for whole in [true, false] {
        let block = Block::new(whole, 0.2);
        let q = Random::new(9).numbers(block.case.u.len());
        let product = block.case.times_hessian(&block.stiffness(), Hessian::Projected, &q);
        assert!(dot(&q, &product) > 0.0);
    }
}

#[test]
fn the_rotation_of_a_part_is_known() {
    for whole in [true, false] {
        let block = Block::new(whole, 0.0);
        let expected = Rotation3::from_euler_angles(0.7, -0.4, 1.9).scaled_axis();
        assert!((block.stiffness().rotation(&block.case.u) - expected).norm() < 1e-9);
    }
}

/// A turned part has no energy; one that is stretched by d about ½ k d².
#[test]
fn only_strains_cost_energy() {
    for whole in [true, false] {
        let case = Block::new(whole, 0.0);
        let rigid = case.stiffness();
        let turned = rigid.value(&case.case.here());
        let stretched: Vec<f64> =
            case.positions().into_iter().flat_map(|x| [0.01 * x.x, 0.0, 0.0]).collect();
        let stretched = rigid.value(&case.at(&stretched));
        assert!(turned < 1e-9 * stretched, "{turned} {stretched}");
        let extent = case.part.extents().iter().copied().fold(0.0, f64::max);
        let (k, d) = (STIFFNESS * 2.0 * extent, 0.01 * extent);
        let ratio = stretched / (0.5 * k * d * d);
        assert!((0.5..2.5).contains(&ratio), "{ratio}");
    }
}

/// A moment works by the angle where the part turns about its axis.
#[test]
fn a_moment_works_by_the_angle() {
    for whole in [true, false] {
        let case = Block::new(whole, 0.0);
        let term = case.moment();
        for (axis, share) in [0.3, -0.2, 0.5].into_iter().enumerate() {
            let unit = nalgebra::Unit::new_unchecked(Vec3::ith(axis, 1.0));
            let turn = Rotation3::from_axis_angle(&unit, 1.3);
            let u: Vec<f64> =
                case.positions().iter().flat_map(|x| <[f64; 3]>::from(turn * x - x)).collect();
            let work = -term.value(&case.at(&u));
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
