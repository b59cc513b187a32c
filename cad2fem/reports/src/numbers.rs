//! Numbers that may not be finite: a distance to a surface that is not there, for one.

use std::collections::BTreeMap;

/// Numbers by their names.
pub type Numbers = BTreeMap<String, Option<f64>>;

/// Numbers for a report.
pub fn numbers(found: &BTreeMap<String, f64>) -> Numbers {
    found.iter().map(|(name, value)| (name.clone(), Some(*value))).collect()
}
