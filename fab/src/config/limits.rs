//! `[limits]`: what decides between methods and partings.

use super::table::{length, ratio, table};

table! {
    /// Limits on measures. All are judgements from practice, not measurements.
    LimitsConfig, "limits." {
        /// Largest girth of a rigid core over that of its inlet: how far the inlet must stretch [1].
        girth: f64 = 2.5, ratio;
        /// Largest depth of an undercut over the width of the silicone that must deform [1].
        peel: f64 = 0.5, ratio;
        /// Least part of the chamber's outline that a flat wall must cover for an open-top mold [1].
        flat: f64 = 0.8, ratio;
        /// Largest motion of the far end of a core that is not reported [m].
        sag: f64 = 5e-4, length;
    }
}
