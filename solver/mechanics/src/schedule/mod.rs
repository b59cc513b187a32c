//! Values of loads and supports over time.
//!
//! A scene begins at t = 0 with its body at rest and ends its first time step
//! at t₁. The written value w(t) acts unchanged from t₁ on; w(0) is ramped up during the
//! first step:
//!
//! v(t) = w(t) − (1 − t/t₁) w(0)   for t < t₁,   v(t) = w(t) after
//!
//! so that a number grows in proportion to t and then stays. A static scene is
//! one time step with t₁ = 1; t is then the fraction of the load.

mod expression;
mod jet;
mod node;
mod parser;
mod table;
mod written;

pub use expression::Expression;
pub use jet::Jet;
pub use parser::{FUNCTIONS, Malformed, UnknownName, is_free_name};
pub use table::Table;
pub use written::{Written, WrittenField};

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use mesh::Vec3;

use crate::math::tensor::Mat3;

/// The values over time, and over rest positions, of what was [`Written`].
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// w(t), whose names have values.
    value: Written,
    /// t₁ [s].
    first: f64,
    /// The time at which it is held, whatever the time [s].
    still: Option<f64>,
}

/// The largest value of an expression or table: squares of forces by it are finite.
const LARGEST: f64 = 1e100;

/// A number, which grows until t₁ = 1 s.
impl From<f64> for Schedule {
    fn from(value: f64) -> Self {
        Self { value: Written::Number(value), first: 1.0, still: None }
    }
}

/// An expression without parameters, with t₁ = 1 s.
impl std::str::FromStr for Schedule {
    type Err = Malformed;

    fn from_str(text: &str) -> Result<Self, Malformed> {
        text.parse::<Written>()?.schedule(&BTreeMap::new(), 1.0)
    }
}

impl Schedule {
    /// Linear between values at increasing times [s], the first 0.
    pub fn table(times: &[f64], values: &[f64]) -> Result<Self, String> {
        let table = Table::new(times.to_vec(), values.to_vec())?;
        Ok(Self { value: Written::Table(Arc::new(table)), first: times[1], still: None })
    }

    /// A value that does not change at t > 0.
    pub fn held(value: f64) -> Self {
        Self { value: Written::Number(value), first: f64::MIN_POSITIVE, still: None }
    }

    /// This schedule as it is at a time [s], for all times.
    pub fn held_at(&self, time: f64) -> Self {
        Self { still: Some(time), ..self.clone() }
    }

    /// A value that grows in proportion to t without end, and is `value` at a time > 0 [s].
    pub fn proportional(value: f64, time: f64) -> Self {
        let rate = Expression::proportional(value / time);
        Self { value: Written::Expression(Arc::new(rate)), first: f64::MIN_POSITIVE, still: None }
    }

    /// ∂v/∂p by a parameter at a time, where v does not depend on the position.
    pub fn by_parameter(&self, parameter: &str, time: f64) -> f64 {
        let Written::Expression(expression) = &self.value else { return 0.0 };
        let time = self.still.unwrap_or(time);
        let now = expression.by_parameter(parameter, time);
        match self.to_come(time) {
            0.0 => now,
            to_come => now - to_come * expression.by_parameter(parameter, 0.0),
        }
    }

    /// Whether it was written as the number zero.
    pub fn is_zero(&self) -> bool {
        self.value.is_zero()
    }

    /// Whether it depends on the position.
    pub fn uses_position(&self) -> bool {
        self.value.uses_position()
    }

    /// 1 − t/t₁ during the first step, 0 after it.
    pub fn to_come(&self, time: f64) -> f64 {
        (1.0 - self.still.unwrap_or(time) / self.first).max(0.0)
    }

    /// v at a time t [s], where it does not depend on the position; NaN
    /// where it is not defined.
    pub fn at(&self, time: f64) -> f64 {
        self.jet(Vec3::zeros(), time).value
    }

    /// w and its gradient at a rest position [m] and a time [s].
    pub fn as_written(&self, position: Vec3, time: f64) -> Jet {
        match &self.value {
            Written::Number(value) => Jet::constant(*value),
            Written::Expression(expression) => expression.at(position, time),
            Written::Table(table) => Jet::constant(table.at(time)),
        }
    }

    /// v and its gradient at a rest position [m] and a time.
    pub fn jet(&self, position: Vec3, time: f64) -> Jet {
        let time = self.still.unwrap_or(time);
        let to_come = self.to_come(time);
        if let Written::Number(value) = self.value {
            return Jet::constant((time / self.first).min(1.0) * value);
        }
        let now = self.as_written(position, time);
        if to_come == 0.0 {
            return now;
        }
        now - Jet::constant(to_come) * self.as_written(position, 0.0)
    }

