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
//! Laws with axes have other strips, for which see [`Woven`](super::Woven); the rest is the same.
//!
//! No stiffness is left where the sheet is slack, and none across wrinkles: what it is bonded to
//! carries all of the load. A bare sheet has no unique equilibrium there.
//!
//! Source: Pipkin 1986, "The relaxed energy density for isotropic elastic membranes",
//! doi:10.1093/imamat/36.1.85; Steigmann 1990, "Tension-field theory",
//! doi:10.1098/rspa.1990.0055.

use super::{Sheet, Strain, Stress};
use crate::material::Parameter;
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
pub fn principal(e: &Strain) -> [f64; 2] {
    let (mean, radius) = (0.5 * (e[0] + e[1]), 0.5 * (e[0] - e[1]).hypot(e[2]));
    [mean + radius, mean - radius]
}

/// What a sheet of an isotropic law does at principal strains, by its natural width.
pub(super) fn state([first, second]: [f64; 2], natural_width: impl Fn(f64) -> f64) -> State {
    if first >= 0.0 && second >= natural_width(first) {
        State::Taut
    } else if first > 0.0 {
        State::Wrinkled
    } else {
        State::Slack
    }
}

/// The strips that carry all of a wrinkled sheet, at their natural width:
/// D = slope N⊗N + turning M⊗M.
pub struct Strip {
    /// Strain of the law in them: of isotropic ones E₁ and e(E₁).
    pub at: Strain,
    /// σ [Pa].
    pub stress: f64,
    /// σ′ [Pa].
    pub slope: f64,
    /// N.
    pub along: Stress,
    /// M.
    pub shear: Stress,
    /// 2σ/(E₁ − E₂) [Pa].
    pub turning: f64,
    /// The derivative of `at` by E, as a sum of dyads; what leaves S alone is left out.
    pub parts: [(Strain, Stress); 2],
}

impl Strip {
    /// The strips of an isotropic law at the strain `e`; `at` is their own strain, with its stress and tangent.
    pub(super) fn isotropic(e: &Strain, at: Strain, stress: f64, d: &Mat3) -> Self {
        let [first, second] = principal(e);
        let narrowing = d[(0, 1)] / d[(1, 1)];
        // cosine and sine of twice the angle of n
        let (cos, sin) = ((e[0] - e[1]) / (first - second), e[2] / (first - second));
        let along = 0.5 * Stress::new(1.0 + cos, 1.0 - cos, sin);
        Self {
            at,
            stress,
            slope: d[(0, 0)] - narrowing * d[(0, 1)],
            along,
            shear: 0.5 * Stress::new(-sin, sin, cos),
            turning: 2.0 * stress / (first - second),
            parts: [(Strain::new(1.0, -narrowing, 0.0), along), (Strain::zeros(), Stress::zeros())],
        }
    }
}

impl Sheet for TensionField {
    fn energy_density(&self, e: &Strain) -> f64 {
        match self.0.state(e) {
            State::Taut => self.0.energy_density(e),
            State::Wrinkled => self.0.energy_density(&self.0.strip(e).at),
            State::Slack => 0.0,
        }
    }

    fn stress(&self, e: &Strain) -> Stress {
        match self.0.state(e) {
            State::Taut => self.0.stress(e),
            State::Wrinkled => {
                let strip = self.0.strip(e);
                strip.stress * strip.along
            }
            State::Slack => Stress::zeros(),
        }
    }

    fn tangent(&self, e: &Strain) -> Mat3 {
        match self.0.state(e) {
            State::Taut => self.0.tangent(e),
            State::Wrinkled => {
                let Strip { slope, along, shear, turning, .. } = self.0.strip(e);
                slope * along * along.transpose() + turning * shear * shear.transpose()
            }
            State::Slack => Mat3::zeros(),
        }
    }

    fn parameters(&self) -> &'static [Parameter] {
        self.0.parameters()
    }

    /// ∂ψᵣ/∂p is ∂ψ/∂p in the strip, so that ∂S/∂p is ∂S/∂p there times the derivative of its strain by E: of
    /// isotropic laws ∂σ/∂p = ∂S₁/∂p − D₁₂/D₂₂ ∂S₂/∂p.
    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]) {
        match self.0.state(e) {
            State::Taut => self.0.add_parameter_vjp(e, s_bar, out),
            State::Wrinkled => {
                let strip = self.0.strip(e);
                let bar = strip.parts.iter().map(|(by, of)| by * of.dot(s_bar)).sum();
                self.0.add_parameter_vjp(&strip.at, &bar, out);
            }
            State::Slack => {}
        }
    }

    fn natural_width(&self, stretched: f64) -> f64 {
        self.0.natural_width(stretched)
    }

    fn has_axes(&self) -> bool {
        self.0.has_axes()
    }

    fn state(&self, e: &Strain) -> State {
        self.0.state(e)
    }

    fn strip(&self, e: &Strain) -> Strip {
        self.0.strip(e)
    }
}
