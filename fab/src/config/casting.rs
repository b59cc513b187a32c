//! `[casting]`: what is cast, and what the mold is printed on.

use library::{Printer, Silicone, printers, silicones};
use program::schema::one_of_these_or_none;
use program::table;
use program::table::Range;
use program::{KeyPath, Misfit, misfit};
use schemars::{Schema, SchemaGenerator};

use super::LENGTH;

table! {
    /// What is cast, and what the mold is printed on.
    #[derive(Clone, Debug, PartialEq)]
    pub struct CastingConfig {
        /// A silicone of `cad2fem/library/silicones.toml`: for masses, times,
        /// moduli and warnings of `cast.html`.
        #[schemars(schema_with = "silicone_names")]
        silicone: Option<String> = None => "none: volumes only", known_silicone;
        /// A printer of `cad2fem/library/printers.toml`: for gaps, build volume and overhangs, and a
        /// warning of resin.
        #[schemars(schema_with = "printer_names")]
        printer: Option<String> = None => "none", known_printer;
        /// Silicone that stays in the cup, as a share of what fills the mold [1].
        waste: f64 = 0.2, Range::between(0.0, 10.0);
        /// Least thickness of the silicone at rest [m].
        least_wall: f64 = 1e-3, LENGTH;
        /// Least thickness of a core, which breaks or is not printed where it is thinner [m].
        least_core: Option<f64> = None => "none", LENGTH;
        /// Whether a second casting goes around this one, such as a skin over thread: the core stays inside, and
        /// the holes of its pins stay open.
        first_shot: bool = false;
        /// Gauge pressure of the leak test [Pa].
        leak_test: Option<f64> = None => "the working pressure", Range::above(0.0).at_most(1e6).unit("Pa");
    }
}

impl CastingConfig {
    /// The silicone that is named.
    pub fn silicone(&self) -> Option<&'static Silicone> {
        self.silicone.as_deref().and_then(|key| silicones().find(key).ok())
    }

    /// By how much it stretches until it breaks, if that is known [%].
    pub fn elongation(&self) -> Option<f64> {
        self.silicone()?.casting.as_ref()?.elongation
    }

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

fn known_silicone(key: &KeyPath, name: &Option<String>) -> Result<(), Misfit> {
    let Some(name) = name else { return Ok(()) };
    silicones().find(name).map(drop).map_err(|message| misfit!(key.clone(), ": {message}"))
}

fn known_printer(key: &KeyPath, name: &Option<String>) -> Result<(), Misfit> {
    let Some(name) = name else { return Ok(()) };
    printers().find(name).map(drop).map_err(|message| misfit!(key.clone(), ": {message}"))
}
