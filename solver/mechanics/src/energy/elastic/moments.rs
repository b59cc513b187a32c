//! Hessians of elements of degree 2 by second moments of the tangent.
//!
//! In a straight-sided element the gradients of the basis are linear, ∇φ_a = Σ_c λ_c ∇φ_a|_c with the barycentric
//! coordinates λ and values at corners c, so that ten moments of the tangent A stand for all quadrature points:
//!
//! ∂²E/∂u_a∂u_b = Σ_cd ∇φ_a|_c · M_cd · ∇φ_b|_d      M_cd = ∫ λ_c λ_d A dX
//!
//! The gradients at the corners are those of [`Batch`]. With
//! M_cd[m n] = ∇λ_m · M_cd · ∇λ_n, S_c = Σ_d M_cd and T = Σ_c S_c the blocks are
//!
//! corners a, b:        16 M_ab[a b] − 4 S_a[a b] − 4 S_b[a b] + T[a b]
//! edge ab, corner c:   4 (4 M_bc − S_b)[a c] + 4 (4 M_ac − S_a)[b c]
//! edges ab, cd:        16 (M_bd[a c] + M_bc[a d] + M_ad[b c] + M_ac[b d])
//!
//! The exact Hessian of an element with 14 points takes 0.6 of the time of a sum over points and pairs.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use pulp::Simd;

use crate::element::{EDGES, Tabulation};
use crate::energy::elements::{Batch, CORNERS};
use crate::math::lanes::Lanes;
use crate::math::lanes::projection::Tangents;
use crate::math::lanes::tensor::Tensor;
use crate::math::sparse::{pair_count, pair_index};

/// Products λ_c λ_d, d ≤ c.
const PRODUCTS: usize = pair_count(CORNERS);
/// Their corners, in the order of [`pair_index`].
const PAIRS: [[usize; 2]; PRODUCTS] =
    [[0, 0], [1, 0], [1, 1], [2, 0], [2, 1], [2, 2], [3, 0], [3, 1], [3, 2], [3, 3]];
/// Entries of a symmetric matrix of the components (m, i) with the corners m = 1, 2, 3.
const ENTRIES: usize = pair_count(9);
/// Entries of such a matrix that has corner 0, too, whose components come last.
const ALL_ENTRIES: usize = pair_count(3 * CORNERS);

/// M_cd, S_c and T of one entry.
type Moment<S> = [Lanes<S>; PRODUCTS + CORNERS + 1];

/// Memory for the moments of a batch.
pub(super) struct Moments<S: Simd> {
    /// w λ_c λ_d at each quadrature point.
    factors: Vec<[f64; PRODUCTS]>,
    /// The tangent of each quadrature point in the gradients of barycentric coordinates.
    points: Vec<[Lanes<S>; ENTRIES]>,
    /// The moments of each entry.
    entries: Vec<Moment<S>>,
}

impl<S: Simd> Default for Moments<S> {
    fn default() -> Self {
        Self { factors: Vec::new(), points: Vec::new(), entries: Vec::new() }
    }
}

impl<S: Simd> Moments<S> {
    /// Makes room for the points of a rule, which is the same for all batches.
    #[inline(always)]
    pub(super) fn reserve(&mut self, rule: &Tabulation, zero: Lanes<S>) {
        if self.points.is_empty() {
            let of = |(w, l): (&f64, &Vec<f64>)| {
                std::array::from_fn(|p| w * l[PAIRS[p][0]] * l[PAIRS[p][1]])
            };
            self.factors = rule.weights.iter().zip(&rule.points).map(of).collect();
            self.points.resize(rule.weights.len(), [zero; ENTRIES]);
            self.entries.resize(ALL_ENTRIES, [zero; PRODUCTS + CORNERS + 1]);
        }
    }

    /// Sets the tangent of quadrature point q.
    #[inline(always)]
    pub(super) fn set(&mut self, q: usize, tangents: &Tangents<S>, to_rest: &Tensor<S>) {
        let zero = tangents[0][0].zero();
        // by the second derivative: (i, j), (k, n) at [3 j + i][3 n + k]
        let mut half = [[zero; 9]; 9];
        for row in 0..9 {
            for k in 0..3 {
                let first = tangents[row.max(k)][row.min(k)];
                let second = tangents[row.max(3 + k)][row.min(3 + k)];
                let third = tangents[row.max(6 + k)][row.min(6 + k)];
                for n in 0..3 {
                    let g = &to_rest[n];
                    half[row][3 * n + k] = first.mul_add(g[0], second.mul_add(g[1], third * g[2]));
                }
            }
        }
        let entries = &mut self.points[q];
        for m in 0..3 {
            let g = &to_rest[m];
            for i in 0..3 {
                for column in 0..=3 * m + i {
                    let by = g[1].mul_add(half[3 + i][column], g[2] * half[6 + i][column]);
                    entries[pair_index(3 * m + i, column)] = g[0].mul_add(half[i][column], by);
                }
            }
        }
    }

