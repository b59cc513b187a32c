//! Taylor tests of whole runs: small bodies that fall on each other, slide with friction
//! and are inflated.

use std::collections::BTreeMap;
use std::sync::Arc;

use mesh::{TetMesh, Vec3, topology};

use super::*;
use crate::contact::barrier::{Barrier, Form};
use crate::contact::density::Density;
use crate::contact::potential::Partners;
use crate::contact::surface::Surface;
use crate::element::FunctionSpace;
use crate::energy::{
    BodyForce, Chamber, Contact, Elastic, Energies, Friction, Inertia, Multiplier, Owner, Term,
    Wall,
};
use crate::forward::{Integrator, Method, Newton, Stepping, TimeStepper};
use crate::material::MooneyRivlin;
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::schedule::{Field, Schedule, Written};
use crate::testing::{check_gradient, cube, flat, points};

mod inside;
mod linearizations;
mod neighbours;
mod probe;
mod rigid;
mod viscous;

use inside::Inside;
use probe::{Probe, Runs, by_factors};

const TIGHT: Stepping = Stepping {
    first: 1.0,
    largest: 1.0,
    smallest: 1e-3,
    newton: Newton {
        iterations: 100,
        relative: 1e-13,
        absolute: 1e-13,
        negligible: 0.0,
        ballooned: None,
    },
};

/// Numbers that the energies are made with.
#[derive(Clone, Copy)]
struct Numbers {
    law: [f64; 4],
    density: f64,
    friction: f64,
    /// Pressure, or fill of a closed gas [Pa]; of a prescribed volume its change in
    /// [`CHANGE`], or its factor in [`FACTOR`].
    pressure: f64,
    stiffness: f64,
    gravity: [f64; 3],
}

const TINY: f64 = 1e6;
/// [m³/Pa]
const CHANGE: f64 = 1e-11;
/// [1/Pa]
const FACTOR: f64 = 3e-4;
/// No memory for states but the first: the others are read back from disk.
const ON_DISK: f64 = 0.0;

/// What is simulated.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// One element on one of its facets, with gas behind the others.
    Tet,
    /// A block with a chamber.
    Hollow,
    /// A block with a chamber, three times as long as it is wide.
    Bar,
    /// A block that hits another.
    Blocks,
}

const NUMBERS: Numbers = Numbers {
    law: [55e3, 5e3, 1.7e3, 1e6],
    density: 1000.0,
    friction: 0.5,
    pressure: 4e3,
    stiffness: 1e5,
    gravity: [2.0, 1.0, -9.8],
};

/// What is run.
struct Case {
    method: Method,
    degree: usize,
    steps: usize,
    dt: f64,
    body: Shape,
    inside: Inside,
}

/// The cube with its middle cell taken out, and the wall of the hole.
fn hollow() -> (TetMesh, Vec<[usize; 3]>) {
    let mut mesh = cube(3, 0.0);
    let middle = |t: &[usize; 4]| {
        let c = t.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 4.0;
        (c - Vec3::repeat(0.5)).amax() < 1.0 / 6.0
    };
    mesh.tets = mesh.tets.iter().filter(|t| !middle(t)).copied().collect();
    let inside =
        |f: &[usize; 3]| f.iter().all(|&v| (mesh.vertices[v] - Vec3::repeat(0.5)).amax() < 0.4);
    let wall = topology::boundary(&mesh).facets.into_iter().filter(inside).collect();
    (mesh, wall)
}

