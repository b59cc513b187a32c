//! A fixed amount of ideal gas.
//!
//! Φ' = p_a − (P₀ + p_a)(V₀/V)^γ
//!
//! P₀   gauge pressure of the fill in the rest volume [Pa]
//! p_a  ambient pressure [Pa]
//! γ    1 isothermal, 1.4 adiabatic for air

use super::{BelowVacuum, GasLaw, Key, Least, Moment, Potential, Row, check_full};
use crate::schedule::Schedule;

pub(super) const ROW: Row = Row {
    name: "ideal gas",
    formula: "P = (P₀ + p_a)(V₀/V)^γ − p_a",
    keys: &[
        Key::selecting(
            "fill",
            "Pa",
            "P₀, gauge pressure in the rest volume, where the chamber is closed",
        ),
        Key::number("ambient", "Pa", "p_a, ambient pressure", Least::Above(0.0)),
        Key::number(
            "exponent",
            "1",
            "γ ≥ 1, polytropic exponent: 1 isothermal, 1.4 adiabatic for air",
            Least::From(1.0),
        ),
    ],
    source: "polytropic law",
    build: |_, fill, numbers| {
        Box::new(IdealGas { fill, ambient: numbers[0], exponent: numbers[1] })
    },
};

/// A chamber that is filled in its rest shape and closed.
#[derive(Clone, Debug, PartialEq)]
pub struct IdealGas {
    /// Gauge pressure in the rest volume [Pa].
    pub fill: Schedule,
    /// Ambient pressure [Pa].
    pub ambient: f64,
    /// Polytropic exponent γ [1].
    pub exponent: f64,
}

impl GasLaw for IdealGas {
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential {
        let &Self { ref fill, ambient, exponent } = self;
        if v <= 0.0 {
            let value = f64::INFINITY;
            return Potential { value, ..Potential::default() };
        }
        let full = fill.at(moment.time) + ambient;
        let ratio = rest / v;
        let absolute = full * ratio.powf(exponent);
        // ∫ (V₀/V)^γ dV from V₀, a logarithm at γ = 1
        let work = if exponent == 1.0 {
            -rest * ratio.ln()
        } else {
            rest * (ratio.powf(exponent - 1.0) - 1.0) / (1.0 - exponent)
        };
        Potential {
            value: ambient * (v - rest) - full * work,
            pressure: absolute - ambient,
            stiffness: exponent * absolute / v,
            pressure_by_rest: exponent * absolute / rest,
            pressure_by_past: 0.0,
        }
    }

    fn schedule(&self) -> &Schedule {
        &self.fill
    }

    fn with_schedule(&self, fill: Schedule) -> Box<dyn GasLaw> {
        Box::new(Self { fill, ..self.clone() })
    }

    fn check(&self, moments: &[f64]) -> Result<(), BelowVacuum> {
        check_full("fill", &self.fill, self.ambient, moments)
    }

    fn pressure_by_parameter(&self, v: f64, rest: f64, _: &Moment) -> Option<f64> {
        Some((rest / v).powf(self.exponent))
    }
}
