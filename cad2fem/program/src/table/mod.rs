//! A table of a file as rows: each key with its type, default, range and meaning.
//!
//! From the rows of [`table!`](crate::table!) come the struct that is read, its defaults, its checks, its schema,
//! and with that its table in the book. A key without a default is needed.
//!
//! ```text
//! program::table! {
//!     /// A sheet bonded to facets.
//!     #[derive(Clone, Debug)]
//!     pub struct MembraneConfig {
//!         /// Tag of the facets.
//!         on: String;
//!         /// Thickness at rest [m].
//!         thickness: f64, Range::POSITIVE.unit("m").advice("; such as 1e-4 for paper");
//!         /// Whether it wrinkles rather than carry compression.
//!         tension: bool = false;
//!         /// Force per length at which it tears [N/m].
//!         strength: Option<f64> = None => "never", Range::POSITIVE.unit("N/m");
//!         /// The axis of its warp.
//!         around: Option<AroundConfig> = None, nested;
//!     }
//! }
//!
//! membrane.check_ranges(&KeyPath::list("membrane").on(&membrane.on))?;
//! // [[membrane]] on "lid": thickness = -1 m: must be positive and finite; such as 1e-4 for paper
//! ```
//!
//! `=> "words"` describes a default that a value cannot, and stands in the book. What follows the comma is a [`Rule`]:
//! a [`Range`], [`nested`] for a table, [`each`] for a list of tables, [`named`] for values by names, or a function of
//! the key and the value. An
//! enumeration is an `enum` with serde's attributes: its words come from there. Between the meaning and the key may
//! stand one `#[serde(…)]` and then one `#[schemars(…)]` of the field, such as `#[schemars(with = "FieldSchema")]`.
//! Types have to be `Serialize`, as the schema states the defaults; a default that states
//! nothing, such as an empty list, is not written. A table of which each key has a default is `Default`.

mod range;

use std::collections::BTreeMap;

use schemars::Schema;
use serde::Serialize;
use serde_json::{Value, json};

use crate::{KeyPath, Misfit};
pub use range::{Numbers, Range};

/// The keyword of a schema for a default in words.
pub(crate) const DEFAULT_IN_WORDS: &str = "x-default";

/// A table that knows the ranges of its values.
pub trait Table {
    /// Refuses the first value that is out of its range. `at` leads to the table.
    fn check_ranges(&self, at: &KeyPath) -> Result<(), Misfit>;
}

impl<T: Table> Table for Option<T> {
    fn check_ranges(&self, at: &KeyPath) -> Result<(), Misfit> {
        self.as_ref().map_or(Ok(()), |table| table.check_ranges(at))
    }
}

/// What the value of a key may be.
pub trait Rule<T> {
    /// Refuses a value. `at` leads to it.
    fn check(&self, at: &KeyPath, value: &T) -> Result<(), Misfit>;
}

impl<T, F: Fn(&KeyPath, &T) -> Result<(), Misfit>> Rule<T> for F {
    fn check(&self, at: &KeyPath, value: &T) -> Result<(), Misfit> {
        self(at, value)
    }
}

/// The rule of a table in a table: its own ranges.
pub fn nested<T: Table>(at: &KeyPath, table: &T) -> Result<(), Misfit> {
    table.check_ranges(&at.clone().as_table())
}

/// The rule of values by names, such as those of tags: each is below its name.
pub fn named<T>(rule: impl Rule<T>) -> impl Rule<BTreeMap<String, T>> {
    move |at: &KeyPath, values: &BTreeMap<String, T>| {
        values.iter().try_for_each(|(name, value)| rule.check(&at.clone().key(name), value))
    }
}

/// The rule of a list of tables: the ranges of each, which messages call by its title.
pub fn each<T: Table>(title: impl Fn(&T) -> KeyPath) -> impl Rule<Vec<T>> {
    move |_: &KeyPath, tables: &Vec<T>| {
        tables.iter().try_for_each(|table| table.check_ranges(&title(table)))
    }
}

/// The rule of a direction, if there is one: of any length but 0.
pub fn direction(at: &KeyPath, direction: &Option<[f64; 3]>) -> Result<(), Misfit> {
    let Some(components) = direction else { return Ok(()) };
    let length = mesh::Vec3::from(*components).norm();
    match length.is_finite() && length > 1e-9 {
        true => Ok(()),
        false => Err(at
            .clone()
            .says(format!(" = {components:?}: must be a direction with a length above 0"))),
    }
}

/// The name of a key that is a word of Rust, too, such as `r#box`.
#[doc(hidden)]
pub fn plain(key: &str) -> &str {
    key.trim_start_matches("r#")
}

/// Puts into the schema of a table what its type does not say of a key: its default, that in words, or that the key
/// is needed, which has no default.
#[doc(hidden)]
pub fn state(schema: &mut Schema, key: &str, default: Option<Value>, words: &[&str]) {
    let table = schema.ensure_object();
    let Some(default) = default else {
        let needed = table.entry("required").or_insert_with(|| json!([]));
        needed.as_array_mut().into_iter().for_each(|keys| keys.push(key.into()));
        return;
    };
    let Some(key) = table["properties"][plain(key)].as_object_mut() else { return };
    let is_empty = default.as_array().is_some_and(Vec::is_empty);
    if let Some(words) = words.first() {
        key.insert(DEFAULT_IN_WORDS.into(), (*words).into());
    } else if !(default.is_null() || default.is_object() || is_empty) {
        key.insert("default".into(), default);
    }
}

