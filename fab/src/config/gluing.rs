//! `[gluing]`: where halves are glued.

use program::table;
use program::table::direction;

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
