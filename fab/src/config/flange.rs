//! `[flange]`: the rim on which shells are bolted to each other.

use super::table::{length, table};

table! {
    /// The rim on which shells are bolted to each other.
    FlangeConfig, "flange." {
        /// Thickness on each side of a joint [m].
        thickness: f64 = 6e-3, length;
        /// Radius of the bolt holes: 1.7 mm for M3 [m].
        bolt: f64 = 1.7e-3, length;
        /// Radius of the half-round slots for a screwdriver [m].
        pry: f64 = 2e-3, length;
    }
}
