//! Printers, and what they can print.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::Catalog;

/// A printer. Lengths are millimetres.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Printer {
    /// The name.
    pub name: String,
    /// What it prints.
    pub kind: PrinterKind,
    /// The largest part it prints [mm]; none for a kind of printers.
    pub volume: Option<[f64; 3]>,
    /// Width of a line, or of a pixel [mm].
    pub nozzle: f64,
    /// Smallest and largest height of a layer [mm].
    pub layer: [f64; 2],
    /// How far a printed wall may be off [mm].
    pub tolerance: f64,
    /// Gap between parts that fit into each other [mm].
    pub clearance: f64,
    /// Steepest angle from the vertical printed without support [degrees].
    pub overhang: f64,
    /// Key of the source of its numbers.
    pub source: String,
}

/// What a printer prints.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PrinterKind {
    /// Molten filament.
    Filament,
    /// Resin that light hardens.
    Resin,
}

impl PrinterKind {
    /// The usual plastic and its density [kg/m³]: PLA, and acrylic resin when cured.
    pub fn plastic(self) -> (&'static str, f64) {
        match self {
            Self::Filament => ("PLA", 1240.0),
            Self::Resin => ("resin", 1200.0),
        }
    }
}

/// All printers.
pub fn printers() -> &'static Catalog<Printer> {
    static CATALOG: LazyLock<Catalog<Printer>> =
        LazyLock::new(|| Catalog::new("printer", include_str!("../printers.toml")));
    &CATALOG
}

impl Printer {
    /// Where its numbers come from.
    pub fn citation(&self) -> &'static str {
        &printers().source(&self.source).citation
    }

    /// Two lines side by side: what is thinner leaks, or is not printed at all [mm].
    pub fn least_wall(&self) -> f64 {
        2.0 * self.nozzle
    }

    /// Whether a part of this size fits when turned about the vertical by quarters [mm].
    pub fn holds(&self, size: [f64; 3]) -> bool {
        let Some([x, y, z]) = self.volume else { return true };
        let flat = |a: f64, b: f64| size[0] <= a && size[1] <= b;
        size[2] <= z && (flat(x, y) || flat(y, x))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn printers_can_be_and_have_a_source() {
        for (key, printer) in printers().iter() {
            assert!(!printer.citation().is_empty(), "{key}");
            let [thin, thick] = printer.layer;
            assert!(0.0 < thin && thin < thick, "{key}");
            // A layer is no higher than its line is wide.
            assert!(printer.kind == PrinterKind::Resin || thick < printer.nozzle, "{key}");
            assert!(printer.clearance >= 0.1 && printer.tolerance > 0.0, "{key}");
        }
    }

    #[test]
    fn parts_may_be_turned_on_the_bed() {
        let form = printers().find("form-4").unwrap();
        assert!(form.holds([125.0, 200.0, 210.0]));
        assert!(!form.holds([126.0, 130.0, 10.0]));
        assert!(printers().find("printer").unwrap_err().contains("prusa-mk4"));
    }
}
