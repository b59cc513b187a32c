//! The law of a family of fibres: energy per rest volume by the strain along them, beside any law of
//! the matrix.
//!
//! ψ(E) = k₁/(2k₂) (exp(k₂ q(E)) − 1)      E = κ I₁ + (1 − 3κ) I₄ − 1
//!
//! k₁  stiffness [Pa]
//! k₂  by how much it grows with strain [1]; as k₂ → 0 it is the standard reinforcing model, ψ = ½ k₁ E²
//! κ   dispersion [1], from 0 (all fibres along a₀) to 1/3 (none preferred)
//! q   E², or that of tension only with a smooth beginning, [`square`]
//!
//! I₁ = tr C and I₄ = a₀ · C a₀ are those of the whole deformation. Written with the isochoric Ī₄ = J^{−2/3} I₄,
//! fibres of a nearly incompressible body would strain by dilation alone: a ball of such material stays a ball
//! under hydrostatic tension, and stiff fibres swell instead of being stretched.
//!
//! One formula has both laws, so there is no table of them: k₂ = 0 is exact, without a division.
//! Small strain: along the fibres, Young's modulus of the matrix grows by about 4 k₁ at κ = 0, as E ≈ 2 ε.
//!
//! Sources: Holzapfel, Gasser and Ogden 2000, doi:10.1023/A:1010835316564; dispersion: Gasser, Ogden and
//! Holzapfel 2006, doi:10.1098/rsif.2005.0073; whole invariants: Helfenstein et al. 2010,
//! doi:10.1016/j.ijsolstr.2010.04.012, and Nolan et al. 2014, doi:10.1016/j.jmbbm.2014.06.016; the smooth
//! beginning is ours. Fibres of which E is negative carry nothing, where they carry tension only.

use super::slack::square;

/// Largest dispersion, at which no direction is preferred.
pub const LARGEST_DISPERSION: f64 = 1.0 / 3.0;

/// The law of a family of fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// k₁ [Pa].
    pub k1: f64,
    /// k₂ [1].
    pub k2: f64,
    /// κ [1].
    pub dispersion: f64,
    /// Strain E over which fibres that carry tension only become taut [1]; none if they carry
    /// compression, too.
    pub slack: Option<f64>,
}

/// What fibres do at a strain E.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// ψ [J/m³].
    pub energy: f64,
    /// ψ′ [Pa].
    pub slope: f64,
    /// ψ″ [Pa], which is never negative.
    pub curvature: f64,
}

impl Fibre {
    /// ψ and its derivatives by E.
    #[inline]
    pub fn response(&self, strain: f64) -> Response {
        let [q, by, twice] = square(strain, self.slack);
        let exponent = self.k2 * q;
        // (eˣ − 1)/x and eˣ
        let (mean, growth) = if exponent == 0.0 {
            (1.0, 1.0)
        } else {
            (exponent.exp_m1() / exponent, exponent.exp())
        };
        let half = 0.5 * self.k1;
        Response {
            energy: half * q * mean,
            slope: half * growth * by,
            curvature: half * growth * (twice + self.k2 * by * by),
        }
    }

    /// ∂ψ′/∂k₁ [1] and ∂ψ′/∂k₂ [Pa].
    pub fn slope_by_parameters(&self, strain: f64) -> [f64; 2] {
        let [q, by, _] = square(strain, self.slack);
        let by_k1 = 0.5 * (self.k2 * q).exp() * by;
        [by_k1, self.k1 * q * by_k1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Fibre = Fibre { k1: 3e5, k2: 4.0, dispersion: 0.0, slack: Some(0.05) };

    /// The two laws meet: no digits are lost as k₂ → 0.
    #[test]
    fn without_growth_it_is_the_standard_reinforcing_model() {
        let law = Fibre { k2: 0.0, slack: None, ..LAW };
        let Response { energy, slope, curvature } = law.response(0.3);
        assert!((energy / (0.5 * 3e5 * 0.09) - 1.0).abs() < 1e-15);
        assert_eq!((slope, curvature), (3e5 * 0.3, 3e5));
        for k2 in [1e-14, 1e-9] {
            let near = Fibre { k2, ..law }.response(0.3);
            assert!((near.energy / energy - 1.0).abs() < k2, "{k2}: {near:?}");
        }
    }

    /// ψ′ = k₁ E exp(k₂ E²), by hand.
    #[test]
    fn stress_has_its_closed_form() {
        let law = Fibre { slack: None, ..LAW };
        let exact = 3e5 * 0.3 * (4.0_f64 * 0.09).exp();
        assert!((law.response(0.3).slope / exact - 1.0).abs() < 1e-14);
        assert_eq!(LAW.response(-0.3), Response::default());
    }
}
