//! Numbers so large or small that powers of them leave the range of f64.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Magnitudes of all lengths, moduli, pressures, times and tolerances lie far within; eighth powers
/// are finite and no zero.
const LEAST: f64 = 1e-30;
const MOST: f64 = 1e30;

/// The first number of a file that cannot be computed with, and why.
pub fn refused(table: &DeTable) -> Option<(String, Range<usize>)> {
    table.iter().find_map(|(key, value)| refused_in(key.get_ref(), value))
}

fn refused_in(key: &str, value: &Spanned<DeValue>) -> Option<(String, Range<usize>)> {
    match value.get_ref() {
        DeValue::Float(number) => {
            let size = number.as_str().parse::<f64>().ok()?.abs();
            // what is infinite or no number is for the key to say
            let sound = size == 0.0 || !size.is_finite() || (LEAST..=MOST).contains(&size);
            let what = || {
                let number = number.as_str();
                format!(
                    "{key}: {number}: numbers are 0, or from {LEAST:e} to {MOST:e} in magnitude"
                )
            };
            (!sound).then(|| (what(), value.span()))
        }
        DeValue::Array(list) => list.iter().find_map(|item| refused_in(key, item)),
        DeValue::Table(below) => refused(below),
        _ => None,
    }
}
