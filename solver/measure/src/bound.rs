//! `[[constraint]]` of the end of a run: a probe of the scene, or the slope of the pressure, stays within bounds.

use program::table::Range;
use program::{KeyPath, Misfit, misfit};

program::table! {
    /// Bounds of a probe, in its unit.
    #[derive(Clone, Debug)]
    pub struct ProbeBound {
        /// As reports call it.
        name: String;
        /// Name of a probe of the scene.
        probe: String;
        /// The smallest value that the probe may have.
        least: Option<f64> = None, Range::FINITE;
        /// The largest value that the probe may have.
        most: Option<f64> = None, Range::FINITE;
    }
}

impl ProbeBound {
    pub(crate) fn check(&self) -> Result<(), Misfit> {
        match (self.least, self.most) {
            (None, None) => Err(misfit!(
                KeyPath::of("probe"),
                ": without least and most nothing is kept; expected one of them, or both"
            )),
            (Some(low), Some(high)) if low >= high => Err(misfit!(
                KeyPath::of("least"),
                " = {low} and most = {high}: expected numbers, least below most"
            )),
            _ => Ok(()),
        }
    }
}

program::table! {
    /// The least slope of the pressure by the volume, over pressure by change of volume from rest: 1 where the body
    /// answers in proportion, 0 where it balloons.
    #[derive(Clone, Debug)]
    pub struct SlopeBound {
        /// As reports call it.
        name: String;
        /// The smallest slope [1].
        least: f64, Range::POSITIVE.advice(": 0 is the slope where it balloons");
    }
}
