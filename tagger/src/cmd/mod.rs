//! The verbs of `tagger`, one file each.

pub mod schema;
pub mod show;
pub mod tag;
pub mod transfer;

use std::path::Path;

use anyhow::Result;
use clap::Subcommand;
use mesh::{Tags, TetMesh, io, measure, topology};
use program::schema::SchemaArguments;
use serde::Serialize;

/// What `tagger` can do.
#[derive(Subcommand)]
pub enum Verb {
    /// Select boundary facets and name them.
    Tag(tag::Args),
    /// Print a table of the tags of a mesh.
    Show(show::Args),
    /// Carry tags to a mesh with the same boundary.
    Transfer(transfer::Args),
    /// The JSON Schema of a file that this program reads, for editors and other programs
    Schema(SchemaArguments),
}

impl Verb {
    /// Runs the verb.
    pub fn run(self) -> Result<()> {
        match self {
            Self::Tag(args) => tag::run(&args),
            Self::Show(args) => show::run(&args),
            Self::Transfer(args) => transfer::run(&args),
            Self::Schema(args) => args.print(schema::FORMATS),
        }
    }
}

/// What `tags.json` says about each tag, in order of ids from 1.
#[derive(Serialize)]
struct Legend<'a> {
    program: &'static str,
    names: &'a [String],
    ids: Vec<u32>,
    /// Number of facets.
    facets: Vec<usize>,
    /// Area [m²].
    areas: Vec<f64>,
}

/// Writes a tagged mesh, and beside it `tags.txt`, the table of [`show`], and `tags.json`.
fn write_tagged(path: &Path, mesh: &TetMesh, tags: &Tags) -> Result<()> {
    let ids: Vec<u32> = tags.names.iter().filter_map(|name| tags.id(name)).collect();
    let facets: Vec<_> = ids.iter().map(|&id| tags.facets_of(id)).collect();
    let area = |f: &Vec<_>| measure::area(&topology::submesh(&mesh.vertices, f).0);
    let legend = Legend {
        program: concat!("tagger ", env!("CARGO_PKG_VERSION")),
        names: &tags.names,
        ids,
        facets: facets.iter().map(Vec::len).collect(),
        areas: facets.iter().map(area).collect(),
    };
    let table = show::table(mesh, tags);
    io::write_atomic(&path.with_file_name("tags.txt"), |out| out.write_all(table.as_bytes()))?;
    io::write_atomic(&path.with_file_name("tags.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &legend)?;
        writeln!(out)
    })?;
    io::write_tets(path, mesh, tags)?;
    Ok(())
}
