//! Ogden's law of N terms in principal stretches.
//!
//! ψ = Σ_p μ_p/α_p (λ̄₁^α_p + λ̄₂^α_p + λ̄₃^α_p − 3) + ½ bulk ln²J
//! λ̄ᵢ = J^{−1/3} λᵢ
//!
//! With εᵢ = ln λ̄ᵢ, s(ε) = Σ_p μ_p exp(α_p ε) and unit axes nᵢ of FFᵀ, Nᵢ of FᵀF:
//!
//! P = Σᵢ βᵢ/λᵢ nᵢ⊗Nᵢ      βᵢ = s(εᵢ) − ⅓ Σₖ s(εₖ) + bulk ln J
//!
//! and, for i ≠ j, with d_ij = (βᵢ − βⱼ)/(λᵢ² − λⱼ²):
//! A_ijij = d_ij      A_ijji = (λⱼ/λᵢ) d_ij − βⱼ/(λᵢλⱼ)
//!
//! Since εᵢ sum to zero, ψ = Σ μ/α Σ(exp(αεᵢ) − 1 − αεᵢ), all positive terms of
//! second order; and d_ij = J^{−2/3} Σ μ exp((α − 2)m) sinh(αδ/2)/sinh δ, where
//! m is the mean and δ the difference of εᵢ and εⱼ: repeated stretches need no
//! tolerance.
//!
//! Source: Ogden 1972, doi:10.1098/rspa.1972.0026, with μ_p as there (Abaqus
//! writes 2μ_p/α_p in place of μ_p); tangent: Ogden, "Non-linear Elastic
//! Deformations", section 6.1.

use nalgebra::Vector3;

use super::law::{Law, Moduli, PA, Parameter};
use super::{Decoupled, Invariants, Kinematics, Material, Partials, Split};
use crate::math::lanes::exp_m1_minus;
use crate::math::tensor::{Mat3, Mat9};

/// Parameters of the law.
#[derive(Clone, Debug, PartialEq)]
pub struct Ogden {
    /// (μ_p [Pa], α_p [1]) of every term.
    pub terms: Vec<(f64, f64)>,
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "ogden",
    formula: "ψ = Σ mu/alpha (λ̄1^alpha + λ̄2^alpha + λ̄3^alpha − 3) + ½ bulk ln²J",
    parameters: &[
        Parameter::list("mu", PA, "stress-like coefficients, one per term"),
        Parameter::list("alpha", "1", "exponents, not 0, one per term"),
        Parameter::one("bulk", PA, "bulk modulus"),
    ],
    shear: "½ Σ mu alpha",
    bulk: "bulk",
    source: "Ogden 1972, doi:10.1098/rspa.1972.0026 (Abaqus' mu is ½ mu alpha of this one)",
    limits: "stable at any stretch when mu alpha > 0 in every term and |alpha| is 2 or more",
    objective: true,
    moduli: |p| {
        let n = p.len() / 2;
        let shear = p[..n].iter().zip(&p[n..2 * n]).map(|(mu, alpha)| 0.5 * mu * alpha).sum();
        Moduli { shear, bulk: p[2 * n] }
    },
    build: |p| {
        let n = p.len() / 2;
        let terms = p[..n].iter().copied().zip(p[n..2 * n].iter().copied()).collect();
        Box::new(Ogden { terms, bulk: p[2 * n] })
    },
    // α = 0 makes a term of no stiffness an infinite energy: no modulus at all
    refuses: |p| {
        let at = p[p.len() / 2..p.len() - 1].iter().position(|alpha| *alpha == 0.0)?;
        Some(format!("alpha of term {} is 0: must not be 0; leave that term out", at + 1))
    },
    sample: &[34e3, -12e3, 2.9, -1.7, 2.5e6],
};

/// F = Σ λᵢ nᵢ⊗Nᵢ.
struct Principal {
    /// Axes nᵢ of FFᵀ, in columns.
    left: Mat3,
    /// Axes Nᵢ of FᵀF, in columns.
    right: Mat3,
    /// λᵢ.
    stretch: Vector3<f64>,
    /// εᵢ = ln λᵢ − ⅓ ln J.
    strain: Vector3<f64>,
    log_j: f64,
}

impl Principal {
    fn new(k: &Kinematics) -> Self {
        let eigen = k.left_minus_1().symmetric_eigen();
        let log = eigen.eigenvalues.map(|g| 0.5 * g.ln_1p());
        let mean = log.sum() / 3.0;
        let stretch = log.map(f64::exp);
        let mut right = k.f.transpose() * eigen.eigenvectors;
        for (i, l) in stretch.iter().enumerate() {
            right.column_mut(i).unscale_mut(*l);
        }
        Self {
            left: eigen.eigenvectors,
            right,
            stretch,
            strain: log.add_scalar(-mean),
            log_j: k.log_j(),
        }
    }

