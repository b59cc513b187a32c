//! Whether a core stays where it should while silicone rises around it.
//!
//! Held at one end, the core floats with F = |ρ_silicone − ρ_core| g V. Its moment about the inlet,
//! M = F (a + h sin 5°), with the centroid at the distance a from the stub's axis and the
//! height h above the inlet in a mold that stands up to 5° askew, bends the neck, taken
//! as a rod of the stub's radius r up to the centroid: it turns the core by θ = M h/(E π r⁴/4). The play c
//! of the stub in its socket of length l lets it turn by 2c/l. Both turn it about some level axis through the
//! inlet, and its farthest point moves by the angle times its distance from that axis.
//!
//! A pin of the mold that stands in a pit of the core at p, along the unit vector n out of the core, with the play c,
//! stops a turn that moves p by more than c across n, or by more than c along n. A turn by φ about the axis e through
//! the inlet o moves p by φ e × (p − o). The angle about every axis is thus at most
//! min(φ₀, c/|(e × (p − o))⊥n|, c/(e × (p − o))·n), and the motion is the largest one over all axes.

use mesh::measure::tet_volume;
use mesh::{SurfaceMesh, Vec3};

use geometry::frustum::Frustum;

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

/// Axes about which turns are tried, over half a turn: one per degree, by which a motion is underestimated by
/// 4·10⁻⁵ of it at most if nothing but the stub holds the core.
const AXES: usize = 180;

/// A core on its stub.
pub struct Stand {
    /// Force with which it floats [N].
    pub lift: f64,
    /// Distance of its far end from the inlet [m].
    pub reach: f64,
    /// By how much the neck bends [rad].
    bend: f64,
    /// By how much the play of the stub lets it turn [rad].
    lean: f64,
    /// The inlet [m].
    inlet: Vec3,
    /// Level axes, and how far the core reaches from each [m].
    axes: Vec<(Vec3, f64)>,
}

/// Where a pin holds a core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The place [m].
    pub at: Vec3,
    /// The unit vector along the pin, out of the core [1].
    pub out: Vec3,
    /// How far the core can move there, across the pin and toward it [m].
    pub play: f64,
}

/// How far a core moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sag {
    /// Motion of its farthest point by bending of the neck [m].
    pub bend: f64,
    /// Motion of its farthest point by play [m].
    pub lean: f64,
    /// The mean of that over all axes [m].
    pub mean: f64,
}

impl Sag {
    /// The larger motion [m].
    pub fn most(&self) -> f64 {
        self.bend.max(self.lean)
    }
}

impl Stand {
    /// The stand of `core`, held at `inlet` by `stub` with `clearance` around it [m], in
    /// silicone of the given density [kg/m³].
    pub fn new(
        core: &SurfaceMesh,
        inlet: &Vec3,
        stub: &Frustum,
        clearance: f64,
        density: f64,
    ) -> Self {
        let (volume, centroid) = centroid(core);
        let reach = core.vertices.iter().map(|p| (p - inlet).norm()).fold(0.0, f64::max);
        let offset = centroid - inlet;
        let height = offset.z.max(0.0);
        let lift = (density - CORE).abs() * GRAVITY * volume;
        let moment = lift * (offset.xy().norm() + height * ASKEW);
        let inertia = std::f64::consts::PI * stub.base_radius.powi(4) / 4.0;
        let held = (inlet.z - (stub.base.z + stub.axis.z)).max(clearance);
        let axis = |k: usize| {
            let angle = std::f64::consts::PI * k as f64 / AXES as f64;
            let axis = Vec3::new(angle.cos(), angle.sin(), 0.0);
            let away = core.vertices.iter().map(|p| axis.cross(&(p - inlet)).norm_squared());
            (axis, away.fold(0.0, f64::max).sqrt())
        };
        Self {
            lift,
            reach,
            bend: moment * height / (STIFFNESS * inertia),
            lean: 2.0 * clearance / held,
            inlet: *inlet,
            axes: (0..AXES).map(axis).collect(),
        }
    }

