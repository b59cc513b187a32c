//! What the programs report is what their schemas say.

use std::sync::LazyLock;

use jsonschema::Validator;
use program::schema::Format;
use reports::Simulation;
use serde_json::Value;

/// The schema of a report, which `solver schema report` prints.
static SCHEMA: LazyLock<Validator> = LazyLock::new(|| {
    let named = |format: &&Format| format.name == "report";
    let format = solver::cmd::schema::FORMATS.iter().find(named).expect("it is there");
    jsonschema::validator_for(&(format.schema)()).expect("a sound schema")
});

/// Asserts that the report of a simulation has what its schema says, and that who reads it as its type
/// loses nothing.
///
/// # Panics
/// When it has another key, or one of another type.
pub fn check(report: &Value) {
    let found: Vec<String> =
        SCHEMA.iter_errors(report).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(found.is_empty(), "{found:#?}");
    let read: Simulation = serde_json::from_value(report.clone()).expect("its type");
    let again = serde_json::to_value(read).expect("its type");
    assert_eq!(&again, report);
}