/// A value that is to be written: defaults are, so that a report says them, but not those that state nothing.
#[doc(hidden)]
pub fn unless_nothing<'a, T: Serialize>(value: &'a T, default: &T) -> Option<&'a T> {
    let value_is = stated(value);
    let is_nothing = matches!(&value_is, Some(Value::Null))
        || value_is.as_ref().and_then(Value::as_array).is_some_and(Vec::is_empty);
    (!is_nothing || value_is != stated(default)).then_some(value)
}

/// A default as JSON.
#[doc(hidden)]
pub fn stated<T: Serialize>(default: &T) -> Option<Value> {
    Some(serde_json::to_value(default).unwrap_or_default())
}

/// Defines a table of a file by its rows: [how](mod@crate::table).
#[macro_export]
macro_rules! table {
    (@rows
        $(#[doc = $about:literal])+
        $(#[derive($($derive:path),+)])?
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)+)])?
                $(#[schemars($($schemars:tt)+)])?
                $key:ident: $type:ty $(= $default:expr $(=> $words:literal)?)? $(, $rule:expr)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        $(#[derive($($derive),+)])?
        $vis struct $name {
            $(
                $(#[doc = $doc])+
                pub $key: $type,
            )+
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, output: S) -> Result<S::Ok, S::Error> {
                #[derive(serde::Serialize)]
                struct AsWritten<'a> {
                    $(
                        #[serde(skip_serializing_if = "Option::is_none")]
                        $(#[serde($($serde)+)])?
                        $key: Option<&'a $type>,
                    )+
                }
                let written = AsWritten {
                    $( $key: $crate::table!(@written self.$key, $type $(, $default)?), )+
                };
                written.serialize(output)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
                #[derive(serde::Deserialize)]
                #[serde(deny_unknown_fields, expecting = "a table")]
                struct AsWritten {
                    $(
                        #[serde(default)]
                        $(#[serde($($serde)+)])?
                        $key: Option<$type>,
                    )+
                }
                let written = AsWritten::deserialize(input)?;
                Ok(Self {
                    $( $key: $crate::table!(@value D, written, $key $(, $default)?), )+
                })
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn schema_id() -> std::borrow::Cow<'static, str> {
                concat!(module_path!(), "::", stringify!($name)).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $(#[doc = $about])+
                #[derive(schemars::JsonSchema)]
                #[schemars(deny_unknown_fields)]
                #[expect(dead_code, reason = "described, never built")]
                struct Described {
                    $(
                        $(#[doc = $doc])+
                        $(#[serde($($serde)+)])?
                        $(#[schemars($($schemars)+)])?
                        $key: $type,
                    )+
                }
                let mut schema = Described::json_schema(generator);
                schema.remove("required");
                $(
                    let default = $crate::table!(@stated $type $(, $default)?);
                    $crate::table::state(&mut schema, stringify!($key), default, &[$($($words)?)?]);
                )+
                schema
            }
        }

        impl $crate::table::Table for $name {
            fn check_ranges(&self, at: &$crate::KeyPath) -> Result<(), $crate::Misfit> {
                $($(
                    let key = at.clone().key($crate::table::plain(stringify!($key)));
                    $crate::table::Rule::<$type>::check(&$rule, &key, &self.$key)?;
                )?)+
                Ok(())
            }
        }
    };
    (@value $input:ident, $written:ident, $key:ident) => {
        match $written.$key {
            Some(value) => value,
            None => {
                let missing = <$input::Error as serde::de::Error>::missing_field;
                return Err(missing(stringify!($key)));
            }
        }
    };
    (@value $input:ident, $written:ident, $key:ident, $default:expr) => {
        $written.$key.unwrap_or_else(|| $default)
    };
    (@written $value:expr, $type:ty) => { Some(&$value) };
    (@written $value:expr, $type:ty, $default:expr) => {
        $crate::table::unless_nothing::<$type>(&$value, &$default)
    };
    (@stated $type:ty) => { None };
    (@stated $type:ty, $default:expr) => { $crate::table::stated::<$type>(&$default) };
    // a table of which each key has a default has one, too
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derive:path),+)])?
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)+)])?
                $(#[schemars($($schemars:tt)+)])?
                $key:ident: $type:ty = $default:expr $(=> $words:literal)? $(, $rule:expr)?;
            )+
        }
    ) => {
        $crate::table! {
            @rows
            $(#[doc = $about])+
            $(#[derive($($derive),+)])?
            $vis struct $name {
                $(
                    $(#[doc = $doc])+
                    $(#[serde($($serde)+)])?
                    $(#[schemars($($schemars)+)])?
                    $key: $type = $default $(=> $words)? $(, $rule)?;
                )+
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $key: $default, )+ }
            }
        }
    };
    ($($table:tt)+) => {
        $crate::table! { @rows $($table)+ }
    };
}

#[cfg(test)]
mod tests;
