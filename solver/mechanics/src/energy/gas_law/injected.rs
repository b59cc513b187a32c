//! A liquid that a syringe injects through tubing that gives.
//!
//! Φ' = −P,   P = (V_i + V₀ − V)/C
//!
//! V_i  volume that left the syringe [m³]
//! C    compliance of what lies between: the volume that it takes up per pressure [m³/Pa]
//!
//! As C → 0 the volume is prescribed: V = V₀ + V_i.

use super::{GasLaw, Key, Least, Moment, Potential, Row};
use crate::schedule::Schedule;

pub(super) const ROW: Row = Row {
    name: "injected liquid",
    formula: "P = (V_i + V₀ − V)/C",
    keys: &[
        Key::selecting(
            "injected",
            "m³",
            "V_i, volume of liquid that a syringe has injected; negative: drawn out",
        ),
        Key::number(
            "compliance",
            "m³/Pa",
            "C > 0, volume that tubing and syringe take up per pressure",
            Least::Above(0.0),
        ),
    ],
    source: "conservation of volume",
    build: |_, injected, numbers| Box::new(InjectedLiquid { injected, compliance: numbers[0] }),
};

/// A chamber that is filled with a liquid by a syringe.
#[derive(Clone, Debug, PartialEq)]
pub struct InjectedLiquid {
    /// Volume that left the syringe [m³].
    pub injected: Schedule,
    /// Compliance of tubing and syringe [m³/Pa].
    pub compliance: f64,
}

impl GasLaw for InjectedLiquid {
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential {
        let stored = self.injected.at(moment.time) + rest - v;
        Potential {
            value: stored * stored / (2.0 * self.compliance),
            pressure: stored / self.compliance,
            stiffness: 1.0 / self.compliance,
            pressure_by_rest: 1.0 / self.compliance,
            pressure_by_past: 0.0,
        }
    }

    fn schedule(&self) -> &Schedule {
        &self.injected
    }

    fn with_schedule(&self, injected: Schedule) -> Box<dyn GasLaw> {
        Box::new(Self { injected, ..self.clone() })
    }

    fn needs_space(&self) -> bool {
        false
    }

    fn pressure_by_parameter(&self, _: f64, _: f64, _: &Moment) -> Option<f64> {
        Some(1.0 / self.compliance)
    }
}
