//! Taylor tests of quantities at random states.

use mechanics::element::FunctionSpace;
use mechanics::energy::{Energies, Term, Winding, polyline};
use mechanics::math::random::Random;
use mechanics::testing::{check_gradient, cube, flat, points};
use mesh::Vec3;

use super::{Equilibrium, Partials, Quantity};

/// A body at a state.
pub struct Case {
    /// The nodes.
    pub space: FunctionSpace,
    /// X.
    pub rest: Vec<Vec3>,
    /// u.
    pub u: Vec<f64>,
    /// Forces of contact on the nodes.
    pub contact: Vec<f64>,
    /// Forces of supports on the nodes.
    pub reaction: Vec<f64>,
    /// Boundary facets.
    pub facets: Vec<[usize; 3]>,
    /// Size of the body [m].
    pub scale: f64,
    /// Two threads, each across a side of the cube; none on other bodies.
    pub threads: Energies,
}

impl Case {
    /// A cube of side `scale` in 48 tetrahedra at a random displacement.
    pub fn cube(degree: usize, scale: f64) -> Self {
        let mut case = Self::of(&cube(2, 0.2), degree, scale);
        let path = [[0.1, 0.2, 1.0], [0.8, 0.35, 1.0], [0.4, 0.9, 1.0]].map(Vec3::from);
        let threads = [path, path.map(|p| p.zyx())].map(|path| case.thread(&path));
        let place = threads.into_iter().enumerate();
        case.threads = place.map(|(i, thread)| Term::of(Winding::owner(i), thread)).collect();
        case
    }

    /// A body times `scale`, every node of which is moved by up to 0.05 of it.
    pub fn of(mesh: &mesh::TetMesh, degree: usize, scale: f64) -> Self {
        let rest: Vec<Vec3> = mesh.vertices.iter().map(|x| x * scale).collect();
        let space = FunctionSpace::new(degree, rest.len(), mesh.tets.clone());
        let mut random = Random::new(31);
        let n = 3 * space.node_count();
        let u = random.numbers(n).iter().map(|u| 0.05 * scale * u).collect();
        let facets = mesh::topology::boundary(mesh).facets;
        let [contact, reaction] = [0, 1].map(|_| random.numbers(n));
        Self { space, rest, u, contact, reaction, facets, scale, threads: Energies::default() }
    }

    /// A thread through points of a unit cube, with a pretension that keeps it taut, and a stiffness that varies with
    /// strain.
    fn thread(&self, path: &[Vec3]) -> Winding {
        let path: Vec<Vec3> = path.iter().map(|x| x * self.scale).collect();
        let end = |x: Vec3| x.max() > 1.0 - 1e-9;
        let facets = self.facets_where(end);
        let pieces = polyline(&facets, &self.rest, &path).expect("it lies on the side");
        Winding::new(&self.space, &pieces, [40.0, 30.0, 1.0])
    }

    /// The facets whose middle is where `wanted` says.
    pub fn facets_where(&self, wanted: impl Fn(Vec3) -> bool) -> Vec<[usize; 3]> {
        let middle = |f: &[usize; 3]| f.iter().map(|&v| self.rest[v]).sum::<Vec3>() / 3.0;
        self.facets.iter().copied().filter(|f| wanted(middle(f) / self.scale)).collect()
    }

    /// The state.
    pub fn at(&self) -> Equilibrium<'_> {
        let Self { space, rest, u, contact, reaction, threads, .. } = self;
        Equilibrium { space, rest, u, time: 0.7, contact, reaction, energies: threads }
    }

    /// Partial derivatives of a quantity times a weight.
    pub fn partials(&self, quantity: &dyn Quantity, weight: f64) -> Lists {
        let [u, contact, reaction] = [0, 1, 2].map(|_| vec![0.0; self.u.len()]);
        let mut lists = Lists { u, rest: vec![0.0; 3 * self.rest.len()], contact, reaction };
        lists.add(quantity, &self.at(), weight);
        lists
    }

    /// Taylor tests of all derivatives within a distance `near` of the state, in sizes of the body; those that vanish
    /// must do so exactly, and the value must not change there.
    pub fn check_near(&self, quantity: &dyn Quantity, near: f64) {
        let (at, mut by) = (self.at(), self.partials(quantity, 1.5));
        let value = |at: Equilibrium| 1.5 * quantity.value(&at);
        let size = near * self.scale;
        along(&self.u, &by.u, size, |u| value(Equilibrium { u, ..self.at() }));
        along(&flat(&self.rest), &by.rest, size, |x| {
            value(Equilibrium { rest: &points(x), ..self.at() })
        });
        along(&self.contact, &by.contact, 1e-2, |f| value(Equilibrium { contact: f, ..self.at() }));
        along(&self.reaction, &by.reaction, 1e-2, |r| {
            value(Equilibrium { reaction: r, ..self.at() })
        });
        // values are added to those that are there
        let before = by.u.clone();
        by.add(quantity, &at, -1.5);
        let left = by.u.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let largest = before.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(left <= 1e-12 * largest, "{left} {largest}");
    }
}

/// Partial derivatives of a quantity.
pub struct Lists {
    /// By u.
    pub u: Vec<f64>,
    /// By X.
    pub rest: Vec<f64>,
    /// By the forces of contact.
    pub contact: Vec<f64>,
    /// By the forces of supports.
    pub reaction: Vec<f64>,
}

impl Lists {
    fn add(&mut self, quantity: &dyn Quantity, at: &Equilibrium, weight: f64) {
        let Self { u, rest, contact, reaction } = self;
        quantity.add_partials(at, weight, &mut Partials { u, rest, contact, reaction });
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
