//! Mean dilatation: the volume of an element changes as a whole.
//!
//! E_e(u; X) = ∫ ψ_p(F) dX + V U(J̄)      J̄ = (1/V) ∫ J dX      ψ(F) = ψ_p(F) + U(J)
//!
//! With s_a = (1/V) ∫ cof F ∇φ_a dX = ∂J̄/∂u_a, and p = U'(J̄) [Pa] in place of U'(J):
//!
//! ∂E/∂u_a = ∫ (P_p + p cof F) ∇φ_a dX
//! ∂²E/∂u_a∂u_b = ∫ ∇φ_a · (A_p + p ∂²J/∂F²) · ∇φ_b dX + V U''(J̄) s_a s_bᵀ
//!
//! which couples the nodes of an element, as the standard one does. Shape derivative along a velocity
//! field V⃗, whose gradient is constant in an element, with nodal u fixed: that of the pointwise law with
//! P = P_p + p cof F and A = A_p + p ∂²J/∂F², and from δJ̄ = −(1/V) ∫ ∇uᵀ cof F dX : ∇V⃗
//!
//! δ(λ·∂E/∂u) ∋ U''(J̄) δJ̄ ∫ cof F : ∇λ dX
//!
//! The pressure is thus constant in an element. In one of degree 1 J is, so that there is no difference.
//! Where the pressure varies in an element, as over the height of a bar that bends, it is too soft: a bar of
//! one cell of degree 2 by 15 %, of two cells by 2.5 %, whatever its bulk modulus.
//!
//! The projected Hessian has the tangent A_p + p ∂²J/∂F² of every point made positive semidefinite, and
//! the part of rank one with max(U'', 0). The finger at 120 kPa takes 12 iterations of Newton's method, 15
//! with the standard element; an iteration takes 1.05 times as long.
//!
//! Source: Nagtegaal, Parks and Rice 1974, doi:10.1016/0045-7825(74)90032-2; Hughes 1980,
//! doi:10.1002/nme.1620150914; of finite strain Simo, Taylor and Pister 1985,
//! doi:10.1016/0045-7825(85)90033-7.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use pulp::Simd;

use crate::energy::elements::{Batch, points};
use crate::energy::{Hessian, Iterate};
use crate::material::{Kinematics, Material, Split, add_j_hessian, j_minus_1};
use crate::math::lanes::projection::Tangents;
use crate::math::lanes::tensor::{Tensor, cofactor, plus_identity, scaled};
use crate::math::lanes::{Lanes, MOST};
use crate::math::tensor::Mat3;

/// U and its derivatives at the mean dilatations of elements side by side.
pub(super) struct Mean<S: Simd> {
    /// U [J/m³].
    pub(super) values: [f64; MOST],
    /// p = U' [Pa].
    pressure: Lanes<S>,
    /// U'' [Pa].
    stiffness: Lanes<S>,
}

impl<S: Simd> Mean<S> {
    /// U and its derivatives for the elements of a batch.
    #[inline(always)]
    pub(super) fn new<const N: usize>(batch: &Batch<S, N>, split: &Split) -> Self {
        let simd = batch.simd;
        let mut mean = Lanes::splat(simd, 0.0);
        for (q, weight) in points::<N>(batch.iterate) {
            mean += j_minus_1(&batch.grad_u(q, &batch.gradients(q))) * weight;
        }
        let each = mean.to_array();
        let mut by = [[0.0; MOST]; 3];
        for l in 0..Lanes::<S>::COUNT {
            let of = split.volumetric(each[l]);
            for k in 0..3 {
                by[k][l] = of[k];
            }
        }
        let [values, first, second] = by;
        let (pressure, stiffness) = (Lanes::load(simd, &first), Lanes::load(simd, &second));
        Self { values, pressure, stiffness }
    }

