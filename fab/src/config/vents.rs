//! `[vents]`: channels through which the air leaves.

use super::table::{length, table};

table! {
    /// Vents at the local maxima of height.
    VentsConfig, "vents." {
        /// Radius of a vent [m].
        radius: f64 = 8e-4, length;
        /// A local maximum of height gets a vent if one has to descend at least this far from it
        /// to reach a higher one [m].
        persistence: f64 = 1e-3, length;
    }
}
