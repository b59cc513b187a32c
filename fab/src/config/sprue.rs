//! `[sprue]`: the channel through which silicone enters.

use super::table::{any, length, table};

table! {
    /// The conical sprue.
    SprueConfig, "sprue." {
        /// A point of the design on the vertical through the sprue [m].
        at: Option<[f64; 3]> = None => "the highest point", any;
        /// Radius at the part [m].
        radius: f64 = 3e-3, length;
        /// Radius at the top of the mold [m].
        top_radius: f64 = 5.4e-3, length;
        /// Share of the body that a funnel in the sprue holds; it opens at 45° and is left out with
        /// a warning where the sprue leaves the mold on a steep slope [1].
        head: Option<f64> = None => "no funnel", share;
    }
}

fn share(key: &str, head: &Option<f64>) -> Result<(), String> {
    match head {
        Some(head) if !(*head > 0.0 && *head <= 1.0) => {
            Err(format!("{key} is {head}, must be a share of the body above 0 and at most 1"))
        }
        _ => Ok(()),
    }
}
