//! A sheet that wrinkles rather than being compressed: tension-field theory.
//!
//! Wrinkles much shorter than an element take up length W ⪰ 0 without energy, so that the sheet
//! itself has the strain E + W. Its energy is the least of these, the relaxed energy
//!
//! ψᵣ(E) = min_{W ⪰ 0} ψ(E + W)      S = ∂ψ/∂E at the least: S ⪰ 0, S : W = 0
//!
//! With the principal strains E₁ ≥ E₂, their directions n and m, and the natural width e(E₁) at
//! which the stress across a strip in tension vanishes:
//!
//! taut      E₁ ≥ 0, E₂ ≥ e(E₁)   ψᵣ = ψ(E)
//! wrinkled  E₁ > 0, E₂ < e(E₁)   ψᵣ = ψ(E₁, e(E₁)) =: p(E₁), S = σ n⊗n, σ = p′
//! slack     otherwise            ψᵣ = 0, S = 0
//!
//! σ = S₁ at (E₁, e(E₁)), since S₂ = 0 there, and σ′ = D₁₁ − D₁₂²/D₂₂. Where it is wrinkled,
//!
//! D = σ′ N⊗N + 2σ/(E₁ − E₂) M⊗M      N = n⊗n, M = ½ (n⊗m + m⊗n)
//!
//! as δE₁ = N : δE and δN = 2 (M : δE)/(E₁ − E₂) M. There E₁ − E₂ > E₁ − e(E₁) > 0, and σ/(E₁ − e(E₁))
//! tends to twice the shear modulus as E₁ tends to 0. Equal principal strains occur in taut and
//! slack sheets only, where no principal direction is needed.
//!
//! ψᵣ is once continuously differentiable. D jumps where a sheet becomes taut, wrinkled or slack:
//! the derivative there is that of the taut side at E = 0, so that a sheet at rest is as stiff as
//! it is when it is pulled, and else that of the side on which the strain is. Both laws are
//! convex in C; a minimum over W of a convex function is convex, and it does not decrease with C
//! as S ⪰ 0. FᵀF is convex in F in the order of ⪰. So ψᵣ is convex in F, and its Hessian is
//! positive semidefinite in any state: a sheet in tension never needs projecting.
//!
//! No stiffness is left where the sheet is slack, and none across wrinkles: what it is bonded to
//! carries all of the load. A bare sheet has no unique equilibrium there.
//!
//! Source: Pipkin 1986, "The relaxed energy density for isotropic elastic membranes",
//! doi:10.1093/imamat/36.1.85; Steigmann 1990, "Tension-field theory",
//! doi:10.1098/rspa.1990.0055.

use super::{Sheet, Strain, Stress};
use crate::math::tensor::Mat3;

/// The relaxed energy of a law.
pub struct TensionField(pub Box<dyn Sheet>);

/// What a sheet does at a strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Tension along both principal directions.
    Taut,
    /// Compressed across its largest strain; in tension-field theory it wrinkles.
    Wrinkled,
    /// Nothing is stretched.
    Slack,
}

/// Principal strains E₁ ≥ E₂.
#[must_use]
pub fn principal(e: &Strain) -> [f64; 2] {
    let (mean, radius) = (0.5 * (e[0] + e[1]), 0.5 * (e[0] - e[1]).hypot(e[2]));
    [mean + radius, mean - radius]
}

/// What a sheet of a law does at a strain.
#[must_use]
pub fn state(law: &dyn Sheet, e: &Strain) -> State {
    let [first, second] = principal(e);
    if first >= 0.0 && second >= law.natural_width(first) {
        State::Taut
    } else if first > 0.0 {
        State::Wrinkled
    } else {
        State::Slack
    }
}

/// A strip in tension at its natural width.
struct Strip {
    /// E₁, e(E₁).
    at: Strain,
    /// D₁₂/D₂₂ there: −e′.
    narrowing: f64,
    /// σ [Pa].
    stress: f64,
    /// σ′ [Pa].
    slope: f64,
    /// N.
    along: Stress,
    /// M.
    shear: Stress,
    /// 2σ/(E₁ − E₂) [Pa].
    turning: f64,
}

impl TensionField {
    fn strip(&self, e: &Strain) -> Strip {
        let [first, second] = principal(e);
        let at = Strain::new(first, self.0.natural_width(first), 0.0);
        let (stress, d) = (self.0.stress(&at)[0], self.0.tangent(&at));
        let narrowing = d[(0, 1)] / d[(1, 1)];
        // cosine and sine of twice the angle of n
        let (cos, sin) = ((e[0] - e[1]) / (first - second), e[2] / (first - second));
        Strip {
            at,
            narrowing,
            stress,
            slope: d[(0, 0)] - narrowing * d[(0, 1)],
            along: 0.5 * Stress::new(1.0 + cos, 1.0 - cos, sin),
            shear: 0.5 * Stress::new(-sin, sin, cos),
            turning: 2.0 * stress / (first - second),
        }
    }
}

impl Sheet for TensionField {
    fn energy_density(&self, e: &Strain) -> f64 {
        match state(&*self.0, e) {
            State::Taut => self.0.energy_density(e),
            State::Wrinkled => self.0.energy_density(&self.strip(e).at),
            State::Slack => 0.0,
        }
    }

    fn stress(&self, e: &Strain) -> Stress {
        match state(&*self.0, e) {
            State::Taut => self.0.stress(e),
            State::Wrinkled => {
                let strip = self.strip(e);
                strip.stress * strip.along
            }
            State::Slack => Stress::zeros(),
        }
    }

    fn tangent(&self, e: &Strain) -> Mat3 {
        match state(&*self.0, e) {
            State::Taut => self.0.tangent(e),
            State::Wrinkled => {
                let Strip { slope, along, shear, turning, .. } = self.strip(e);
                slope * along * along.transpose() + turning * shear * shear.transpose()
            }
            State::Slack => Mat3::zeros(),
        }
    }

    fn parameter_count(&self) -> usize {
        self.0.parameter_count()
    }

    /// The strip has ∂σ/∂p = ∂S₁/∂p − D₁₂/D₂₂ ∂S₂/∂p at the same strains.
    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]) {
        match state(&*self.0, e) {
            State::Taut => self.0.add_parameter_vjp(e, s_bar, out),
            State::Wrinkled => {
                let strip = self.strip(e);
                let bar = Strain::new(1.0, -strip.narrowing, 0.0) * strip.along.dot(s_bar);
                self.0.add_parameter_vjp(&strip.at, &bar, out);
            }
            State::Slack => {}
        }
    }

    fn natural_width(&self, stretched: f64) -> f64 {
        self.0.natural_width(stretched)
    }
}
