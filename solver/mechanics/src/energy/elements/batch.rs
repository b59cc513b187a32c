//! Elements side by side, one in each lane: their shapes and displacements.
//!
//! In a straight-sided element of degree 2 gradients of the basis are linear: they follow from those at the corners by
//! barycentric coordinates, ∇φ_a = Σ_c λ_c ∇φ_a|_c. The node of a corner has ∇φ_a|_c = (4 δ_ac − 1) ∇λ_a, that of an
//! edge ab 4 (δ_bc ∇λ_a + δ_ac ∇λ_b).

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use std::ops::Range;

use pulp::Simd;

use crate::element::{EDGES, at};
use crate::energy::Iterate;
use crate::math::lanes::tensor::{Tensor, cofactor, determinant, scaled};
use crate::math::lanes::{Lanes, MOST};

/// Vectors of components, one for each of N nodes.
pub(in crate::energy) type Nodal<S, const N: usize> = [[Lanes<S>; 3]; N];

/// Corners of a tetrahedron.
pub(in crate::energy) const CORNERS: usize = 4;
/// Nodes of an element of degree 2.
pub(in crate::energy) const QUADRATIC: usize = 10;
/// Nodes of an element of degree 3.
pub(in crate::energy) const CUBIC: usize = 20;

/// Consecutive straight-sided elements, as many as there are lanes.
pub(in crate::energy) struct Batch<'a, S: Simd, const N: usize> {
    pub(in crate::energy) simd: S,
    pub(in crate::energy) iterate: &'a Iterate<'a>,
    /// G⁻¹, whose rows are the rest gradients of three barycentric coordinates [1/m].
    pub(in crate::energy) to_rest: Tensor<S>,
    /// Rest volume [m³].
    pub(in crate::energy) volume: Lanes<S>,
    /// The elements, of which there may be fewer than lanes.
    pub(in crate::energy) elements: Range<usize>,
    /// Displacements of the nodes [m].
    u: Nodal<S, N>,
    /// ∇u at the corners of elements of degree 2.
    at_corners: [Tensor<S>; CORNERS],
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
        let at_corners = [edges; CORNERS];
        let volume = det * (1.0 / 6.0);
        let mut batch = Self { simd, iterate, to_rest, volume, elements, u, at_corners };
        if N == QUADRATIC {
            batch.set_corners();
        }
        batch
    }

    /// Sets ∇u at the corners.
    #[inline(always)]
    fn set_corners(&mut self) {
        for c in 0..CORNERS {
            // ∂u/∂λ_m
            let mut by = [[self.splat(0.0); 3]; CORNERS];
            for i in 0..3 {
                for m in 0..CORNERS {
                    by[m][i] = if m == c { self.u[c][i] * 3.0 } else { -self.u[m][i] };
                }
                for (edge, [a, b]) in EDGES.into_iter().enumerate() {
                    let four = self.u[CORNERS + edge][i] * 4.0;
                    if a == c {
                        by[b][i] += four;
                    } else if b == c {
                        by[a][i] += four;
                    }
                }
            }
            for i in 0..3 {
                let [x, y, z] = [by[1][i] - by[0][i], by[2][i] - by[0][i], by[3][i] - by[0][i]];
                for j in 0..3 {
                    let to = &self.to_rest;
                    self.at_corners[c][i][j] =
                        x.mul_add(to[0][j], y.mul_add(to[1][j], z * to[2][j]));
                }
            }
        }
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

    /// ∇u = Σ u_a ⊗ ∇φ_a at quadrature point q, where the basis has these gradients.
    #[inline(always)]
    pub(in crate::energy) fn grad_u(&self, q: usize, gradients: &Nodal<S, N>) -> Tensor<S> {
        let mut sum = [[Lanes::splat(self.simd, 0.0); 3]; 3];
        if N == QUADRATIC {
            for c in 0..CORNERS {
                let share = self.coordinate(q, c);
                for i in 0..3 {
                    for j in 0..3 {
                        sum[i][j] = share.mul_add(self.at_corners[c][i][j], sum[i][j]);
                    }
                }
            }
            return sum;
        }
        for (u, g) in self.u.iter().zip(gradients) {
            for i in 0..3 {
                for j in 0..3 {
                    sum[i][j] = u[i].mul_add(g[j], sum[i][j]);
                }
            }
        }
        sum
    }

    /// λ_c at quadrature point q.
    #[inline(always)]
    fn coordinate(&self, q: usize, c: usize) -> Lanes<S> {
        self.splat(self.iterate.space.volume_table().points[q][c])
    }
}

