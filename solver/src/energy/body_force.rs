//! Constant force per rest volume, such as gravity.
//!
//! E(u; X) = −∫ f · u dX           ∂E/∂u_a = −∫ φ_a f dX      ∂²E/∂u² = 0
//! δ(λ·∂E/∂u) = −∫ (f · λ) div V dX for a velocity field V of the rest shape
//!
//! f [N/m³] acts in full at full load.

use mesh::Vec3;

use super::{Energy, Hessian, Iterate};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;

/// A constant force per rest volume.
pub struct BodyForce {
    /// f at full load [N/m³].
    pub force: Vec3,
}

/// ∫ φ_a over the reference tetrahedron divided by its volume, for each a.
fn shares(space: &FunctionSpace) -> Vec<f64> {
    let table = space.volume_table();
    let mut shares = vec![0.0; space.nodes_per_element()];
    for (values, weight) in table.values.iter().zip(&table.weights) {
        shares.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
    }
    shares
}

/// Calls `f` with the corners of each element and the mean of a nodal field.
fn for_each_mean(space: &FunctionSpace, field: &[f64], mut f: impl FnMut([usize; 4], Vec3)) {
    let shares = shares(space);
    let nodes = space.element_nodes().chunks_exact(shares.len());
    for (&tet, nodes) in space.tets().iter().zip(nodes) {
        f(tet, nodes.iter().zip(&shares).map(|(&n, s)| at(field, n) * *s).sum());
    }
}

fn volume(tet: [usize; 4], rest: &[Vec3]) -> f64 {
    let [a, b, c, d] = tet.map(|v| rest[v]);
    mesh::measure::tet_volume(a, b, c, d)
}

impl Energy for BodyForce {
    fn name(&self) -> &'static str {
        "body_force"
    }

    fn value(&self, at_: &Iterate) -> f64 {
        let mut work = 0.0;
        for_each_mean(at_.space, at_.u, |tet, mean| {
            work += volume(tet, at_.rest) * self.force.dot(&mean);
        });
        -at_.load * work
    }

    fn add_gradient(&self, at_: &Iterate, out: &mut [f64]) {
        let shares = shares(at_.space);
        let nodes = at_.space.element_nodes().chunks_exact(shares.len());
        for (&tet, nodes) in at_.space.tets().iter().zip(nodes) {
            let force = -at_.load * volume(tet, at_.rest) * self.force;
            for (&node, share) in nodes.iter().zip(&shares) {
                add_at(out, node, &(force * *share));
            }
        }
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}

    fn add_mixed_vjp(&self, at_: &Iterate, lambda: &[f64], out: &mut [f64]) {
        for_each_mean(at_.space, lambda, |tet, mean| {
            let density = -at_.load * self.force.dot(&mean);
            let [a, b, c, d] = tet.map(|v| at_.rest[v]);
            // gradient of the volume with respect to b, c, d; that of a is minus their sum
            let by = [(c - a).cross(&(d - a)), (d - a).cross(&(b - a)), (b - a).cross(&(c - a))];
            for (vertex, by) in tet[1..].iter().zip(by) {
                let part = density / 6.0 * by;
                add_at(out, *vertex, &part);
                add_at(out, tet[0], &-part);
            }
        });
    }
}
