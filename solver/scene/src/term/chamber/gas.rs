//! Gas laws as people write them: keys of `[[chamber]]`.
//!
//! All of it follows from the rows of [`GAS_LAWS`].

use measure::written::ScheduleSchema;
use mechanics::energy::GasLaw;
use mechanics::energy::gas_law::{GAS_LAWS, Key, Least, Row};
use mechanics::schedule::{Schedule, Written};
use program::schema::one_of;
use program::table::Range;
use program::{KeyPath, Misfit, misfit, read_key};
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Value as Json, json};
use toml::{Table, Value};

use crate::law_table;

/// The gas of a chamber as it is written: a row of [`GAS_LAWS`], with its numbers.
#[derive(Clone, Debug)]
pub struct GasConfig {
    row: &'static Row,
    /// The key that selects the law.
    selecting: &'static Key,
    /// Its value: the one number that the gas follows over time.
    pub value: Written,
    /// Those of the other keys, in their order.
    numbers: Vec<f64>,
}

impl GasConfig {
    /// The law that the keys of a `[[chamber]]` select, `on` left out.
    pub fn read(keys: &Table) -> Result<Self, Misfit> {
        let (row, selecting) = select(keys)?;
        let missing = |key: &Key| {
            KeyPath::default().told(format!("missing field `{}` [{}]", key.name, key.unit))
        };
        let value: Option<Written> = read_key(keys, selecting.name).map_err(|what| {
            let value = keys.get(selecting.name).map_or_else(String::new, Value::to_string);
            what.titled(format!("{} = {value}", selecting.name))
        })?;
        let value = value.ok_or_else(|| missing(selecting))?;
        let number = |key: &Key| match (keys.get(key.name), key.default) {
            (Some(value), _) => number(key, value),
            (None, default) => default.ok_or_else(|| missing(key)),
        };
        let numbers = others(row).map(number).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { row, selecting, value, numbers })
    }

    /// The key that selects the law.
    pub fn key(&self) -> &'static str {
        self.selecting.name
    }

    /// Unit of the number that it follows over time.
    pub fn unit(&self) -> &'static str {
        self.selecting.unit
    }

    /// The pressure, where the law prescribes it [Pa].
    pub fn pressure(&self) -> Option<&Written> {
        (self.key() == "pressure").then_some(&self.value)
    }

    /// Whether the number that it follows is a pressure.
    pub fn is_pressure(&self) -> bool {
        matches!(self.key(), "pressure" | "fill")
    }

    /// The law with the values of the number that it follows.
    pub fn law(&self, schedule: Schedule) -> Box<dyn GasLaw> {
        (self.row.build)(self.selecting.name, schedule, &self.numbers)
    }

    /// The keys, as [`Self::read`] takes them.
    pub fn written(&self) -> Table {
        let value = Value::try_from(&self.value).expect("a number, a text or lists of numbers");
        let numbers = self.numbers.iter().map(|number| Value::Float(*number));
        let names = others(self.row).map(|key| key.name.to_owned());
        let mut table: Table = names.zip(numbers).collect();
        table.insert(self.selecting.name.to_owned(), value);
        table
    }
}