impl Case {
    /// Mesh [m], first tetrahedron of the second body, and a wall.
    fn bodies(&self) -> (TetMesh, usize, Vec<[usize; 3]>) {
        let size = 0.02;
        let alone = match self.body {
            Shape::Blocks => None,
            Shape::Tet => {
                let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.1, 1.1, 0.0], [0.3, 0.2, 0.9]];
                let mesh =
                    TetMesh { vertices: corners.map(Vec3::from).into(), tets: vec![[0, 1, 2, 3]] };
                let facets = topology::boundary(&mesh).facets.into_iter();
                let wall = facets.filter(|f| f.contains(&3)).map(|[a, b, c]| [a, c, b]).collect();
                Some((mesh, wall, 1.0))
            }
            Shape::Hollow => Some(hollow()).map(|(mesh, wall)| (mesh, wall, 1.0)),
            Shape::Bar => Some(hollow()).map(|(mesh, wall)| (mesh, wall, 3.0)),
        };
        if let Some((mesh, wall, long)) = alone {
            let stretch = Vec3::new(1.0, 1.0, long) * size;
            let vertices = mesh.vertices.iter().map(|v| v.component_mul(&stretch)).collect();
            return (TetMesh { vertices, ..mesh }, 0, wall);
        }
        let lower = cube(1, 0.0);
        let turn = nalgebra::Rotation3::from_euler_angles(0.02, -0.015, 0.01);
        // not above a diagonal, where closest points change their kind and forces bend
        let along = if self.degree > 1 { 0.04 } else { 0.03 };
        let lift = Vec3::new(along, 0.02, 1.045);
        let upper = lower.vertices.iter().map(|v| turn * v + lift);
        let rest: Vec<Vec3> =
            lower.vertices.iter().copied().chain(upper).map(|v| size * v).collect();
        let shifted = lower.tets.iter().map(|t| t.map(|v| v + 8));
        let tets: Vec<[usize; 4]> = lower.tets.iter().copied().chain(shifted).collect();
        (TetMesh { vertices: rest, tets }, 6, Vec::new())
    }

    /// What acts in full at the end of each step.
    fn steady(&self, value: f64) -> Schedule {
        let written = Written::from(value);
        written.schedule(&BTreeMap::new(), self.dt).expect("a number")
    }

    fn prescribes_volume(&self) -> bool {
        matches!(self.inside, Inside::Volume | Inside::Factor)
    }

    fn problem(&self, numbers: &Numbers) -> (Problem, Workspace, Vec<Vec3>) {
        let (mesh, upper, wall) = self.bodies();
        let TetMesh { vertices: rest, tets } = mesh.clone();
        let count = tets.len();
        let space = FunctionSpace::new(self.degree, rest.len(), tets);
        let nodes = space.node_positions(&rest);
        let fixed: Vec<bool> = nodes.iter().flat_map(|x| [x.z == 0.0; 3]).collect();
        let [c1, c2, c3, d1] = numbers.law;
        let law = MooneyRivlin { c1, c2, c3, d1 };
        let gravity = numbers.gravity.map(|g| g.to_string().parse().expect("fine"));
        let inertia = if self.method.has_inertia() {
            Some(Inertia::new(&space, numbers.density, 0..count))
        } else {
            self.hits().then(|| Inertia::tiny(&space, TINY * numbers.density, upper..count))
        };
        let weight = BodyForce::weight(Field(gravity), numbers.density, 0..count);
        let mut energies = Energies::elastic(Box::new(law));
        energies.extend([Term::of(BodyForce::weight_owner(0), weight)]);
        energies.extend(inertia.map(|inertia| Term::of(Inertia::owner(0), inertia)));
        if !wall.is_empty() {
            let number = numbers.pressure;
            let gas = inside::gas(self, number);
            let memory = gas.remembers().map(|_| 0);
            let multiplier = self.prescribes_volume().then_some(0);
            let chamber = Chamber::new(Wall::new(&space, &wall), gas);
            let chamber = Chamber { multiplier, memory, ..chamber };
            energies = energies.with_chamber("hole", chamber);
        }
        let held = !wall.is_empty() && self.prescribes_volume();
        let penalty = 10.0 * 2.0 * (numbers.law[0] + numbers.law[1]) / 3e-7;
        let multipliers =
            if held { vec![Multiplier { pressure: 0.0, penalty }] } else { Vec::new() };
        if self.hits() {
            let contact = self.barrier(&mesh, &space, &fixed).with_stiffness(numbers.stiffness);
            let surface = Arc::clone(contact.surface());
            let friction = Friction::new(surface, numbers.friction, 0.05);
            energies.extend([Term::of(Contact::OWNER, contact)]);
            energies.extend([Term::of(Friction::OWNER, friction)]);
        }
        let problem = Problem::new(space, energies, &fixed).with_multipliers(multipliers);
        let workspace = Workspace::new(&problem);
        (problem, workspace, rest)
    }

    fn hits(&self) -> bool {
        self.body == Shape::Blocks
    }

    fn barrier(&self, mesh: &TetMesh, space: &FunctionSpace, fixed: &[bool]) -> Contact {
        let facets = topology::boundary(mesh).facets;
        let bodies: Vec<usize> = facets.iter().map(|f| usize::from(f[0] >= 8)).collect();
        let surface = Surface::new(&[], space, &facets, &bodies, Vec::new(), self.degree, fixed);
        let (form, thickness) = (Form::Convergent, 0.0);
        // both barriers are tried
        let smooth = matches!(self.method, Method::Newmark | Method::GeneralizedAlpha);
        let density = if smooth { Density::LogSquared } else { Density::Log };
        let barrier =
            Barrier { form, density, activation: 1.2e-3, stiffness: NUMBERS.stiffness, thickness };
        Contact::new(Arc::new(surface), Partners::ThroughAir, barrier)
    }

    fn run(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        start: State,
    ) -> Trajectory {
        let times: Vec<f64> = (1..=self.steps).map(|n| self.dt * n as f64).collect();
        let mut stepper = TimeStepper::new(TIGHT, Integrator::new(self.method, start));
        let run = stepper.run(problem, workspace, rest, &times, ON_DISK, |_| ());
        run.expect("an equilibrium")
    }

    /// At rest, the upper body in motion.
    fn start(&self, problem: &Problem, rest: &[Vec3]) -> State {
        let mut v = vec![0.0; problem.dofs()];
        if self.hits() && self.method.has_inertia() {
            for (node, x) in problem.space.node_positions(rest).iter().enumerate() {
                if x.z > 0.0205 {
                    v[3 * node..3 * node + 3].copy_from_slice(&[0.15, 0.05, -0.3]);
                }
            }
        }
        State::new(vec![0.0; problem.dofs()], v)
    }
}

