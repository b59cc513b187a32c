//! Gas at a prescribed gauge pressure behind a wall.
//!
//! V(x) = −⅓ ∫_Γ x · (g₁ × g₂) dξ      g_α = ∂x/∂ξ_α,  x = ΠX + u
//! E(u; X) = −P (V(x) − V(X))           P > 0 inflates
//! ∂E/∂x_a = P ∫ φ_a (g₁ × g₂) dξ
//! ∂²E/∂x_a∂x_b = P S_ab,  S_ab = ∫ φ_a (−∂₁φ_b [g₂]ₓ + ∂₂φ_b [g₁]ₓ) dξ
//!
//! Facets are oriented out of the solid, so that g₁ × g₂ points into the
//! chamber. S is symmetric when Γ is closed or its rim is fixed; the volume of
//! an open wall is that of the cone from the origin and only its change counts.
//!
//! Source: Rumpel and Schweizerhof 2003, doi:10.1002/nme.561; Niewiarowski,
//! Adriaenssens and Pauletti 2020, doi:10.1016/j.cma.2020.113059.

use mesh::Vec3;

use super::{Energy, Hessian, Iterate};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, cross_matrix};

/// The wall of a chamber: facets of the solid, as node ids.
pub struct Wall {
    facets: Vec<Vec<usize>>,
}

/// Values of a facet at one quadrature point; the weight includes the ½ of the
/// reference triangle's area.
struct Point<'a> {
    weight: f64,
    values: &'a [f64],
    gradients: &'a [[f64; 3]],
    g1: Vec3,
    g2: Vec3,
}

impl Wall {
    /// A wall of boundary facets (vertex ids, oriented out of the solid).
    #[must_use]
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]]) -> Self {
        Self { facets: facets.iter().map(|&f| space.facet_nodes(f)).collect() }
    }

    /// Calls `f` with each facet's nodes, their positions and each point.
    fn for_each_point(
        &self,
        space: &FunctionSpace,
        x: &[Vec3],
        mut f: impl FnMut(&[usize], &[Vec3], &Point),
    ) {
        let table = space.facet_table();
        for nodes in &self.facets {
            let x: Vec<Vec3> = nodes.iter().map(|&n| x[n]).collect();
            for (q, weight) in table.weights.iter().enumerate() {
                let gradients = &table.gradients[q];
                let tangent =
                    |k: usize| x.iter().zip(gradients).map(|(x, g)| x * g[k]).sum::<Vec3>();
                let point = Point {
                    weight: 0.5 * weight,
                    values: &table.values[q],
                    gradients,
                    g1: tangent(0),
                    g2: tangent(1),
                };
                f(nodes, &x, &point);
            }
        }
    }

    /// Volume behind the wall at node positions `x` [m³].
    #[must_use]
    pub fn volume(&self, space: &FunctionSpace, x: &[Vec3]) -> f64 {
        let mut volume = 0.0;
        self.for_each_point(space, x, |_, x, p| {
            let position: Vec3 = x.iter().zip(p.values).map(|(x, v)| x * *v).sum();
            volume -= p.weight / 3.0 * position.dot(&p.g1.cross(&p.g2));
        });
        volume
    }

    /// Adds `scale` ∂(−V)/∂x, the load of a unit pressure [m²].
    fn add_load(&self, space: &FunctionSpace, x: &[Vec3], scale: f64, out: &mut [f64]) {
        self.for_each_point(space, x, |nodes, _, p| {
            let normal = scale * p.weight * p.g1.cross(&p.g2);
            for (node, v) in nodes.iter().zip(p.values) {
                add_at(out, *node, &(normal * *v));
            }
        });
    }
}

/// Prescribed pressure behind one wall.
pub struct Pressure {
    /// The wall.
    pub wall: Wall,
    /// Gauge pressure at full load [Pa].
    pub pressure: f64,
}

/// Node positions x = ΠX + u.
fn positions(at_: &Iterate) -> Vec<Vec3> {
    let mut x = at_.space.node_positions(at_.rest);
    for (i, x) in x.iter_mut().enumerate() {
        *x += at(at_.u, i);
    }
    x
}

/// S_ab at one point, without the weight.
fn stiffness(p: &Point, a: usize, b: usize) -> Mat3 {
    let [d1, d2, _] = p.gradients[b];
    p.values[a] * (d2 * cross_matrix(&p.g1) - d1 * cross_matrix(&p.g2))
}

impl Energy for Pressure {
    fn name(&self) -> &'static str {
        "pressure"
    }

    fn value(&self, at_: &Iterate) -> f64 {
        let rest = at_.space.node_positions(at_.rest);
        let change =
            self.wall.volume(at_.space, &positions(at_)) - self.wall.volume(at_.space, &rest);
        -at_.load * self.pressure * change
    }

    fn add_gradient(&self, at_: &Iterate, out: &mut [f64]) {
        self.wall.add_load(at_.space, &positions(at_), at_.load * self.pressure, out);
    }

    fn add_hessian(&self, at_: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let pressure = at_.load * self.pressure;
        self.wall.for_each_point(at_.space, &positions(at_), |nodes, _, p| {
            for a in 0..nodes.len() {
                for b in 0..nodes.len() {
                    // S is symmetric once assembled, so its symmetric part is it
                    let block = stiffness(p, a, b) + stiffness(p, b, a).transpose();
                    out.add_lower(nodes[a], nodes[b], &(0.5 * pressure * p.weight * block));
                }
            }
        });
    }

    fn add_mixed_vjp(&self, at_: &Iterate, lambda: &[f64], out: &mut [f64]) {
        // x = ΠX + u: the mixed derivative is P S Π
        let mut nodal = vec![0.0; at_.u.len()];
        let pressure = at_.load * self.pressure;
        self.wall.for_each_point(at_.space, &positions(at_), |nodes, _, p| {
            let l: Vec3 = nodes.iter().zip(p.values).map(|(n, v)| at(lambda, *n) * *v).sum();
            for (b, node) in nodes.iter().enumerate() {
                let [d1, d2, _] = p.gradients[b];
                let row = (d2 * cross_matrix(&p.g1) - d1 * cross_matrix(&p.g2)).transpose() * l;
                add_at(&mut nodal, *node, &(pressure * p.weight * row));
            }
        });
        at_.space.add_to_vertices(&nodal, out);
    }
}
