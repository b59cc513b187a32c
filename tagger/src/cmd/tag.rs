//! `tagger tag`: select and assign.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use log::{info, warn};
use mesh::{Tags, TetMesh, io, measure};
use program::Changes;
use serde::Serialize;
use serde_json::Value;

use super::show;
use crate::assign::{self, Assignment};
use crate::config::Config;
use crate::facets::{self, Facets};
use crate::select::Sources;
use crate::volumes;

/// Selection distance where the tag file gives none [envelope of the mesher].
const REACH: f64 = 4.0 / 3.0;

/// Selection distance where no report of the mesher is found either [diagonal].
const LEAST: f64 = 1e-3;

/// Gives every boundary facet to the first selection that holds its centroid.
#[derive(clap::Args)]
pub struct Args {
    /// Tetrahedral mesh (Gmsh .msh), in metres.
    volume: PathBuf,
    /// Tag file: an ordered list of [[tag]].
    #[arg(long)]
    config: PathBuf,
    /// Folder of the selection files [default: that of the tag file].
    #[arg(long)]
    patches: Option<PathBuf>,
    /// Tagged mesh to write; tags.txt and tags.json appear beside it.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    changes: Changes,
}

/// Runs `tagger tag`.
pub fn run(args: &Args) -> Result<()> {
    let config = Config::read(&args.config, &args.changes.set)?;
    let io::MshFile { mesh, tags: before } = io::read_tets(&args.volume)?;
    if mesh.tets.is_empty() {
        bail!("{}: no tetrahedra, so there is no boundary to tag", args.volume.display());
    }
    let facets = Facets::of(&mesh);
    let diagonal = measure::diagonal(&mesh.vertices);
    let epsilon = match config.epsilon(diagonal) {
        Some(epsilon) => epsilon,
        None => envelope(&args.volume)?.map_or(LEAST * diagonal, |envelope| REACH * envelope),
    };
    let folder = args.patches.as_deref().or(args.config.parent()).unwrap_or(Path::new(""));
    let mut sources = Sources::new(folder, epsilon);
    if let Some(surface) = &config.surface {
        sources.surface = Some(io::read_surface_in_metres(&folder.join(surface))?);
    }
    let of_config = || args.config.display().to_string();
    if !config.faces.is_empty() {
        sources.recognize(&config.faces).with_context(of_config)?;
        remark_on_faces(args, &config, &sources);
    }
    info!("{} facets, diagonal {diagonal:.6} m, epsilon {epsilon:.3e} m", facets.len());
    let volumes = volumes::assign(&config, &mesh, &before.volumes, &facets, &mut sources);
    let volumes = volumes.with_context(of_config)?;
    let assignment = assign::assign(&config, &mesh, &facets, sources).with_context(of_config)?;
    report(&config, &assignment, &facets);
    let tags = Tags { volumes, ..assignment.tags(&config, &facets) };
    write_tagged(&args.output, &mesh, &tags)
}

/// Says which faces are not quite those that were picked.
fn remark_on_faces(args: &Args, config: &Config, sources: &Sources) {
    let path = args.config.display();
    let faces = &sources.recognized;
    faces.changes().iter().for_each(|line| info!("{path}: {line}"));
    let model = sources.folder.parent().unwrap_or(Path::new("."));
    let look = format!("look: cad2fem pick {} --tags {path} -o pick.html", model.display());
    for (name, doubt) in faces.doubts() {
        if let Some(tag) = config.tag.iter().find(|tag| tag.patches().iter().any(|own| own == name))
        {
            warn!("{path}: {} may mean another face now: {doubt}; {look}", tag.name);
        }
    }
    let has_tag = |file: &str| {
        let mut own = config.tag.iter().flat_map(|tag| tag.patches());
        own.any(|own| program::fits(file, own))
    };
    if let Some(new) = faces.new_faces(has_tag) {
        warn!("{path}: {new}; {look}");
    }
}

/// The envelope of the mesher [m], if its report lies beside the mesh.
fn envelope(volume: &Path) -> Result<Option<f64>> {
    let path = volume.with_extension("report.json");
    if !path.exists() {
        return Ok(None);
    }
    let read = || -> Result<Value> { Ok(serde_json::from_str(&io::read_text(&path)?)?) };
    let report = read().with_context(|| {
        let path = path.display();
        format!(
            "{path}: no report of cad2fem tetmesh; make it again, or give epsilon in the tag file"
        )
    })?;
    Ok(report["options"]["envelope"].as_f64().filter(|envelope| *envelope > 0.0))
}

fn report(config: &Config, assignment: &Assignment, facets: &Facets) {
    for (index, (tag, tally)) in config.tag.iter().zip(&assignment.tallies).enumerate() {
        let on_boundary = assignment.owners.iter().filter(|&&o| o == Some(index)).count();
        let inside = assignment.inside.iter().filter(|&&(_, owner)| owner == index).count();
        let count = on_boundary + inside;
        info!(
            "{}: {count} facets{}, {:.3} mm², {} contested, {} pinholes filled",
            tag.name,
            if tag.inside { " inside" } else { "" },
            1e6 * tally.area,
            tally.contested,
            tally.pinholes
        );
        if let (Some(mismatch), Some(expected)) = (tally.area_mismatch(), tally.expected_area) {
            warn!(
                "{}: area {:.3} mm² differs by {:.1} % from the {:.3} mm² of its patch (3 % is usual \
                 at most): is the mesh too coarse for its rim, or does another selection overlap?",
                tag.name,
                1e6 * tally.area,
                100.0 * mismatch,
                1e6 * expected
            );
        }
    }
    let contested: usize = assignment.tallies.iter().map(|t| t.contested).sum();
    let left_over = assignment.left_over();
    info!("{contested} contested, {left_over} of {} facets left over", facets.len());
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

/// Writes a tagged mesh, and beside it `tags.txt`, the table of `tagger show`, and `tags.json`.
fn write_tagged(path: &Path, mesh: &TetMesh, tags: &Tags) -> Result<()> {
    let ids: Vec<u32> = tags.names.iter().filter_map(|name| tags.id(name)).collect();
    let facets: Vec<_> = ids.iter().map(|&id| tags.facets_of(id)).collect();
    let legend = Legend {
        program: concat!("tagger ", env!("CARGO_PKG_VERSION")),
        names: &tags.names,
        ids,
        facets: facets.iter().map(Vec::len).collect(),
        areas: facets.iter().map(|own| facets::area(mesh, own)).collect(),
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// One number is enough: the envelope of the mesher, which it writes beside the mesh.
    #[test]
    fn the_envelope_is_that_of_the_report_beside_the_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let (mesh, report) =
            (folder.path().join("volume.msh"), folder.path().join("volume.report.json"));
        assert_eq!(envelope(&mesh).unwrap(), None);
        std::fs::write(&report, "{\"options\": {\"envelope\": 3e-5}}").unwrap();
        assert_eq!(envelope(&mesh).unwrap(), Some(3e-5));
        std::fs::write(&report, "{").unwrap();
        let error = format!("{:#}", envelope(&mesh).unwrap_err());
        assert!(error.contains("volume.report.json") && error.contains("give epsilon"), "{error}");
    }
}
