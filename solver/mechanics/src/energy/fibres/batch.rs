//! Elements with fibres side by side, one in each lane: their energies, forces and Hessians.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use std::ops::Range;

use pulp::Simd;

use super::Fibres;
use crate::element::FunctionSpace;
use crate::energy::elements::{Batch, Blocks, ElementEnergy, Nodal, points};
use crate::energy::{Hessian, Iterate, Profile, Slot};
use crate::material::fibre::Fibre;
use crate::math::lanes::tensor::{Tensor, plus_identity, scaled};
use crate::math::lanes::{Lanes, MOST};
use crate::math::sparse::pair_index;
use mesh::Vec3;

/// A vector in each lane.
type Vector<S> = [Lanes<S>; 3];

/// Fibres of consecutive elements at a quadrature point.
struct Points<S: Simd> {
    /// F.
    f: Tensor<S>,
    /// a₀.
    along: Vector<S>,
    /// κ and 1 − 3κ.
    shares: [Lanes<S>; 2],
    /// ε.
    strain: Lanes<S>,
}

/// ψ, ψ′ and ψ″ of each lane.
type Responses<S> = [Lanes<S>; 3];

#[inline(always)]
fn dot<S: Simd>(a: &Vector<S>, b: &Vector<S>) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
fn apply<S: Simd>(a: &Tensor<S>, v: &Vector<S>) -> Vector<S> {
    [dot(&a[0], v), dot(&a[1], v), dot(&a[2], v)]
}

/// The element in a lane, and the rest position at barycentric coordinates in it [m].
#[inline(always)]
fn place<S: Simd, const N: usize>(
    batch: &Batch<S, N>,
    lambda: &[f64],
    lane: usize,
) -> (usize, Vec3) {
    let Batch { iterate, elements, .. } = batch;
    let e = (elements.start + lane).min(elements.end - 1);
    let corners = iterate.space.tets()[e].iter().zip(lambda);
    (e, corners.map(|(&v, l)| *l * iterate.rest[v]).sum())
}

/// a₀ at barycentric coordinates in each of some elements.
#[inline(always)]
fn directions<S: Simd, const N: usize>(
    batch: &Batch<S, N>,
    fibres: &Fibres,
    lambda: &[f64],
) -> Vector<S> {
    let mut values = [[0.0; MOST]; 3];
    for lane in 0..Lanes::<S>::COUNT {
        let (e, place) = place(batch, lambda, lane);
        let along = fibres.along(e, place);
        for i in 0..3 {
            values[i][lane] = along[i];
        }
    }
    values.map(|value| Lanes::load(batch.simd, &value))
}

impl<S: Simd> Points<S> {
    #[inline(always)]
    fn new(fibres: &Fibres, grad_u: &Tensor<S>, along: Vector<S>) -> Self {
        let h = grad_u;
        let one = along[0].zero() + 1.0;
        let shares = [one * fibres.law.dispersion, one * (1.0 - 3.0 * fibres.law.dispersion)];
        // 2G = h + hᵀ + hᵀh: along a₀ and its trace
        let moved = apply(h, &along);
        let own = dot(&along, &moved) * 2.0 + dot(&moved, &moved);
        let mut trace = (h[0][0] + h[1][1] + h[2][2]) * 2.0;
        for row in h {
            trace += dot(row, row);
        }
        let strain = shares[0] * trace + shares[1] * own;
        Self { f: plus_identity(h, one), along, shares, strain }
    }

    /// Of the law in each lane.
    #[inline(always)]
    fn responses(&self, simd: S, law: impl Fn(usize) -> Fibre) -> Responses<S> {
        let strain = self.strain.to_array();
        let mut values = [[0.0; MOST]; 3];
        for lane in 0..Lanes::<S>::COUNT {
            let response = law(lane).response(strain[lane]);
            values[0][lane] = response.energy;
            values[1][lane] = response.slope;
            values[2][lane] = response.curvature;
        }
        values.map(|value| Lanes::load(simd, &value))
    }

    /// H g.
    #[inline(always)]
    fn structured(&self, g: &Vector<S>) -> Vector<S> {
        let own = self.shares[1] * dot(&self.along, g);
        let mut out = *g;
        for i in 0..3 {
            out[i] = own.mul_add(self.along[i], self.shares[0] * g[i]);
        }
        out
    }
}

impl Fibres {
    /// The points of elements, and fractions of the volume: one where all is constant.
    #[inline(always)]
    fn points<'a, const N: usize>(
        &self,
        iterate: &'a Iterate<'a>,
    ) -> impl Iterator<Item = (usize, f64)> + use<'a, N> {
        let weights = &iterate.space.volume_table().weights;
        let constant = N == 4 && self.is_constant();
        let all = weights.iter().copied().enumerate().filter(move |_| !constant);
        points::<N>(iterate).filter(move |_| constant).chain(all)
    }

    /// A point, with the gradients of the basis and ψ with its derivatives.
    #[inline(always)]
    fn at<S: Simd, const N: usize>(
        &self,
        batch: &Batch<S, N>,
        q: usize,
    ) -> (Points<S>, Nodal<S, N>, Responses<S>) {
        let g = batch.gradients(q);
        let lambda = &batch.iterate.space.volume_table().points[q];
        let points = Points::new(self, &batch.grad_u(q, &g), directions(batch, self, lambda));
        let responses = match &self.stiffness {
            None => points.responses(batch.simd, |_| self.law),
            Some(stiffness) => points.responses(batch.simd, |lane| Fibre {
                k1: stiffness.at(place(batch, lambda, lane).1),
                ..self.law
            }),
        };
        (points, g, responses)
    }
}

