//! Length units of the files that people and CAD programs give us.
//!
//! Everything that `cad2fem` writes is in metres; a length is converted once,
//! where it enters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
            Self::Inch => 25.4e-3,
        }
    }

    /// Its sign, as in "0.8 mm".
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::Inch => "inch",
        }
    }
}
