//! `[gluing]`: where halves are glued.

use super::table::{any, optional_direction, table};

table! {
    /// The plane in which a body is cut into halves.
    GluingConfig, "gluing." {
        /// Normal of the plane in which halves are glued [1].
        normal: Option<[f64; 3]> = None => "searched", optional_direction;
        /// Position of that plane along its normal, in the design's coordinates [m].
        offset: Option<f64> = None => "searched", any;
    }
}
