//! Taylor tests of objectives at random states.

mod symmetry;

use mechanics::element::FunctionSpace;
use mechanics::math::random::Random;
use mechanics::testing::{check_gradient, cube, flat, points};
use mesh::Vec3;

use super::{Equilibrium, Objective};

/// A body at a state.
pub struct Case {
    /// Its nodes.
    pub space: FunctionSpace,
    /// X.
    pub rest: Vec<Vec3>,
    /// u.
    pub u: Vec<f64>,
    /// Forces of contact on the nodes.
    pub contact: Vec<f64>,
    /// Boundary facets.
    pub facets: Vec<[usize; 3]>,
    /// Size of the body [m].
    pub scale: f64,
}

impl Case {
    /// A cube of side `scale` in 48 tetrahedra at a random displacement.
    pub fn cube(degree: usize, scale: f64) -> Self {
        Self::of(&cube(2, 0.2), degree, scale)
    }

    /// A body times `scale`, every node of which is moved by up to 0.05 of it.
    pub fn of(mesh: &mesh::TetMesh, degree: usize, scale: f64) -> Self {
        let rest: Vec<Vec3> = mesh.vertices.iter().map(|x| x * scale).collect();
        let space = FunctionSpace::new(degree, rest.len(), mesh.tets.clone());
        let mut random = Random::new(31);
        let n = 3 * space.node_count();
        let u = random.numbers(n).iter().map(|u| 0.05 * scale * u).collect();
        let facets = mesh::topology::boundary(mesh).facets;
        Self { space, rest, u, contact: random.numbers(n), facets, scale }
    }

    /// The facets whose middle is where `wanted` says.
    pub fn facets_where(&self, wanted: impl Fn(Vec3) -> bool) -> Vec<[usize; 3]> {
        let middle = |f: &[usize; 3]| f.iter().map(|&v| self.rest[v]).sum::<Vec3>() / 3.0;
        self.facets.iter().copied().filter(|f| wanted(middle(f) / self.scale)).collect()
    }

    /// The state.
    pub fn at(&self) -> Equilibrium<'_> {
        self.with(&self.rest, &self.u, &self.contact)
    }

    fn with<'a>(&'a self, rest: &'a [Vec3], u: &'a [f64], contact: &'a [f64]) -> Equilibrium<'a> {
        Equilibrium { space: &self.space, rest, u, load: 0.7, contact, reaction: &[] }
    }

    /// Taylor tests of all derivatives; those that vanish must do so exactly, and
    /// the value must not change there.
    pub fn check(&self, objective: &dyn Objective) {
        self.check_near(objective, 1e-4);
    }

    /// Tests of [`Self::check`] within a distance `near` of the state, in sizes of the body.
    pub fn check_near(&self, objective: &dyn Objective, near: f64) {
        let at = self.at();
        let (mut by_u, mut by_rest) = (vec![0.0; self.u.len()], vec![0.0; 3 * self.rest.len()]);
        let mut by_contact = vec![0.0; self.u.len()];
        objective.add_du(&at, 1.5, &mut by_u);
        objective.add_drest(&at, 1.5, &mut by_rest);
        objective.add_dcontact(&at, 1.5, &mut by_contact);
        let value = |rest: &[Vec3], u: &[f64], contact: &[f64]| {
            1.5 * objective.value(&self.with(rest, u, contact))
        };
        let size = near * self.scale;
        along(&self.u, &by_u, size, |u| value(&self.rest, u, &self.contact));
        along(&flat(&self.rest), &by_rest, size, |x| value(&points(x), &self.u, &self.contact));
        along(&self.contact, &by_contact, 1e-2, |f| value(&self.rest, &self.u, f));
        // values are added to those that are there
        let before = by_u.clone();
        objective.add_du(&at, -1.5, &mut by_u);
        let left = by_u.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let largest = before.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(left <= 1e-12 * largest, "{left} {largest}");
    }
}

fn along(x: &[f64], gradient: &[f64], size: f64, value: impl Fn(&[f64]) -> f64) {
    if gradient.iter().all(|g| *g == 0.0) {
        let mut random = Random::new(3);
        let moved: Vec<f64> = x.iter().map(|x| x + size * random.uniform()).collect();
        assert!(value(&moved) == value(x), "the value changes, its gradient is zero");
        return;
    }
    check_gradient(x, gradient, size, value);
}
