//! Length units of the files that people and CAD programs give us.
//!
//! Everything that `cad2fem` writes is in metres; a length is converted once,
//! where it enters.

use std::path::Path;

use anyhow::{Result, bail};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bodies that are cast of silicone are between these sizes, from corner to corner [m]. What is
/// within them in one of metres and millimetres only has that unit.
const BODIES: std::ops::RangeInclusive<f64> = 5e-3..=1.5;

/// The unit of a file that states none, by its size: metres or millimetres.
pub fn guess(file: &Path, diagonal: f64) -> Result<Unit> {
    let likely = |unit: &Unit| BODIES.contains(&(diagonal * unit.metres()));
    match [Unit::M, Unit::Mm].into_iter().find(likely) {
        Some(unit) => Ok(unit),
        None => bail!("{}: {}", file.display(), sizes(diagonal)),
    }
}

/// How large a file is in each unit, and what to do.
pub fn sizes(diagonal: f64) -> String {
    format!(
        "no unit is stated, and it is {} as metres, {} as millimetres, {} as inches from corner to \
         corner: pass --unit m, --unit mm, ...",
        length(diagonal),
        length(diagonal * Unit::Mm.metres()),
        length(diagonal * Unit::Inch.metres()),
    )
}

/// A length with its unit, such as "98 mm".
fn length(metres: f64) -> String {
    match metres {
        m if m >= 1.0 => format!("{m:.3} m"),
        m if m >= 1e-3 => format!("{:.3} mm", m * 1e3),
        m => format!("{:.3} µm", m * 1e6),
    }
}

/// A unit of length.
#[derive(
    Clone, Copy, Debug, Deserialize, JsonSchema, Serialize, PartialEq, Eq, clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Metre
    M,
    /// Centimetre
    Cm,
    /// Millimetre
    Mm,
    /// International inch, 25.4 mm
    Inch,
}

impl Unit {
    /// Metres per unit [m].
    pub fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
            Self::Inch => 25.4e-3,
        }
    }

    /// The sign, as in "0.8 mm".
    pub fn symbol(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::Inch => "inch",
        }
    }

    /// As OpenCASCADE calls it.
    pub fn of_cad(self) -> String {
        self.symbol().to_uppercase()
    }
}