/// Largest number of pairs of nearly parallel edges that repel each other in a step.
fn mollified_pairs(problem: &Problem, rest: &[Vec3], run: &Trajectory) -> usize {
    let contact = problem.energies.contact().expect("bodies that hit");
    let at =
        |n: usize| contact.mollified_pairs(&problem.iterate(rest, &run.state(n).u, run.times[n]));
    (1..=run.steps()).map(at).max().unwrap_or(0)
}

fn check(case: &Case, forces: bool) {
    let (problem, _, rest) = case.problem(&NUMBERS);
    let start = case.start(&problem, &rest);
    let with = |p: &[f64]| {
        let numbers = Numbers {
            law: std::array::from_fn(|k| NUMBERS.law[k] * p[k]),
            density: NUMBERS.density * p[4],
            friction: NUMBERS.friction * p[5],
            pressure: NUMBERS.pressure * p[6],
            stiffness: NUMBERS.stiffness * p[7],
            gravity: std::array::from_fn(|k| NUMBERS.gravity[k] * p[8 + k]),
        };
        let (problem, workspace, _) = case.problem(&numbers);
        (problem, workspace)
    };
    let run = |problem: &Problem, workspace: &mut Workspace, rest: &[Vec3]| {
        case.run(problem, workspace, rest, start.clone())
    };
    let chamber = problem.energies.chambers().map(|(id, _)| id.owner()).next();
    let by = |gradient: &Gradient| {
        let of = |id: Owner| gradient.parameters.total(id);
        let one = |id: Owner| of(id).first().copied().unwrap_or(0.0);
        let mut by = by_factors(gradient, Elastic::owner(0), &NUMBERS.law);
        let heavier = if case.method.has_inertia() { 1.0 } else { TINY };
        let by_density = one(BodyForce::weight_owner(0)) + heavier * one(Inertia::owner(0));
        by.push(by_density * NUMBERS.density);
        by.push(one(Friction::OWNER) * NUMBERS.friction);
        by.push(chamber.map_or(0.0, one) * case.by_pressure() * NUMBERS.pressure);
        by.push(one(Contact::OWNER) * NUMBERS.stiffness);
        let falls = of(BodyForce::weight_owner(0)).into_iter().skip(1);
        by.extend(falls.zip(NUMBERS.gravity).map(|(by, g)| by * g));
        vec![by]
    };
    // quadratic surfaces have more contacts that come and go
    let size = if case.hits() && case.degree > 1 { 0.125 } else { 1.0 };
    // without contact the remainder of a smaller change is lost in rounding
    let part = if case.hits() { 1e-3 } else { 8e-3 };
    let runs = Runs { problem: &with, run: &run, forces, moves: |_| true };
    let (problem, run, gradient) = runs.check(&rest, 2e-6 * size, &[part * size], by);
    if case.hits() {
        assert!(mollified_pairs(&problem, &rest, &run) > 0, "no edges are nearly parallel");
        let size = |n: usize| -> f64 {
            run.step(&problem, &rest, n).lagged_contacts.iter().map(|s| s.force.abs()).sum()
        };
        let with_friction = (1..=case.steps).filter(|&n| size(n) > 0.0).count();
        assert!(case.steps == 1 || with_friction > 0, "there is no friction");
    }
    if !case.method.has_inertia() {
        return;
    }
    // the start, of what can move
    let free = |g: &[f64]| -> Vec<f64> {
        let fixed = problem.dirichlet.fixed();
        g.iter().zip(fixed).map(|(g, fixed)| if *fixed { 0.0 } else { *g }).collect()
    };
    let probe = Probe::new(problem.dofs(), forces);
    let value = |from: State| {
        let (problem, mut workspace, _) = case.problem(&NUMBERS);
        let run = case.run(&problem, &mut workspace, &rest, from);
        probe.value(&problem, &rest, &run)
    };
    let [of_u, of_v] = if case.hits() { [1e-6, 1e-3] } else { [2e-4, 0.2] };
    check_gradient(&start.v, &free(&gradient.start.v), size * of_v, |v| {
        value(State::new(start.u.clone(), free(v)))
    });
    check_gradient(&start.u, &free(&gradient.start.u), size * of_u, |u| {
        value(State::new(free(u), start.v.clone()))
    });
}

