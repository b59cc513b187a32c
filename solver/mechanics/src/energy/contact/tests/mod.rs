use std::ops::{Deref, DerefMut};

use mesh::{SurfaceMesh, TetMesh};

use super::*;
use crate::contact::barrier::Form;
use crate::contact::density::Density;
use crate::contact::surface::{Motion, Obstacle};
use crate::contact::terms::Term;
use crate::element::{FunctionSpace, at};
use crate::energy::TimeStep;
use crate::energy::tests::Case;
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::symmetry::Plane;
use crate::testing::{check_gradient, cube, flat, points, square};

mod friction;
mod rest;
mod symmetry;
mod weights;

/// Bodies with contact, at a displacement.
struct Scene {
    case: Case,
    contact: Contact,
}

impl Deref for Scene {
    type Target = Case;

    fn deref(&self) -> &Case {
        &self.case
    }
}

impl DerefMut for Scene {
    fn deref_mut(&mut self) -> &mut Case {
        &mut self.case
    }
}

impl Scene {
    fn new(
        degree: usize,
        meshes: &[TetMesh],
        obstacles: Vec<Obstacle>,
        barrier: Barrier,
        skin: impl Fn([Vec3; 3]) -> bool,
    ) -> Self {
        Self::cut_by(&[], degree, meshes, obstacles, barrier, skin)
    }

    fn cut_by(
        planes: &[Plane],
        degree: usize,
        meshes: &[TetMesh],
        obstacles: Vec<Obstacle>,
        barrier: Barrier,
        skin: impl Fn([Vec3; 3]) -> bool,
    ) -> Self {
        let (mut rest, mut tets) = (Vec::new(), Vec::new());
        let (mut facets, mut bodies) = (Vec::new(), Vec::new());
        for (body, mesh) in meshes.iter().enumerate() {
            let offset = rest.len();
            rest.extend(&mesh.vertices);
            tets.extend(mesh.tets.iter().map(|t| t.map(|v| v + offset)));
            let own = mesh::topology::boundary(mesh).facets;
            let own: Vec<_> = own.into_iter().map(|f| f.map(|v| v + offset)).collect();
            facets.extend(own.into_iter().filter(|f| skin(f.map(|v| rest[v]))));
            bodies.resize(facets.len(), body);
        }
        let space = FunctionSpace::new(degree, rest.len(), tets);
        let u = vec![0.0; 3 * space.node_count()];
        let fixed = vec![false; u.len()];
        let surface = Surface::new(planes, &space, &facets, &bodies, obstacles, degree, &fixed);
        let contact = Contact::new(Arc::new(surface), Partners::ThroughAir, barrier);
        Self { case: Case { space, rest, u, step: None }, contact }
    }

