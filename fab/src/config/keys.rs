//! `[keys]`: cones that register one piece on another.

use program::table;

use super::LENGTH;

table! {
    /// Conical registration keys.
    #[derive(Clone, Debug)]
    pub struct KeysConfig {
        /// Radius at the foot of a key; it is half as wide at its tip [m].
        radius: f64 = 3e-3, LENGTH;
        /// Height of a key [m].
        height: f64 = 3e-3, LENGTH;
        /// Gap between a key and its hole [m].
        clearance: Option<f64> = None => "that of `casting.printer`, else 2e-4", LENGTH;
    }
}
