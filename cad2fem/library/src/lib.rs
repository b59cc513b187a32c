//! Silicones, printed elastomers, printers and tubes that configurations may name.
//!
//! The entries are in `silicones.toml`, `printed.toml`, `printers.toml` and `tubes.toml` of this crate and are
//! compiled into the programs. Every number has a source with a licence.

mod catalog;
mod printer;
mod silicone;
mod tube;

pub use catalog::{Catalog, Source};
pub use printer::{Printer, PrinterKind, printers};
pub use silicone::{
    Casting, Chemistry, Fit, Printed, Silicone, Softening, Test, kilopascals, printed, silicones,
};
pub use tube::{Tube, tubes};
