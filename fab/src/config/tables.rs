//! Tables of keys alone: `[limits]`, `[gluing]`, `[flange]`, `[keys]`, `[sprue]`, `[vents]`.

use program::table;
use program::table::{Range, direction};

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

table! {
    /// The plane in which a body is cut into halves.
    #[derive(Clone, Debug)]
    pub struct GluingConfig {
        /// Normal of the plane in which halves are glued [1].
        normal: Option<[f64; 3]> = None => "searched", direction;
        /// Position of that plane along its normal, in the design's coordinates [m].
        offset: Option<f64> = None => "searched";
    }
}

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

table! {
    /// The conical sprue.
    #[derive(Clone, Debug)]
    pub struct SprueConfig {
        /// A point of the design on the vertical through the sprue [m].
        at: Option<[f64; 3]> = None => "the highest point";
        /// Radius at the part [m].
        radius: f64 = 3e-3, LENGTH;
        /// Radius at the top of the mold [m].
        top_radius: f64 = 5.4e-3, LENGTH;
    }
}

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
