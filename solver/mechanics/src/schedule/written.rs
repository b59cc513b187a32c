//! What people write of a value over time. It has no value itself: [`Schedule`]s are made of it.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use mesh::Vec3;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Expression, Field, Malformed, Schedule, Table};

/// What may be written, for messages.
const NEEDED: &str =
    "a number, an expression such as \"20e3*t\", or a table { t = [...], value = [...] }";

/// A number over time, and over the rest position, as it is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Written {
    /// The same at all times.
    Number(f64),
    /// An expression, whose parameters have their values elsewhere.
    Expression(Arc<Expression>),
    /// Linear between values.
    Table(Arc<Table>),
}

impl From<f64> for Written {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

/// An expression.
impl std::str::FromStr for Written {
    type Err = Malformed;

    fn from_str(text: &str) -> Result<Self, Malformed> {
        Expression::open(text).map(|expression| Self::Expression(Arc::new(expression)))
    }
}

impl Written {
    /// Its values with those of the parameters and the end of the first time step, t₁ > 0 [s].
    pub fn schedule(
        &self,
        parameters: &BTreeMap<String, f64>,
        first: f64,
    ) -> Result<Schedule, Malformed> {
        let value = match self {
            Self::Expression(open) => Self::Expression(Arc::new(open.with(parameters)?)),
            Self::Number(_) | Self::Table(_) => self.clone(),
        };
        Ok(Schedule { value, first, still: None })
    }

    /// Adds a constant.
    pub fn add(&mut self, constant: f64) -> Result<(), Malformed> {
        match self {
            Self::Number(value) => *value += constant,
            Self::Expression(expression) => {
                *self = format!("({}) + ({constant:e})", expression.text()).parse()?;
            }
            Self::Table(table) => Arc::make_mut(table).add(constant),
        }
        Ok(())
    }

    /// Whether a parameter occurs in it.
    pub fn uses(&self, parameter: &str) -> bool {
        matches!(self, Self::Expression(expression) if expression.uses(parameter))
    }

    /// The number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Expression(_) | Self::Table(_) => None,
        }
    }

    /// Whether it is the number zero.
    pub fn is_zero(&self) -> bool {
        self.number() == Some(0.0)
    }

    /// Whether it depends on the position.
    pub fn uses_position(&self) -> bool {
        matches!(self, Self::Expression(expression) if expression.uses_position())
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Expression(expression) => write!(f, "\"{}\"", expression.text()),
            Self::Table(_) => f.write_str("the table"),
        }
    }
}

impl Serialize for Written {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Expression(expression) => serializer.serialize_str(expression.text()),
            Self::Table(table) => table.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Written;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(NEEDED)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Written, E> {
        Ok(Written::Number(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Written, E> {
        Ok(Written::Number(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Written, E> {
        Ok(Written::Number(value as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Written, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Written, A::Error> {
        let table = Table::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Written::Table(Arc::new(table)))
    }
}

/// A vector over time and the rest position, as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct WrittenField(pub [Written; 3]);

impl From<[f64; 3]> for WrittenField {
    fn from(values: [f64; 3]) -> Self {
        Self(values.map(Written::from))
    }
}

impl From<Vec3> for WrittenField {
    fn from(values: Vec3) -> Self {
        <[f64; 3]>::from(values).into()
    }
}

impl Default for WrittenField {
    fn default() -> Self {
        [0.0; 3].into()
    }
}

impl WrittenField {
    /// Its values with those of the parameters and the end of the first time step, t₁ > 0 [s].
    pub fn field(
        &self,
        parameters: &BTreeMap<String, f64>,
        first: f64,
    ) -> Result<Field, Malformed> {
        let [x, y, z] = self.0.each_ref().map(|written| written.schedule(parameters, first));
        Ok(Field([x?, y?, z?]))
    }

    /// Whether all components are the number zero.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(Written::is_zero)
    }
}
