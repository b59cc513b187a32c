//! `[keys]`: cones that register one piece on another.

use super::table::{length, optional_length, table};

table! {
    /// Conical registration keys.
    KeysConfig, "keys." {
        /// Radius at the foot of a key; it is half as wide at its tip [m].
        radius: f64 = 3e-3, length;
        /// Height of a key [m].
        height: f64 = 3e-3, length;
        /// Gap between a key and its hole [m].
        clearance: Option<f64> = None => "that of `casting.printer`, else 2e-4", optional_length;
    }
}
