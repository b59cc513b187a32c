//! `[[parameter]]` and `[[chamber]]` of a design: numbers of the scene that may change, and pressures over time.

use program::table::{Numbers, Range};
use program::{KeyPath, Misfit, misfit};

program::table! {
    /// A number of the scene that may change, such as a peak pressure or a delay.
    #[derive(Clone, Debug)]
    pub struct ParameterDesign {
        /// The name in the scene's `[parameters]`, or the path of a number of `solver list --numbers`.
        name: String;
        /// Smallest and largest value.
        bounds: [f64; 2], rising::<[f64; 2]>("");
        /// Largest change in one iteration.
        change: Option<f64> = None, Range::POSITIVE;
        /// Keeps it small: `small × (value / scale)²` is a term of the objective with its name.
        small: Option<f64> = None, Range::POSITIVE;
        /// The value that counts as `small`.
        scale: Option<f64> = None => "the larger of the bounds", Range::POSITIVE;
    }
}

/// The rule of two bounds in a unit, if they are given: the smaller comes first.
fn rising<T: Numbers>(unit: &str) -> impl Fn(&KeyPath, &T) -> Result<(), Misfit> {
    move |at, bounds| match bounds.numbers()[..] {
        [low, high] if !(low < high && low.is_finite() && high.is_finite()) => Err(misfit!(
            at.clone(),
            " = [{low}, {high}]{unit}; expected two numbers, the smaller first"
        )),
        _ => Ok(()),
    }
}

impl ParameterDesign {
    /// The value at which the term that keeps the parameter small is 1: scale / √small; none without `small`.
    pub fn unit_cost(&self) -> Option<f64> {
        let largest = self.bounds.iter().fold(0.0, |most: f64, bound| most.max(bound.abs()));
        Some(self.scale.unwrap_or(largest) / self.small?.sqrt())
    }

    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("parameter").named(&self.name)
    }
}

program::table! {
    /// A chamber of a design: its pressure in the scene follows slopes over time, one for each
    /// time step.
    #[derive(Clone, Debug)]
    pub struct ChamberDesign {
        /// Name of the chamber in the scene, or the tag of its wall if it has none. The scene prescribes its pressure.
        on: String;
        /// Smallest and largest slope [Pa/s].
        slope: [f64; 2], rising::<[f64; 2]>(" Pa/s");
        /// Smallest and largest pressure at the ends of time steps [Pa].
        bounds: Option<[f64; 2]> = None, rising::<Option<[f64; 2]>>(" Pa");
        /// Largest change of a slope in one iteration [Pa/s].
        change: Option<f64> = None, Range::POSITIVE.unit("Pa/s");
    }
}

impl ChamberDesign {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("chamber").on(&self.on)
    }
}
