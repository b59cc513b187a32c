//! `[sprue]`: the channel through which silicone enters.

use program::table;

use super::LENGTH;

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
