//! Gradients of runs of blocks with fibres and threads.

use super::membrane::at_full_load;
use super::*;
use crate::energy::Isobaric;
use crate::energy::{Axis, Direction, Directions, Fibres, Profile, Winding, polyline};
use crate::material::fibre::Fibre;
use crate::material::{Lame, NeoHookean};

/// A block with gas around it, two families of fibres, and a thread on its top.
struct Reinforced {
    degree: usize,
    /// Pressure on the block: positive, it pulls [Pa].
    pressure: f64,
    /// Whether k₁ and the angle of the first family change along its axis.
    profiles: bool,
}

/// Control values of k₁ [Pa], from below the block to above it, and of the angle [rad].
const STIFFNESSES: [f64; 4] = [3e4, 9e4, 6e4, 4e4];
const ANGLES: [f64; 3] = [0.9, -0.4, 0.7];

/// Angle [rad] and stiffness of both families.
const FAMILIES: [(f64, f64); 2] = [(0.5, 6e4), (-0.9, 3e4)];
const STIFFNESS: f64 = 0.5;

impl Reinforced {
    fn mesh() -> TetMesh {
        let mut mesh = cube(2, 0.0);
        mesh.vertices.iter_mut().for_each(|v| *v *= 0.02);
        mesh
    }

    /// The numbers of the first family in the order of its parameters, then EA.
    fn values(&self) -> Vec<f64> {
        let [(angle, k1), _] = FAMILIES;
        if self.profiles {
            return [&STIFFNESSES[..], &[2.0, 0.05], &ANGLES, &[STIFFNESS]].concat();
        }
        vec![k1, 2.0, 0.05, angle, STIFFNESS]
    }

    /// The first family, by the numbers of its parameters.
    fn family(&self, values: &[f64], axis: Axis, slack: Option<f64>, count: usize) -> Fibres {
        let split = if self.profiles { STIFFNESSES.len() } else { 1 };
        let (stiffnesses, others) = values.split_at(split);
        let law = Fibre { k1: stiffnesses[0], k2: others[0], dispersion: others[1], slack };
        if !self.profiles {
            return Fibres::new(law, Direction::Helical(axis, others[2]), 0..count);
        }
        let profile = |values: &[f64]| Profile::new(axis, [-0.01, 0.03], values.to_vec());
        let angle = profile(&others[2..]).expect("it is good");
        Fibres::new(law, Directions::Twisting(angle), 0..count).with_stiffness(profile(stiffnesses))
    }

    /// With numbers relative to those of the case.
    fn problem(&self, by: &[f64]) -> (Problem, Workspace) {
        let mesh = Self::mesh();
        let boundary = topology::boundary(&mesh).facets;
        let TetMesh { vertices, tets } = mesh;
        let all = |f: &[usize; 3], z: f64| f.iter().all(|&v| (vertices[v].z - z).abs() < 1e-9);
        let top: Vec<_> = boundary.iter().filter(|f| all(f, 0.02)).copied().collect();
        let wall: Vec<_> =
            boundary.iter().filter(|f| !all(f, 0.0)).map(|&[a, b, c]| [a, c, b]).collect();
        let count = tets.len();
        let space = FunctionSpace::new(self.degree, vertices.len(), tets);
        let nodes = space.node_positions(&vertices);
        let fixed: Vec<bool> = nodes.iter().flat_map(|x| [x.z == 0.0; 3]).collect();
        let mut energies = Energies::elastic(Box::new(NeoHookean(Lame::new(5e4, 0.4))));
        // pressed together, fibres that carry tension only would do nothing
        let slack = (self.pressure > 0.0).then_some(0.2);
        let axis = Axis { point: Vec3::new(-0.01, 0.01, 0.0), along: Vec3::z() };
        let mut values = self.values();
        values.iter_mut().zip(by).for_each(|(value, by)| *value *= by);
        let stiffness = values.pop().expect("that of the thread");
        let family = self.family(&values, axis, slack, count);
        energies.extend([Term::of(Fibres::owner(0), family)]);
        let [_, (angle, k1)] = FAMILIES;
        let law = Fibre { k1, k2: 2.0, dispersion: 0.05, slack };
        energies = energies.with(Fibres::new(law, Direction::Helical(axis, angle), 0..count));
        let path = [[0.003, 0.004, 0.02], [0.016, 0.013, 0.02]].map(Vec3::from);
        let pieces = polyline(&top, &Self::mesh().vertices, &path).expect("it lies on the top");
        let numbers = [stiffness, 0.02, 0.1];
        let thread = Winding::new(&space, &pieces, numbers);
        energies.extend([Term::of(Winding::owner(0), thread)]);
        let gas = Box::new(Isobaric { pressure: self.pressure.into() });
        let wall = Wall::new(&space, &wall);
        energies = energies.with_chamber("around", Chamber::new(wall, gas));
        let problem = Problem::new(space, energies, &fixed);
        let workspace = Workspace::new(&problem);
        (problem, workspace)
    }

    fn check(&self) {
        let values = self.values();
        let (own, thread) = values.split_at(values.len() - 1);
        let by = |gradient: &Gradient| {
            let mut by = by_factors(gradient, Fibres::owner(0), own);
            by.push(gradient.parameters.total(Winding::owner(0))[0] * thread[0]);
            assert!(by.iter().all(|by| *by != 0.0), "{by:?}");
            vec![by]
        };
        let problem = |by: &[f64]| self.problem(by);
        let runs = Runs { problem: &problem, run: &at_full_load, forces: false };
        runs.check(&Self::mesh().vertices, &[1e-2], by);
    }
}

#[test]
fn bodies_with_fibres_and_threads_have_their_gradient() {
    for degree in [1, 2] {
        // blown up, and pressed together
        for pressure in [4e3, -4e3] {
            Reinforced { degree, pressure, profiles: false }.check();
        }
    }
}

/// By each control value of k₁ and of the angle, and by shape, which moves points along the axis.
#[test]
fn bodies_with_fibres_that_change_along_an_axis_have_their_gradient() {
    for degree in [1, 2] {
        Reinforced { degree, pressure: 4e3, profiles: true }.check();
    }
}