    /// The moments, once all points are set.
    #[inline(always)]
    pub(super) fn integrate<const N: usize>(&mut self, batch: &Batch<S, N>) {
        let zero = batch.splat(0.0);
        for entry in 0..ENTRIES {
            let mut sums = [zero; PRODUCTS];
            for (point, factors) in self.points.iter().zip(&self.factors) {
                for p in 0..PRODUCTS {
                    sums[p] = point[entry].mul_add(batch.splat(factors[p]), sums[p]);
                }
            }
            for p in 0..PRODUCTS {
                self.entries[entry][p] = sums[p] * batch.volume;
            }
        }
        self.add_first_corner();
        for moment in &mut self.entries {
            add_sums(moment);
        }
    }

    /// The entries of corner 0, whose barycentric coordinate has the gradient −Σ ∇λ_m.
    #[inline(always)]
    fn add_first_corner(&mut self) {
        for i in 0..3 {
            for column in 0..9 + i + 1 {
                for product in 0..PRODUCTS {
                    let first = self.entries[symmetric(i, column)][product];
                    let second = self.entries[symmetric(3 + i, column)][product];
                    let third = self.entries[symmetric(6 + i, column)][product];
                    self.entries[pair_index(9 + i, column)][product] = -(first + second + third);
                }
            }
        }
    }

    /// The block of two nodes, entry (i, j) at 3 i + j; a ≥ b.
    #[inline(always)]
    pub(super) fn block(&self, a: usize, b: usize) -> [Lanes<S>; 9] {
        let mut block = [self.entries[0][0]; 9];
        if a < CORNERS {
            let moments = self.of(a, b);
            for e in 0..9 {
                let m = moments[e];
                let [s_a, s_b, t] = [m[PRODUCTS + a], m[PRODUCTS + b], m[PRODUCTS + CORNERS]];
                block[e] = (m[symmetric(a, b)] * 4.0 - s_a - s_b) * 4.0 + t;
            }
            return block;
        }
        let [from, to] = EDGES[a - CORNERS];
        if b < CORNERS {
            let (of_from, of_to) = (self.of(from, b), self.of(to, b));
            for e in 0..9 {
                let by_from = of_from[e][symmetric(to, b)] * 4.0 - of_from[e][PRODUCTS + to];
                let by_to = of_to[e][symmetric(from, b)] * 4.0 - of_to[e][PRODUCTS + from];
                block[e] = (by_from + by_to) * 4.0;
            }
            return block;
        }
        let [start, end] = EDGES[b - CORNERS];
        let [from_start, from_end] = [self.of(from, start), self.of(from, end)];
        let [to_start, to_end] = [self.of(to, start), self.of(to, end)];
        for e in 0..9 {
            let by_from = from_start[e][symmetric(to, end)] + from_end[e][symmetric(to, start)];
            let by_to = to_start[e][symmetric(from, end)] + to_end[e][symmetric(from, start)];
            block[e] = (by_from + by_to) * 16.0;
        }
        block
    }

    /// The moments of each entry of two corners.
    #[inline(always)]
    fn of(&self, m: usize, n: usize) -> [&Moment<S>; 9] {
        let (row, column) = (3 * ((m + CORNERS - 1) % CORNERS), 3 * ((n + CORNERS - 1) % CORNERS));
        let mut of = [&self.entries[0]; 9];
        for i in 0..3 {
            for j in 0..3 {
                of[3 * i + j] = &self.entries[symmetric(row + i, column + j)];
            }
        }
        of
    }
}

/// S_c and T of M_cd.
#[inline(always)]
fn add_sums<S: Simd>(moment: &mut Moment<S>) {
    let mut whole = moment[0].zero();
    for c in 0..CORNERS {
        let mut sum = moment[symmetric(c, 0)];
        for d in 1..CORNERS {
            sum += moment[symmetric(c, d)];
        }
        moment[PRODUCTS + c] = sum;
        whole += sum;
    }
    moment[PRODUCTS + CORNERS] = whole;
}

/// Index of an entry of a symmetric matrix, or of λ_c λ_d among the products.
#[inline(always)]
fn symmetric(row: usize, column: usize) -> usize {
    pair_index(row.max(column), row.min(column))
}
