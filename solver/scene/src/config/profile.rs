//! Numbers that may change along an axis.

use std::fmt;

use anyhow::{Context, Result, ensure};
use mechanics::energy::{Axis, Profile};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::line::AroundConfig;

/// A number, or one that changes along an axis.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Along {
    /// The number has one value everywhere.
    Number(f64),
    /// A spline of the height.
    Profile(ProfileConfig),
}

/// A number that changes along an axis: a B-spline of the height, which begins at the first of its values, ends at the
/// last, and lies between the smallest and the largest. Beyond both ends it is constant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileConfig {
    /// Control values, from 2 to 64, at equal steps of the spline between both ends.
    pub values: Vec<f64>,
    /// Height of the first, along the axis from its point [m].
    pub start: f64,
    /// Height of the last [m].
    pub end: f64,
    /// The axis, where the table around has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<AroundConfig>,
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
        self.check(key)?;
        let below = |name: &str| key.clone().key(name);
        let axis = match (around, &self.line) {
            (Some(axis), None) => axis,
            (None, Some(line)) => line.line_at(&below("line"))?,
            (Some(_), Some(_)) => {
                return Err(
                    misfit!(below("line"), " beside around: heights are along that axis").into()
                );
            }
            (None, None) => {
                return Err(misfit!(
                    key.clone(),
                    " has no axis: add line = {{ point = [0, 0, 0], axis = [0, 0, 1] }}, along which start and end are \
                     heights"
                )
                .into());
            }
        };
        let Self { values, start, end, .. } = self;
        let profile = Profile::new(axis, [*start, *end], values.clone());
        profile.context("a profile that was checked")
    }

    /// Whether its numbers are admissible.
    fn check(&self, key: &KeyPath) -> Result<()> {
        let below = |name: &str| key.clone().key(name);
        let Self { values, start, end, .. } = self;
        let count = values.len();
        ensure!(
            count >= 2,
            misfit!(
                below("values"),
                " = {values:?}: expected two values or more; one alone is written as a number, without a table"
            )
        );
        ensure!(
            count <= Profile::MOST_VALUES,
            misfit!(
                below("values"),
                ": {count} values; expected {} or fewer",
                Profile::MOST_VALUES
            )
        );
        ensure!(
            values.iter().all(|value| value.is_finite()),
            misfit!(below("values"), " = {values:?}: all must be finite")
        );
        ensure!(
            start.is_finite() && end.is_finite() && start < end,
            misfit!(
                below("end"),
                " = {end} m, with start = {start} m: expected finite heights, the end above the start"
            )
        );
        Ok(())
    }
}

/// By hand, so that a table that does not fit says which of its keys does not.
impl<'de> Deserialize<'de> for Along {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Along;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("a number, or a table { values = [1, 2], start = 0.0, end = 0.08 }")
            }
            fn visit_f64<E>(self, number: f64) -> Result<Along, E> {
                Ok(Along::Number(number))
            }
            fn visit_i64<E>(self, number: i64) -> Result<Along, E> {
                Ok(Along::Number(number as f64))
            }
            fn visit_u64<E>(self, number: u64) -> Result<Along, E> {
                Ok(Along::Number(number as f64))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Along, A::Error> {
                ProfileConfig::deserialize(MapAccessDeserializer::new(map)).map(Along::Profile)
            }
        }
        deserializer.deserialize_any(Either)
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

    #[test]
    fn what_is_neither_says_what_was_expected() {
        for (value, words) in [
            ("\"stiff\"", &["invalid type: string \"stiff\"", "a number, or a table { values"][..]),
            ("[1, 2]", &["invalid type: sequence", "a number, or a table { values"]),
            ("{ values = [1, 2], start = 0 }", &["missing field `end`"]),
            ("{ values = [1, 2], from = 0 }", &["unknown field `from`", "`values`", "`line`"]),
            ("{ values = 3, start = 0, end = 1 }", &["invalid type: integer `3`"]),
        ] {
            let error = read(value).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
    }

    #[test]
    fn what_is_no_profile_is_refused_with_its_numbers() {
        let line = "line = { point = [0, 0, 0], axis = [0, 0, 1] }";
        let many = format!("{:?}", vec![1.0; 65]);
        for (values, ends, more, around, words) in [
            ("[1]", "start = 0, end = 1", "", true, &["k1: values = [1.0]", "without a table"][..]),
            (&*many, "start = 0, end = 1", "", true, &["65 values", "64 or fewer"]),
            ("[1, inf]", "start = 0, end = 1", "", true, &["inf", "finite"]),
            ("[1, 2]", "start = 0.1, end = 0", "", true, &["end = 0 m, with start = 0.1 m"]),
            ("[1, 2]", "start = 0, end = nan", "", true, &["end = NaN m"]),
            ("[1, 2]", "start = 0, end = 1", line, true, &["line beside around"]),
            ("[1, 2]", "start = 0, end = 1", "", false, &["no axis", "line = {"]),
        ] {
            let comma = if more.is_empty() { "" } else { ", " };
            let value = read(&format!("{{ values = {values}, {ends}{comma}{more} }}")).unwrap();
            let built = value.profile().unwrap().build(&KeyPath::of("k1"), around.then(axis));
            let error = built.unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
    }
}