    /// How far it moves if pins hold it, too.
    pub fn sag(&self, contacts: &[Contact]) -> Sag {
        let mut sag = Sag { bend: 0.0, lean: 0.0, mean: 0.0 };
        for (axis, away) in &self.axes {
            for axis in [*axis, -axis] {
                let stops = contacts.iter().map(|contact| contact.stops(&axis, &self.inlet));
                let stop = stops.fold(f64::INFINITY, f64::min);
                sag.bend = sag.bend.max(self.bend.min(stop) * away);
                let lean = self.lean.min(stop) * away;
                sag.lean = sag.lean.max(lean);
                sag.mean += lean / (2 * AXES) as f64;
            }
        }
        sag
    }
}

impl Contact {
    /// The angle of a turn about an axis through a point at which this stops it [rad].
    fn stops(&self, axis: &Vec3, through: &Vec3) -> f64 {
        let way = axis.cross(&(self.at - through));
        let along = way.dot(&self.out);
        let across = (way - self.out * along).norm();
        self.play / along.max(across).max(f64::MIN_POSITIVE)
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

    /// A ball of 20 mm, its middle 30 mm above and 40 mm beside the inlet, on a stub of 8 mm.
    fn ball_on_a_stalk() -> Stand {
        let middle = Vec3::new(40e-3, 0.0, 30e-3);
        let ball = Solid::sphere(&middle, 10e-3, 256).to_surface();
        let stub = Frustum::cylinder(Vec3::z() * 1e-3, -Vec3::z() * 9e-3, 2e-3);
        Stand::new(&ball, &Vec3::zeros(), &stub, 2e-4, 1070.0)
    }

    #[test]
    fn a_ball_on_a_stalk() {
        let stand = ball_on_a_stalk();
        let found = stand.sag(&[]);
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
        let lift = 670.0 * 9.81 * volume;
        assert!((stand.lift / lift - 1.0).abs() < 1e-3, "{}", stand.lift);
        assert!((stand.reach - 60e-3).abs() < 1e-4, "{}", stand.reach);
        // I = π·16·10⁻¹²/4 = 12.57·10⁻¹² m⁴; M = F (0.040 + 0.030·0.0872).
        let slope = lift * (0.04 + 0.03 * 0.0872) * 0.03 / (1e9 * 12.566e-12);
        assert!((found.bend / (slope * 60e-3) - 1.0).abs() < 2e-3, "{found:?}");
        // 0.4 mm of play over 8 mm.
        assert!((found.lean / 3e-3 - 1.0).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn pins_stop_turns_that_move_the_core_across_or_toward_them() {
        let stand = ball_on_a_stalk();
        let above = |x: f64, z: f64| Contact {
            at: Vec3::new(x, 0.0, z),
            out: Vec3::z() * z.signum(),
            play: 2e-4,
        };
        // Above the inlet it stops all turns alike, by 0.2 mm at 30 mm: the far end moves by 0.4 mm.
        let straight = stand.sag(&[above(0.0, 30e-3)]);
        assert!((straight.lean / 0.4e-3 - 1.0).abs() < 2e-3, "{straight:?}");
        assert!(straight.bend <= stand.sag(&[]).bend);
        // Level with the inlet, one above stops a turn upward, by 0.2 mm at 40 mm, and none downward.
        let level = Contact { at: Vec3::x() * 40e-3, out: Vec3::z(), play: 2e-4 };
        let one = stand.sag(&[level]);
        assert!((one.lean / 3e-3 - 1.0).abs() < 2e-3, "{one:?}");
        // One above and one below stop both, but not the turn about their own direction.
        let both = stand.sag(&[level, Contact { out: -Vec3::z(), ..level }]);
        // Then the ball, up to 40 mm from that axis, swings sideways.
        assert!((both.lean / (0.05 * 40e-3) - 1.0).abs() < 0.05, "{both:?}");
    }
}