    /// Gradient, Hessian and mixed derivative against differences.
    fn check(&self, energy: &dyn Energy, scale: f64) {
        let gradient = self.gradient(energy, &self.u, &self.rest);
        check_gradient(&self.u, &gradient, 1e-3 * scale, |u| energy.value(&self.at(u, &self.rest)));

        let mut random = Random::new(5);
        let lambda = random.numbers(self.u.len());
        let shifted = |x: &[f64], q: &[f64], h: f64| -> Vec<f64> {
            x.iter().zip(q).map(|(x, q)| x + h * q).collect()
        };
        let (h, close) = (2e-7 * scale, |difference: f64, exact: f64, what: &str| {
            let error = (difference - exact).abs() / exact.abs();
            assert!(error < 1e-6, "{what}: {difference:e} against {exact:e}, {error:e}");
        });
        for along in [gradient, random.numbers(self.u.len())] {
            let largest = along.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let q: Vec<f64> = along.iter().map(|v| v / largest).collect();
            let by_u = |h: f64| self.gradient(energy, &shifted(&self.u, &q, h), &self.rest);
            let difference: Vec<f64> =
                by_u(h).iter().zip(by_u(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect();
            let exact = self.times_hessian(energy, Hessian::Exact, &q);
            close(dot(&difference, &q), dot(&exact, &q), "hessian along its direction");
            let error = shifted(&difference, &exact, -1.0);
            let relative = (dot(&error, &error) / dot(&exact, &exact)).sqrt();
            assert!(relative < 1e-6, "hessian: {relative:e}");
        }

        let mut mixed = vec![0.0; 3 * self.rest.len()];
        energy.add_mixed_vjp(&self.here(), &lambda, &mut mixed);
        let largest = mixed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if largest == 0.0 {
            return;
        }
        let along = mixed.iter().map(|v| v / largest).collect();
        for q in [along, random.numbers(mixed.len()), random.numbers(mixed.len())] {
            let by_rest = |h: f64| {
                let rest = points(&shifted(&flat(&self.rest), &q, h));
                dot(&self.gradient(energy, &self.u, &rest), &lambda)
            };
            close((by_rest(h) - by_rest(-h)) / (2.0 * h), dot(&mixed, &q), "mixed");
        }
    }
}

fn barrier(form: Form, activation: f64) -> Barrier {
    let stiffness = if form == Form::Plain { 1e5 / activation.powi(4) } else { 1e5 };
    Barrier { form, density: Density::Log, activation, stiffness, thickness: 0.0 }
}

/// A block of n³ cells whose flat skin is near a floor of two triangles, and away from its edges.
fn on_floor(n: usize, motion: Option<Box<Motion>>) -> Scene {
    let place = |v: &Vec3| Vec3::new(20.0 * v.x - 2.0, 20.0 * v.y - 15.0, -0.006);
    let floor = square(1, 0.0);
    let vertices = floor.vertices.iter().map(place).collect();
    let obstacle = Obstacle { surface: SurfaceMesh { vertices, ..floor }, motion };
    let low = |x: [Vec3; 3]| x.iter().all(|x| x.z == 0.0);
    let barrier = barrier(Form::Convergent, 0.01);
    Scene::new(1, &[cube(n, 0.2)], vec![obstacle], barrier, low)
}

/// A block on another, turned by so little that their edges are mollified, and a
/// large plate beside them; touching in a thousand ways.
fn blocks(degree: usize, form: Form, scale: f64, thickness: f64) -> Scene {
    // the more features, the nearer one is to where closest points change their kind
    let lower = cube(if degree < 3 { 2 } else { 1 }, 0.1);
    let mut upper = lower.clone();
    let turn = nalgebra::Rotation3::from_euler_angles(0.02, -0.015, 0.01);
    let lift = Vec3::new(0.06, 0.05, 1.06 + thickness);
    upper.vertices.iter_mut().for_each(|v| *v = turn * *v + lift);
    let mut meshes = [lower, upper];
    meshes.iter_mut().flat_map(|m| &mut m.vertices).for_each(|v| *v *= scale);
    let plate = |v: &Vec3| Vec3::new(-0.05 - thickness, 3.0 * v.x - 1.0, 3.0 * v.y - 1.0) * scale;
    let surface = square(1, 0.0);
    let vertices = surface.vertices.iter().map(plate).collect();
    let surface = SurfaceMesh { vertices, ..surface };
    let motion: Box<Motion> = Box::new(move |_, t| Vec3::new(0.0, 0.3 * t, 0.1 * t) * scale);
    let obstacle = Obstacle { surface, motion: Some(motion) };
    let barrier = Barrier { thickness: thickness * scale, ..barrier(form, 0.12 * scale) };
    let mut scene = Scene::new(degree, &meshes, vec![obstacle], barrier, |_| true);
    let mut random = Random::new(3);
    scene.u = random.numbers(scene.u.len()).iter().map(|v| 0.004 * scale * v).collect();
    scene
}

impl Contact {
    /// Number of pairs of nearly parallel edges that repel each other.
    pub(crate) fn mollified_pairs(&self, at: &Iterate) -> usize {
        let contacts = self.contacts(at);
        let matters =
            |t: &&Term| t.weight != 0.0 && t.stencil.mollified && contacts.local(t).value() > 0.0;
        contacts.terms().iter().filter(matters).count()
    }
}

/// Numbers of mollified terms that matter, of terms with negative weight, and of all.
fn census(scene: &Scene) -> [usize; 3] {
    let contacts = scene.contact.contacts(&scene.here());
    let count = |wanted: &dyn Fn(&Term) -> bool| {
        contacts.terms().iter().filter(|t| t.weight != 0.0 && wanted(t)).count()
    };
    let mollified = scene.contact.mollified_pairs(&scene.here());
    [mollified, count(&|t| t.weight < 0.0), count(&|_| true)]
}

#[test]
fn every_derivative_belongs_to_the_energy_at_any_scale() {
    for (degree, scale, form, thickness) in [
        (1, 1.0, Form::Convergent, 0.0),
        (2, 1e-3, Form::Convergent, 0.03),
        (1, 1e3, Form::Convergent, 0.03),
        (3, 1.0, Form::Convergent, 0.0),
        (3, 1e-3, Form::Plain, 0.0),
        (1, 1e-3, Form::Plain, 0.0),
        (1, 1.0, Form::Even, 0.0),
    ] {
        let scene = blocks(degree, form, scale, thickness);
        let [mollified, negative, all] = census(&scene);
        assert!(mollified >= 5 && all > 50, "{mollified} mollified of {all}");
        assert!(form == Form::Plain || negative > 0, "{negative} of {all} negative");
        scene.check(&scene.contact, scale);
    }
}

#[test]
fn the_projected_hessian_is_positive_and_the_exact_one_is_not() {
    let scene = blocks(1, Form::Convergent, 1.0, 0.0);
    assert!(scene.smallest(&scene.contact, Hessian::Projected) > -1e-14);
    assert!(scene.smallest(&scene.contact, Hessian::Exact) < -1e-3);
}

/// Whatever the two sides do to each other cancels, and so does its torque.
#[test]
fn forces_and_torques_between_surfaces_cancel() {
    for form in [Form::Convergent, Form::Plain] {
        let scene = blocks(2, form, 1.0, 0.0);
        let forces = scene.contact.forces(&scene.here());
        let x = scene.contact.positions(&scene.here());
        let size: f64 = forces.iter().map(Vec3::norm).sum();
        let total: Vec3 = forces.iter().sum();
        let torque: Vec3 = x.iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
        assert!(size > 0.0 && total.norm() < 1e-13 * size && torque.norm() < 1e-12 * size);
        // the upper block is pushed up by the lower one, which the plate pushes
        let between = scene.contact.body_forces(&scene.here());
        let pairs: Vec<_> = between.iter().map(|b| b.bodies).collect();
        assert_eq!(pairs, [[0, 1], [0, 2], [1, 2]]);
        assert!(between[0].force.z < 0.0 && between[1].force.x > 0.0);
        assert!(between.iter().all(|b| b.force.norm() <= b.magnitude * (1.0 + 1e-12)));
    }
}

/// Bits do not depend on threads, nor on what was asked before.
#[test]
fn results_depend_neither_on_threads_nor_on_the_list_of_pairs() {
    let run = |threads: usize, detour: f64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a thread pool").install(|| {
            let scene = blocks(2, Form::Convergent, 1.0, 0.0);
            let away: Vec<f64> = scene.u.iter().map(|u| u + detour).collect();
            scene.contact.value(&scene.at(&away, &scene.rest));
            let gradient = scene.gradient(&scene.contact, &scene.u, &scene.rest);
            let value = scene.contact.value(&scene.here());
            gradient.into_iter().chain([value]).map(f64::to_bits).collect::<Vec<_>>()
        })
    };
    let expected = run(1, 0.0);
    assert!([(2, 0.0), (5, 0.01), (3, 1.0)].into_iter().all(|(n, d)| run(n, d) == expected));
}

