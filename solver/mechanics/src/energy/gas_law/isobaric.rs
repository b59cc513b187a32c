//! A prescribed pressure.
//!
//! Φ = −P (V − V₀)

use super::{GasLaw, Key, Moment, Potential, Row};
use crate::schedule::Schedule;

pub(super) const ROW: Row = Row {
    name: "isobaric",
    formula: "Φ = −P (V − V₀)",
    keys: &[Key::selecting("pressure", "Pa", "P, gauge pressure at any volume; positive inflates")],
    source: "work of a constant pressure",
    build: |_, pressure, _| Box::new(Isobaric { pressure }),
};

/// A gauge pressure that is the same at any volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Isobaric {
    /// Gauge pressure [Pa].
    pub pressure: Schedule,
}

impl GasLaw for Isobaric {
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential {
        let pressure = self.pressure.at(moment.time);
        Potential { value: -pressure * (v - rest), pressure, ..Potential::default() }
    }

    fn schedule(&self) -> &Schedule {
        &self.pressure
    }

    fn with_schedule(&self, pressure: Schedule) -> Box<dyn GasLaw> {
        Box::new(Self { pressure })
    }

    fn pressure(&self) -> Option<&Schedule> {
        Some(&self.pressure)
    }

    fn needs_space(&self) -> bool {
        false
    }

    fn pressure_by_parameter(&self, _: f64, _: f64, _: &Moment) -> Option<f64> {
        Some(1.0)
    }
}
