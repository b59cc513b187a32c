//! What the programs report is what their schemas say.

use std::sync::LazyLock;

use fab::files::report::MoldReport;
use jsonschema::Validator;
use program::schema::Format;
use reports::{Iteration, Optimization, Simulation};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

const SOLVER: &[Format] = solver::cmd::schema::FORMATS;
const FAB: &[Format] = fab::cmd::schema::FORMATS;

/// A number of a report.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

static SIMULATION: LazyLock<Validator> = LazyLock::new(|| schema(SOLVER, "report"));
static OPTIMIZATION: LazyLock<Validator> = LazyLock::new(|| schema(SOLVER, "optimization"));
static ITERATION: LazyLock<Validator> = LazyLock::new(|| schema(SOLVER, "history"));
static MOLD: LazyLock<Validator> = LazyLock::new(|| schema(FAB, "mold-report"));

/// The schema that `PROGRAM schema NAME` prints, for a program with these formats.
fn schema(formats: &[Format], name: &str) -> Validator {
    let named = |format: &&Format| format.name == name;
    let format = formats.iter().find(named).expect("it is there");
    jsonschema::validator_for(&(format.schema)()).expect("a sound schema")
}

/// Asserts that the report of a simulation has what its schema says, and that who reads it as its type
/// loses nothing.
pub fn check_simulation(report: &Value) {
    check::<Simulation>(&SIMULATION, report);
}

/// Asserts as [`check_simulation`] for the report of an optimisation.
pub fn check_optimization(report: &Value) {
    check::<Optimization>(&OPTIMIZATION, report);
}

/// Asserts as [`check_simulation`] for a line of a history.
pub fn check_iteration(line: &Value) {
    check::<Iteration>(&ITERATION, line);
}

/// Asserts as [`check_simulation`] for the report of a mold.
pub fn check_mold(report: &Value) {
    check::<MoldReport>(&MOLD, report);
}

fn check<T: DeserializeOwned + Serialize>(schema: &Validator, report: &Value) {
    let found: Vec<String> =
        schema.iter_errors(report).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    let read: T = serde_json::from_value(report.clone()).expect("its type");
    let again = serde_json::to_value(read).expect("its type");
    assert!(again == *report, "read as its type it is {again:#}, not {report:#}");
}