/// The displacement of a scene with its upper block moved on.
fn with_upper(scene: &Scene, by: Vec3) -> Vec<f64> {
    let positions = scene.space.node_positions(&scene.rest);
    let own = positions.iter().map(|x| if x.z > 1.02 { by } else { Vec3::zeros() });
    flat(&own.collect::<Vec<_>>()).iter().zip(&scene.u).map(|(by, u)| u + by).collect()
}

/// The list of neighbours on the way of a step is taken from what collision detection met.
#[test]
fn on_the_way_of_a_step_contact_is_what_it_is_without() {
    let scene = blocks(2, Form::Convergent, 1.0, 0.0);
    let down = |share: f64| with_upper(&scene, -0.5 * share * Vec3::z());
    let share = scene.contact.max_step(&scene.here(), &scene.at(&down(1.0), &scene.rest));
    let mut touched = 0;
    for part in [share, 0.5 * share, 0.9 * share] {
        let u = down(part);
        let fresh = blocks(2, Form::Convergent, 1.0, 0.0);
        let [found, expected] =
            [&scene, &fresh].map(|of| of.contact.value(&of.at(&u, &of.rest)).to_bits());
        assert_eq!(found, expected, "{part} of the step");
        let slack = |of: &Scene| {
            let (x, rest) =
                (of.contact.positions(&of.at(&u, &of.rest)), of.contact.rest(&of.here()));
            of.contact.neighbours.last_at(&rest, &[&x]).expect("a list").slack
        };
        assert!(slack(&scene) < slack(&fresh), "the list is not of the step");
        touched += usize::from(f64::from_bits(found) > 0.0);
    }
    assert!(touched > 0, "nothing touched on the way");
}

/// Steps end before anything touches, with a little of the gap left.
#[test]
fn steps_are_cut_where_surfaces_meet() {
    for thickness in [0.0, 0.03] {
        for (direction, free) in [(Vec3::z(), true), (-0.5 * Vec3::z(), false)] {
            let mut scene = blocks(2, Form::Convergent, 1.0, thickness);
            let to = with_upper(&scene, direction);
            let share = scene.contact.max_step(&scene.here(), &scene.at(&to, &scene.rest));
            assert!((share == 1.0) == free && share > 0.02, "{share}");
            scene.u = with_upper(&scene, share * direction);
            assert!(scene.contact.value(&scene.here()).is_finite());
            assert_eq!(scene.contact.objection(&scene.here()), None);
            let left = scene.contact.gaps(&scene.here()).smallest;
            assert!(free || (left > 0.0 && left < 0.2), "{left}");
        }
    }
}
