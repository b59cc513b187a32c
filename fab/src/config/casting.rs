//! `[casting]`: what is cast, and what the mold is printed on.

use library::{Printer, printers, silicones};
use program::schema::one_of_these_or_none;
use schemars::{Schema, SchemaGenerator};
use serde::Serialize;

use super::table::{any, optional_length, table};

table! {
    /// What is cast, and what the mold is printed on.
    #[derive(PartialEq, Serialize)]
    CastingConfig, "casting." {
        /// A silicone of `cad2fem/library/silicones.toml`: for masses, times,
        /// moduli and warnings of `cast.md`.
        #[schemars(schema_with = "silicone_names")]
        silicone: Option<String> = None => "none: volumes only", known_silicone;
        /// A printer of `cad2fem/library/printers.toml`: for gaps, build volume and overhangs, and a
        /// warning of resin.
        #[schemars(schema_with = "printer_names")]
        printer: Option<String> = None => "none", known_printer;
        /// Silicone that stays in the cup, as a share of what fills the mold [1].
        waste: f64 = 0.2, share;
        /// Least thickness of the silicone at rest [m].
        least_wall: f64 = 1e-3, wall;
        /// Least thickness of a core, which breaks or is not printed where it is thinner [m].
        least_core: Option<f64> = None => "none", optional_length;
        /// Whether a second casting goes around this one, such as a skin over thread: the core stays inside, and
        /// the holes of its pins stay open.
        first_shot: bool = false, any;
        /// Gauge pressure of the leak test [Pa].
        leak_test: Option<f64> = None => "the working pressure", pressure;
    }
}

impl CastingConfig {
    /// The printer that is named.
    pub fn printer(&self) -> Option<&'static Printer> {
        self.printer.as_deref().and_then(|key| printers().find(key).ok())
    }
}

fn silicone_names(_: &mut SchemaGenerator) -> Schema {
    one_of_these_or_none(silicones().iter().map(|(key, _)| key))
}

fn printer_names(_: &mut SchemaGenerator) -> Schema {
    one_of_these_or_none(printers().iter().map(|(key, _)| key))
}

fn known_silicone(key: &str, name: &Option<String>) -> Result<(), String> {
    let Some(name) = name else { return Ok(()) };
    silicones().find(name).map(drop).map_err(|message| format!("{key}: {message}"))
}

fn known_printer(key: &str, name: &Option<String>) -> Result<(), String> {
    let Some(name) = name else { return Ok(()) };
    printers().find(name).map(drop).map_err(|message| format!("{key}: {message}"))
}

fn share(key: &str, waste: &f64) -> Result<(), String> {
    match (0.0..=10.0).contains(waste) {
        true => Ok(()),
        false => Err(format!("{key} is {waste}, must lie between 0 and 10")),
    }
}

fn wall(key: &str, least: &f64) -> Result<(), String> {
    match *least > 0.0 && *least < 1.0 {
        true => Ok(()),
        false => Err(format!("{key} is {least}, must be above 0 and below 1 m")),
    }
}

fn pressure(key: &str, pressure: &Option<f64>) -> Result<(), String> {
    match pressure {
        Some(pressure) if !(*pressure > 0.0 && *pressure <= 1e6) => {
            Err(format!("{key} is {pressure} Pa, must be above 0 and at most 1e6 Pa"))
        }
        _ => Ok(()),
    }
}
