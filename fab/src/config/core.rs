//! `[core]`: how a core is held, and its bore.

use program::table;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Config, LENGTH};

/// Distance of the flat from the stub's axis, in radii.
pub const STUB_FLAT: f64 = 0.7;

/// The thinnest stub that can be printed [m].
const THINNEST: f64 = 5e-4;

/// Least part of its socket that a stub must fill: `fab verify` asks for half, and sockets are
/// prisms.
const FILLED: f64 = 0.51;

/// Whether a core is held at a second place.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Support {
    /// By pins if it moves more than `limits.sag`.
    Auto,
    /// By at least one pin.
    Pin,
    /// By its stub alone.
    Stub,
}

table! {
    /// The core print: a stub below the inlet, in a socket of the piece below.
    #[derive(Clone, Debug)]
    pub struct CoreConfig {
        /// Length of the stub, and thickness of the mold below the part [m].
        length: f64 = 8e-3, LENGTH;
        /// Gap between stub and socket [m].
        clearance: Option<f64> = None => "that of `casting.printer`, else 2e-4", LENGTH;
        /// Width of the ring around the socket on which the core rests [m].
        shoulder: f64 = 1e-4, LENGTH;
        /// What holds a core beside its stub: `"pin"`, at least one pin of the mold, whose hole in the silicone
        /// is closed afterwards; `"stub"`, nothing; or `"auto"`, pins if the core leans or bends by more than
        /// `limits.sag`.
        support: Support = Support::Auto;
        /// Radius of those pins [m].
        pin: f64 = 1e-3, LENGTH;
        /// Points of the design beside which pins hold a core, each within four radii of the axis of its pin [m].
        pins: Vec<[f64; 3]> = Vec::new() => "searched, as few as are needed";
        /// Radius of the bore for water in a soluble core [m].
        drain: f64 = 6e-4, LENGTH;
        /// Least thickness of a soluble core around its bore [m].
        skin: f64 = 8e-4, LENGTH;
    }
}

impl Config {
    /// Radius of the stub in an inlet of this inscribed radius: less by the clearance and the
    /// shoulder [m].
    pub fn stub_radius(&self, inlet: f64) -> f64 {
        inlet - self.stub_clearance() - self.core.shoulder
    }

    /// How far from the point of a pin the silicone is to be even: the pin stands up to half a radius beside it, and
    /// silicone is left around [m].
    pub fn even_around_pins(&self) -> f64 {
        1.5 * self.core.pin + self.stub_clearance() + self.casting.least_wall
    }

    /// Least inscribed radius of an inlet that holds a stub [m]. A stub of radius r and length
    /// L − c with a flat fills the part f (r/(r + c))² (L − c)/L of its socket, where c is the
    /// clearance and f the part of a circle that its flat leaves.
    pub fn least_inlet(&self) -> f64 {
        let clearance = self.stub_clearance();
        let angle = STUB_FLAT.acos();
        let left = 1.0 - (angle - STUB_FLAT * angle.sin()) / std::f64::consts::PI;
        let long = 1.0 - clearance / self.core.length.max(self.wall);
        let ratio = (FILLED / (left * long).max(FILLED)).sqrt();
        let held = if ratio < 1.0 { clearance * ratio / (1.0 - ratio) } else { f64::INFINITY };
        held.max(THINNEST) + clearance + self.core.shoulder
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_least_inlet_holds_a_stub_that_fills_half_of_its_socket() {
        let config = Config::default();
        let [clearance, length] = [config.stub_clearance(), config.core.length];
        let radius = config.stub_radius(config.least_inlet());
        let angle = STUB_FLAT.acos();
        let stub = radius.powi(2) * (std::f64::consts::PI - angle + STUB_FLAT * angle.sin());
        let socket = std::f64::consts::PI * (radius + clearance).powi(2);
        let filled = stub / socket * (length - clearance) / length;
        assert!((filled - FILLED).abs() < 1e-9, "{filled}");
        // Without a gap, what can be printed decides.
        let tight = Config::parse("[core]\nclearance = 1e-6").unwrap();
        assert!((tight.stub_radius(tight.least_inlet()) - THINNEST).abs() < 1e-12);
    }
}
