//! Gas laws: how the pressure in a chamber follows its volume.
//!
//! A law is a potential Φ(V; V₀) [J] of the chamber's volume V and rest volume V₀,
//! with the gauge pressure P = −∂Φ/∂V; P > 0 inflates. One law per file, one row per
//! law in [`GAS_LAWS`].

mod ideal_gas;
mod injected;
mod isobaric;
mod prescribed_volume;
mod supplied;

use std::fmt::Debug;

use super::Multiplier;
use crate::schedule::Schedule;

pub use ideal_gas::IdealGas;
pub use injected::InjectedLiquid;
pub use isobaric::Isobaric;
pub use prescribed_volume::PrescribedVolume;
pub use supplied::SuppliedGas;

/// The laws, in the order in which they are listed.
pub const GAS_LAWS: &[Row] =
    &[isobaric::ROW, ideal_gas::ROW, prescribed_volume::ROW, injected::ROW, supplied::ROW];

/// A gas law: what to write, what it means, how to build it.
#[derive(Debug)]
pub struct Row {
    /// What lists call it.
    pub name: &'static str,
    /// The potential Φ or the pressure P.
    pub formula: &'static str,
    /// Keys in `[[chamber]]` besides `on`; the value of one that selects may change over time,
    /// the others are numbers.
    pub keys: &'static [Key],
    /// Where it comes from.
    pub source: &'static str,
    /// The law of a key that selects it, the one number that it follows over time, and the
    /// numbers of its other keys in their order.
    pub build: fn(&str, Schedule, &[f64]) -> Box<dyn GasLaw>,
}

/// A key of a gas law in `[[chamber]]`.
#[derive(Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Whether it selects the law: a chamber has exactly one such key.
    pub selects: bool,
    /// What it is where it is not written; none where it has to be.
    pub default: Option<f64>,
    /// How small it may be, if it is a number.
    pub least: Least,
}

/// How small a number may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Least {
    /// Above this.
    Above(f64),
    /// This or more.
    From(f64),
}

impl Key {
    /// A key that selects its law.
    const fn selecting(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        let least = Least::From(f64::NEG_INFINITY);
        Self { name, unit, meaning, selects: true, default: None, least }
    }

    /// A number that has to be written.
    const fn number(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        least: Least,
    ) -> Self {
        Self { name, unit, meaning, selects: false, default: None, least }
    }
}

/// A fill or supply below a vacuum.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("ambient + {key} = {full} Pa at t = {t} must be positive")]
pub struct BelowVacuum {
    /// What is added to the ambient pressure.
    pub key: &'static str,
    /// Absolute pressure [Pa].
    pub full: f64,
    /// Time [s].
    pub t: f64,
}

/// A gas law with its numbers.
pub trait GasLaw: Debug + Send + Sync {
    /// Φ and its derivatives at volume `v` of a chamber with rest volume `rest` [m³].
    fn at(&self, v: f64, rest: f64, moment: &Moment) -> Potential;
    /// The one number that it follows over time, the parameter p: pressure, fill, change,
    /// factor, injected volume or supply.
    fn schedule(&self) -> &Schedule;
    /// The same law with another schedule of that number.
    fn with_schedule(&self, schedule: Schedule) -> Box<dyn GasLaw>;
    /// Checks its schedule at the moments of the scene [s].
    fn check(&self, _moments: &[f64]) -> Result<(), BelowVacuum> {
        Ok(())
    }
    /// The pressure, where the law prescribes it [Pa].
    fn pressure(&self) -> Option<&Schedule> {
        None
    }
    /// Whether it holds only where a chamber has some volume at rest. Where not, its wall may be flat, or the
    /// outside of a body in a liquid, behind which there is a negative one.
    fn needs_space(&self) -> bool {
        true
    }
    /// ∂P/∂p at a volume, where the law does not prescribe the volume.
    fn pressure_by_parameter(&self, v: f64, rest: f64, moment: &Moment) -> Option<f64>;
    /// Ambient pressure p_a of a law that remembers from step to step how much gas it has more than at rest,
    /// M = (p_a + P) V − p_a V₀ [J].
    fn remembers(&self) -> Option<f64> {
        None
    }
    /// V*, where the law prescribes it.
    fn wanted(&self, _rest: f64, _load: f64) -> Option<Wanted> {
        None
    }
}

impl Clone for Box<dyn GasLaw> {
    fn clone(&self) -> Self {
        self.with_schedule(self.schedule().clone())
    }
}

/// When, and after what, a chamber is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time [s].
    pub time: f64,
    /// Multiplier of a prescribed volume, which other laws ignore.
    pub multiplier: Multiplier,
    /// What the step in time begins with, for a law that remembers its gas; none in a static scene.
    pub past: Option<Past>,
}

/// The gas that a step in time begins with, by which the rate at its end is Ṁ = (M − M°)/h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past {
    /// h [s].
    pub h: f64,
    /// M°, above that at rest [J].
    pub amount: f64,
}

/// Φ and its derivatives at one volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Potential {
    /// Φ [J]; infinite for V ≤ 0 of a fixed amount of gas.
    pub value: f64,
    /// Gauge pressure −Φ' [Pa].
    pub pressure: f64,
    /// Φ'' [Pa/m³].
    pub stiffness: f64,
    /// ∂P/∂V₀ [Pa/m³].
    pub pressure_by_rest: f64,
    /// ∂P/∂M° of a law that remembers its gas [1/m³]; else 0.
    pub pressure_by_past: f64,
}

/// A volume V* that a chamber shall have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// V* [m³].
    pub volume: f64,
    /// ∂V*/∂V₀ [1].
    pub by_rest: f64,
    /// ∂V*/∂p.
    pub by_parameter: f64,
}

/// Refuses a gauge pressure that is below a vacuum at some moment [s].
fn check_full(
    key: &'static str,
    gauge: &Schedule,
    ambient: f64,
    moments: &[f64],
) -> Result<(), BelowVacuum> {
    let full = |&t: &f64| (t, gauge.at(t) + ambient);
    match moments.iter().map(full).find(|&(_, full)| full.is_nan() || full <= 0.0) {
        Some((t, full)) => Err(BelowVacuum { key, full, t }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
