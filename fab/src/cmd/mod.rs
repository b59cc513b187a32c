//! The verbs, one per file.

pub mod mold;
pub mod plan;
pub mod tolerance;
pub mod verify;

use anyhow::Result;
use clap::Subcommand;

/// What `fab` can do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Tagged volume mesh → printable mold parts and mold.json
    Mold(mold::Args),
    /// Tagged volume mesh → how it is to be molded, and why (plan.json)
    Plan(plan::Args),
    /// Read a mold back from its files and prove it right
    Verify(verify::Args),
    /// Simulate a body with walls off by the print tolerance: spread of its response
    Tolerance(tolerance::Args),
}

impl Verb {
    /// Runs the verb.
    ///
    /// # Errors
    /// What the verb says.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Mold(args) => mold::run(args),
            Self::Plan(args) => plan::run(args),
            Self::Verify(args) => verify::run(args),
            Self::Tolerance(args) => tolerance::run(args),
        }
    }
}
