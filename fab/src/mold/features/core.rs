//! The core print: a stub that holds the core at its inlet.
//!
//! The stub is narrower than the inlet by the clearance of its socket and by a
//! shoulder, with which the core rests on the floor around the socket and seals
//! it. A flat on one side keeps the core from turning.

use anyhow::{Result, bail};
use geometry::frustum::Frustum;
use mesh::Vec3;
use mesh::solid::Solid;

use crate::config::{Config, CoreConfig, STUB_FLAT};
use crate::mold::cast_body::Opening;

/// A turn by less than this is seen as none.
const TURN: f64 = std::f64::consts::FRAC_PI_6;

/// A corner that stands out by less gives way: `fab verify` lets parts share 0.01 mm³, which is a
/// corner of 0.02 mm on a stub of 8 mm [m].
const CATCH: f64 = 5e-5;

/// Tries to root the stub in the core, each half as deep as the one before.
const TRIES: usize = 10;

/// A stub and the socket for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Print {
    /// The stub, its axis pointing down from inside the core.
    pub stub: Frustum,
    /// The socket, open at the bottom.
    pub socket: Frustum,
    /// Gap between the flats [m].
    clearance: f64,
}

impl Print {
    /// A stub from an inlet, whose radius is at least [`Config::least_inlet`], down to just above `floor` [m], rooted in
    /// the core without touching `cast`.
    pub fn new(inlet: &Opening, floor: f64, cast: &Solid, config: &Config) -> Result<Self> {
        let Opening { centre, radius } = *inlet;
        let clearance = config.stub_clearance();
        let narrow = config.stub_radius(radius);
        for k in 0..TRIES {
            let root = radius * 0.5_f64.powi(k as i32);
            let top = centre + Vec3::z() * root;
            let column =
                |radius: f64, end: f64| Frustum::cylinder(top, Vec3::z() * (end - top.z), radius);
            let print = Self {
                stub: column(narrow, floor + clearance),
                socket: column(narrow + clearance, floor - clearance),
                clearance,
            };
            if cast.intersection(&print.socket.solid()).is_empty() {
                return Ok(print);
            }
        }
        bail!(
            "a stub in the inlet at ({:.5}, {:.5}) m of the mold cuts into the part: the chamber narrows behind its rim; increase \
             core.shoulder",
            centre.x,
            centre.y
        );
    }

    /// The stub as a solid.
    pub fn stub_solid(&self) -> Solid {
        self.flattened(&self.stub, 0.0)
    }

    /// The socket as a solid.
    pub fn socket_solid(&self) -> Solid {
        self.flattened(&self.socket, self.clearance)
    }

    /// Distance of the flat in front from the stub's axis [m].
    fn flat(&self) -> f64 {
        STUB_FLAT * self.stub.base_radius
    }

    /// Whether the stub does not enter its socket when it is turned, wherever it lies within its clearance: its corner
    /// beside the flat stands out, by more than what gives way.
    pub fn keeps_from_turning(&self) -> bool {
        let (radius, flat) = (self.stub.base_radius, self.flat());
        let corner = ((flat / radius).acos() - TURN).max(0.0);
        radius * corner.cos() > flat + 2.0 * self.clearance + CATCH
    }

    fn flattened(&self, frustum: &Frustum, gap: f64) -> Solid {
        let flat = self.stub.base.x + self.flat() + gap;
        frustum.solid().trim_by_plane(&-Vec3::x(), -flat)
    }
}

/// Halvings of the range in which the end of a bore is searched.
const HALVINGS: usize = 10;

/// The least that a bore must reach beyond the stub's root, in its radii.
const LEAST: f64 = 1.0;

