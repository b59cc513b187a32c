//! Blocks with a rigid top: what it bears, how it swings, and gradients of its runs.

use super::*;
use crate::energy::{MassPoint, Rigid, RigidLoad, RigidMass};
use crate::material::{Lame, NeoHookean};
use crate::rigid::{Moves, RigidSet};
use crate::stability::{ArcLength, Continuation};

/// Edge of the block [m].
const EDGE: f64 = 0.02;
/// Shear modulus [Pa].
const SHEAR: f64 = 5e4;
/// Young's modulus [Pa].
const YOUNG: f64 = 1.5e5;

/// A block on a fixed bottom, of which the top is rigid.
struct Topped {
    degree: usize,
    method: Method,
    steps: usize,
    moves: Moves,
}

impl Topped {
    fn mesh() -> TetMesh {
        let mut mesh = cube(2, 0.2);
        mesh.vertices.iter_mut().for_each(|v| *v *= EDGE);
        mesh
    }

    /// With a mass [kg] and a force [N] on the top, and a factor on the modulus.
    fn problem(&self, mass: f64, force: [f64; 3], factor: f64) -> (Problem, Workspace) {
        let TetMesh { vertices, tets } = Self::mesh();
        let space = FunctionSpace::new(self.degree, vertices.len(), tets);
        let nodes = space.node_positions(&vertices);
        let guided = |x: &Vec3| self.moves == Moves::InPlane(0) && (x.z - EDGE).abs() < 1e-9;
        let held = |x: &Vec3| [x.z == 0.0 || guided(x), x.z == 0.0, x.z == 0.0];
        let fixed: Vec<bool> = nodes.iter().flat_map(held).collect();
        let top: Vec<usize> =
            (0..nodes.len()).filter(|&n| (nodes[n].z - EDGE).abs() < 1e-9).collect();
        let part = RigidSet::new(&top, &nodes, self.moves).expect("nodes");
        let center = Vec3::new(0.5 * EDGE, 0.4 * EDGE, EDGE);
        let weights = part.weights_at(center).expect("on the top");
        let gravity = Field(["0", "0", "-9.8"].map(|g| g.parse::<Schedule>().expect("a number")));
        let force = Field(force.map(Schedule::from));
        let corners = [[0.0, 0.0], [EDGE, 0.0], [0.0, EDGE], [EDGE, EDGE]];
        let corner = |[x, y]: [f64; 2]| MassPoint {
            share: 0.25,
            weights: part.weights_at(Vec3::new(x, y, EDGE)).expect("on the top"),
        };
        let points: Vec<_> = corners.into_iter().map(corner).collect();
        let law = NeoHookean(Lame::new(YOUNG * factor, 0.45));
        let mut energies = Energies::elastic(Box::new(law));
        if self.method.has_inertia() {
            energies = energies.with(Inertia::new(&space, 1000.0, 0..space.tets().len()));
        }
        let inertia = self.method.has_inertia();
        let stiffness = (part.masters().len() > 1).then(|| Rigid::new(&part, &nodes, SHEAR));
        let own = inertia.then(|| RigidMass::new(&part, mass, &points));
        let load = RigidLoad::new(&part, weights, force, gravity, mass);
        energies.extend(stiffness.map(|own| Term::of(Rigid::owner(0), own)));
        energies.extend(own.map(|own| Term::of(RigidMass::owner(0), own)));
        energies.extend([Term::of(RigidLoad::owner(0), load)]);
        let problem = Problem::new(space, energies, &fixed).with_rigid(&[part]);
        let workspace = Workspace::new(&problem);
        (problem, workspace)
    }

    fn run(&self, problem: &Problem, workspace: &mut Workspace, rest: &[Vec3]) -> Trajectory {
        let zero = vec![0.0; problem.dofs()];
        let integrator = Integrator::new(self.method, State::new(zero.clone(), zero));
        let dt = if self.method.has_inertia() { 2e-3 } else { 1.0 };
        let times: Vec<f64> = (1..=self.steps).map(|n| dt * n as f64).collect();
        let mut stepper = TimeStepper::new(TIGHT, integrator);
        stepper.run(problem, workspace, rest, &times, ON_DISK, |_| ()).expect("a run")
    }

