//! The core print: a stub that holds the core at its inlet.
//!
//! The stub is narrower than the inlet by the clearance of its socket and by a
//! shoulder, with which the core rests on the floor around the socket and seals
//! it. A flat on one side keeps the core from turning.

use mesh::Vec3;
use mesh::solid::Solid;

use super::Frustum;
use crate::config::Core;

/// Distance of the flat from the stub's axis, in radii.
const FLAT: f64 = 0.7;

/// The thinnest stub that can be printed [m].
const THINNEST: f64 = 5e-4;

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

/// Why an inlet cannot hold a stub.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PrintError {
    /// The inlet is too narrow.
    #[error(
        "the inlet at ({x:.5}, {y:.5}) m has an inscribed radius of {radius_mm:.3} mm; less clearance and shoulder \
         it leaves a stub of radius {stub_mm:.3} mm, at least {least_mm:.3} mm are needed: \
         widen the inlet or reduce core.clearance and core.shoulder",
        x = centre.x, y = centre.y
    )]
    Narrow {
        /// Centre of the inlet in the mold's frame [m].
        centre: Vec3,
        /// Inscribed radius of the inlet [mm].
        radius_mm: f64,
        /// Radius left for the stub [mm].
        stub_mm: f64,
        /// Radius needed [mm].
        least_mm: f64,
    },
    /// The stub would cut into the part wherever it is rooted.
    #[error(
        "a stub in the inlet at ({:.5}, {:.5}) m cuts into the part: the cavity narrows behind its rim; \
         increase core.shoulder",
        centre.x, centre.y
    )]
    Blocked {
        /// Centre of the inlet in the mold's frame [m].
        centre: Vec3,
    },
}

impl Print {
    /// A stub from the inlet at `centre` [m] with the inscribed `radius` [m] down
    /// to just above `floor` [m], rooted in the core without touching `cast`.
    ///
    /// # Errors
    /// [`PrintError`] if the inlet is too narrow.
    pub fn new(
        centre: Vec3,
        radius: f64,
        floor: f64,
        cast: &Solid,
        settings: &Core,
    ) -> Result<Self, PrintError> {
        let narrow = radius - settings.clearance - settings.shoulder;
        if narrow < THINNEST {
            return Err(PrintError::Narrow {
                centre,
                radius_mm: radius * 1e3,
                stub_mm: narrow * 1e3,
                least_mm: THINNEST * 1e3,
            });
        }
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
                stub: column(narrow, floor + settings.clearance),
                socket: column(narrow + settings.clearance, floor - settings.clearance),
                clearance: settings.clearance,
            };
            if cast.intersection(&print.socket.solid()).is_empty() {
                return Ok(print);
            }
        }
        Err(PrintError::Blocked { centre })
    }

    /// The stub as a solid.
    #[must_use]
    pub fn stub_solid(&self) -> Solid {
        self.flattened(&self.stub, 0.0)
    }

    /// The socket as a solid.
    #[must_use]
    pub fn socket_solid(&self) -> Solid {
        self.flattened(&self.socket, self.clearance)
    }

    fn flattened(&self, frustum: &Frustum, gap: f64) -> Solid {
        let flat = self.stub.base.x + FLAT * self.stub.base_radius + gap;
        frustum.solid().trim_by_plane(&-Vec3::x(), -flat)
    }
}
