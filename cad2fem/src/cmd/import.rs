//! `cad2fem import`: meshes and CAD files of others → closed surface and patches.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use mesh::io::remove_litter;
use program::FolderLock;

use crate::import::{Request, import};
use crate::model::LabelledSurface;
use crate::report::Input;

/// Writes what `cad2fem model` writes: `DIR/model.stl`, `DIR/patches/<patch>.stl` and
/// `DIR/model.json`, in metres
///
/// Patches are the faces of a STEP, BREP or IGES file by name, by colour or by number; objects of a
/// 3MF file; `outer` and `cavity` of a mesh; with several files those of each with its name.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    request: Request,
    /// Folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let files = args.request.files.iter().map(|file| file.display().to_string());
    let files = files.collect::<Vec<_>>().join(" ");
    run_as(args, &format!("cad2fem import {files} -o {}", args.output.display()))
}

/// Runs the verb for another one, of which `command` is what the user would write again.
pub(super) fn run_as(args: &Args, command: &str) -> Result<()> {
    let start = Instant::now();
    let Args { request, output } = args;
    let mut labelled = import(request, command)?;
    remark_on_chord(request.chord * request.scale, &labelled);
    let _lock = FolderLock::new(output)?;
    for file in labelled.import.iter_mut().flat_map(|record| &mut record.files) {
        file.input = file.input.seen_from(output);
    }
    remove_litter(&output.join("patches"));
    labelled.write(output, Input::of(&request.files[0])?, start)?.log();
    Ok(())
}

/// Says so where triangles do not follow the faces of CAD as closely as was wanted [m].
fn remark_on_chord(wanted: f64, labelled: &LabelledSurface) {
    match labelled.facts.chord_error {
        Some(error) if error > wanted => log::warn!(
            "triangles are up to {:.4} mm from the faces of the CAD, --chord asks for {:.4} mm",
            error * 1e3,
            wanted * 1e3
        ),
        None if !labelled.facts.kinds.is_empty() => log::warn!(
            "how far triangles are from the faces of the CAD is not known: gmsh cannot measure it"
        ),
        _ => {}
    }
}
