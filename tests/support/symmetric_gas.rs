//! Gas in a part of a chamber that is cut out by planes of symmetry.

use mesh::Vec3;
use solver::element::{FunctionSpace, at};
use solver::energy::{Chamber, Energy, GasLaw, Hessian, Iterate, Wall};
use solver::math::sparse::BlockMatrix;

/// Where the planes are, on which the rim of the wall slides.
#[derive(Clone, Copy)]
pub enum Planes {
    /// All through the origin: V = −⅓ ∫ x · (g₁ × g₂) dξ.
    ThroughOrigin,
    /// Through the z axis, and at two heights: V = −½ ∫ (x, y, 0) · (g₁ × g₂) dξ.
    Slab,
}

/// Constant pressure behind an open wall. [`Chamber`] closes it by caps from
/// rim to rim, which is not the chamber's share here; force and stiffness of
/// the wall are the same.
pub struct SymmetricGas {
    chamber: Chamber,
    pressure: f64,
    facets: Vec<Vec<usize>>,
    planes: Planes,
}

impl SymmetricGas {
    /// Gas behind facets (vertex ids, oriented out of the solid) at a gauge
    /// pressure [Pa].
    #[must_use]
    pub fn new(
        space: &FunctionSpace,
        facets: &[[usize; 3]],
        planes: Planes,
        pressure: f64,
    ) -> Self {
        let chamber =
            Chamber { wall: Wall::new(space, facets), gas: GasLaw::Isobaric { pressure } };
        let facets = facets.iter().map(|&f| space.facet_nodes(f)).collect();
        Self { chamber, pressure, facets, planes }
    }

    /// Volume at node positions `x` [m³].
    #[must_use]
    pub fn volume(&self, space: &FunctionSpace, x: &[Vec3]) -> f64 {
        let table = space.facet_table();
        let (mask, share) = match self.planes {
            Planes::ThroughOrigin => (Vec3::repeat(1.0), 1.0 / 3.0),
            Planes::Slab => (Vec3::new(1.0, 1.0, 0.0), 1.0 / 2.0),
        };
        let mut volume = 0.0;
        for nodes in &self.facets {
            for (q, weight) in table.weights.iter().enumerate() {
                let tangent = |k: usize| -> Vec3 {
                    nodes.iter().zip(&table.gradients[q]).map(|(&n, g)| x[n] * g[k]).sum()
                };
                let normal = tangent(0).cross(&tangent(1));
                let p: Vec3 = nodes.iter().zip(&table.values[q]).map(|(&n, v)| x[n] * *v).sum();
                volume -= 0.5 * weight * share * mask.component_mul(&p).dot(&normal);
            }
        }
        volume
    }
}

impl Energy for SymmetricGas {
    fn name(&self) -> &'static str {
        "pressure"
    }
    fn value(&self, at_: &Iterate) -> f64 {
        let rest = at_.space.node_positions(at_.rest);
        let x: Vec<Vec3> = rest.iter().enumerate().map(|(i, x)| x + at(at_.u, i)).collect();
        let change = self.volume(at_.space, &x) - self.volume(at_.space, &rest);
        -at_.load * self.pressure * change
    }
    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        self.chamber.add_gradient(at, out);
    }
    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        self.chamber.add_hessian(at, kind, out);
    }
    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        self.chamber.add_mixed_vjp(at, lambda, out);
    }
}
