//! `[vents]`: channels through which the air leaves.

use program::table;

use super::LENGTH;

table! {
    /// Vents at the local maxima of height.
    #[derive(Clone, Debug)]
    pub struct VentsConfig {
        /// Radius of a vent [m].
        radius: f64 = 8e-4, LENGTH;
        /// A local maximum of height gets a vent if one has to descend at least this far from it
        /// to reach a higher one [m].
        persistence: f64 = 1e-3, LENGTH;
    }
}
