//! Linear between Green strain and its stress, with other moduli along the warp than along the weft: fabric, mesh and
//! paper with a grain, in any rotation.
//!
//! S = D E      C = D⁻¹ = [1/warp, −ν/warp, 0; −ν/warp, 1/weft, 0; 0, 0, 1/shear]      ν = poisson
//!
//! in the axes of the sheet, [E₁₁, E₂₂, 2 E₁₂] along warp and weft. A strip at the angle θ to the warp is stretched by
//! S = σ N as a bar of the modulus 1/c(θ), with N = [cos²θ, sin²θ, sin θ cos θ]:
//!
//! c = N · C N = cos⁴θ/warp + sin⁴θ/weft + (1/shear − 2ν/warp) sin²θ cos²θ
//!
//! Without compression, ψᵣ = min_{W ⪰ 0} ψ(E + W) = max_{S ⪰ 0} S · E − ½ S · C S. Where the least S is neither that
//! of the whole sheet nor zero, S = σ N is that of the strips that store most:
//!
//! ψᵣ = max_θ ½ ε²/c      ε = N · E > 0      σ = ε/c
//! D = N⊗N/c + v⊗v/|∂²(½ ε²/c)/∂θ²|      v = ∂(σ N)/∂θ at constant E
//!
//! At the greatest value h = 2 ε′ c − ε c′ = 0, and ∂²(½ ε²/c)/∂θ² = ε h′/(2 c²). Wrinkles cross the strips, which
//! are the principal direction of S, though not of E.
//!
//! Source: Jones, "Mechanics of Composite Materials", sections 2.6 and 2.7; Pipkin 1986, doi:10.1093/imamat/36.1.85.

use super::{Sheet, State, Strain, Stress, Strip, principal};
use crate::material::law::{Law, Moduli, PA, Parameter};
use crate::math::tensor::Mat3;

/// Directions of strips among which the first guess is.
const STRIPS: usize = 32;
/// Steps by Newton's method or halving, of which about eight are needed.
const MOST_STEPS: usize = 80;

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Woven {
    /// Young's modulus along the warp [Pa].
    pub warp: f64,
    /// Young's modulus along the weft [Pa].
    pub weft: f64,
    /// Shear modulus between both [Pa].
    pub shear: f64,
    /// Poisson's ratio ν: how much the weft narrows where the warp is pulled [1].
    pub poisson: f64,
}

/// The row of the table.
pub(super) const LAW: Law<dyn Sheet> = Law {
    key: "woven",
    formula: "ψ = ½ E · D E,  D⁻¹ = [1/warp, −ν/warp, 0; −ν/warp, 1/weft, 0; 0, 0, 1/shear],  ν = poisson",
    parameters: &[
        Parameter::one("warp", PA, "Young's modulus along the warp"),
        Parameter::one("weft", PA, "Young's modulus along the weft"),
        Parameter::one("shear", PA, "shear modulus between warp and weft"),
        Parameter::one(
            "poisson",
            "1",
            "Poisson's ratio ν of the weft where the warp is pulled, ν² below warp/weft",
        ),
    ],
    shear: "shear",
    bulk: "1 / (1/warp + 1/weft − 2 poisson/warp) of area, with warp and weft above 0 and poisson² below warp/weft",
    source: "Jones, Mechanics of Composite Materials, section 2.6",
    limits: "fabric, mesh, paper with a grain: small strains in any rotation. The crimp of threads is not in it. In \
             compression it is as stiff as in tension although a real sheet buckles or wrinkles, unless tension = \
             true",
    objective: true,
    moduli: |p| {
        let [warp, weft, shear, poisson] = [p[0], p[1], p[2], p[3]];
        Moduli { shear, bulk: 1.0 / (1.0 / warp + 1.0 / weft - 2.0 * poisson / warp) }
    },
    build: |p| Box::new(Woven { warp: p[0], weft: p[1], shear: p[2], poisson: p[3] }),
    refuses,
    sample: &[2.6e5, 1.7e5, 7e4, 0.25],
};

/// C has to be positive definite.
fn refuses(p: &[f64]) -> Option<String> {
    let [warp, weft, poisson] = [p[0], p[1], p[3]];
    if warp <= 0.0 || weft <= 0.0 {
        return Some(format!("warp = {warp:e} Pa and weft = {weft:e} Pa: both must be above 0"));
    }
    let limit = (warp / weft).sqrt();
    (poisson * poisson * weft >= warp).then(|| {
        format!(
            "poisson = {poisson}: must be between -{limit:.4} and {limit:.4}, the square root of warp/weft, with warp = \
             {warp:e} Pa and weft = {weft:e} Pa; it is how much the weft narrows where the warp is pulled, and \
             weft/warp times as much the other way round"
        )
    })
}

/// A strip at an angle: N, N′ and N″.
fn strips(angle: f64) -> [Stress; 3] {
    let (sin, cos) = (2.0 * angle).sin_cos();
    [
        0.5 * Stress::new(1.0 + cos, 1.0 - cos, sin),
        Stress::new(-sin, sin, cos),
        -2.0 * Stress::new(cos, -cos, sin),
    ]
}

