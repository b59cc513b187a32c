//! `[groove]`: the groove that a ridge of the mold leaves in the casting for its thread.

use super::table::{any, length, optional_length, table};

table! {
    /// The groove for the thread of `wound`.
    GrooveConfig, "groove." {
        /// Diameter of the thread [m].
        thread: f64 = 0.0 => "needed", thread;
        /// How much wider than the thread the bottom of the groove is [m].
        clearance: f64 = 1e-4, length;
        /// Depth of the groove [m].
        depth: Option<f64> = None => "the diameter of the thread", optional_length;
        /// Angle by which each flank leans out [°].
        draft: f64 = 10.0, lean;
        /// How far, at most, the groove is widened beside the thread so that its ridge leaves the silicone without
        /// pressing into it; where more is needed there is no ridge [m].
        relief: Option<f64> = None => "half the diameter of the thread", optional_length;
        /// Diameter of the pits for the knots at the ends of the thread, over its own; 0 for no pits [1].
        knot: f64 = 3.0, knot;
        /// Tags of the casting that get a groove.
        on: Vec<String> = Vec::new() => "all on which the thread lies", any;
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

fn thread(key: &str, diameter: &f64) -> Result<(), String> {
    match *diameter > 0.0 && *diameter < 0.02 {
        true => Ok(()),
        false => Err(format!(
            "{key} is {diameter}, must be above 0 and below 0.02: the diameter of the thread in metres"
        )),
    }
}

fn lean(key: &str, draft: &f64) -> Result<(), String> {
    match (0.0..=45.0).contains(draft) {
        true => Ok(()),
        false => Err(format!("{key} is {draft}, must lie between 0 and 45 degrees")),
    }
}

fn knot(key: &str, knot: &f64) -> Result<(), String> {
    match *knot == 0.0 || (1.0..=10.0).contains(knot) {
        true => Ok(()),
        false => Err(format!("{key} is {knot}, must be 0 or lie between 1 and 10 diameters")),
    }
}
