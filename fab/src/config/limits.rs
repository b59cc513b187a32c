//! `[limits]`: what decides between methods and partings.

use program::table;
use program::table::Range;

use super::LENGTH;

/// A ratio.
const RATIO: Range = Range::POSITIVE;

table! {
    /// Limits on measures. All are judgements from practice, not measurements.
    #[derive(Clone, Debug)]
    pub struct LimitsConfig {
        /// Largest girth of a rigid core over that of its inlet: how far the inlet must stretch [1].
        girth: f64 = 2.5, RATIO;
        /// Largest depth of an undercut over the width of the silicone that must deform [1].
        peel: f64 = 0.5, RATIO;
        /// Least part of the chamber's outline that a flat wall must cover for an open-top mold [1].
        flat: f64 = 0.8, RATIO;
        /// Largest motion of the far end of a core that is not reported [m].
        sag: f64 = 5e-4, LENGTH;
    }
}
