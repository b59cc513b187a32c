use std::sync::Arc;

use mesh::{SurfaceMesh, Vec3};

use super::*;
use crate::contact::barrier::{Barrier, Form};
use crate::contact::density::Density;
use crate::contact::potential::Partners;
use crate::contact::surface::{Obstacle, Surface};
use crate::element::FunctionSpace;
use crate::energy::{Contact, Energies, Energy, FreeFlight, Inertia, TimeStep};
use crate::forward::stepping::{Failed, attempt};
use crate::forward::{Failure, LoadStep};
use crate::material::{Lame, NeoHookean};
use crate::math::linear::norm;
use crate::math::sparse::BlockMatrix;
use crate::testing::{check_gradient, cube, square};

const EDGE: f64 = 0.01;
/// Between the two cubes [m].
const GAP: f64 = 1e-3;
const NEWTON: Newton =
    Newton { iterations: 100, relative: 1e-10, absolute: 0.0, negligible: 0.0, ballooned: None };

/// A cube whose skin is moved up by `distance` [m], and a free one a millimetre above it, with inertia in a step of 0.1 s;
/// and a ceiling.
fn pusher(degree: usize, distance: f64, ceiling: f64) -> Pusher {
    let unit = cube(2, 0.1);
    let lift = Vec3::new(0.3 * GAP, 0.2 * GAP, EDGE + GAP);
    let upper = unit.vertices.iter().map(|v| EDGE * v + lift);
    let rest: Vec<Vec3> = unit.vertices.iter().map(|v| EDGE * v).chain(upper).collect();
    let count = unit.vertices.len();
    let mut tets = unit.tets.clone();
    tets.extend(unit.tets.iter().map(|t| t.map(|v| v + count)));
    let own = mesh::topology::boundary(&unit).facets;
    let mut facets = own.clone();
    facets.extend(own.iter().map(|f| f.map(|v| v + count)));
    let bodies: Vec<usize> = (0..facets.len()).map(|f| f / own.len()).collect();

    let space = FunctionSpace::new(degree, rest.len(), tets);
    let mut fixed = vec![false; 3 * space.node_count()];
    for node in own.iter().flat_map(|&f| space.facet_nodes(f)) {
        fixed[3 * node..3 * node + 3].fill(true);
    }
    let plate = |v: &Vec3| Vec3::new(0.1 * (v.x - 0.5), 0.1 * (v.y - 0.5), 2.0 * EDGE + ceiling);
    let surface = square(1, 0.0);
    let vertices = surface.vertices.iter().map(plate).collect();
    let obstacle = Obstacle { surface: SurfaceMesh { vertices, ..surface }, motion: None };
    let surface = Surface::new(&[], &space, &facets, &bodies, vec![obstacle], degree, &fixed);
    let (form, activation, stiffness) = (Form::Convergent, 2e-4, 1e5);
    let barrier = Barrier { form, density: Density::Log, activation, stiffness, thickness: 0.0 };
    let elements = 0..space.tets().len();
    let mut energies = Energies::elastic(Box::new(NeoHookean(Lame::new(1e5, 0.35))));
    let contact = Contact::new(Arc::new(surface), Partners::ThroughAir, barrier);
    energies = energies.with(Inertia::new(&space, 1e3, elements)).with(contact.certified());
    let still = vec![0.0; fixed.len()];
    let free_flight = Some(FreeFlight { at: still.clone(), square: 0.01 });
    let step = TimeStep { h: 0.1, history: still, free_flight, ..TimeStep::default() };
    let up: Vec<f64> = (0..fixed.len()).map(|d| if d % 3 == 2 { distance } else { 0.0 }).collect();
    let problem = Problem::new(space, energies, &fixed).with_displacement(&up);
    Pusher { workspace: Workspace::new(&problem), problem, rest, step: Arc::new(step) }
}

/// Two cubes in one time step.
struct Pusher {
    problem: Problem,
    workspace: Workspace,
    rest: Vec<Vec3>,
    step: Arc<TimeStep>,
}

impl Pusher {
    fn attempt(&mut self, u: &[f64]) -> Result<LoadStep, Failed> {
        let (rest, step, multipliers) = (&self.rest[..], Some(&self.step), Vec::new());
        let start =
            Configuration { rest, time: 0.0, step, u: u.to_vec(), multipliers, balanced_at: None };
        attempt(&self.problem, &mut self.workspace, &start, 1.0, &NEWTON)
    }
}

/// The ceiling leaves no room for both cubes.
#[test]
fn places_out_of_reach_are_given_up_with_everything_as_before() {
    let mut pusher = pusher(1, 2.0 * EDGE, 2.0 * GAP);
    let fixed = pusher.problem.dirichlet.fixed().to_vec();
    let count = pusher.problem.energies.iter().count();
    let zero = vec![0.0; pusher.problem.dofs()];
    let failed = pusher.attempt(&zero).err();
    let Some(Failed { failure: Failure::Blocked { free }, u, .. }) = failed else {
        panic!("it was not blocked");
    };
    assert!(free < 0.1 && u == zero, "{free}");
    let problem = &pusher.problem;
    assert!(problem.dirichlet.fixed() == fixed && problem.energies.iter().count() == count);
}

#[test]
fn springs_have_their_derivatives() {
    let Pusher { problem, mut workspace, rest, step } = pusher(2, GAP, 1.0);
    let u: Vec<f64> = (0..problem.dofs()).map(|d| 1e-4 * (d as f64).sin()).collect();
    let places = problem.dirichlet.displacement(1.0);
    let released = problem.with_fixed(&vec![false; u.len()]);
    let dofs: Vec<usize> = (0..u.len()).step_by(7).collect();
    let at = Iterate { step: Some(&step), ..released.iterate(&rest, &u, 1.0) };
    let springs = stiff_springs(&released, &mut workspace, &at, &dofs, &places);
    assert!(springs.each().iter().all(|s| s.stiffness > 0.0));
    let springs = springs.renewed(&u, 2.0);
    let value = |u: &[f64]| springs.value(&released.iterate(&rest, u, 1.0));
    let gradient = |u: &[f64]| {
        let mut gradient = vec![0.0; u.len()];
        springs.add_gradient(&released.iterate(&rest, u, 1.0), &mut gradient);
        gradient
    };
    check_gradient(&u, &gradient(&u), 1e-3, value);
    let nodes: Vec<usize> = (0..u.len() / 3).collect();
    let dense = crate::math::sparse::Pattern::new(nodes.len(), &nodes, nodes.len(), &[]);
    let mut matrix = BlockMatrix::zeros(&dense);
    springs.add_hessian(&at, Hessian::Exact, &mut matrix);
    // it is quadratic
    let by: Vec<f64> = gradient(&places).iter().zip(gradient(&u)).map(|(a, b)| a - b).collect();
    let to_places: Vec<f64> = places.iter().zip(&u).map(|(a, b)| a - b).collect();
    let off: Vec<f64> = matrix.multiply(&to_places).iter().zip(&by).map(|(a, b)| a - b).collect();
    assert!(norm(&off) < 1e-12 * norm(&by));
}
