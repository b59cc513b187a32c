//! `cad2fem offset`: open patch → closed selection volume.

use std::path::PathBuf;

use anyhow::{Context, Result};
use mesh::crossings::self_intersecting_pairs;
use mesh::io::write_surface;
use mesh::measure::{diagonal, enclosed_volume};
use mesh::topology::boundary_loops;
use program::units::Unit;

use crate::report::read_in;
use crate::selection::offset;

/// Distance over the diagonal of the bounding box unless --distance is given.
const RELATIVE_DISTANCE: f64 = 1e-3;

/// Vertices move along their normals to both sides; walls close the rim
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Open patch [m], or as --unit says
    patch: PathBuf,
    /// Unit of the surfaces, if not metres; the volume is in metres
    #[arg(long)]
    unit: Option<Unit>,
    /// Volume to write (.obj keeps full precision, .stl rounds to 32 bits)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Distance to either side [m]; by default 1e-3 of the bounding box diagonal
    #[arg(long, value_name = "M")]
    distance: Option<f64>,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let patch = read_in(&args.patch, args.unit)?;
    let usual = || RELATIVE_DISTANCE * diagonal(&patch.vertices);
    let distance = args.distance.unwrap_or_else(usual);
    let place = || args.patch.display().to_string();
    let volume = offset(&patch, distance).with_context(place)?;
    let crossings = self_intersecting_pairs(&volume).len();
    if crossings > 0 {
        log::warn!(
            "{}: {crossings} pairs of triangles of the volume intersect: the patch bends more \
             sharply than the distance {distance:.3e} m; choose a smaller --distance",
            place()
        );
    }
    if boundary_loops(&patch.triangles).is_empty() {
        log::info!("the patch is closed: the volume is a shell around it");
    }
    log::info!(
        "distance {:.4} mm to either side, volume {:.5} cm3, {} triangles",
        distance * 1e3,
        enclosed_volume(&volume) * 1e6,
        volume.triangles.len()
    );
    write_surface(&args.output, &volume)?;
    Ok(())
}
