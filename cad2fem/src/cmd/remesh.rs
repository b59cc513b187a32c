//! `cad2fem remesh`: better tetrahedra inside, the surface untouched.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use mesh::check::check_tets;
use mesh::improve::improve_around;
use mesh::io::{read_tets, write_tets};
use mesh::measure::Quality;

use crate::report::findings;

/// Boundary vertices and facets, those inside with a tag, and tags stay as they are, bit for bit
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tetrahedral mesh (.msh)
    mesh: PathBuf,
    /// Mesh to write (.msh)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Passes over the mesh
    #[arg(long, value_name = "N", default_value_t = 10)]
    passes: usize,
}

/// Runs the verb.
///
/// # Errors
/// If the mesh cannot be read or is not valid, or the result cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let mut file = read_tets(&args.mesh)?;
    let found = check_tets(&file.mesh);
    if !found.is_empty() {
        bail!("{}: not a valid mesh:{}", args.mesh.display(), findings(&found));
    }
    ensure!(
        file.tags.volumes.names.is_empty(),
        "{}: it has the volumes {}, which other tetrahedra do not have; mesh its surface anew: cad2fem \
         tetmesh",
        args.mesh.display(),
        file.tags.volumes.names.join(", ")
    );
    let tagged: BTreeSet<[usize; 3]> = file.tags.facets.keys().copied().collect();
    let report = improve_around(&mut file.mesh, &tagged, args.passes);
    log_quality("before", &report.before);
    log_quality("after", &report.after);
    log::info!("{} moves, {} flips", report.moved, report.flips);
    write_tets(&args.output, &file.mesh, &file.tags)
        .with_context(|| format!("improving {}", args.mesh.display()))
}

fn log_quality(when: &str, q: &Quality) {
    log::info!(
        "{when:<6}  radius ratio min {:.3}  p1 {:.3}  mean {:.3}; dihedral {:.1}..{:.1} deg",
        q.radius_ratio_min,
        q.radius_ratio_p1,
        q.radius_ratio_mean,
        q.min_dihedral,
        q.max_dihedral
    );
}