    /// Positions of the nodes of the top at rest and in the last state [m].
    fn top(&self, problem: &Problem, rest: &[Vec3], run: &Trajectory) -> Vec<[Vec3; 2]> {
        let nodes = problem.space.node_positions(rest);
        let top = nodes.iter().enumerate().filter(|(_, x)| (x.z - EDGE).abs() < 1e-9);
        top.map(|(n, x)| [*x, x + crate::element::at(&run.last(), n)]).collect()
    }
}

/// Under a force beside its middle the top turns without strain.
#[test]
fn a_rigid_top_stays_as_it_is() {
    for degree in [1, 2] {
        let case = Topped { degree, method: Method::Quasistatic, steps: 1, moves: Moves::Freely };
        let rest = Topped::mesh().vertices;
        let (problem, mut workspace) = case.problem(0.2, [3.0, 1.0, -2.0], 1.0);
        let run = case.run(&problem, &mut workspace, &rest);
        let top = case.top(&problem, &rest, &run);
        let (mut moved, mut strain) = (0.0_f64, 0.0_f64);
        for [x, now_x] in &top {
            moved = moved.max((now_x - x).norm());
            for [y, now_y] in &top {
                let length = (x - y).norm();
                if length > 0.0 {
                    strain = strain.max(((now_x - now_y).norm() / length - 1.0).abs());
                }
            }
        }
        assert!(moved > 0.1 * EDGE, "{moved}");
        assert!(strain < 1e-4, "{strain}");
    }
}

/// A top that cannot turn under a force has the state of one that is moved as far.
#[test]
fn a_top_that_cannot_turn_is_that_of_a_moved_support() {
    let case = Topped { degree: 2, method: Method::Quasistatic, steps: 1, moves: Moves::Straight };
    let rest = Topped::mesh().vertices;
    let (problem, mut workspace) = case.problem(0.0, [1.0, 0.5, 2.0], 1.0);
    let run = case.run(&problem, &mut workspace, &rest);
    let [x, now] = case.top(&problem, &rest, &run)[0];
    let motion = now - x;
    let nodes = problem.space.node_positions(&rest);
    let held = |x: &Vec3| x.z == 0.0 || (x.z - EDGE).abs() < 1e-9;
    let fixed: Vec<bool> = nodes.iter().flat_map(|x| [held(x); 3]).collect();
    let moved: Vec<f64> =
        nodes.iter().flat_map(|x| if x.z > 0.0 { motion.into() } else { [0.0; 3] }).collect();
    let space = FunctionSpace::new(2, rest.len(), Topped::mesh().tets);
    let elastic = problem.energies.terms().filter(|term| term.downcast::<Elastic>().is_some());
    let elastic = elastic.cloned().collect();
    let held = Problem::new(space, elastic, &fixed).with_displacement(&moved);
    let other = case.run(&held, &mut Workspace::new(&held), &rest);
    let (run, other) = (run.last(), other.last());
    let off = run.iter().zip(other.iter()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9 * motion.norm());
}

/// A path by arc length leads to the state that the load leads to, followers and all.
#[test]
fn a_path_carries_a_rigid_top_along() {
    let case = Topped { degree: 1, method: Method::Quasistatic, steps: 1, moves: Moves::Freely };
    let (problem, mut workspace) = case.problem(0.2, [3.0, 1.0, -2.0], 1.0);
    let rest = Topped::mesh().vertices;
    let run = case.run(&problem, &mut workspace, &rest);
    let zero = vec![0.0; problem.dofs()];
    let integrator = Integrator::new(Method::Quasistatic, State::new(zero.clone(), zero));
    let mut stepper = TimeStepper::new(TIGHT, integrator);
    let path = ArcLength { first: 0.2, largest: 0.5, smallest: 1e-3, end: 1.0 };
    let mut follower = Continuation::new(path);
    let mut workspace = Workspace::new(&problem);
    let end = loop {
        let step = follower.next(&mut stepper, &problem, &mut workspace, &rest).expect("a state");
        if step.ends_time_step {
            break step;
        }
    };
    let last = run.last();
    let size = last.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let off = end.u.iter().zip(last.iter()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-8 * size);
}

