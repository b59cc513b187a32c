//! The core print: a stub that holds the core at its inlet.
//!
//! The stub is narrower than the inlet by the clearance of its socket and by a
//! shoulder, with which the core rests on the floor around the socket and seals
//! it. A flat on one side keeps the core from turning.

use mesh::Vec3;
use mesh::solid::Solid;

use super::keying::{self, Code};
use super::label::Face;
use crate::config::{Config, CoreConfig, STUB_FLAT};
use crate::geometry::frustum::Frustum;

/// A number on a stub keeps this far from its end and from the inlet [m].
const EDGE: f64 = 3e-4;

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
    /// Height of the inlet [m].
    inlet: f64,
    /// What tells it from the stubs of other cores, if there are any.
    code: Option<Code>,
}

/// Why an inlet cannot hold a stub.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PrintError {
    /// The stub would cut into the part wherever it is rooted.
    #[error(
        "a stub in the inlet at ({:.5}, {:.5}) m cuts into the part: the chamber narrows behind its rim; \
         increase core.shoulder",
        centre.x, centre.y
    )]
    Blocked {
        /// Centre of the inlet in the mold's frame [m].
        centre: Vec3,
    },
}

impl Print {
    /// A stub from the inlet at `centre` [m] with the inscribed `radius` [m], at least
    /// [`Config::least_inlet`], down to just above `floor` [m], rooted in the core without
    /// touching `cast`; with a `code` if there are several cores.
    pub fn new(
        centre: Vec3,
        radius: f64,
        floor: f64,
        cast: &Solid,
        code: Option<Code>,
        config: &Config,
    ) -> Result<Self, PrintError> {
        let clearance = config.stub_clearance();
        let narrow = config.stub_radius(radius);
        for k in 0..TRIES {
            let root = radius * 0.5_f64.powi(k as i32);
            let top = centre + Vec3::z() * root;
            let column = |radius: f64, end: f64| Frustum {
                base: top,
                axis: Vec3::z() * (end - top.z),
                base_radius: radius,
                top_radius: radius,
            };
            let print = Self {
                stub: column(narrow, floor + clearance),
                socket: column(narrow + clearance, floor - clearance),
                clearance,
                inlet: centre.z,
                code,
            };
            if cast.intersection(&print.socket.solid()).is_empty() {
                return Ok(print);
            }
        }
        Err(PrintError::Blocked { centre })
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
        self.code.map_or(STUB_FLAT * self.stub.base_radius, |code| code.flat)
    }

    /// Whether its flat keeps the stub from turning in its socket.
    pub fn keeps_from_turning(&self) -> bool {
        keying::keeps_from_turning(self.stub.base_radius, self.flat(), self.clearance)
    }

    /// The face of the flat below the inlet, as it stands on the printer.
    pub fn front(&self) -> Face {
        let [top, end] = [self.inlet - EDGE, self.stub.base.z + self.stub.axis.z + EDGE];
        let flat = self.flat();
        // Half of its chord; a flat at the side leaves less.
        let half = (self.stub.base_radius.powi(2) - flat * flat).sqrt().min(flat);
        let middle = self.stub.base + Vec3::x() * flat;
        Face {
            middle: Vec3::new(middle.x, middle.y, (top + end) / 2.0),
            along: Vec3::y(),
            up: Vec3::z(),
            size: [2.0 * half, top - end],
            down: -Vec3::z(),
        }
    }

    fn flattened(&self, frustum: &Frustum, gap: f64) -> Solid {
        let flat = self.stub.base.x + self.flat() + gap;
        let front = frustum.solid().trim_by_plane(&-Vec3::x(), -flat);
        let cuts = self.code.map(|code| code.cuts(frustum, self.inlet, gap));
        cuts.into_iter().flatten().fold(front, |stub, cut| stub.difference(&cut))
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
    let bore = |from: f64, to: f64, radius: f64| Frustum {
        base: Vec3::new(stub.base.x, stub.base.y, from),
        axis: Vec3::z() * (to - from),
        base_radius: radius,
        top_radius: radius,
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

    #[test]
    fn a_bore_ends_below_the_top_of_its_core() {
        let config = Config::default();
        let stub = Frustum {
            base: Vec3::z() * 1e-3,
            axis: -Vec3::z() * 9e-3,
            base_radius: 1.7e-3,
            top_radius: 1.7e-3,
        };
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