impl ElementEnergy for Fibres {
    const NAME: &'static str = "fibre";
    const REINFORCES: bool = true;

    type Memory<S: Simd, const N: usize> = Vec<Factors<S, N>>;

    fn range(&self, _: &FunctionSpace) -> Range<usize> {
        self.elements()
    }

    #[inline(always)]
    fn energies<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> [f64; MOST] {
        let volume = batch.volume.to_array();
        let mut values = [0.0; MOST];
        for (q, weight) in self.points::<N>(batch.iterate) {
            let densities = self.at(batch, q).2[0].to_array();
            for l in 0..Lanes::<S>::COUNT {
                values[l] += weight * volume[l] * densities[l];
            }
        }
        values
    }

    #[inline(always)]
    fn forces<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> Nodal<S, N> {
        let mut forces = [[batch.splat(0.0); 3]; N];
        for (q, weight) in self.points::<N>(batch.iterate) {
            let (points, g, [_, slope, _]) = self.at(batch, q);
            let by_strain = scaled(&points.f, slope * batch.volume * (2.0 * weight));
            for (force, g) in forces.iter_mut().zip(&g) {
                let pulled = apply(&by_strain, &points.structured(g));
                for i in 0..3 {
                    force[i] += pulled[i];
                }
            }
        }
        forces
    }

    #[inline(always)]
    fn write_blocks<S: Simd, const N: usize>(
        &self,
        batch: &Batch<S, N>,
        kind: Hessian,
        factors: &mut Vec<Factors<S, N>>,
        out: &mut Blocks,
    ) {
        let zero = batch.splat(0.0);
        factors.clear();
        for (q, weight) in self.points::<N>(batch.iterate) {
            let (points, g, [_, slope, curvature]) = self.at(batch, q);
            let slope = match kind {
                Hessian::Exact => slope,
                Hessian::Projected => slope.if_positive(slope, zero),
            };
            let weight = batch.volume * weight;
            factors.push(Factors::new(&points, &g, [weight * slope, weight * curvature]));
        }
        for a in 0..N {
            for b in 0..=a {
                out.write(pair_index(a, b), &block(factors, a, b, zero));
            }
        }
    }

    fn mixed_vjp(&self, at: &Iterate, lambda: &[f64], element: usize) -> [Vec3; 4] {
        self.element_mixed(at, lambda, element)
    }

    fn slots(&self) -> Vec<Slot> {
        let along = |profile: Option<&Profile>| profile.map(|profile| profile.values().len());
        let mut slots = Slot::along("k1", "Pa", along(self.stiffness.as_ref()));
        slots.extend(["k2", "dispersion"].map(|key| Slot::new(key, "1")));
        slots.extend(Slot::along("angle", "rad", along(self.directions.profile())));
        slots
    }

    fn parameter_count(&self) -> usize {
        let [stiffnesses, angles] = self.counts();
        stiffnesses + 2 + angles
    }

    fn parameters_vjp(&self, at: &Iterate, lambda: &[f64], elements: Range<usize>) -> Vec<f64> {
        elements.flat_map(|e| self.element_parameters(at, lambda, e)).collect()
    }
}

/// What the blocks of a quadrature point are made of. All points are kept, so that each block is summed
/// in registers and written once: else memory would take most of the time.
pub struct Factors<S: Simd, const N: usize> {
    /// 2 √(w ψ″) F H ∇φ_a.
    strains: Nodal<S, N>,
    /// ∇φ_a.
    gradients: Nodal<S, N>,
    /// 2 w ψ′ H ∇φ_a.
    structured: Nodal<S, N>,
}

impl<S: Simd, const N: usize> Factors<S, N> {
    #[inline(always)]
    fn new(points: &Points<S>, g: &Nodal<S, N>, [slope, curvature]: [Lanes<S>; 2]) -> Self {
        let (mut strains, mut structured) = (*g, *g);
        let (root, twice) = (curvature.sqrt() * 2.0, slope * 2.0);
        for a in 0..N {
            let h = points.structured(&g[a]);
            let strain = apply(&points.f, &h);
            for i in 0..3 {
                strains[a][i] = strain[i] * root;
                structured[a][i] = h[i] * twice;
            }
        }
        Self { strains, gradients: *g, structured }
    }
}

/// Σ 4 w ψ″ (F H ∇φ_a) ⊗ (F H ∇φ_b) + 2 w ψ′ (∇φ_a · H ∇φ_b) I; entry (i, j) at 3 i + j.
#[inline(always)]
fn block<S: Simd, const N: usize>(
    factors: &[Factors<S, N>],
    a: usize,
    b: usize,
    zero: Lanes<S>,
) -> [Lanes<S>; 9] {
    let mut sum = [zero; 9];
    for point in factors {
        let (row, column) = (&point.strains[a], &point.strains[b]);
        let geometric = dot(&point.gradients[a], &point.structured[b]);
        for i in 0..3 {
            for j in 0..3 {
                sum[3 * i + j] = row[i].mul_add(column[j], sum[3 * i + j]);
            }
            sum[4 * i] += geometric;
        }
    }
    sum
}