/// What a strip stores, and where the one that stores most lies.
struct Stored {
    /// ε.
    strain: f64,
    /// c [1/Pa].
    softness: f64,
    /// h, of which h = 0 where most is stored, and h′.
    slopes: [f64; 2],
    /// ∂σ/∂θ [Pa].
    turned: f64,
}

impl Woven {
    /// C [1/Pa].
    fn compliance(&self) -> Mat3 {
        let Self { warp, weft, shear, poisson } = *self;
        let across = -poisson / warp;
        Mat3::new(1.0 / warp, across, 0.0, across, 1.0 / weft, 0.0, 0.0, 0.0, 1.0 / shear)
    }

    /// D [Pa].
    fn stiffness(&self) -> Mat3 {
        let Self { warp, weft, shear, poisson } = *self;
        let part = 1.0 - poisson * poisson * weft / warp;
        let across = poisson * weft / part;
        Mat3::new(warp / part, across, 0.0, across, weft / part, 0.0, 0.0, 0.0, shear)
    }

    fn stored(&self, e: &Strain, angle: f64) -> Stored {
        let [n, by, twice] = strips(angle);
        let compliance = self.compliance();
        let (cn, cby) = (compliance * n, compliance * by);
        let (strain, first, second) = (e.dot(&n), e.dot(&by), e.dot(&twice));
        let (softness, soft) = (cn.dot(&n), 2.0 * cn.dot(&by));
        let softer = 2.0 * (cn.dot(&twice) + cby.dot(&by));
        let slopes = [
            2.0 * first * softness - strain * soft,
            2.0 * second * softness + first * soft - strain * softer,
        ];
        let turned = (first * softness - strain * soft) / (softness * softness);
        Stored { strain, softness, slopes, turned }
    }

    /// Angle of the strip that stores most: the best of some, then the zero of h beside it.
    fn angle(&self, e: &Strain) -> f64 {
        let step = std::f64::consts::PI / STRIPS as f64;
        let most = |angle: f64| {
            let Stored { strain, softness, .. } = self.stored(e, angle);
            strain.max(0.0).powi(2) / softness
        };
        let all = (0..STRIPS).map(|k| step * k as f64);
        let start = all.max_by(|a, b| most(*a).total_cmp(&most(*b))).unwrap_or_default();
        let (mut low, mut high, mut angle) = (start - step, start + step, start);
        for _ in 0..MOST_STEPS {
            let Stored { strain, slopes: [value, slope], .. } = self.stored(e, angle);
            // where nothing is stored, more is on the side of the start
            let rises = if strain > 0.0 { value > 0.0 } else { angle < start };
            if rises {
                low = angle
            } else {
                high = angle
            }
            let newton = angle - value / slope;
            let inside = strain > 0.0 && slope < 0.0 && low <= newton && newton <= high;
            let next = if inside { newton } else { f64::midpoint(low, high) };
            if (next - angle).abs() < 1e-16 {
                break;
            }
            angle = next;
        }
        angle
    }
}

impl Sheet for Woven {
    fn energy_density(&self, e: &Strain) -> f64 {
        0.5 * self.stress(e).dot(e)
    }

    fn stress(&self, e: &Strain) -> Stress {
        self.stiffness() * e
    }

    fn tangent(&self, _: &Strain) -> Mat3 {
        self.stiffness()
    }

    fn parameters(&self) -> &'static [Parameter] {
        LAW.parameters
    }

    /// ∂D = −D ∂C D, with T = D S̄.
    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]) {
        let Self { warp, weft, shear, poisson } = *self;
        let (s, t) = (self.stress(e), self.stiffness() * s_bar);
        let across = t[0] * s[1] + t[1] * s[0];
        out[0] += (t[0] * s[0] - poisson * across) / (warp * warp);
        out[1] += t[1] * s[1] / (weft * weft);
        out[2] += t[2] * s[2] / (shear * shear);
        out[3] += across / warp;
    }

    /// Of a strip along the warp.
    fn natural_width(&self, stretched: f64) -> f64 {
        -self.poisson * stretched
    }

    fn has_axes(&self) -> bool {
        true
    }

    /// Taut where the stress of the whole sheet is nowhere compression, slack where nothing is stretched.
    fn state(&self, e: &Strain) -> State {
        let s = self.stress(e);
        if s[0] + s[1] >= 0.0 && s[0] * s[1] >= s[2] * s[2] {
            State::Taut
        } else if principal(e)[0] > 0.0 {
            State::Wrinkled
        } else {
            State::Slack
        }
    }

    fn strip(&self, e: &Strain) -> Strip {
        let angle = self.angle(e);
        let [along, by, _] = strips(angle);
        let Stored { strain, softness, slopes: [_, slope], turned } = self.stored(e, angle);
        let stress = strain / softness;
        let shear = turned * along + stress * by;
        let (stiffness, turning) = (1.0 / softness, -2.0 * softness * softness / (strain * slope));
        let compliance = self.compliance();
        Strip {
            at: stress * (compliance * along),
            stress,
            slope: stiffness,
            along,
            shear,
            turning,
            parts: [
                (stiffness * (compliance * along), along),
                (turning * (compliance * shear), shear),
            ],
        }
    }
}
