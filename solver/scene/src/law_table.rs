//! Laws of materials as people write them: a table with `kind` and the parameters of the law.
//!
//! All of it follows from the rows of [`material::LAWS`] and [`sheet::LAWS`].

use anyhow::{Context, Result, bail, ensure};
use mechanics::material::response::Mode;
use mechanics::material::{self, Law, Parameter, Softening, Specification, sheet};
use program::schema::{add_keys, add_kind, add_table, take_keys};
use program::table::{Range, Table as _};
use program::{KeyPath, Misfit, misfit, unknown};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use serde_json::json;
use toml::{Table, Value};

program::table! {
    /// What is known of a material beside its law.
    #[derive(Clone, Debug)]
    struct Beside {
        /// Density [kg/m³].
        density: Option<f64> = None, Range::POSITIVE.unit("kg/m³");
        /// Smallest and largest principal stretch that it was fitted to [1].
        stretch_range: Option<[f64; 2]> = None, around_one;
        /// Modes that it was fitted in.
        modes: Vec<Tested> = Vec::new();
        /// Uniaxial stretch at which it tears: 1 + elongation at break [1].
        stretch_at_break: Option<f64> = None, Range::above(1.0).advice(", 1 + elongation at break");
        /// Part by which strain grows while a load is held [1].
        creep: Option<f64> = None, Range::POSITIVE.advice("; a part such as 0.2");
        /// Part by which stress falls after a first stretch [1].
        mullins: Option<f64> = None, Range::above(0.0).below(1.0);
    }
}

/// A mode of a test.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Tested {
    /// Along one axis.
    Tension,
    /// Along one axis; at constant volume a block is stretched along both others.
    Compression,
    /// Along two axes.
    Biaxial,
    /// Along one axis, while another is held.
    Planar,
}

impl Tested {
    fn mode(self) -> Mode {
        match self {
            Self::Tension => Mode::Uniaxial,
            Self::Compression | Self::Biaxial => Mode::Biaxial,
            Self::Planar => Mode::Planar,
        }
    }
}

fn around_one(at: &KeyPath, range: &Option<[f64; 2]>) -> Result<(), Misfit> {
    match range {
        Some([low, high]) if !(0.0 < *low && (*low..=*high).contains(&1.0) && high.is_finite()) => {
            Err(misfit!(
                at.clone(),
                " = [{low}, {high}]: must be [smallest, largest] principal stretch around 1"
            ))
        }
        _ => Ok(()),
    }
}

/// Reads `kind`, the parameters of a law of a volume, and optionally `density`,
/// `stretch_range`, `modes`, `stretch_at_break`, `creep` and `mullins`.
pub fn volume(table: &Table) -> Result<Specification> {
    let mut parameters = table.clone();
    let law = law(&mut parameters, material::LAWS, "solver list")?;
    let beside: Beside = take_keys(&mut parameters)?;
    beside.check_ranges(&KeyPath::default())?;
    let mut modes: Vec<Mode> = beside.modes.into_iter().map(Tested::mode).collect();
    modes.sort_unstable_by_key(|mode| mode.state());
    modes.dedup();
    Ok(Specification {
        law,
        values: values(law, &parameters)?,
        density: beside.density,
        stretch_range: beside.stretch_range,
        modes,
        stretch_at_break: beside.stretch_at_break,
        softening: Softening { creep: beside.creep, mullins: beside.mullins },
    })
}

/// Reads `kind` and the parameters of a law of a sheet.
pub fn sheet(table: &Table) -> Result<sheet::Specification> {
    let mut parameters = table.clone();
    let law = law(&mut parameters, sheet::LAWS, "solver list --sheets")?;
    Ok(sheet::Specification { law, values: values(law, &parameters)? })
}

