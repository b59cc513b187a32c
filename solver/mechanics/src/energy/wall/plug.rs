//! A wall whose rims are closed by plugs: the gas pushes on the caps, too, and they pass this on to the rims.
//!
//! A plug gives way as the cap does: it has no stiffness of its own, but holds the gas. With it V is the volume
//! within a closed surface that moves with the body, so that the gas exerts no net force on a body that is free,
//! and ∂²V/∂x∂x is symmetric without any support. V is cubic in x, a sum of triple products det(·, ·, ·):
//!
//! wall   −⅓ ∫ det(x − o, g₁, g₂) dξ
//! caps    ⅙ Σ K_ij det(x_i − o, x_j − o, c − o)     over the nodes i < j of each edge of a rim
//!
//! Every two of the three factors give blocks of the second derivative. As c is the mean of all vertices of a rim,
//! it couples each node of the rim with each.

use mesh::Vec3;

use super::{Wall, points, swept_terms};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, cross_matrix};

impl Wall {
    /// This wall with plugs in all that is open.
    pub fn plugged(self) -> Self {
        Self { plugged: true, ..self }
    }

    /// Whether it has them.
    pub fn is_plugged(&self) -> bool {
        self.plugged
    }

    /// Pairs of nodes (row > column) of a rim, which a plug couples.
    pub fn couplings(&self, space: &FunctionSpace) -> Vec<[usize; 2]> {
        if !self.plugged {
            return Vec::new();
        }
        let mut pairs = Vec::new();
        for rim in &self.rims {
            let inside = rim.edges().flat_map(|edge| space.edge_nodes(edge));
            let nodes: Vec<usize> = rim.vertices.iter().copied().chain(inside).collect();
            let below = |&a: &usize| nodes.iter().filter(move |&&b| b < a).map(move |&b| [a, b]);
            pairs.extend(nodes.iter().flat_map(below));
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Adds −`scale` ∂²V/∂x∂x to the lower triangle.
    pub(super) fn add_plugged_stiffness(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Copy,
        scale: f64,
        out: &mut BlockMatrix,
    ) {
        for nodes in &self.facets {
            points(space, nodes, x, |x, p| {
                let y = cross_matrix(&self.position(x, p));
                let [g1, g2] = [p.g1, p.g2].map(|g| cross_matrix(&g));
                for (a, &row) in nodes.iter().enumerate() {
                    for (b, &column) in nodes.iter().enumerate() {
                        let ([a1, a2, _], [b1, b2, _]) = (p.gradients[a], p.gradients[b]);
                        let (va, vb) = (p.values[a], p.values[b]);
                        let block = (vb * a1 - va * b1) * g2
                            + (va * b2 - vb * a2) * g1
                            + (b1 * a2 - a1 * b2) * y;
                        out.add_lower(row, column, &(scale * p.weight / 3.0 * block));
                    }
                }
            });
        }
        self.add_cap_stiffness(space, x, scale, out);
    }

    fn add_cap_stiffness(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Copy,
        scale: f64,
        out: &mut BlockMatrix,
    ) {
        let mut add = |row: usize, column: usize, block: Mat3| {
            out.add_lower(row, column, &block);
            out.add_lower(column, row, &block.transpose());
        };
        self.for_each_rim_edge(space, x, |rim, edge, nodes, c| {
            for (i, j, k) in swept_terms(edge.len()) {
                let k = -scale * k / 6.0;
                let [yi, yj] = [i, j].map(|n| cross_matrix(&nodes[n]));
                add(edge[i], edge[j], -k * cross_matrix(&c));
                for (v, share) in rim.apex_vjp(1.0, Vec3::repeat(1.0)) {
                    let share = Mat3::from_diagonal(&share);
                    add(edge[i], v, k * yj * share);
                    add(edge[j], v, -k * yi * share);
                }
            }
        });
    }

    /// Adds −`scale` λᵀ ∂²V/∂x∂x at the nodes. ∂V/∂x is quadratic in x, so that the central difference along λ
    /// is exact, and as long a step as the wall is large loses nothing by rounding.
    pub(super) fn add_plugged_stiffness_vjp(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Copy,
        lambda: &[f64],
        scale: f64,
        out: &mut [f64],
    ) {
        let nodes = || self.facets.iter().flatten();
        let size = nodes().map(|&n| (x(n) - self.origin).norm()).fold(0.0, f64::max);
        let largest = nodes().map(|&n| at(lambda, n).norm()).fold(0.0, f64::max);
        if largest == 0.0 {
            return;
        }
        let step = size / largest;
        let mut difference = vec![0.0; out.len()];
        for sign in [1.0, -1.0] {
            let moved = |n: usize| x(n) + sign * step * at(lambda, n);
            self.add_gradient(space, moved, -sign * scale / (2.0 * step), &mut difference);
        }
        (0..out.len() / 3).for_each(|n| add_at(out, n, &at(&difference, n)));
    }
}