/// Σ_q w P ∇φ_a of tensors P at quadrature points.
#[derive(Clone, Copy)]
pub(in crate::energy) struct Forces<S: Simd, const N: usize> {
    of_nodes: Nodal<S, N>,
    /// Σ_q w λ_c P in elements of degree 2.
    of_corners: [Tensor<S>; CORNERS],
}

impl<S: Simd, const N: usize> Forces<S, N> {
    /// The sums before a point is added.
    #[inline(always)]
    pub(in crate::energy) fn none(batch: &Batch<S, N>) -> Self {
        let zero = batch.splat(0.0);
        Self { of_nodes: [[zero; 3]; N], of_corners: [[[zero; 3]; 3]; CORNERS] }
    }

    /// Adds w P of quadrature point q, where the basis has these gradients.
    #[inline(always)]
    pub(in crate::energy) fn add(
        &mut self,
        batch: &Batch<S, N>,
        q: usize,
        gradients: &Nodal<S, N>,
        stress: &Tensor<S>,
    ) {
        if N == QUADRATIC {
            for c in 0..CORNERS {
                let share = batch.coordinate(q, c);
                for i in 0..3 {
                    for j in 0..3 {
                        let sum = &mut self.of_corners[c][i][j];
                        *sum = share.mul_add(stress[i][j], *sum);
                    }
                }
            }
            return;
        }
        for (force, g) in self.of_nodes.iter_mut().zip(gradients) {
            add_product(stress, g, force);
        }
    }

    /// The sums.
    #[inline(always)]
    pub(in crate::energy) fn of_nodes(self, batch: &Batch<S, N>) -> Nodal<S, N> {
        let Self { mut of_nodes, of_corners } = self;
        if N != QUADRATIC {
            return of_nodes;
        }
        // the barycentric coordinates' gradients
        let to = &batch.to_rest;
        let mut g = [[batch.splat(0.0); 3]; CORNERS];
        for j in 0..3 {
            g[0][j] = -(to[0][j] + to[1][j] + to[2][j]);
            (g[1][j], g[2][j], g[3][j]) = (to[0][j], to[1][j], to[2][j]);
        }
        let mut whole = of_corners[0];
        for of_corner in &of_corners[1..] {
            for i in 0..3 {
                for j in 0..3 {
                    whole[i][j] += of_corner[i][j];
                }
            }
        }
        for a in 0..CORNERS {
            let mut own = scaled(&of_corners[a], batch.splat(4.0));
            for i in 0..3 {
                for j in 0..3 {
                    own[i][j] -= whole[i][j];
                }
            }
            add_product(&own, &g[a], &mut of_nodes[a]);
        }
        for (edge, [a, b]) in EDGES.into_iter().enumerate() {
            let force = &mut of_nodes[CORNERS + edge];
            add_product(&of_corners[b], &g[a], force);
            add_product(&of_corners[a], &g[b], force);
            for i in 0..3 {
                force[i] = force[i] * 4.0;
            }
        }
        of_nodes
    }
}

/// Adds P g.
#[inline(always)]
fn add_product<S: Simd>(stress: &Tensor<S>, g: &[Lanes<S>; 3], force: &mut [Lanes<S>; 3]) {
    for i in 0..3 {
        let along = stress[i][1].mul_add(g[1], stress[i][2].mul_add(g[2], force[i]));
        force[i] = stress[i][0].mul_add(g[0], along);
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