/// A bore for water along a stub and up into its core, as high as the core stays
/// `core.skin` thick around it; none if the stub or the core is too thin.
pub fn drain(stub: &Frustum, core: &Solid, config: &Config) -> Option<Frustum> {
    let CoreConfig { drain: radius, skin, .. } = config.core;
    if stub.base_radius < radius + skin {
        return None;
    }
    let top = core.bounds().1.z;
    let bore = |from: f64, to: f64, radius: f64| {
        let base = Vec3::new(stub.base.x, stub.base.y, from);
        Frustum::cylinder(base, Vec3::z() * (to - from), radius)
    };
    let fits = |height: f64| {
        let around = bore(stub.base.z, height + skin, radius + skin).solid();
        around.difference(core).volume() <= 1e-6 * around.volume()
    };
    // Whatever fits up to a height fits up to all lower ones.
    let (mut low, mut high) = (stub.base.z + LEAST * radius, top - skin);
    if low >= high || !fits(low) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if fits(middle) { low = middle } else { high = middle }
    }
    // Beyond the end of the stub, so that no faces coincide.
    let end = stub.base.z + stub.axis.z - skin;
    Some(bore(end, low, radius))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nalgebra::Matrix3x4;

    /// The thinnest stub that is said to fit one way only meets its socket where it is turned by 30°, wherever its play lets
    /// it lie.
    #[test]
    fn the_thinnest_stub_that_keeps_from_turning_does() {
        let config = Config::default();
        let away = Solid::cube(&Vec3::repeat(1.0), &Vec3::repeat(2.0));
        let print = |inlet: f64| {
            let inlet = Opening { centre: Vec3::zeros(), radius: inlet };
            Print::new(&inlet, -8e-3, &away, &config).unwrap()
        };
        let mut prints = (1200..3000).map(|k| print(1e-6 * f64::from(k)));
        let thinnest = prints.find(Print::keeps_from_turning).unwrap();
        let outside = Solid::cube(&Vec3::new(-9e-3, -9e-3, -8e-3), &Vec3::new(9e-3, 9e-3, 0.0));
        let floor = outside.difference(&thinnest.socket_solid());
        let (sin, cos) = TURN.sin_cos();
        let turned = [Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::z()];
        for k in 0..6 {
            let (y, x) = (TURN * 2.0 * f64::from(k)).sin_cos();
            let aside = Vec3::new(x, y, 0.0) * (0.95 * config.stub_clearance());
            let place = Matrix3x4::from_columns(&[turned[0], turned[1], turned[2], aside]);
            let shared = thinnest.stub_solid().transform(&place).intersection(&floor);
            assert!(shared.volume() > 1e-11, "{k}: {} m³", shared.volume());
        }
    }

    #[test]
    fn a_bore_ends_below_the_top_of_its_core() {
        let config = Config::default();
        let stub = Frustum::cylinder(Vec3::z() * 1e-3, -Vec3::z() * 9e-3, 1.7e-3);
        let neck = Solid::cylinder(&Vec3::zeros(), &(Vec3::z() * 5e-3), 2e-3, 2e-3, 48);
        let ball = Solid::sphere(&(Vec3::z() * 14e-3), 10e-3, 96);
        let core = neck.union(&ball);
        let bore = drain(&stub, &core, &config).unwrap();
        let reaches = bore.base.z + bore.axis.z;
        // The ball ends at 24 mm, at r = drain + skin from its axis a little lower.
        let top = 14e-3 + (100e-6_f64 - 1.4e-3_f64.powi(2)).sqrt() - config.core.skin;
        assert!((reaches - top).abs() < 1e-4, "{reaches} {top}");
        // A neck that bends away after 5 mm.
        let bent = neck.union(&Solid::sphere(&Vec3::new(11e-3, 0.0, 5e-3), 10e-3, 96));
        let bore = drain(&stub, &bent, &config).unwrap();
        let reaches = bore.base.z + bore.axis.z;
        assert!((3.5e-3..5e-3).contains(&(reaches + config.core.skin)), "{reaches}");
        assert!(bore.base.z < stub.base.z + stub.axis.z);
        let thin = Frustum { base_radius: 1.3e-3, ..stub };
        assert_eq!(drain(&thin, &core, &config), None);
    }
}
