//! How a chamber comes into a body.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The methods to make a chamber.
#[derive(
    Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, PartialOrd, Ord, Serialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A rigid core, pulled out through the inlet.
    PullOut,
    /// Two castings: the chamber, open to a plane, and the sheet that closes it.
    OpenTop,
    /// A core printed of what water dissolves.
    Soluble,
    /// Two halves, each cast on a half core, and glued.
    Halves,
    /// A core cast of wax in a mold of its own, and molten out.
    Wax,
    /// None: the body has no chamber.
    Solid,
}

impl Method {
    /// All methods, in the order in which they are preferred.
    pub const ALL: [Self; 6] =
        [Self::PullOut, Self::OpenTop, Self::Soluble, Self::Halves, Self::Wax, Self::Solid];

    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PullOut => "pull-out",
            Self::Soluble => "soluble",
            Self::Wax => "wax",
            Self::Halves => "halves",
            Self::OpenTop => "open-top",
            Self::Solid => "solid",
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