/// The numbers of a law of a sheet in its table, in the order of the law.
pub(crate) fn sheet_numbers(table: &mut Value) -> Vec<(Parameter, &mut f64)> {
    let Value::Table(table) = table else { return Vec::new() };
    let kind = table.get("kind").and_then(Value::as_str);
    let Some(law) = sheet::LAWS.iter().find(|law| Some(law.key) == kind) else { return Vec::new() };
    let place = |key: &str| law.parameters.iter().position(|own| own.name == key);
    let mut numbers: Vec<(usize, &mut f64)> = Vec::new();
    for (key, value) in table.iter_mut() {
        if let Value::Integer(whole) = value {
            *value = Value::Float(*whole as f64);
        }
        if let (Some(place), Value::Float(number)) = (place(key), value) {
            numbers.push((place, number));
        }
    }
    numbers.sort_by_key(|(place, _)| *place);
    numbers.into_iter().map(|(place, number)| (law.parameters[place], number)).collect()
}

/// The law of a `kind`.
pub fn find(kind: &str) -> Result<&'static Law> {
    find_in(material::LAWS, kind, "solver list")
}

/// Takes `kind` out of a table of one of the laws that a `command` lists.
fn law<M: ?Sized + 'static>(
    table: &mut Table,
    laws: &'static [Law<M>],
    command: &str,
) -> Result<&'static Law<M>> {
    match table.remove("kind") {
        Some(Value::String(kind)) => find_in(laws, &kind, command),
        Some(other) => {
            bail!(misfit!(KeyPath::of("kind"), " = {other}: expected the name of a law in quotes"))
        }
        None => bail!("no kind; `{command}` names the laws"),
    }
}

fn find_in<M: ?Sized + 'static>(
    laws: &'static [Law<M>],
    kind: &str,
    command: &str,
) -> Result<&'static Law<M>> {
    let found = laws.iter().find(|law| law.key == kind);
    Ok(found.ok_or_else(|| {
        let known: Vec<_> = laws.iter().map(|law| law.key).collect();
        let listed = format!("known are {}\n  `{command}` explains them", known.join(", "));
        let before = format!("unknown kind \"{kind}\"");
        KeyPath::of("kind").told(unknown(&before, kind, known, ';', &listed))
    })?)
}

/// Reads the parameters of a law from a table, which must hold nothing else.
pub fn values<M: ?Sized + 'static>(law: &Law<M>, table: &Table) -> Result<Vec<f64>> {
    let is_known = |name: &String| law.parameters.iter().any(|p| p.name == *name);
    if let Some(name) = table.keys().find(|name| !is_known(name)) {
        let before = format!("{}: unknown parameter \"{name}\"", law.key);
        let (known, listed) = (law.parameters.iter().map(|p| p.name), needs(law));
        let what = unknown(&before, name, known, ';', &format!("expected {listed}"));
        bail!(KeyPath::of(name).told(what));
    }
    let mut values = Vec::new();
    let mut terms = None;
    for parameter in law.parameters {
        let value = table.get(parameter.name).with_context(|| {
            format!("{}: no \"{}\"; expected {}", law.key, parameter.name, needs(law))
        })?;
        let numbers = numbers(parameter, value).with_context(|| law.key.to_owned())?;
        if parameter.list {
            let (first, length) = *terms.get_or_insert((parameter.name, numbers.len()));
            ensure!(
                numbers.len() == length,
                "{}: {first} has {length} numbers, {} has {}; one of each per term is needed",
                law.key,
                parameter.name,
                numbers.len()
            );
        }
        values.extend(numbers);
    }
    law.check(&values)?;
    Ok(values)
}