/// Where pressures alone grow, the force and the weight of a part stay.
#[test]
fn the_load_of_a_held_part_does_not_grow() {
    let case = Topped { degree: 1, method: Method::Quasistatic, steps: 1, moves: Moves::Freely };
    let (problem, _) = case.problem(0.2, [3.0, 1.0, -2.0], 1.0);
    let rest = Topped::mesh().vertices;
    let u: Vec<f64> = Random::new(2).numbers(problem.dofs()).iter().map(|x| 1e-4 * x).collect();
    let at = |problem: &Problem, time: f64| problem.gradient(&problem.iterate(&rest, &u, time)).0;
    let mut grows = problem.clone();
    grows.energies.change(|_, own: &RigidLoad| {
        let mut load = own.clone();
        load.force.0[0] = "3*t".parse().expect("an expression");
        load
    });
    let held = grows.with_scaled_pressures(1.0, &[]);
    assert_eq!(at(&held, 1.0), at(&grows, 1.0));
    assert_eq!(at(&held, 2.5), at(&held, 1.0));
    assert_ne!(at(&grows, 2.5), at(&grows, 1.0));
}

/// By the material, the mass and the force, and by the rest shape of what is not rigid.
#[test]
fn runs_with_a_rigid_top_have_their_gradients() {
    for (degree, method, steps, moves) in [
        (1, Method::Quasistatic, 1, Moves::Freely),
        (2, Method::Quasistatic, 2, Moves::Freely),
        (1, Method::GeneralizedAlpha, 4, Moves::Freely),
        (1, Method::ImplicitEuler, 3, Moves::InPlane(0)),
        (1, Method::Newmark, 3, Moves::Straight),
    ] {
        let case = Topped { degree, method, steps, moves };
        let rest = Topped::mesh().vertices;
        let numbers = [0.2, 3.0, 1.0, -2.0];
        let problem = |factors: &[f64]| {
            let [mass, x, y, z] = std::array::from_fn(|i| numbers[i] * factors[i]);
            case.problem(mass, [x, y, z], factors[4])
        };
        let run = |problem: &Problem, workspace: &mut Workspace, rest: &[Vec3]| {
            case.run(problem, workspace, rest)
        };
        let by = |gradient: &Gradient| -> Vec<Vec<f64>> {
            let load = gradient.parameters.total(RigidLoad::owner(0));
            let inertia = gradient.parameters.total(RigidMass::owner(0));
            let mass = load[0] + inertia.first().copied().unwrap_or(0.0);
            let by = [mass, load[1], load[2], load[3]].into_iter().zip(numbers);
            let by_law = gradient.parameters.total(Elastic::owner(0))[0] * YOUNG;
            vec![by.map(|(by, number)| by * number).chain([by_law]).collect()]
        };
        let moves = |x: Vec3| (x.z - EDGE).abs() > 1e-9;
        Runs { problem: &problem, run: &run, forces: false, moves }.check(&rest, 2e-6, &[1e-3], by);
    }
}

/// A rigid block around the origin, free or hanging on one of its edges, of which the nodes come last; with gravity
/// downwards [m/s²].
fn rigid_block(hangs: bool, gravity: f64) -> (Problem, Vec<Vec3>, Vec<usize>) {
    let TetMesh { vertices, tets } = cube(2, 0.0);
    let rest: Vec<Vec3> = vertices.iter().map(|v| EDGE * (v - Vec3::repeat(0.5))).collect();
    let space = FunctionSpace::new(1, rest.len(), tets);
    let all: Vec<usize> = (0..rest.len()).collect();
    let is_held = |&n: &usize| hangs && rest[n].x < -0.499 * EDGE && rest[n].z > 0.499 * EDGE;
    let edge: Vec<usize> = all.iter().copied().filter(is_held).collect();
    let fixed: Vec<bool> = all.iter().flat_map(|n| [edge.contains(n); 3]).collect();
    let part = match hangs {
        true => RigidSet::hinged(&all, &edge, &rest, Moves::Freely),
        false => RigidSet::new(&all, &rest, Moves::Freely),
    };
    let part = part.expect("nodes");
    let mut energies = Energies::elastic(Box::new(NeoHookean(Lame::new(YOUNG, 0.4))));
    let [none, down] = [0.0, -gravity].map(|g| Field([0.0, 0.0, g].map(Schedule::held)));
    let middle = part.weights_at(Vec3::zeros()).expect("inside");
    energies = energies
        .with(Inertia::new(&space, 1000.0, 0..space.tets().len()))
        .with(Rigid::new(&part, &rest, SHEAR))
        .with(RigidLoad::new(&part, middle, none, down, 1000.0 * EDGE.powi(3)));
    (Problem::new(space, energies, &fixed).with_rigid(&[part]), rest, edge)
}

