//! Piecewise linear values over time.

use serde::{Deserialize, Serialize};

/// Columns of a table with increasing times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Columns")]
pub struct Table {
    t: Vec<f64>,
    value: Vec<f64>,
}

/// As it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Columns {
    t: Vec<f64>,
    value: Vec<f64>,
}

impl TryFrom<Columns> for Table {
    type Error = String;

    fn try_from(Columns { t, value }: Columns) -> Result<Self, String> {
        Self::new(t, value)
    }
}

impl Table {
    /// Values at increasing times [s].
    pub fn new(t: Vec<f64>, value: Vec<f64>) -> Result<Self, String> {
        if t.len() != value.len() || t.len() < 2 {
            return Err(format!(
                "the table has {} times and {} values; expected one value for each of two or more \
                 times",
                t.len(),
                value.len()
            ));
        }
        if let Some(bad) = t.iter().chain(&value).find(|v| !v.is_finite()) {
            return Err(format!("the table has {bad}; expected finite numbers"));
        }
        if let Some(pair) = t.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(format!("the table's times must increase, not {}, {}", pair[0], pair[1]));
        }
        Ok(Self { t, value })
    }

    /// Adds a constant to all values.
    pub fn add(&mut self, constant: f64) {
        self.value.iter_mut().for_each(|value| *value += constant);
    }

    /// First and last time [s].
    pub fn range(&self) -> (f64, f64) {
        (self.t[0], self.t[self.t.len() - 1])
    }

    /// Whether all times [s] are in its range.
    pub fn check_range(&self, times: &[f64]) -> Result<(), String> {
        let (first, last) = self.range();
        let from = times.iter().copied().fold(f64::INFINITY, f64::min);
        let to = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if first <= from && to <= last {
            return Ok(());
        }
        Err(format!("the table goes from t = {first} to {last} s, expected from {from} to {to} s"))
    }

    /// The value at a time [s]; NaN outside the range.
    pub fn at(&self, time: f64) -> f64 {
        let (first, last) = self.range();
        if !(first..=last).contains(&time) {
            return f64::NAN;
        }
        let after = self.t.partition_point(|&t| t <= time).min(self.t.len() - 1);
        let [(t0, v0), (t1, v1)] = [after - 1, after].map(|i| (self.t[i], self.value[i]));
        v0 + (time - t0) / (t1 - t0) * (v1 - v0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_linear_in_between_and_exact_at_the_rows() {
        let columns = Columns { t: vec![0.0, 0.1, 0.4], value: vec![1.0, 3.0, -3.0] };
        let table = Table::try_from(columns).expect("sound");
        for (t, expected) in [(0.0, 1.0), (0.05, 2.0), (0.1, 3.0), (0.25, 0.0), (0.4, -3.0)] {
            assert!((table.at(t) - expected).abs() < 1e-15, "{t}: {}", table.at(t));
        }
        assert!(table.at(-1e-9).is_nan() && table.at(0.4 + 1e-9).is_nan());
    }
}
