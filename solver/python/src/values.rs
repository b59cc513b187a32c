//! Values of Python as settings have them.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyMapping, PySequence, PyString};
use toml::{Table, Value};

use crate::error::refused_as;

/// Lists and tables in each other, at most: one that is in itself has no end.
const DEEPEST: usize = 32;

/// A table of numbers, texts, lists and tables; NumPy's are among them, and paths are texts.
pub fn table(given: &Bound<'_, PyMapping>) -> PyResult<Table> {
    table_at(&mut Vec::new(), given)
}

/// The table to which these keys lead.
fn table_at(at: &mut Vec<String>, given: &Bound<'_, PyMapping>) -> PyResult<Table> {
    let mut table = Table::new();
    for entry in given.items()? {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = entry.extract()?;
        let key = key.str()?.to_cow()?.into_owned();
        table.insert(key.clone(), below(at, key, &value)?);
    }
    Ok(table)
}

/// The value below a key, or the number of an item.
fn below(at: &mut Vec<String>, key: String, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    at.push(key);
    let value = value_at(at, given)?;
    at.pop();
    Ok(value)
}

fn value_at(at: &mut Vec<String>, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    let wrong = |at: &[String], why: &str| {
        let shown = given.repr().map(|shown| shown.to_string()).unwrap_or_default();
        refused_as(format!("{}: {shown}: {why}", at.join(" ")))
    };
    if at.len() > DEEPEST {
        return Err(refused_as(format!("{}: {DEEPEST} lists and tables in each other", at[0])));
    }
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(Value::String(text.to_cow()?.into_owned()));
    }
    if let Ok(flag) = given.cast::<PyBool>() {
        return Ok(Value::Boolean(flag.is_true()));
    }
    if given.is_instance_of::<PyInt>()
        && let Ok(number) = given.extract()
    {
        return Ok(Value::Integer(number));
    }
    if given.is_instance_of::<PyInt>() || given.is_instance_of::<PyFloat>() {
        let number = given.extract().ok().filter(|number: &f64| number.is_finite());
        return number.map(Value::Float).ok_or_else(|| wrong(at, "must be finite"));
    }
    if let Ok(table) = given.cast::<PyMapping>() {
        return Ok(Value::Table(table_at(at, table)?));
    }
    if let Ok(list) = given.cast::<PySequence>() {
        let items = (1..).zip(list.try_iter()?);
        let items = items.map(|(number, item): (usize, _)| below(at, number.to_string(), &item?));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    // arrays and numbers of NumPy, and paths
    for method in ["tolist", "__fspath__"] {
        if let Ok(plain) = given.call_method0(method) {
            return value_at(at, &plain);
        }
    }
    Err(wrong(at, "a scene has numbers, texts, lists and tables"))
}
