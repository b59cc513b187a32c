//! Constant force per rest area on a part of the boundary (a dead load).
//!
//! E(u; X) = −∫_Γ t · u dA        ∂E/∂u_a = −∫_Γ φ_a t dA      ∂²E/∂u² = 0
//! δ(λ·∂E/∂u) = −Σ (mean of t · λ over a facet) δA
//! ∂A/∂X_i = ½ n × (X_{i+2} − X_{i+1})      n the unit normal of the facet
//!
//! t [Pa] is neither turned nor stretched by the deformation, unlike gas
//! pressure; it acts in full at full load.

use mesh::Vec3;

use super::{Energy, Hessian, Iterate};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;

/// A constant force per rest area of some facets.
pub struct Traction {
    /// t at full load [Pa].
    pub traction: Vec3,
    /// Facets as vertices and nodes.
    facets: Vec<([usize; 3], Vec<usize>)>,
    /// ∫ φ_a over a facet divided by its area, for each a.
    shares: Vec<f64>,
}

impl Traction {
    /// The force t [Pa] on boundary facets (vertex ids).
    #[must_use]
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]], traction: Vec3) -> Self {
        let table = space.facet_table();
        let mut shares = vec![0.0; table.values[0].len()];
        for (values, weight) in table.values.iter().zip(&table.weights) {
            shares.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
        }
        let facets = facets.iter().map(|&f| (f, space.facet_nodes(f))).collect();
        Self { traction, facets, shares }
    }

    /// The mean of a nodal field over a facet.
    fn mean(&self, nodes: &[usize], field: &[f64]) -> Vec3 {
        nodes.iter().zip(&self.shares).map(|(&n, s)| at(field, n) * *s).sum()
    }
}

/// Twice the area vector n A [m²].
fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

impl Energy for Traction {
    fn name(&self) -> &'static str {
        "traction"
    }

    fn value(&self, at_: &Iterate) -> f64 {
        let work = |(facet, nodes): &([usize; 3], Vec<usize>)| {
            let area = 0.5 * normal(facet.map(|v| at_.rest[v])).norm();
            area * self.traction.dot(&self.mean(nodes, at_.u))
        };
        -at_.load * self.facets.iter().map(work).sum::<f64>()
    }

    fn add_gradient(&self, at_: &Iterate, out: &mut [f64]) {
        for (facet, nodes) in &self.facets {
            let area = 0.5 * normal(facet.map(|v| at_.rest[v])).norm();
            let force = -at_.load * area * self.traction;
            for (&node, share) in nodes.iter().zip(&self.shares) {
                add_at(out, node, &(force * *share));
            }
        }
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}

    fn add_mixed_vjp(&self, at_: &Iterate, lambda: &[f64], out: &mut [f64]) {
        for (facet, nodes) in &self.facets {
            let x = facet.map(|v| at_.rest[v]);
            let unit = normal(x).normalize();
            let density = -at_.load * self.traction.dot(&self.mean(nodes, lambda));
            for i in 0..3 {
                let by = 0.5 * unit.cross(&(x[(i + 2) % 3] - x[(i + 1) % 3]));
                add_at(out, facet[i], &(density * by));
            }
        }
    }
}
