//! `solver mirror`: the whole body, or its results, of a part that planes of symmetry cut.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::symmetry::AXES;
use mesh::io::vtu;
use mesh::io::vtu::Grid;
use program::FolderLock;
use reports::CutPlane;
use serde::Deserialize;

use run::report::mirror::{mirror_body, mirror_grid};
use run::report::results::write_arrays;

/// Complete a part of a symmetric body, or its results, by its mirror images
///
/// A mesh is mirrored in the planes of the tags that --on names. Nodes in the planes are
/// shared, other tags are mirrored with it, and those of the cuts vanish. Of a folder of
/// simulate or optimize, the states are mirrored in the planes of its scene: result.vtu and
/// the states of all steps with result.pvd, and of simulate nodes.npy and displacement.npy.
#[derive(clap::Args)]
pub struct Arguments {
    /// A tagged mesh (.msh), or a folder of simulate or optimize
    part: PathBuf,
    /// The mesh of the whole, or the folder for its states
    #[arg(short, long)]
    output: PathBuf,
    /// Tag of a cut, once for each plane; of a mesh only
    #[arg(long, value_name = "TAG")]
    on: Vec<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { part, output, on } = arguments;
    let context = || part.display().to_string();
    if part.is_dir() {
        ensure!(
            on.is_empty(),
            "--on {}: of results, the planes are those of their scene; expected no --on",
            on[0]
        );
        return states(part, output).with_context(context);
    }
    ensure!(!on.is_empty(), "{}: expected --on TAG, the tag of a cut", part.display());
    mesh_of_whole(part, output, on).with_context(context)
}

fn mesh_of_whole(part: &Path, output: &Path, on: &[String]) -> Result<()> {
    let file = mesh::io::read_tets(part)?;
    let (mut mesh, mut tags) = (file.mesh, file.tags);
    let before = mesh.tets.len();
    // all planes are checked on the part; those that are left are found again in each whole
    let cuts: Vec<Vec<String>> = on.iter().map(|tag| vec![tag.clone()]).collect();
    Body::new(mesh.clone(), tags.clone()).cut_by(&cuts)?;
    for cut in &cuts {
        let body = Body::new(mesh, tags).cut_by(std::slice::from_ref(cut))?;
        (mesh, tags) = mirror_body(&body.mesh, &body.tags, &body.planes[0]);
    }
    mesh::io::write_tets(output, &mesh, &tags)?;
    log::info!("{before} tetrahedra mirrored to {} in {}", mesh.tets.len(), output.display());
    Ok(())
}

fn states(part: &Path, output: &Path) -> Result<()> {
    let planes = planes(&part.join("report.json"))?;
    let same = output.exists() && system::canonical(output)? == system::canonical(part)?;
    ensure!(!same, "it cannot be its own whole: expected another folder after -o");
    let _lock = FolderLock::new(output)?;
    let mut count = 0;
    for entry in std::fs::read_dir(part)? {
        let path = entry?.path();
        if path.extension().is_none_or(|extension| extension != "vtu") {
            continue;
        }
        let name = path.file_name().unwrap_or_default();
        let mirror = |grid: Grid, &(axis, level): &(usize, f64)| mirror_grid(&grid, axis, level);
        let whole = planes.iter().fold(vtu::read_vtu(&path)?, mirror);
        vtu::write_vtu(&output.join(name), &whole)?;
        count += 1;
        if name == "result.vtu" && part.join("displacement.npy").exists() {
            let u = whole.point_fields.iter().find(|field| field.name == "displacement");
            let u = u.context("result.vtu has no displacement")?;
            write_arrays(output, &whole.points, &u.values)?;
        }
    }
    ensure!(count > 0, "no .vtu file; expected a folder of simulate or optimize");
    let list = part.join("result.pvd");
    if list.exists() {
        let list = mesh::io::read_bytes(&list)?;
        mesh::io::write_atomic(&output.join("result.pvd"), |out| out.write_all(&list))?;
    }
    log::info!("{count} states mirrored to {}", output.display());
    Ok(())
}

/// What is read of a report of simulate or optimize.
#[derive(Deserialize)]
struct Symmetry {
    symmetry: Option<Vec<CutPlane>>,
}

/// Axes and levels [m] of the planes of symmetry that a report names.
fn planes(path: &Path) -> Result<Vec<(usize, f64)>> {
    let report: Symmetry = serde_json::from_str(&mesh::io::read_text(path)?)
        .with_context(|| path.display().to_string())?;
    let Some(planes) = report.symmetry else {
        bail!("report.json has no symmetry: its scene has no [[symmetry]], or it has no result");
    };
    let plane = |plane: &CutPlane| {
        let axis = AXES.iter().position(|axis| plane.axis == *axis);
        Ok((axis.context("symmetry in report.json: expected an axis")?, plane.level))
    };
    planes.iter().map(plane).collect()
}
