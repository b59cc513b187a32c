//! The verbs, one per file.

pub mod doctor;
pub mod film;
pub mod import;
pub mod info;
pub mod model;
pub mod new;
pub mod offset;
pub mod pack;
pub mod pick;
pub mod picture;
pub mod remesh;
pub mod report;
pub mod rules;
pub mod schema;
pub mod tetmesh;

use anyhow::Result;
use clap::Subcommand;
use program::schema::SchemaArguments;

/// What `cad2fem` can do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// A folder with all files of a body, to begin with
    New(new::Args),
    /// What this machine lacks, and how to get it
    Doctor(doctor::Args),
    /// Implicit model or CAD file → closed surface and one patch per region
    Model(model::Args),
    /// Meshes and CAD files of others, in any unit, sound or not → the same
    Import(import::Args),
    /// Open patch → closed selection volume of thickness ±distance
    Offset(offset::Args),
    /// Closed surface → tetrahedra
    Tetmesh(tetmesh::Args),
    /// Improve the interior of a tetrahedral mesh, its surface untouched
    Remesh(remesh::Args),
    /// Counts, sizes, quality and validity of any surface or mesh
    Info(info::Args),
    /// A body → a page on which you name its faces by clicking, and get tags.toml
    Pick(pick::Args),
    /// Any surface, mesh or result → a shaded PNG, drawn without a display
    Picture(picture::Args),
    /// A run, step by step → an animated GIF, drawn without a display
    Film(film::Args),
    /// All results in a folder → one page to look at in a browser, without a network
    Report(report::Args),
    /// Where the rules for make are, which the Makefile of a body includes
    Rules(rules::Args),
    /// All that printer, bench and colleagues need of a body → one file to send
    Pack(pack::Args),
    /// The JSON Schema of a file that this program reads, for editors and other programs
    Schema(SchemaArguments),
}

impl Verb {
    /// Runs the verb.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::New(args) => new::run(args),
            Self::Doctor(args) => doctor::run(args),
            Self::Model(args) => model::run(args),
            Self::Import(args) => import::run(args),
            Self::Offset(args) => offset::run(args),
            Self::Tetmesh(args) => tetmesh::run(args),
            Self::Remesh(args) => remesh::run(args),
            Self::Info(args) => info::run(args),
            Self::Pick(args) => pick::run(args),
            Self::Picture(args) => picture::run(args),
            Self::Film(args) => film::run(args),
            Self::Report(args) => report::run(args),
            Self::Rules(args) => rules::run(args),
            Self::Pack(args) => pack::run(args),
            Self::Schema(args) => args.print(schema::FORMATS),
        }
    }
}
