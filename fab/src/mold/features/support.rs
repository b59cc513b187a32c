//! Whether a core that is held at one end stays where it should while silicone rises
//! around it.
//!
//! The core floats with F = |ρ_silicone − ρ_core| g V. Its moment about the inlet,
//! M = F (a + h sin 5°), with the centroid at the distance a from the stub's axis and the
//! height h above the inlet in a mold that stands up to 5° askew, bends the neck, taken
//! as a rod of the stub's radius r up to the centroid: θ = M h / (E π r⁴/4), and the far
//! end moves by θ times its distance from the inlet. The play c of the stub in its
//! socket of length l lets it lean by 2c/l times that distance.

use mesh::measure::tet_volume;
use mesh::{SurfaceMesh, Vec3};

use crate::geometry::frustum::Frustum;

/// Silicone, if none is named [kg/m³].
pub const SILICONE: f64 = 1070.0;

/// A core printed of PLA with 30 % infill, which floats [kg/m³].
const CORE: f64 = 400.0;

/// Stiffness of printed plastic across its layers: a third of PLA's, a judgement [Pa].
const STIFFNESS: f64 = 1e9;

/// Sine of the angle by which a mold may stand askew (5°).
const ASKEW: f64 = 0.0872;

/// Gravity [m/s²].
const GRAVITY: f64 = 9.81;

/// How a core moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sag {
    /// Force with which it floats [N].
    pub lift: f64,
    /// Distance of its far end from the inlet [m].
    pub reach: f64,
    /// Motion of the far end by bending of the neck [m].
    pub bend: f64,
    /// Motion of the far end by play in the socket [m].
    pub lean: f64,
}

/// The motion of `core`, held at `inlet` by `stub` with `clearance` around it [m], in
/// silicone of the given density [kg/m³].
#[must_use]
pub fn sag(core: &SurfaceMesh, inlet: &Vec3, stub: &Frustum, clearance: f64, density: f64) -> Sag {
    let (volume, centroid) = centroid(core);
    let reach = core.vertices.iter().map(|p| (p - inlet).norm()).fold(0.0, f64::max);
    let offset = centroid - inlet;
    let height = offset.z.max(0.0);
    let lift = (density - CORE).abs() * GRAVITY * volume;
    let moment = lift * (offset.xy().norm() + height * ASKEW);
    let inertia = std::f64::consts::PI * stub.base_radius.powi(4) / 4.0;
    let held = (inlet.z - (stub.base.z + stub.axis.z)).max(clearance);
    Sag {
        lift,
        reach,
        bend: moment * height / (STIFFNESS * inertia) * reach,
        lean: 2.0 * clearance / held * reach,
    }
}

/// Volume [m³] and centroid [m] of what a closed surface bounds.
fn centroid(surface: &SurfaceMesh) -> (f64, Vec3) {
    let origin = surface.vertices[0];
    let (mut volume, mut moment) = (0.0, Vec3::zeros());
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        let part = tet_volume(origin, a, b, c);
        volume += part;
        moment += (origin + a + b + c) / 4.0 * part;
    }
    (volume, moment / volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;

    #[test]
    fn a_ball_on_a_stalk() {
        // A ball of 20 mm, its middle 30 mm above and 40 mm beside the inlet.
        let middle = Vec3::new(40e-3, 0.0, 30e-3);
        let ball = Solid::sphere(&middle, 10e-3, 256).to_surface();
        let stub = Frustum {
            base: Vec3::z() * 1e-3,
            axis: -Vec3::z() * 9e-3,
            base_radius: 2e-3,
            top_radius: 2e-3,
        };
        let found = sag(&ball, &Vec3::zeros(), &stub, 2e-4, 1070.0);
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
        let lift = 670.0 * 9.81 * volume;
        assert!((found.lift / lift - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found.reach - 60e-3).abs() < 1e-4, "{found:?}");
        // I = π·16·10⁻¹²/4 = 12.57·10⁻¹² m⁴; M = F (0.040 + 0.030·0.0872).
        let slope = lift * (0.04 + 0.03 * 0.0872) * 0.03 / (1e9 * 12.566e-12);
        assert!((found.bend / (slope * 60e-3) - 1.0).abs() < 2e-3, "{found:?}");
        // 0.4 mm of play over 8 mm.
        assert!((found.lean / 3e-3 - 1.0).abs() < 2e-3, "{found:?}");
    }
}