/// The keys of a law that do not select it.
fn others(row: &'static Row) -> impl Iterator<Item = &'static Key> {
    row.keys.iter().filter(|key| !key.selects)
}

/// The row that keys select, with the key that selects it.
fn select(keys: &Table) -> Result<(&'static Row, &'static Key), Misfit> {
    let all = || GAS_LAWS.iter().flat_map(|row| row.keys.iter().map(move |key| (row, key)));
    let known = |name: &String| all().any(|(_, key)| key.name == *name);
    if let Some(unknown) = keys.keys().find(|name| !known(name)) {
        let known: Vec<&str> =
            ["name", "on", "plug"].into_iter().chain(all().map(|(_, key)| key.name)).collect();
        return Err(KeyPath::word(unknown).unknown("field", unknown, &known));
    }
    let selecting: Vec<_> = all().filter(|(_, key)| key.selects).collect();
    let found: Vec<_> =
        selecting.iter().copied().filter(|(_, key)| keys.contains_key(key.name)).collect();
    let [(law, one)] = found[..] else {
        let needed = selecting.iter().map(|(_, key)| format!("{} [{}]", key.name, key.unit));
        let found: Vec<&str> = found.iter().map(|(_, key)| key.name).collect();
        return Err(KeyPath::default().told(format!(
            "expected exactly one of {}; found {}",
            needed.collect::<Vec<_>>().join(", "),
            if found.is_empty() { "none".to_owned() } else { found.join(" and ") }
        )));
    };
    let own = |name: &String| law.keys.iter().any(|key| key.name == *name);
    let Some(other) = keys.keys().find(|name| !own(name)) else { return Ok((law, one)) };
    let names: Vec<&str> = law.keys.iter().map(|key| key.name).collect();
    Err(misfit!(
        KeyPath::of(other),
        " cannot be combined with {}; the {} law has {}",
        one.name,
        law.name,
        names.join(", ")
    ))
}

fn number(key: &Key, value: &Value) -> Result<f64, Misfit> {
    let at = KeyPath::of(key.name);
    let Some(number) = law_table::number(value) else {
        return Err(misfit!(at, " = {value}: expected a number [{}]", key.unit));
    };
    let range = match key.least {
        Least::Above(least) => Range::above(least),
        Least::From(least) => Range::at_least(least),
    };
    let unit = if key.unit == "1" { "" } else { key.unit };
    range.unit(unit).admit(&at, number).map(|()| number)
}

/// `[[chamber]]` of one of the laws, without `on`.
pub fn schema(generator: &mut SchemaGenerator) -> Schema {
    let schedule = generator.subschema_for::<ScheduleSchema>().to_value();
    let forms = GAS_LAWS.iter().flat_map(|law| {
        let schedule = &schedule;
        law.keys.iter().filter(|key| key.selects).map(move |key| form(law, key, schedule))
    });
    one_of(forms)
}

/// One law by one of the keys that select it.
fn form(law: &Row, selecting: &Key, schedule: &Json) -> Schema {
    let own = || law.keys.iter().filter(|key| !key.selects || key.name == selecting.name);
    let property = |key: &Key| {
        let mut value = if key.selects { schedule.clone() } else { json!({ "type": "number" }) };
        value["description"] = format!("{} [{}].", key.meaning, key.unit).into();
        if let Some(default) = key.default {
            value["default"] = default.into();
        }
        (key.name.to_owned(), value)
    };
    let properties: serde_json::Map<String, Json> = own().map(property).collect();
    let needed = own().filter(|key| key.default.is_none());
    let required: Vec<&str> = needed.map(|key| key.name).collect();
    json_schema!({
        "type": "object",
        "title": law.name,
        "description": format!("{}. Source: {}.", law.formula, law.source),
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What may be written is what is listed, and is written again as it was read.
    #[test]
    fn every_law_is_read_by_its_keys() {
        for text in [
            "pressure = 55e3",
            "fill = \"2e4*t\"\nambient = 101.3e3\nexponent = 1.4",
            "volume_change = { t = [0, 1], value = [0, 2e-6] }",
            "volume_factor = 1.5",
            "injected = \"2e-6*t\"\ncompliance = 1e-11",
            "supply = 60e3\nresistance = 1e9\nleak = 1e-12\nambient = 95e3",
            "checked_supply = \"60e3*t\"\nresistance = 1e9\nleak = 0\nambient = 95e3",
        ] {
            let table: toml::Table = toml::from_str(text).expect("TOML");
            let gas = GasConfig::read(&table).expect(text);
            let written = gas.written();
            let again = GasConfig::read(&written).expect("as it was written");
            assert_eq!((again.written(), again.value), (written.clone(), gas.value));
            assert!(written.keys().eq(table.keys()), "{written:?}");
        }
    }

    #[test]
    fn exactly_one_key_selects_the_law() {
        let all = "pressure [Pa], fill [Pa], volume_change [m³], \
                   volume_factor [1], injected [m³], supply [Pa], checked_supply [Pa]";
        for (text, words) in [
            ("", &["expected exactly one of", all, "found none"][..]),
            ("ambient = 1e5", &[all, "found none"]),
            ("pressure = 1\nfill = 2", &[all, "found pressure and fill"]),
            ("volume_change = 1\nvolume_factor = 2", &["found volume_change and volume_factor"]),
            (
                "pressure = 1\nexponent = 1.4",
                &["exponent cannot be combined with pressure", "isobaric"],
            ),
            ("fill = 1\nambient = 1e5", &["missing field `exponent`"]),
            ("fill = 1\nambient = 1e5\nexponent = \"a\"", &["exponent", "\"a\""]),
            ("pressure = [1]", &["a number, an expression"]),
            ("injected = 1e-6", &["missing field `compliance`"]),
            ("supply = 1e5", &["missing field `resistance`"]),
            ("pressures = 1", &["unknown field `pressures`", "`pressure`, `fill`"]),
        ] {
            let error =
                GasConfig::read(&toml::from_str(text).expect("TOML")).expect_err(text).to_string();
            assert!(words.iter().all(|w| error.contains(w)), "{text}: {error}");
        }
    }
}