    /// Whether it is defined at all these times [s] and positions [m].
    pub fn check(&self, times: &[f64], positions: &[Vec3]) -> Result<(), String> {
        if let Written::Number(value) = self.value {
            return if value.is_finite() { Ok(()) } else { Err(format!("{value} is not finite")) };
        }
        if let Written::Table(table) = &self.value {
            table.check_range(times)?;
        }
        let everywhere = if self.uses_position() { positions } else { &[Vec3::zeros()] };
        for &t in times {
            for &x in everywhere {
                let value = self.as_written(x, t).value;
                if value.is_nan() || value.abs() > LARGEST {
                    let place = if self.uses_position() {
                        format!(" at ({:.5}, {:.5}, {:.5}) m", x.x, x.y, x.z)
                    } else {
                        String::new()
                    };
                    return Err(format!("{self} is {value:e} at t = {t} s{place}"));
                }
            }
        }
        Ok(())
    }
}

/// As it was written.
impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.value)
    }
}

/// Three schedules: a vector that may change with time and position.
#[derive(Clone, Debug, PartialEq)]
pub struct Field(pub [Schedule; 3]);

impl From<[f64; 3]> for Field {
    fn from(values: [f64; 3]) -> Self {
        Self(values.map(Schedule::from))
    }
}

impl From<Vec3> for Field {
    fn from(values: Vec3) -> Self {
        <[f64; 3]>::from(values).into()
    }
}

impl Default for Field {
    fn default() -> Self {
        [0.0; 3].into()
    }
}

/// Which of x, y, z are named.
pub fn axes(components: &str) -> [bool; 3] {
    ['x', 'y', 'z'].map(|axis| components.contains(axis))
}

impl Field {
    /// Whether it depends on the position.
    pub fn uses_position(&self) -> bool {
        self.0.iter().any(Schedule::uses_position)
    }

    /// This field as it is at a time [s], for all times.
    pub fn held_at(&self, time: f64) -> Self {
        Self(self.0.each_ref().map(|component| component.held_at(time)))
    }

    /// The vector at a rest position [m] and a time.
    pub fn at(&self, position: Vec3, time: f64) -> Vec3 {
        Vec3::from_fn(|k, _| self.0[k].jet(position, time).value)
    }

    /// ∂f_i/∂X_j at a rest position [m] and a time.
    pub fn gradient(&self, position: Vec3, time: f64) -> Mat3 {
        let rows = self.0.each_ref().map(|s| s.jet(position, time).gradient.transpose());
        Mat3::from_rows(&rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun(written: &Written, first: f64) -> Schedule {
        written.schedule(&BTreeMap::new(), first).expect("no parameters")
    }

    fn written(text: &str, first: f64) -> Schedule {
        begun(&text.parse().expect(text), first)
    }

    #[test]
    fn a_number_grows_in_the_first_step_and_stays() {
        let number = begun(&8.0.into(), 0.5);
        let values = [0.0, 0.125, 0.5, 3.0].map(|t| number.at(t));
        assert_eq!(values, [0.0, 2.0, 8.0, 8.0]);
        // of a static scene exactly proportional
        assert_eq!(Schedule::from(55e3).at(0.3), 0.3 * 55e3);
    }

    #[test]
    fn numbers_expressions_and_tables_of_one_value_agree() {
        let table = Table::new(vec![0.0, 2.0, 3.0], vec![8.0; 3]).expect("sound");
        let (number, expression) = (begun(&8.0.into(), 0.5), written("8 + 0*t", 0.5));
        let table = begun(&Written::Table(Arc::new(table)), 0.5);
        for t in [0.0, 0.1, 0.3, 0.5, 1.0, 2.7] {
            assert!((expression.at(t) - number.at(t)).abs() < 1e-14);
            assert!((table.at(t) - number.at(t)).abs() < 1e-14);
        }
        // what begins with nothing is not touched
        for t in [0.0, 0.2, 1.3] {
            assert_eq!(written("3*t", 0.5).at(t), 3.0 * t);
        }
    }

    #[test]
    fn what_is_not_defined_is_reported_with_its_place() {
        let message = |schedule: &Schedule, times: &[f64]| {
            let at = [Vec3::zeros(), Vec3::new(0.0, 0.0, 0.25)];
            schedule.check(times, &at).expect_err("not defined")
        };
        let refused = |text: &str, times: &[f64]| message(&written(text, 1.0), times);
        assert_eq!(refused("log(t)", &[0.0, 1.0]), "\"log(t)\" is -inf at t = 0 s");
        assert_eq!(
            refused("1/(z - 0.25)", &[0.5]),
            "\"1/(z - 0.25)\" is inf at t = 0.5 s at (0.00000, 0.00000, 0.25000) m"
        );
        assert_eq!(message(&f64::NAN.into(), &[0.0]), "NaN is not finite");
        assert_eq!(refused("1e155*t", &[0.0, 2.0]), "\"1e155*t\" is 2e155 at t = 2 s");
        let table = Schedule::table(&[0.1, 0.5], &[0.0, 1.0]).expect("sound");
        assert!(message(&table, &[0.0, 0.5]).contains("from t = 0.1 to 0.5 s"));
        assert!(table.at(0.6).is_nan(), "never a silent zero");
    }
}
