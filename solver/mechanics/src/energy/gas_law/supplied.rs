//! Gas that a pump or regulator supplies through a line, with a leak, and with or without a check valve.
//!
//! M = (p_a + P) V − p_a V₀,   Ṁ = p_a (Q − L P),   Q = (P_s − P)/R
//!
//! M    amount of gas above that at rest, isothermal [J]
//! P_s  gauge pressure of the supply at the other end of the line [Pa]
//! R    resistance: pressure per volume flow, the volume measured at ambient pressure [Pa s/m³]
//! L    leak: such a flow per gauge pressure of the chamber [m³/(Pa s)]
//! p_a  ambient pressure [Pa]
//!
//! A check valve lets nothing back: Q = max(0, P_s − P)/R. With the formula of a step in time, Ṁ = (M − M°)/h, the
//! pressure is a function of the volume,
//!
//! P = (A − p_a V)/(V + B),   A = M° + p_a V₀ + h p_a P_s/R,   B = h p_a (1/R + L)
//! Φ = p_a (V − V₀) − (A + p_a B) ln((V + B)/(V₀ + B))
//!
//! and the same without 1/R where the valve is shut, from the volume on at which P = P_s; there Φ continues.
//! In a static scene the flow has settled: P = P_s/(1 + L R).
//!
//! Source: conservation of mass, Boyle's law; a flow in proportion to the difference of pressures is that of
//! Hagen and Poiseuille in a thin line.

use super::{BelowVacuum, GasLaw, Key, Least, Moment, Past, Potential, Row, check_full};
use crate::schedule::Schedule;

const SUPPLY: &str = "supply";
const CHECKED: &str = "checked_supply";

pub(super) const ROW: Row = Row {
    name: "supplied gas",
    formula: "(p_a + P) V grows by p_a ((P_s − P)/R − L P) per second; in a static scene P = P_s/(1 + L R)",
    keys: &[
        Key::selecting(
            SUPPLY,
            "Pa",
            "P_s, gauge pressure of a pump or regulator at the other end of a line",
        ),
        Key::selecting(
            CHECKED,
            "Pa",
            "P_s in the same way, through a check valve that lets no gas back",
        ),
        Key::number(
            "resistance",
            "Pa s/m³",
            "R > 0 of the line: pressure per flow of volume at ambient pressure",
            Least::Above(0.0),
        ),
        Key {
            name: "leak",
            unit: "m³/(Pa s)",
            meaning: "L ≥ 0, flow out of the chamber per gauge pressure, measured as that of the line",
            selects: false,
            default: Some(0.0),
            least: Least::From(0.0),
        },
        Key {
            name: "ambient",
            unit: "Pa",
            meaning: "p_a, ambient pressure",
            selects: false,
            default: Some(101_325.0),
            least: Least::Above(0.0),
        },
    ],
    source: "conservation of mass, Boyle's law, Hagen–Poiseuille",
    build: |key, supply, numbers| {
        let &[resistance, leak, ambient] = numbers else { unreachable!("three keys") };
        Box::new(SuppliedGas { supply, checked: key == CHECKED, resistance, leak, ambient })
    },
};

/// A chamber at the end of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct SuppliedGas {
    /// Gauge pressure at the other end [Pa].
    pub supply: Schedule,
    /// Whether a check valve lets nothing back.
    pub checked: bool,
    /// Pressure per flow [Pa s/m³].
    pub resistance: f64,
    /// Flow per pressure out of the chamber [m³/(Pa s)].
    pub leak: f64,
    /// Ambient pressure [Pa].
    pub ambient: f64,
}

/// P = (A − p_a V)/(V + B).
#[derive(Clone, Copy)]
struct Curve {
    a: f64,
    b: f64,
    ambient: f64,
}

impl Curve {
    fn pressure(&self, v: f64) -> f64 {
        (self.a - self.ambient * v) / (v + self.b)
    }

    /// Φ less that at another volume.
    fn work(&self, v: f64, from: f64) -> f64 {
        let Self { a, b, ambient } = *self;
        ambient * (v - from) - (a + ambient * b) * ((v + b) / (from + b)).ln()
    }
}

impl SuppliedGas {
    /// The curves with the line open, and with its valve shut.
    fn curves(&self, rest: f64, past: &Past, supply: f64) -> [Curve; 2] {
        let ambient = self.ambient;
        let shut =
            Curve { a: past.amount + ambient * rest, b: past.h * ambient * self.leak, ambient };
        let through = past.h * ambient / self.resistance;
        [Curve { a: shut.a + through * supply, b: shut.b + through, ambient }, shut]
    }

    /// Whether gas flows through the line at a volume.
    fn is_open(&self, open: &Curve, v: f64, supply: f64) -> bool {
        !self.checked || open.pressure(v) <= supply
    }

    fn settled(&self, supply: f64) -> f64 {
        supply / (1.0 + self.leak * self.resistance)
    }
}

impl GasLaw for SuppliedGas {
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential {
        let supply = self.supply.at(moment.time);
        let Some(past) = &moment.past else {
            let pressure = self.settled(supply);
            return Potential { value: -pressure * (v - rest), pressure, ..Potential::default() };
        };
        let [open, shut] = self.curves(rest, past, supply);
        if v + shut.b <= 0.0 {
            return Potential { value: f64::INFINITY, ..Potential::default() };
        }
        let (curve, value) = if self.is_open(&open, v, supply) {
            (open, open.work(v, rest))
        } else {
            // where P = P_s on both curves
            let meet = (shut.a - shut.b * supply) / (self.ambient + supply);
            (shut, shut.work(v, meet) + open.work(meet, rest))
        };
        let (pressure, width) = (curve.pressure(v), v + curve.b);
        Potential {
            value,
            pressure,
            stiffness: (self.ambient + pressure) / width,
            pressure_by_rest: self.ambient / width,
            pressure_by_past: 1.0 / width,
        }
    }

    fn schedule(&self) -> &Schedule {
        &self.supply
    }

    fn with_schedule(&self, supply: Schedule) -> Box<dyn GasLaw> {
        Box::new(Self { supply, ..self.clone() })
    }

    fn check(&self, moments: &[f64]) -> Result<(), BelowVacuum> {
        let key = if self.checked { CHECKED } else { SUPPLY };
        check_full(key, &self.supply, self.ambient, moments)
    }

    fn pressure_by_parameter(&self, v: f64, rest: f64, moment: &Moment) -> Option<f64> {
        let Some(past) = &moment.past else { return Some(self.settled(1.0)) };
        let supply = self.supply.at(moment.time);
        let [open, _] = self.curves(rest, past, supply);
        let through = past.h * self.ambient / self.resistance;
        Some(if self.is_open(&open, v, supply) { through / (v + open.b) } else { 0.0 })
    }

    fn remembers(&self) -> Option<f64> {
        Some(self.ambient)
    }
}
