//! Elements side by side, one in each lane: their shapes and displacements.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use std::ops::Range;

use pulp::Simd;

use crate::element::at;
use crate::energy::Iterate;
use crate::math::lanes::tensor::{Tensor, cofactor, determinant, scaled};
use crate::math::lanes::{Lanes, MOST};

/// Vectors of components, one for each of N nodes.
pub(in crate::energy) type Nodal<S, const N: usize> = [[Lanes<S>; 3]; N];

/// Consecutive straight-sided elements, as many as there are lanes.
pub(in crate::energy) struct Batch<'a, S: Simd, const N: usize> {
    pub(in crate::energy) simd: S,
    pub(in crate::energy) iterate: &'a Iterate<'a>,
    /// G⁻¹, whose rows are the rest gradients of three barycentric coordinates [1/m].
    to_rest: Tensor<S>,
    /// Rest volume [m³].
    pub(in crate::energy) volume: Lanes<S>,
    /// The elements, of which there may be fewer than lanes.
    pub(in crate::energy) elements: Range<usize>,
    /// Displacements of the nodes [m].
    u: Nodal<S, N>,
}

impl<'a, S: Simd, const N: usize> Batch<'a, S, N> {
    /// From an element on; lanes beyond the last one repeat it.
    #[inline(always)]
    pub(in crate::energy) fn new(
        simd: S,
        iterate: &'a Iterate<'a>,
        elements: Range<usize>,
    ) -> Self {
        let mut indices = [elements.end - 1; MOST];
        for (index, e) in indices.iter_mut().zip(elements.clone()) {
            *index = e;
        }
        let zero = Lanes::splat(simd, 0.0);
        let (mut edges, mut u) = ([[zero; 3]; 3], [[zero; 3]; N]);
        let tets = iterate.space.tets();
        for (k, edge) in edges.iter_mut().enumerate() {
            for (i, edge) in edge.iter_mut().enumerate() {
                let mut values = [0.0; MOST];
                for (value, &e) in values.iter_mut().zip(&indices) {
                    let [first, other] = [tets[e][0], tets[e][k + 1]];
                    *value = iterate.rest[other][i] - iterate.rest[first][i];
                }
                *edge = Lanes::load(simd, &values);
            }
        }
        let nodes = iterate.space.element_nodes();
        for (a, u) in u.iter_mut().enumerate() {
            let mut values = [[0.0; MOST]; 3];
            for (lane, &e) in indices.iter().enumerate() {
                let node = at(iterate.u, nodes[e * N + a]);
                for i in 0..3 {
                    values[i][lane] = node[i];
                }
            }
            for i in 0..3 {
                u[i] = Lanes::load(simd, &values[i]);
            }
        }
        // the edges are the columns of G: of Gᵀ the cofactor over det G is G⁻¹; a flat
        // element gives infinities, which the caller sees as an infinite energy
        let minors = cofactor(&edges);
        let det = determinant(&edges, &minors);
        let to_rest = scaled(&minors, det.recip());
        Self { simd, iterate, to_rest, volume: det * (1.0 / 6.0), elements, u }
    }

    /// Rest gradients ∇φ_a of all nodes at quadrature point q.
    #[inline(always)]
    pub(in crate::energy) fn gradients(&self, q: usize) -> Nodal<S, N> {
        let table = &self.iterate.space.volume_table().gradients[q];
        let mut g = self.u;
        for (g, table) in g.iter_mut().zip(table) {
            let (x, y, z) = (table[0], table[1], table[2]);
            let [x, y, z] = [self.splat(x), self.splat(y), self.splat(z)];
            for i in 0..3 {
                let to = &self.to_rest;
                g[i] = x.mul_add(to[0][i], y.mul_add(to[1][i], z * to[2][i]));
            }
        }
        g
    }

    #[inline(always)]
    pub(in crate::energy) fn splat(&self, x: f64) -> Lanes<S> {
        Lanes::splat(self.simd, x)
    }

    /// ∇u = Σ u_a ⊗ ∇φ_a.
    #[inline(always)]
    pub(in crate::energy) fn grad_u(&self, gradients: &Nodal<S, N>) -> Tensor<S> {
        let mut sum = [[Lanes::splat(self.simd, 0.0); 3]; 3];
        for (u, g) in self.u.iter().zip(gradients) {
            for i in 0..3 {
                for j in 0..3 {
                    sum[i][j] = u[i].mul_add(g[j], sum[i][j]);
                }
            }
        }
        sum
    }
}

/// Quadrature points and fractions of the volume that they stand for. Where strain is constant
/// in an element, one point stands for all.
pub(in crate::energy) fn points<const N: usize>(
    iterate: &Iterate,
) -> impl Iterator<Item = (usize, f64)> {
    let weights = &iterate.space.volume_table().weights;
    let constant = N == 4;
    let of = move |q: usize| if constant { 1.0 } else { weights[q] };
    (0..if constant { 1 } else { weights.len() }).map(move |q| (q, of(q)))
}
