//! `[core]`: how a core is held, and its bore.

use serde::Deserialize;

use super::table::{any, length, optional_length, table};

/// Whether a core is held at a second place.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Support {
    /// By a pin if its neck bends more than `limits.sag`.
    Auto,
    /// By a pin.
    Pin,
    /// By its stub alone.
    Stub,
}

table! {
    /// The core print: a stub below the inlet, in a socket of the piece below.
    CoreConfig, "core." {
        /// Length of the stub, and thickness of the mold below the part [m].
        length: f64 = 8e-3, length;
        /// Gap between stub and socket [m].
        clearance: Option<f64> = None => "that of `casting.printer`, else 2e-4", optional_length;
        /// Width of the ring around the socket on which the core rests [m].
        shoulder: f64 = 1e-4, length;
        /// What holds the far end of a core: `"pin"`, `"stub"` (nothing but the stub), or `"auto"`:
        /// a pin if the neck bends by more than `limits.sag`.
        support: Support = Support::Auto => "\"auto\"", any;
        /// Radius of that pin [m].
        pin: f64 = 1e-3, length;
        /// Radius of the bore for water in a soluble core [m].
        drain: f64 = 6e-4, length;
        /// Least thickness of a soluble core around its bore [m].
        skin: f64 = 8e-4, length;
    }
}