#[test]
fn a_chamber_alone_has_its_gradient_with_any_formula() {
    // a formula is the same for one element as for many
    for (method, degree, steps, body, inside) in [
        (Method::Quasistatic, 1, 1, Shape::Tet, Inside::Pressure),
        (Method::Quasistatic, 2, 1, Shape::Tet, Inside::Pressure),
        (Method::Quasistatic, 1, 2, Shape::Tet, Inside::Gas),
        (Method::Quasistatic, 1, 1, Shape::Tet, Inside::Volume),
        (Method::ImplicitEuler, 1, 1, Shape::Tet, Inside::Gas),
        (Method::ImplicitEuler, 1, 3, Shape::Tet, Inside::Pressure),
        (Method::ImplicitEuler, 2, 2, Shape::Tet, Inside::Pressure),
        (Method::ImplicitEuler, 1, 2, Shape::Tet, Inside::Factor),
        (Method::Bdf2, 1, 2, Shape::Tet, Inside::Pressure),
        (Method::Bdf2, 1, 4, Shape::Tet, Inside::Gas),
        (Method::Bdf3, 1, 5, Shape::Tet, Inside::Pressure),
        (Method::Newmark, 1, 4, Shape::Tet, Inside::Pressure),
        (Method::GeneralizedAlpha, 1, 4, Shape::Tet, Inside::Pressure),
        (Method::ImplicitEuler, 1, 3, Shape::Tet, Inside::CheckedSupply),
        (Method::Quasistatic, 1, 1, Shape::Hollow, Inside::Volume),
        (Method::Quasistatic, 1, 3, Shape::Hollow, Inside::Supply),
        (Method::Bdf2, 2, 2, Shape::Bar, Inside::Gas),
    ] {
        check(&Case { method, degree, steps, dt: 0.02, body, inside }, false);
    }
}

#[test]
fn bodies_that_hit_and_slide_have_their_gradient() {
    let (method, body, inside) = (Method::ImplicitEuler, Shape::Blocks, Inside::Pressure);
    check(&Case { method, degree: 1, steps: 2, dt: 2e-3, body, inside }, true);
}

#[test]
fn quadratic_bodies_that_hit_and_slide_have_their_gradient() {
    let (method, body, inside) = (Method::Bdf2, Shape::Blocks, Inside::Pressure);
    // its first step is one of implicit Euler
    check(&Case { method, degree: 2, steps: 3, dt: 2e-3, body, inside }, true);
}

#[test]
fn without_inertia_bodies_that_hit_and_slide_have_their_gradient() {
    let (method, body, inside) = (Method::Quasistatic, Shape::Blocks, Inside::Pressure);
    check(&Case { method, degree: 1, steps: 4, dt: 0.25, body, inside }, true);
}
