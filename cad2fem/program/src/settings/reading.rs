//! From tables to types, with errors that carry the keys that lead to what does not fit.

use std::cell::Cell;
use std::fmt::Display;

use serde::de::value::MapAccessDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::{Table, Value};

use super::key_path::{KeyPath, Misfit, Step};
use crate::nearest::unknown;

/// A table as a `T`.
pub fn read_table<T: DeserializeOwned>(table: &Table) -> Result<T, Misfit> {
    T::deserialize(MapAccessDeserializer::new(Entries::of(table)))
}

/// The value of a key as a `T`, if there is one.
pub fn read_key<T: DeserializeOwned>(table: &Table, key: &str) -> Result<Option<T>, Misfit> {
    let read = |value| T::deserialize(Reader(value));
    let found = table.get(key).map(read).transpose();
    found.map_err(|error| error.below(Step::Value(key.to_owned())))
}

thread_local! {
    /// An error on its way through `custom`, which takes texts alone.
    static CARRIED: Cell<Option<Misfit>> = const { Cell::new(None) };
}

impl Misfit {
    /// As an error of serde, in a type that reads itself. Where that is a [`Misfit`], too, the keys are kept.
    pub fn carried<E: Error>(self) -> E {
        let message = self.to_string();
        CARRIED.set(Some(self));
        let error = E::custom(message);
        CARRIED.take();
        error
    }

    fn strange(found: Unexpected, expected: &dyn Expected, what: &str) -> Self {
        let path = match found {
            Unexpected::Str(text) => KeyPath::word(text),
            Unexpected::Signed(number) => KeyPath::word(&number.to_string()),
            Unexpected::Bool(value) => KeyPath::word(&value.to_string()),
            _ => KeyPath::default(),
        };
        path.told(format!("invalid {what}: {found}, expected {expected}"))
    }
}

impl Error for Misfit {
    fn custom<T: Display>(what: T) -> Self {
        CARRIED.take().unwrap_or_else(|| KeyPath::default().told(what))
    }

    fn invalid_type(found: Unexpected, expected: &dyn Expected) -> Self {
        Self::strange(found, expected, "type")
    }

    fn invalid_value(found: Unexpected, expected: &dyn Expected) -> Self {
        Self::strange(found, expected, "value")
    }

    fn unknown_field(field: &str, known: &'static [&'static str]) -> Self {
        KeyPath::word(field).unknown("field", field, known)
    }

    fn unknown_variant(variant: &str, known: &'static [&'static str]) -> Self {
        KeyPath::word(variant).unknown("variant", variant, known)
    }
}

impl KeyPath {
    /// The error that a word is none of those that are known.
    pub fn unknown(self, what: &str, word: &str, known: &[&str]) -> Misfit {
        let before = format!("unknown {what} `{word}`");
        self.told(unknown(&before, word, known.iter().copied(), ',', &expected(known)))
    }
}

/// Words that might have been, as serde lists them.
fn expected(known: &[&str]) -> String {
    let quoted: Vec<String> = known.iter().map(|word| format!("`{word}`")).collect();
    match &quoted[..] {
        [] => "there is none".into(),
        [one] => format!("expected {one}"),
        [one, other] => format!("expected {one} or {other}"),
        _ => format!("expected one of {}", quoted.join(", ")),
    }
}

#[derive(Clone, Copy)]
struct Reader<'a>(&'a Value);

impl<'de> Deserializer<'de> for Reader<'de> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.0 {
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(value) => visitor.visit_bool(*value),
            Value::Datetime(date) => visitor.visit_string(date.to_string()),
            Value::Table(table) => visitor.visit_map(Entries::of(table)),
            Value::Array(list) => {
                let mut items = Items { all: list, next: 0 };
                let found = visitor.visit_seq(&mut items)?;
                match items.next < list.len() {
                    true => Err(Misfit::custom(format!(
                        "invalid length {}, expected {}",
                        list.len(),
                        items.next
                    ))),
                    false => Ok(found),
                }
            }
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.0 {
            Value::String(word) => visitor.visit_enum(word.as_str().into_deserializer()),
            Value::Table(table) if table.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(Entries::of(table)))
            }
            Value::Table(table) => Err(Misfit::custom(format!(
                "{} keys in place of one, {}",
                table.len(),
                expected(variants)
            ))),
            other => {
                let found = other.type_str();
                Err(Misfit::custom(format!("invalid type: {found}, {}", expected(variants))))
            }
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map struct identifier ignored_any
    }
}

struct Items<'a> {
    all: &'a [Value],
    next: usize,
}

impl<'de> SeqAccess<'de> for &mut Items<'de> {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Misfit> {
        let Some(item) = self.all.get(self.next) else { return Ok(None) };
        self.next += 1;
        let found = seed.deserialize(Reader(item));
        found.map(Some).map_err(|error| error.below(Step::Item(self.next)))
    }
}

struct Entries<'a> {
    rest: toml::map::Iter<'a, String, Value>,
    /// The key that was read last, with its value.
    last: Option<(&'a String, &'a Value)>,
}

impl<'a> Entries<'a> {
    fn of(table: &'a Table) -> Self {
        Self { rest: table.iter(), last: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Misfit> {
        self.last = self.rest.next();
        let Some((key, _)) = self.last else { return Ok(None) };
        seed.deserialize(key.as_str().into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        let (key, value) = self.last.ok_or_else(|| Misfit::custom("a value without a key"))?;
        seed.deserialize(Reader(value)).map_err(|error| error.below(Step::Value(key.clone())))
    }
}
