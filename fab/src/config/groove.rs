//! `[groove]`: the groove that a ridge of the mold leaves in the casting for its thread.

use program::table;
use program::table::Range;
use program::{KeyPath, Misfit, misfit};

use super::LENGTH;

table! {
    /// The groove for the thread of `wound`.
    #[derive(Clone, Debug)]
    pub struct GrooveConfig {
        /// Diameter of the thread [m].
        thread: f64, Range::above(0.0).below(0.02).unit("m");
        /// How much wider than the thread the bottom of the groove is [m].
        clearance: f64 = 1e-4, LENGTH;
        /// Depth of the groove [m].
        depth: Option<f64> = None => "the diameter of the thread", LENGTH;
        /// Angle by which each flank leans out [°].
        draft: f64 = 10.0, Range::between(0.0, 45.0).unit("°");
        /// How far, at most, the groove is widened beside the thread so that its ridge leaves the silicone without
        /// pressing into it; where more is needed there is no ridge [m].
        relief: Option<f64> = None => "half the diameter of the thread", LENGTH;
        /// Diameter of the pits for the knots at the ends of the thread, over its own; 0 for no pits [1].
        knot: f64 = 3.0, knot;
        /// Tags of the casting that get a groove.
        on: Vec<String> = Vec::new() => "all on which the thread lies";
    }
}

impl GrooveConfig {
    /// Depth [m].
    pub fn depth(&self) -> f64 {
        self.depth.unwrap_or(self.thread)
    }

    /// Largest widening beside the thread [m].
    pub fn relief(&self) -> f64 {
        self.relief.unwrap_or(self.thread / 2.0)
    }
}

/// 0 for no pits, or diameters of the thread.
fn knot(key: &KeyPath, knot: &f64) -> Result<(), Misfit> {
    match *knot == 0.0 || (1.0..=10.0).contains(knot) {
        true => Ok(()),
        false => {
            Err(misfit!(key.clone(), " = {knot}: must be 0 or lie between 1 and 10 diameters"))
        }
    }
}
