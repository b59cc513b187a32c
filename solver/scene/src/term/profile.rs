//! Numbers that may change along an axis.

use anyhow::{Context, Result, bail, ensure};
use mechanics::energy::{Axis, Profile};
use program::table::{Numbers, Range, Table, nested};
use program::{KeyPath, Misfit, misfit, read_table};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use toml::Value;

use super::line::AroundConfig;
use crate::law_table::number;

/// A number, or one that changes along an axis.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Along {
    /// The number has one value everywhere.
    Number(f64),
    /// A spline of the height.
    Profile(ProfileConfig),
}

program::table! {
    /// A number that changes along an axis: a B-spline of the height, which begins at the first of its values, ends at the
    /// last, and lies between the smallest and the largest. Beyond both ends it is constant.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ProfileConfig {
        /// Control values, from 2 to 64, at equal steps of the spline between both ends.
        values: Vec<f64>, Range::FINITE;
        /// Height of the first, along the axis from its point [m].
        start: f64, Range::FINITE.unit("m");
        /// Height of the last [m].
        end: f64, Range::FINITE.unit("m");
        /// The axis, where the table around has none.
        line: Option<AroundConfig> = None, nested;
    }
}

impl Numbers for Along {
    fn numbers(&self) -> Vec<f64> {
        self.values().to_vec()
    }
}

impl From<f64> for Along {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Along {
    /// The one value, or the control values.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Number(number) => std::slice::from_ref(number),
            Self::Profile(profile) => &profile.values,
        }
    }

    /// The same, to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        match self {
            Self::Number(number) => std::slice::from_mut(number),
            Self::Profile(profile) => &mut profile.values,
        }
    }

    /// The table, if it is none for all.
    pub fn profile(&self) -> Option<&ProfileConfig> {
        match self {
            Self::Number(_) => None,
            Self::Profile(profile) => Some(profile),
        }
    }

    /// What reports and messages call it: the number, or the smallest to the largest, each as `written`.
    pub fn in_words(&self, written: impl Fn(f64) -> String) -> String {
        let Self::Profile(profile) = self else { return written(self.values()[0]) };
        let least = profile.values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = profile.values.iter().copied().fold(-f64::INFINITY, f64::max);
        format!("{} to {}", written(least), written(most))
    }
}

impl ProfileConfig {
    /// The profile at a key, in the unit of the file, along the axis of the table around it, or along its own line.
    pub fn build(&self, key: &KeyPath, around: Option<Axis>) -> Result<Profile> {
        let below = |name: &str| key.clone().key(name);
        let Self { values, start, end, .. } = self;
        self.check_ranges(key)?;
        ensure!(
            (2..=Profile::MOST_VALUES).contains(&values.len()),
            misfit!(
                below("values"),
                ": {} values; expected 2 to {}, as one alone is written as a number, without a table",
                values.len(),
                Profile::MOST_VALUES
            )
        );
        ensure!(
            start < end,
            misfit!(
                below("end"),
                " = {end} m, with start = {start} m: expected the end above the start"
            )
        );
        let axis = match (around, &self.line) {
            (Some(axis), None) => axis,
            (None, Some(line)) => line.line(),
            (Some(_), Some(_)) => {
                return Err(
                    misfit!(below("line"), " beside around: heights are along that axis").into()
                );
            }
            (None, None) => {
                bail!(misfit!(
                    key.clone(),
                    " has no axis: add line = {{ point = [0, 0, 0], axis = [0, 0, 1] }}, along which start and end are \
                     heights"
                ));
            }
        };
        let profile = Profile::new(axis, [*start, *end], values.clone());
        profile.context("a profile that was checked")
    }
}

/// By hand, so that a table that does not fit says which of its keys does not.
impl<'de> Deserialize<'de> for Along {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::Table(table) => read_table(&table).map(Self::Profile).map_err(Misfit::carried),
            other => number(&other).map(Self::Number).ok_or_else(|| {
                D::Error::custom(format!(
                    "invalid type: {other}, expected a number, or a table {{ values = [1, 2], start = 0.0, end = 0.08 }}"
                ))
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;

    #[derive(Debug, Deserialize, Serialize)]
    struct File {
        k1: Along,
    }

    fn read(value: &str) -> Result<Along, toml::de::Error> {
        toml::from_str::<File>(&format!("k1 = {value}")).map(|file| file.k1)
    }

    fn axis() -> Axis {
        Axis { point: Vec3::zeros(), along: Vec3::z() }
    }

    #[test]
    fn numbers_and_tables_are_read_and_written() {
        assert_eq!(read("2e5").unwrap(), Along::Number(2e5));
        assert_eq!(read("0").unwrap(), Along::Number(0.0));
        let file = File { k1: read("{ values = [1, 2.5, 4], start = 0, end = 0.08 }").unwrap() };
        assert_eq!(file.k1.values(), [1.0, 2.5, 4.0]);
        assert_eq!(file.k1.in_words(|value| value.to_string()), "1 to 4");
        let again: File = toml::from_str(&toml::to_string(&file).unwrap()).unwrap();
        assert_eq!(again.k1, file.k1);
        let profile = file.k1.profile().unwrap().build(&KeyPath::of("k1"), Some(axis())).unwrap();
        assert_eq!((profile.value(-1.0), profile.value(0.04), profile.value(0.1)), (1.0, 2.5, 4.0));
    }
}
