//! The keys of a table with what they mean, from its type: names and order are what serde reads,
//! meanings the documentation of the fields.

use schemars::{JsonSchema, SchemaGenerator};
use serde::de::value::Error;
use serde::de::{DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;
use toml::Table;

use crate::{Misfit, read_table};

/// A key with what it means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// The name.
    pub name: &'static str,
    /// What it means, with its default.
    pub meaning: String,
}

/// The names of a table's keys, in the order of its type.
pub fn key_names<T: DeserializeOwned>() -> &'static [&'static str] {
    let mut names: &[&str] = &[];
    // ends with an error as soon as the type has said its names
    drop(T::deserialize(Names(&mut names)));
    names
}

/// The keys of a table, in the order of its type.
pub fn keys_of<T: DeserializeOwned + JsonSchema>() -> Vec<Key> {
    let schema = T::json_schema(&mut SchemaGenerator::default()).to_value();
    let key = |&name: &&'static str| {
        let about = &schema["properties"][name];
        let meaning = about["description"].as_str().unwrap_or_default().replace('\n', " ");
        let default = about.get("default").map(|default| format!(" ({default})"));
        Key { name, meaning: meaning + &default.unwrap_or_default() }
    };
    key_names::<T>().iter().map(key).collect()
}

/// Takes the keys of a `T` out of a table, and reads them.
pub fn take_keys<T: DeserializeOwned>(table: &mut Table) -> Result<T, Misfit> {
    let names = key_names::<T>();
    let all = std::mem::take(table).into_iter();
    let (own, others): (Table, Table) = all.partition(|(key, _)| names.contains(&key.as_str()));
    *table = others;
    read_table(&own)
}

/// Asks a type for the names of its fields.
struct Names<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Names<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("names only"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        *self.0 = fields;
        self.deserialize_any(visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize, JsonSchema)]
    #[expect(dead_code, reason = "described, never built")]
    struct Table {
        /// What it is
        /// about.
        on: String,
        /// How far [m].
        away: Option<f64>,
    }

    #[test]
    fn keys_are_in_the_order_of_the_type() {
        let found: Vec<_> = keys_of::<Table>().into_iter().map(|k| (k.name, k.meaning)).collect();
        let wanted = [("on", "What it is about."), ("away", "How far [m].")];
        assert_eq!(found, wanted.map(|(name, meaning)| (name, meaning.to_owned())));
    }
}
