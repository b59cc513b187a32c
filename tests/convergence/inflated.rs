//! Parts of hollow spheres and of long tubes between planes of symmetry, with gas inside.

use mechanics::element::FunctionSpace;
use mechanics::energy::{Chamber, Energies, GasLaw};
use mechanics::testing::symmetric_wall;
use mesh::{TetMesh, Vec3};
use tests::equilibrium::{Equilibrium, mean};

/// How far a node may be off a plane that it is in [m].
const NEAR: f64 = 1e-11;

/// What a part belongs to.
#[derive(Clone, Copy, PartialEq)]
pub enum Hollow {
    /// An octant to a sphere.
    Sphere,
    /// A quarter of a slice to a tube around z that keeps its length.
    Tube,
}

impl Hollow {
    /// Distance from the origin, or from z.
    fn radius(self, p: Vec3) -> f64 {
        if self == Self::Sphere { p.norm() } else { p.xy().norm() }
    }
}

/// A part between the planes x = 0, y = 0 and z = 0.
pub struct Inflated {
    /// The part in its last equilibrium.
    pub body: Equilibrium,
    hollow: Hollow,
}

impl Inflated {
    /// A part with an inner radius [m] in elements of a degree.
    pub fn new(
        hollow: Hollow,
        mesh: TetMesh,
        inner: f64,
        degree: usize,
        energies: impl Fn(&FunctionSpace) -> Energies,
        gas: Box<dyn GasLaw>,
    ) -> Self {
        let top = mesh.vertices.iter().map(|p| p.z).fold(0.0, f64::max);
        let held = |p: Vec3| {
            let [x, y, z] = [p.x, p.y, p.z].map(|c| c < NEAR);
            [x, y, z || (hollow == Hollow::Tube && p.z > top - NEAR)]
        };
        let own = mesh.clone();
        let with_gas = |space: &FunctionSpace| {
            let wall = symmetric_wall(&own, space, |p| hollow.radius(p) < inner * (1.0 + 1e-9));
            energies(space).with_chamber("gas", Chamber::new(wall, gas.clone()))
        };
        Self { body: Equilibrium::new(mesh, degree, with_gas, held), hollow }
    }

    /// The gas inside.
    pub fn chamber(&self) -> &Chamber {
        self.body.problem.energies.chambers().next().expect("there is gas inside").1
    }

    /// Mean stretch of the vertices at a radius at rest [m].
    pub fn stretch_at(&self, rest: f64) -> f64 {
        let vertices = self.body.vertices().into_iter();
        let radii = vertices.map(|(x, now)| [x, now].map(|x| self.hollow.radius(x) / rest));
        mean(&radii.filter(|[x, _]| (x - 1.0).abs() < 1e-9).map(|x| x[1]).collect::<Vec<_>>())
    }

    /// Volume of the gas over that at rest, for displacements of the nodes.
    pub fn growth(&self, u: &[f64]) -> f64 {
        let at = self.body.problem.iterate(&self.body.rest, u, 1.0);
        self.chamber().state(&at).0 / self.chamber().rest_volume(&at)
    }

    /// Stretch of the inner wall by the growth of the gas.
    pub fn stretch(&self, u: &[f64]) -> f64 {
        let dimensions = if self.hollow == Hollow::Sphere { 3.0 } else { 2.0 };
        self.growth(u).powf(1.0 / dimensions)
    }
}
