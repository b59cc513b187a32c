//! `[flange]`: the rim on which shells are bolted to each other.

use program::table;

use super::LENGTH;

table! {
    /// The rim on which shells are bolted to each other.
    #[derive(Clone, Debug)]
    pub struct FlangeConfig {
        /// Thickness on each side of a joint [m].
        thickness: f64 = 6e-3, LENGTH;
        /// Radius of the bolt holes: 1.7 mm for M3 [m].
        bolt: f64 = 1.7e-3, LENGTH;
        /// Radius of the half-round slots for a screwdriver [m].
        pry: f64 = 2e-3, LENGTH;
    }
}