    /// Adds p cof F.
    #[inline(always)]
    pub(super) fn add_stress(&self, grad_u: &Tensor<S>, stress: &mut Tensor<S>) {
        let by_j = cofactor_of(self.pressure, grad_u);
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] += self.pressure * by_j[i][j];
            }
        }
    }

    /// Adds p ∂²J/∂F².
    #[inline(always)]
    pub(super) fn add_tangent(&self, grad_u: &Tensor<S>, tangents: &mut Tangents<S>) {
        let f = plus_identity(grad_u, self.pressure.zero() + 1.0);
        add_j_hessian(&f, self.pressure, tangents);
    }

    /// w cof F, of which s_a is the sum Σ_q w cof F ∇φ_a.
    #[inline(always)]
    pub(super) fn volume_change(&self, grad_u: &Tensor<S>, weight: f64) -> Tensor<S> {
        scaled(&cofactor_of(self.pressure, grad_u), self.pressure.zero() + weight)
    }

    /// U'', in a projected Hessian not below zero.
    #[inline(always)]
    pub(super) fn stiffness(&self, kind: Hessian) -> Lanes<S> {
        let (own, zero) = (self.stiffness, self.stiffness.zero());
        if kind == Hessian::Projected { own.if_positive(own, zero) } else { own }
    }
}

/// cof F; of `like` only the kind of vector counts.
#[inline(always)]
fn cofactor_of<S: Simd>(like: Lanes<S>, grad_u: &Tensor<S>) -> Tensor<S> {
    cofactor(&plus_identity(grad_u, like.zero() + 1.0))
}

/// Adds c s_a s_bᵀ to a block; entry (i, j) at 3 i + j.
#[inline(always)]
pub(super) fn add_dyad<S: Simd>(
    s_a: &[Lanes<S>; 3],
    s_b: &[Lanes<S>; 3],
    scale: Lanes<S>,
    block: &mut [Lanes<S>; 9],
) {
    for i in 0..3 {
        let by = scale * s_a[i];
        for j in 0..3 {
            block[3 * i + j] = by.mul_add(s_b[j], block[3 * i + j]);
        }
    }
}

/// A law in one element of a state.
pub struct ElementLaw<'a> {
    /// ψ, or ψ_p.
    pub(super) law: &'a dyn Material,
    /// Where the volume of the element changes as a whole.
    pub(super) dilatation: Option<Dilatation<'a>>,
}

/// The mean dilatation of one element.
pub(super) struct Dilatation<'a> {
    split: &'a Split,
    /// J̄ − 1.
    mean: f64,
    /// U [J/m³], U' and U'' [Pa] there.
    by: [f64; 3],
}

impl<'a> ElementLaw<'a> {
    pub(super) fn new(
        law: &'a dyn Material,
        split: Option<&'a Split>,
        at: &Iterate,
        element: usize,
    ) -> Self {
        let dilatation = split.map(|split| {
            let weights = &at.space.volume_table().weights;
            let gradients = at.space.displacement_gradients(at.rest, at.u, element);
            let each = weights.iter().zip(gradients);
            let mean = each.map(|(w, grad_u)| w * Kinematics::new(&grad_u).j_minus_1).sum();
            Dilatation { split, mean, by: split.volumetric(mean) }
        });
        Self { law, dilatation }
    }

    /// ψ, or ψ_p + U(J̄) [J/m³].
    #[must_use]
    pub fn energy_density(&self, k: &Kinematics) -> f64 {
        let pointwise = self.law.energy_density(k);
        self.dilatation.as_ref().map_or(pointwise, |mean| pointwise + mean.by[0])
    }

    /// P, or P_p + p cof F [Pa].
    #[must_use]
    pub fn first_piola(&self, k: &Kinematics) -> Mat3 {
        let pointwise = self.law.first_piola(k);
        self.dilatation.as_ref().map_or(pointwise, |mean| pointwise + mean.by[1] * k.cofactor)
    }
}

impl Dilatation<'_> {
    /// U' [Pa].
    pub(super) fn pressure(&self) -> f64 {
        self.by[1]
    }

    /// U'' [Pa].
    pub(super) fn stiffness(&self) -> f64 {
        self.by[2]
    }

    /// Adds bar ∂U'/∂parameters.
    pub(super) fn add_parameter_vjp(&self, bar: f64, out: &mut [f64]) {
        self.split.add_volumetric_vjp(self.mean, bar, out);
    }
}
