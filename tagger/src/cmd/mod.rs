//! The verbs of `tagger`, one file each.

pub mod schema;
pub mod show;
pub mod tag;

use anyhow::Result;
use clap::Subcommand;
use program::schema::SchemaArguments;

/// What `tagger` can do.
#[derive(Subcommand)]
pub enum Verb {
    /// Select boundary facets and name them.
    Tag(tag::Args),
    /// Print a table of the tags of a mesh.
    Show(show::Args),
    /// The JSON Schema of a file that this program reads, for editors and other programs
    Schema(SchemaArguments),
}

impl Verb {
    /// Runs the verb.
    pub fn run(self) -> Result<()> {
        match self {
            Self::Tag(args) => tag::run(&args),
            Self::Show(args) => show::run(&args),
            Self::Schema(args) => args.print(schema::FORMATS),
        }
    }
}
