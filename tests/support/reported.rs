//! What the programs report is what their schemas say.

use std::sync::LazyLock;

use jsonschema::Validator;
use program::schema::Format;
use reports::{Iteration, Optimization, Simulation};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

static SIMULATION: LazyLock<Validator> = LazyLock::new(|| schema("report"));
static OPTIMIZATION: LazyLock<Validator> = LazyLock::new(|| schema("optimization"));
static ITERATION: LazyLock<Validator> = LazyLock::new(|| schema("history"));

/// The schema that `solver schema NAME` prints.
fn schema(name: &str) -> Validator {
    let named = |format: &&Format| format.name == name;
    let format = solver::cmd::schema::FORMATS.iter().find(named).expect("it is there");
    jsonschema::validator_for(&(format.schema)()).expect("a sound schema")
}

/// Asserts that the report of a simulation has what its schema says, and that who reads it as its type
/// loses nothing.
///
/// # Panics
/// When it has another key, or one of another type.
pub fn check_simulation(report: &Value) {
    check::<Simulation>(&SIMULATION, report);
}

/// Asserts as [`check_simulation`] for the report of an optimisation.
///
/// # Panics
/// When it has another key, or one of another type.
pub fn check_optimization(report: &Value) {
    check::<Optimization>(&OPTIMIZATION, report);
}

/// Asserts as [`check_simulation`] for a line of a history.
///
/// # Panics
/// When it has another key, or one of another type.
pub fn check_iteration(line: &Value) {
    check::<Iteration>(&ITERATION, line);
}

fn check<T: DeserializeOwned + Serialize>(schema: &Validator, report: &Value) {
    let found: Vec<String> =
        schema.iter_errors(report).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(found.is_empty(), "{found:#?}");
    let read: T = serde_json::from_value(report.clone()).expect("its type");
    let again = serde_json::to_value(read).expect("its type");
    assert_eq!(&again, report);
}
