//! Stubs of which each fits into one socket only.
//!
//! All stubs of a mold have the same radius r, and a flat in front at the distance f from their
//! axis, which keeps them from turning. Stub k of n has two more such flats: one at its back that begins
//! h + (k − 1) s below the inlet, and one at its side that begins h + (n − k) s below it, h as large as can be. Where a stub has a flat,
//! its socket has one, too. In the socket of another core, one of the two flats begins too early: the stub meets it
//! with r − f − c of its back or side, c the clearance, and stands s − 2.25 c proud in the middle and up to
//! 1.25 c less where it is pushed aside, or more if the numbers differ by more than one. f is at most r − 3c, so that it still meets it when it lies against the other side of its
//! socket.

use mesh::Vec3;
use mesh::solid::Solid;
use nalgebra::Matrix3x4;

use crate::config::{Config, STUB_FLAT};
use crate::geometry::frustum::Frustum;

/// How much deeper the flats of the next core begin [m].
const STEP: f64 = 2e-3;

/// How proud a core stands at least in the socket of another [m]: three layers of a filament printer
/// are seen.
const PROUD: f64 = 6e-4;

/// Flats begin with a slope that rises by this for each unit outward: 39° from the vertical, printed
/// without support.
const SLOPE: f64 = 1.25;

/// A stub is round for at least this length above the slope of its first flat, and flat for as
/// long below the last [m].
const ROUND: f64 = 5e-4;

/// The least distance of a flat from the axis: half of what the thinnest stub is wide [m].
const THINNEST: f64 = 5e-4;

/// A turn by less than this is seen as none.
const TURN: f64 = std::f64::consts::FRAC_PI_6;

/// A corner that stands out by less gives way: `fab verify` lets parts share 0.01 mm³, which is a
/// corner of 0.02 mm on a stub of 8 mm [m].
const CATCH: f64 = 5e-5;

/// What tells a core's stubs from those of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code {
    /// Where its flats begin below the inlet, at the back and at the side [m].
    pub depths: [f64; 2],
    /// Distance of all flats from the axis [m].
    pub flat: f64,
}

/// Why stubs cannot be told apart.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum KeyingError {
    /// They are too thin.
    #[error(
        "the narrowest inlet has an inscribed radius of {radius_mm:.2} mm; for stubs that fit into their own sockets \
         only, {cores} cores need {needed_mm:.2} mm: widen it, reduce core.clearance, or set core.keyed = false and \
         mind the numbers of the cores"
    )]
    Narrow {
        /// Inscribed radius of that inlet in the mold [mm].
        radius_mm: f64,
        /// What is needed [mm].
        needed_mm: f64,
        /// How many cores.
        cores: usize,
    },
    /// They are too short.
    #[error(
        "the stubs are {length_mm:.2} mm long; for stubs that fit into their own sockets only, {cores} cores need \
         core.length = {needed:.4}: lengthen them, or set core.keyed = false and mind the numbers of the cores"
    )]
    Short {
        /// Length of the stubs [mm].
        length_mm: f64,
        /// What `core.length` must be [m].
        needed: f64,
        /// How many cores.
        cores: usize,
    },
}

/// The codes of that many cores on stubs of a radius and a length [m].
pub fn codes(
    cores: usize,
    radius: f64,
    length: f64,
    config: &Config,
) -> Result<Vec<Code>, KeyingError> {
    let clearance = config.stub_clearance();
    let flat = (STUB_FLAT * radius).min(radius - 3.0 * clearance);
    if flat < THINNEST {
        let wider = |radius: f64| (radius + clearance + config.core.shoulder) * 1e3;
        let needed_mm = wider((THINNEST + 3.0 * clearance).max(THINNEST / STUB_FLAT));
        return Err(KeyingError::Narrow { radius_mm: wider(radius), needed_mm, cores });
    }
    let highest = ROUND + SLOPE * (radius - flat);
    let steps = (cores - 1) as f64;
    let step = ((length - highest - ROUND) / steps).min(STEP);
    // The slope in the socket lies lower by the clearance, by what it is moved outward, and by what a
    // stub is pushed aside.
    let least = PROUD + (1.0 + 2.0 * SLOPE) * clearance;
    if step < least {
        let needed = highest + ROUND + steps * least + clearance;
        return Err(KeyingError::Short { length_mm: length * 1e3, needed, cores });
    }
    // As much of each stub as can be is left round: it is stiffer.
    let first = length - ROUND - steps * step;
    let depth = |steps: usize| first + steps as f64 * step;
    Ok((0..cores).map(|k| Code { depths: [depth(k), depth(cores - 1 - k)], flat }).collect())
}

/// Whether a stub with a flat at that distance from its axis does not enter its socket when it is
/// turned, wherever it lies within its clearance: its corner beside the flat stands out, by more than
/// what gives way [m].
pub fn keeps_from_turning(radius: f64, flat: f64, clearance: f64) -> bool {
    let corner = ((flat / radius).acos() - TURN).max(0.0);
    radius * corner.cos() > flat + 2.0 * clearance + CATCH
}

impl Code {
    /// What is cut off at back and side of a stub, or of a socket with `gap` around it; the stub stands below
    /// an inlet at the height `inlet` [m].
    pub fn cuts(&self, frustum: &Frustum, inlet: f64, gap: f64) -> [Solid; 2] {
        let radius = 2.0 * frustum.base_radius;
        let low = (frustum.base + frustum.axis).z.min(frustum.base.z) - radius;
        let cut = |depth: f64, outward: Vec3| {
            let (near, start) = (self.flat + gap, inlet - depth - gap);
            let profile = vec![
                [near, low],
                [radius, low],
                [radius, start + SLOPE * (radius - near)],
                [near, start],
            ];
            let axis = Vec3::new(frustum.base.x, frustum.base.y, 0.0);
            let across = outward.cross(&Vec3::z());
            let place = Matrix3x4::from_columns(&[outward, Vec3::z(), across, axis]);
            Solid::extrude(&[profile], -radius, radius).transform(&place)
        };
        let [back, side] = self.depths;
        [cut(back, -Vec3::x()), cut(side, -Vec3::y())]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn no_code_holds_for_another_core() {
        let config = Config::default();
        for cores in 2..7 {
            let codes = codes(cores, 2.2e-3, 8.6e-3, &config).unwrap();
            for (i, a) in codes.iter().enumerate() {
                for b in &codes[..i] {
                    // One flat begins deeper, the other less deep, by 1.3 mm or more.
                    let apart = [0, 1].map(|k| a.depths[k] - b.depths[k]);
                    assert!(apart[0] >= 1.3e-3 && apart[1] <= -1.3e-3, "{apart:?}");
                }
            }
        }
    }

    #[test]
    fn stubs_that_are_too_thin_or_too_short_are_refused_with_what_is_needed() {
        let config = Config::default();
        let error = codes(3, 1.0e-3, 7.8e-3, &config).unwrap_err();
        let KeyingError::Narrow { needed_mm, .. } = error else { panic!("{error}") };
        let enough = needed_mm * 1e-3 - config.stub_clearance() - config.core.shoulder;
        codes(3, enough + 1e-9, 7.8e-3, &config).unwrap();
        let error = codes(8, 2.2e-3, 7.8e-3, &config).unwrap_err();
        let KeyingError::Short { needed, .. } = error else { panic!("{error}") };
        codes(8, 2.2e-3, needed - config.stub_clearance() + 1e-9, &config).unwrap();
    }
}