/// A free block that spins about its axis for 1000 steps keeps its momentum, energy and speed, and flies on.
#[test]
fn a_spinning_rigid_block_keeps_its_momentum_and_energy() {
    let (turns_per_second, dt, steps) = (2.0, 1e-3, 1000);
    let spin = Vec3::new(0.0, 0.0, std::f64::consts::TAU * turns_per_second);
    let flight = Vec3::new(0.03, -0.01, 0.02);
    let (problem, rest, _) = rigid_block(false, 0.0);
    let inertia = problem.energies.each::<Inertia>().next().expect("of the body").clone();
    let mut workspace = Workspace::new(&problem);
    let velocity: Vec<f64> =
        rest.iter().flat_map(|x| <[f64; 3]>::from(spin.cross(x) + flight)).collect();
    let kinetic = |v: &[f64]| inertia.kinetic_energy(&problem.space, &rest, v);
    let momentum = |v: &[f64]| inertia.momentum(&problem.space, &rest, v);
    let start = State::new(vec![0.0; problem.dofs()], velocity.clone());
    let mut stepper = TimeStepper::new(TIGHT, Integrator::new(Method::GeneralizedAlpha, start));
    for n in 1..=steps {
        let end = dt * f64::from(n);
        stepper.advance(&problem, &mut workspace, &rest, end, |_| ()).expect("a step");
    }
    let state = stepper.progress.integrator.last();
    let off = (momentum(&state.v) - momentum(&velocity)).norm();
    assert!(off < 1e-8 * momentum(&velocity).norm(), "{off}");
    // the first step is one of implicit Euler, which takes a part ω²Δt² of the energy
    let first = (spin.norm() * dt).powi(2);
    let lost = 1.0 - kinetic(&state.v) / kinetic(&velocity);
    assert!((0.0..2.0 * first).contains(&lost), "{lost} {first}");
    let time = dt * f64::from(steps);
    let turn = nalgebra::Rotation3::new(time * spin);
    for (n, x) in rest.iter().enumerate() {
        let expected = turn * x + time * flight;
        let found = x + crate::element::at(&state.u, n);
        assert!((found - expected).norm() < 0.02 * EDGE, "{found} {expected}");
    }
}

/// A block that hangs on one of its edges and swings from 45°: θ'' = −(m g d / I) sin θ with d = a/√2, I = ⅔ m a².
#[test]
fn a_rigid_block_swings_as_a_pendulum() {
    let (gravity, dt, steps) = (9.81, 5e-4, 800);
    let (problem, rest, edge) = rigid_block(true, gravity);
    let mut workspace = Workspace::new(&problem);
    let start = State::new(vec![0.0; problem.dofs()], vec![0.0; problem.dofs()]);
    let mut stepper = TimeStepper::new(TIGHT, Integrator::new(Method::GeneralizedAlpha, start));
    // the same by the classical method of Runge and Kutta
    let rate = 0.75 * 2.0_f64.sqrt() * gravity / EDGE;
    let slope = |[angle, speed]: [f64; 2]| [speed, -rate * angle.sin()];
    let add = |a: [f64; 2], h: f64, b: [f64; 2]| [a[0] + h * b[0], a[1] + h * b[1]];
    let mut expected = [0.25 * std::f64::consts::PI, 0.0];
    let mut farthest = 0.0_f64;
    for n in 1..=steps {
        let end = dt * f64::from(n);
        stepper.advance(&problem, &mut workspace, &rest, end, |_| ()).expect("a step");
        let k1 = slope(expected);
        let k2 = slope(add(expected, 0.5 * dt, k1));
        let k3 = slope(add(expected, 0.5 * dt, k2));
        let k4 = slope(add(expected, dt, k3));
        expected = add(add(expected, dt / 6.0, k1), dt / 3.0, k2);
        expected = add(add(expected, dt / 3.0, k3), dt / 6.0, k4);
        let u = &stepper.progress.integrator.last().u;
        let corner = |n: usize| rest[n] + crate::element::at(u, n);
        let hangs = corner((0..rest.len()).find(|&n| rest[n].norm() < 1e-9).expect("a middle"))
            - corner(edge[0]);
        let angle = hangs.x.atan2(-hangs.z);
        farthest = farthest.max((angle - expected[0]).abs());
        assert!(edge.iter().all(|&n| crate::element::at(u, n).norm() < 1e-12), "the hinge stays");
    }
    // more than two periods
    assert!(farthest < 0.02, "{farthest} rad");
}