    /// Σ valueᵢ/λᵢ nᵢ⊗Nᵢ, the first Piola stress of Kirchhoff stresses.
    fn to_piola(&self, kirchhoff: &Vector3<f64>) -> Mat3 {
        let scaled = kirchhoff.component_div(&self.stretch);
        self.left * Mat3::from_diagonal(&scaled) * self.right.transpose()
    }
}

impl Ogden {
    /// βᵢ: principal Kirchhoff stresses [Pa].
    fn kirchhoff(&self, p: &Principal) -> Vector3<f64> {
        let mut beta = Vector3::from_element(self.bulk * p.log_j);
        for &(mu, alpha) in &self.terms {
            beta += mu * deviator(&p.strain.map(|e| (alpha * e).exp_m1()));
        }
        beta
    }

    /// ∂βᵢ/∂ln λⱼ [Pa].
    fn slopes(&self, p: &Principal) -> Mat3 {
        let w: Vector3<f64> = p.strain.map(|e| {
            self.terms.iter().map(|(mu, alpha)| mu * alpha * (alpha * e).exp()).sum::<f64>()
        });
        let mean = w.sum() / 9.0 + self.bulk;
        Mat3::from_fn(|i, j| mean - (w[i] + w[j]) / 3.0 + if i == j { w[i] } else { 0.0 })
    }

    /// d_ij = (βᵢ − βⱼ)/(λᵢ² − λⱼ²) [Pa].
    fn quotient(&self, p: &Principal, i: usize, j: usize) -> f64 {
        let mean = 0.5 * (p.strain[i] + p.strain[j]);
        let delta = p.strain[i] - p.strain[j];
        let one = |&(mu, alpha): &(f64, f64)| {
            let ratio = if delta == 0.0 {
                0.5 * alpha
            } else {
                (0.5 * alpha * delta).sinh() / delta.sinh()
            };
            mu * ((alpha - 2.0) * mean).exp() * ratio
        };
        (-2.0 / 3.0 * p.log_j).exp() * self.terms.iter().map(one).sum::<f64>()
    }
}

impl Material for Ogden {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() <= 0.0 {
            return f64::INFINITY;
        }
        let p = Principal::new(k);
        let term = |&(mu, alpha): &(f64, f64)| {
            mu / alpha * p.strain.map(|e| exp_m1_minus(alpha * e)).sum()
        };
        self.terms.iter().map(term).sum::<f64>() + 0.5 * self.bulk * p.log_j * p.log_j
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        let p = Principal::new(k);
        p.to_piola(&self.kirchhoff(&p))
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let p = Principal::new(k);
        let (beta, slopes) = (self.kirchhoff(&p), self.slopes(&p));
        let dyad = |i: usize, j: usize| {
            crate::math::tensor::vec9(&(p.left.column(i) * p.right.column(j).transpose()))
        };
        let mut a = Mat9::zeros();
        for i in 0..3 {
            for j in 0..3 {
                let product = p.stretch[i] * p.stretch[j];
                let own = if i == j { beta[i] } else { 0.0 };
                a += ((slopes[(i, j)] - own) / product) * dyad(i, i) * dyad(j, j).transpose();
                if i != j {
                    let d = self.quotient(&p, i, j);
                    let crossed = p.stretch[j] / p.stretch[i] * d - beta[j] / product;
                    let left = d * dyad(i, j) + crossed * dyad(j, i);
                    a += left * dyad(i, j).transpose();
                }
            }
        }
        a
    }

    fn parameter_count(&self) -> usize {
        2 * self.terms.len() + 1
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        let p = Principal::new(k);
        let n = self.terms.len();
        let along = |kirchhoff: &Vector3<f64>| p.to_piola(kirchhoff).dot(p_bar);
        for (t, &(mu, alpha)) in self.terms.iter().enumerate() {
            out[t] += along(&deviator(&p.strain.map(|e| (alpha * e).exp_m1())));
            out[n + t] += along(&deviator(&p.strain.map(|e| mu * e * (alpha * e).exp())));
        }
        out[2 * n] += along(&Vector3::from_element(p.log_j));
    }

    fn split(&self) -> Option<Split> {
        let (bulk, terms) = (self.bulk, self.terms.len());
        Some(Split::by_difference(self.clone(), Volume { bulk, terms }))
    }
}

/// ½ bulk ln²J.
#[derive(Clone)]
struct Volume {
    bulk: f64,
    /// Number of terms, whose parameters come before the bulk modulus.
    terms: usize,
}

impl Decoupled for Volume {
    fn partials(&self, at: &Invariants) -> Partials {
        Partials::half_log_squared(self.bulk, at)
    }

    fn parameter_count(&self) -> usize {
        2 * self.terms + 1
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        out[2 * self.terms] += 0.5 * at.log_j * at.log_j * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        out[2 * self.terms] += at.log_j / at.j * bar[2];
    }
}

fn deviator(v: &Vector3<f64>) -> Vector3<f64> {
    v.add_scalar(-v.sum() / 3.0)
}
