//! `solver schema`: the files that it reads, and those that it writes for others to read.

use program::schema::Format;
use scene::config::{DesignConfig, SimConfig};

use crate::study::{calibration, validation};

/// What the verb can print.
pub const FORMATS: &[Format] = &[
    Format::of::<SimConfig>("sim", "sim.toml"),
    Format::of::<DesignConfig>("design", "design.toml"),
    Format::of::<calibration::Config>("calibrate", "calibrate.toml"),
    Format::of::<validation::Config>("validation", "validation.toml"),
    Format::of_report::<reports::Simulation>("report", "report.json of simulate"),
    Format::of_report::<reports::Step>("steps", "a line of steps.jsonl of simulate"),
    Format::of_report::<reports::Optimization>("optimization", "report.json of optimize"),
    Format::of_report::<reports::Iteration>("history", "a line of history.jsonl of optimize"),
];