/// Names and units of the parameters of a law.
fn needs<M: ?Sized>(law: &Law<M>) -> String {
    let one =
        |p: &Parameter| format!("{}{} [{}]", p.name, if p.list { " (a list)" } else { "" }, p.unit);
    law.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn numbers(parameter: &Parameter, value: &Value) -> Result<Vec<f64>> {
    let Parameter { name, unit, list, .. } = parameter;
    let items = match (list, value) {
        (true, Value::Array(items)) if !items.is_empty() => items.as_slice(),
        (true, _) => {
            bail!(misfit!(KeyPath::of(name), " = {value}: expected a list of numbers [{unit}]"))
        }
        (false, _) => std::slice::from_ref(value),
    };
    let one = |item: &Value| {
        let number = number(item)
            .ok_or_else(|| misfit!(KeyPath::of(name), " = {item}: expected a number [{unit}]"))?;
        ensure!(
            number.is_finite(),
            misfit!(KeyPath::of(name), " = {number} [{unit}]: must be finite")
        );
        Ok(number)
    };
    items.iter().map(one).collect()
}

/// The table that [`values`] reads.
///
/// # Panics
/// As [`Law::named`].
pub fn written<M: ?Sized + 'static>(law: &Law<M>, numbers: &[f64]) -> Table {
    let value = |(p, values): (&Parameter, Vec<f64>)| {
        let mut items: Vec<_> = values.into_iter().map(Value::Float).collect();
        let value = if p.list { Value::Array(items) } else { items.remove(0) };
        (p.name.to_owned(), value)
    };
    law.named(numbers).into_iter().map(value).collect()
}

/// The tables that [`volume`] reads, one for each law.
pub fn volume_schemas(generator: &mut SchemaGenerator) -> Vec<Schema> {
    let one = |law: &Law| {
        let mut schema = schema(law);
        add_table::<Beside>(&mut schema, generator);
        schema
    };
    material::LAWS.iter().map(one).collect()
}

/// The table of `kind` and the parameters of a law.
pub fn schema<M: ?Sized>(law: &Law<M>) -> Schema {
    let limits = if law.limits.is_empty() { "" } else { ". Limits: " };
    let about = format!(
        "{}. Shear modulus at rest {}, bulk modulus {}{limits}{}. Source: {}.",
        law.formula, law.shear, law.bulk, law.limits, law.source
    );
    let mut schema = schemars::json_schema!({ "type": "object", "additionalProperties": false });
    add_kind(&mut schema, law.key, &about);
    for parameter in law.parameters {
        let mut value = json!({ "type": "number" });
        if parameter.list {
            value = json!({ "type": "array", "items": value, "minItems": 1 });
        }
        value["description"] = format!("{} [{}]", parameter.meaning, parameter.unit).into();
        add_keys(&mut schema, &[(parameter.name, value, true)]);
    }
    schema
}

/// A number as TOML has it, with or without a decimal point.
pub(crate) fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

#[cfg(test)]
mod tests {
    use mechanics::material::Moduli;

    use super::*;

    fn read(text: &str) -> Result<Specification> {
        volume(&toml::from_str(text).expect("TOML"))
    }

    fn message(text: &str) -> String {
        format!("{:#}", read(text).err().expect("must be refused"))
    }

    #[test]
    fn the_table_of_the_pipelines_is_read() {
        let material = read("kind = 'mooney-rivlin'\nc1 = 55e3\nc2 = 5000\nc3 = 1.7e3\nd1 = 1e6")
            .expect("as in pipelines/frog/sim.toml");
        assert_eq!(material.values, [55e3, 5e3, 1.7e3, 1e6]);
        assert_eq!(material.moduli(), Moduli { shear: 120e3, bulk: 2e6 });
        assert!((material.moduli().poisson() - 0.470_588_235).abs() < 1e-9);
        assert_eq!((material.density, material.stretch_range), (None, None));
        assert_eq!(material.stretch_at_break, None);
    }

    #[test]
    fn every_law_is_read_as_it_is_written() {
        for law in material::LAWS {
            let read = values(law, &written(law, law.sample)).expect("the sample is admissible");
            assert_eq!(read, law.sample, "{}", law.key);
        }
    }

