//! Laws given as ψ(I₁, I₂, J): stress and tangent by the chain rule.
//!
//! ∂I₁/∂F = 2F      ∂I₂/∂F = 2(I₁F − FC)      ∂J/∂F = cof F
//!
//! Source: Bonet and Wood, "Nonlinear Continuum Mechanics for Finite Element
//! Analysis", chapter on hyperelasticity.

use super::{Kinematics, Material};
use crate::math::tensor::{Mat3, Mat9, cross_matrix, vec9};

/// ψ and its derivatives with respect to (I₁, I₂, J) [J/m³].
pub struct Partials {
    /// ψ.
    pub value: f64,
    /// ∂ψ/∂(I₁, I₂, J).
    pub first: [f64; 3],
    /// Second derivatives in the order 11, 12, 22, 1J, 2J, JJ.
    pub second: [f64; 6],
}

/// An isotropic law; J > 0 is given.
pub trait Isotropic: Send + Sync {
    /// ψ and its derivatives.
    fn partials(&self, k: &Kinematics) -> Partials;
}

impl<T: Isotropic> Material for T {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() > 0.0 { self.partials(k).value } else { f64::INFINITY }
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        let [p1, p2, pj] = self.partials(k).first;
        2.0 * p1 * k.f + p2 * i2_gradient(k) + pj * k.cofactor
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let p = self.partials(k);
        let (g1, g2, gj) = (2.0 * vec9(&k.f), vec9(&i2_gradient(k)), vec9(&k.cofactor));
        let [s11, s12, s22, s1j, s2j, sjj] = p.second;
        let h1 = s11 * g1 + s12 * g2 + s1j * gj;
        let h2 = s12 * g1 + s22 * g2 + s2j * gj;
        let hj = s1j * g1 + s2j * g2 + sjj * gj;
        let mut a = g1 * h1.transpose() + g2 * h2.transpose() + gj * hj.transpose();
        let [p1, p2, pj] = p.first;
        for i in 0..9 {
            a[(i, i)] += 2.0 * p1;
        }
        add_i2_hessian(k, p2, &mut a);
        add_j_hessian(k, pj, &mut a);
        a
    }
}

fn i1(k: &Kinematics) -> f64 {
    k.i1_minus_3 + 3.0
}

fn i2_gradient(k: &Kinematics) -> Mat3 {
    2.0 * (i1(k) * k.f - k.f * k.c)
}

/// ∂²I₂/∂F² : H = 2[2(F:H)F + I₁H − HC − FHᵀF − FFᵀH].
fn add_i2_hessian(k: &Kinematics, scale: f64, a: &mut Mat9) {
    if scale == 0.0 {
        return;
    }
    let s = 2.0 * scale;
    let f = vec9(&k.f);
    *a += (2.0 * s) * f * f.transpose();
    let b = k.f * k.f.transpose();
    for j in 0..3 {
        for i in 0..3 {
            let row = 3 * j + i;
            a[(row, row)] += s * i1(k);
            for m in 0..3 {
                a[(row, 3 * m + i)] -= s * k.c[(m, j)];
                a[(row, 3 * j + m)] -= s * b[(i, m)];
                for l in 0..3 {
                    a[(row, 3 * l + m)] -= s * k.f[(i, l)] * k.f[(m, j)];
                }
            }
        }
    }
}

/// ∂²J/∂F²: column c of cof F is f_{c+1} × f_{c+2}.
fn add_j_hessian(k: &Kinematics, scale: f64, a: &mut Mat9) {
    for c in 0..3 {
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        let (f1, f2) = (k.f.column(c1).into_owned(), k.f.column(c2).into_owned());
        let mut by_c1 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c1);
        by_c1 -= scale * cross_matrix(&f2);
        let mut by_c2 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c2);
        by_c2 += scale * cross_matrix(&f1);
    }
}
