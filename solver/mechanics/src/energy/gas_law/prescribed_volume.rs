//! A prescribed volume, at the pressure that it needs.
//!
//! Φ = −P̂ (V − V*) + ½ k (V − V*)²
//!
//! V*     V₀ plus a change, or V₀ times a factor [m³]
//! P̂, k   multiplier and penalty of the augmented Lagrangian [Pa, Pa/m³]
//!
//! P̂ and k belong to the iterate: `forward` finds the P̂ for which V = V*, and P is then
//! the pressure at which the volume is V*, for any k.

use super::{GasLaw, Key, Moment, Potential, Row, Wanted};
use crate::energy::Multiplier;
use crate::schedule::Schedule;

const CHANGE: &str = "volume_change";
const FACTOR: &str = "volume_factor";

pub(super) const ROW: Row = Row {
    name: "prescribed volume",
    formula: "V = V*, at the pressure that it needs; this is the Lagrange multiplier",
    keys: &[
        Key::selecting(CHANGE, "m³", "V* − V₀, volume that is pumped in"),
        Key::selecting(FACTOR, "1", "V*/V₀, 1 at rest"),
    ],
    source: "augmented Lagrangian: Nocedal and Wright, chapters 17 and 18",
    build: |key, schedule, _| {
        Box::new(match key {
            CHANGE => PrescribedVolume::Change(schedule),
            _ => PrescribedVolume::Factor(schedule),
        })
    },
};

/// A chamber whose volume is prescribed by one of two keys.
#[derive(Clone, Debug, PartialEq)]
pub enum PrescribedVolume {
    /// V₀ plus a change [m³].
    Change(Schedule),
    /// V₀ times a factor, which is 1 at rest.
    Factor(Schedule),
}

impl PrescribedVolume {
    /// V* and its derivatives.
    pub fn at_load(&self, rest: f64, time: f64) -> Wanted {
        match self {
            Self::Change(change) => {
                Wanted { volume: rest + change.at(time), by_rest: 1.0, by_parameter: 1.0 }
            }
            Self::Factor(factor) => {
                let factor = factor.at(time) + factor.to_come(time);
                Wanted { volume: rest * factor, by_rest: factor, by_parameter: rest }
            }
        }
    }
}

impl GasLaw for PrescribedVolume {
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential {
        let Multiplier { pressure, penalty } = moment.multiplier;
        let Wanted { volume, by_rest, .. } = self.at_load(rest, moment.time);
        let gap = v - volume;
        Potential {
            value: (0.5 * penalty * gap - pressure) * gap,
            pressure: pressure - penalty * gap,
            stiffness: penalty,
            pressure_by_rest: penalty * by_rest,
            pressure_by_past: 0.0,
        }
    }

    fn schedule(&self) -> &Schedule {
        let (Self::Change(by) | Self::Factor(by)) = self;
        by
    }

    fn with_schedule(&self, schedule: Schedule) -> Box<dyn GasLaw> {
        Box::new(match self {
            Self::Change(_) => Self::Change(schedule),
            Self::Factor(_) => Self::Factor(schedule),
        })
    }

    fn needs_space(&self) -> bool {
        matches!(self, Self::Factor(_))
    }

    fn pressure_by_parameter(&self, _: f64, _: f64, _: &Moment) -> Option<f64> {
        None
    }

    fn wanted(&self, rest: f64, time: f64) -> Option<Wanted> {
        Some(self.at_load(rest, time))
    }
}