    #[test]
    fn optional_keys_are_read() {
        let text = "kind = 'ogden'\nmu = [1e4, -2e3]\nalpha = [2, -3]\nbulk = 1e6\n";
        let optional =
            "density = 1070\nstretch_range = [0.5, 4]\nstretch_at_break = 10\ncreep = 0.25";
        let modes = "modes = ['tension', 'compression', 'biaxial']";
        let material = read(&format!("{text}{optional}\nmullins = 0.1\n{modes}")).expect("ok");
        assert_eq!(material.modes, [Mode::Biaxial, Mode::Uniaxial]);
        let changes: Vec<_> = material.softening.changes().collect();
        assert_eq!(changes, [("creep", 1.0 / 1.25 - 1.0), ("mullins", -0.1)]);
        assert_eq!(material.values, [1e4, -2e3, 2.0, -3.0, 1e6]);
        assert_eq!(material.density, Some(1070.0));
        assert_eq!(
            (material.stretch_range, material.tested()),
            (Some([0.5, 4.0]), Some([0.5, 4.0]))
        );
        // without its thickness, that of a strip at constant volume
        let pulled = read(&format!("{text}stretch_range = [1.0, 4.0]")).expect("ok");
        assert_eq!((pulled.tested(), pulled.modes), (Some([0.5, 4.0]), Vec::new()));
        assert_eq!(material.stretch_at_break, Some(10.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_numbers() {
        let yeoh = "kind = 'yeoh'\nc1 = 1e4\nc2 = 0\nc3 = 0\nbulk = 1e6\n";
        let ogden = "kind = 'ogden'\nbulk = 1e6\n";
        for (text, needed) in [
            ("kind = 'mooney'".to_owned(), "mooney-rivlin-quadratic, neo-hookean, yeoh"),
            ("c1 = 1.0".to_owned(), "no kind"),
            ("kind = 3".to_owned(), "kind = 3"),
            (
                format!("{yeoh}c4 = 1"),
                "unknown parameter \"c4\"; did you mean `c1`? expected c1 [Pa], c2 [Pa]",
            ),
            ("kind = 'neo-hookean'\nyoung = 1e5".to_owned(), "no \"poisson\""),
            ("kind = 'neo-hookean'\nyoung = 1e5\npoisson = 0.5".to_owned(), "inf Pa"),
            ("kind = 'neo-hookean'\nyoung = -1e5\npoisson = 0.3".to_owned(), "-38461.5"),
            (yeoh.replace("c1 = 1e4", "c1 = -1e4"), "shear = 2 c1 = -20000 Pa"),
            (yeoh.replace("c1 = 1e4", "c1 = nan"), "must be finite"),
            (yeoh.replace("c1 = 1e4", "c1 = 'soft'"), "expected a number [Pa]"),
            (format!("{ogden}mu = [1e4]\nalpha = [2, 3]"), "mu has 1 numbers, alpha has 2"),
            (format!("{ogden}mu = 1e4\nalpha = [2]"), "expected a list of numbers [Pa]"),
            (format!("{ogden}mu = []\nalpha = []"), "expected a list"),
            (format!("{ogden}mu = [1e4]\nalpha = [0]"), "alpha of term 1 is 0"),
            (format!("{yeoh}density = -1"), "density = -1"),
            (format!("{yeoh}stretch_range = [2, 1]"), "around 1"),
            (format!("{yeoh}modes = ['torsion']"), "`tension`, `compression`, `biaxial`, `planar`"),
            (format!("{yeoh}modes = 'tension'"), "expected a sequence"),
            (format!("{yeoh}stretch_at_break = 0.9"), "above 1"),
            (format!("{yeoh}creep = -0.2"), "creep = -0.2"),
            (format!("{yeoh}mullins = 1"), "above 0 and below 1"),
        ] {
            let message = message(&text);
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_sheet_is_said_with_numbers() {
        for (text, needed) in [
            ("young = 1e5", "no kind; `solver list --sheets`"),
            ("kind = 'paper'", "known are sheet, neo-hookean"),
            ("kind = 'sheet'\nyoung = 1e5", "no \"poisson\""),
            ("kind = 'sheet'\nyoung = 1e5\npoisson = 1.0", "inf Pa"),
            ("kind = 'sheet'\nyoung = -1e5\npoisson = 0.3", "-38461.5"),
            ("kind = 'neo-hookean'\nmu = 0.0", "shear = mu = 0 Pa"),
            ("kind = 'neo-hookean'\nmu = 1.0\ndensity = 900", "unknown parameter \"density\""),
        ] {
            let table = toml::from_str(text).expect("TOML");
            let message = format!("{:#}", sheet(&table).err().expect("must be refused"));
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
    }
}
