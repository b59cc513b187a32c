//! Numbers so large or small that powers of them leave the range of f64.

use toml::{Table, Value};

use super::key_path::{KeyPath, Misfit, Step};

/// Magnitudes of all lengths, moduli, pressures, times and tolerances lie far within; eighth powers
/// are finite and no zero.
const LEAST: f64 = 1e-30;
const MOST: f64 = 1e30;

/// Refuses the first number of a table that cannot be computed with.
pub fn check(table: &Table) -> Result<(), Misfit> {
    table.iter().try_for_each(|(key, value)| {
        check_value(value).map_err(|misfit| misfit.below(Step::Value(key.clone())))
    })
}

fn check_value(value: &Value) -> Result<(), Misfit> {
    match value {
        Value::Float(number) => {
            let size = number.abs();
            // what is infinite or no number is for the key to say
            match size == 0.0 || !size.is_finite() || (LEAST..=MOST).contains(&size) {
                true => Ok(()),
                false => Err(KeyPath::default().told(format!(
                    "{number:e}: numbers are 0, or from {LEAST:e} to {MOST:e} in magnitude"
                ))),
            }
        }
        Value::Array(list) => (1..).zip(list).try_for_each(|(number, item)| {
            check_value(item).map_err(|misfit| misfit.below(Step::Item(number)))
        }),
        Value::Table(below) => check(below),
        _ => Ok(()),
    }
}
