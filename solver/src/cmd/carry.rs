//! `solver carry`: a designed shape on another mesh of the same body.

use std::path::PathBuf;

use anyhow::{Context, Result};
use mechanics::body::Body;

use variables::carry;

/// Carry a designed shape to another mesh of the same body
///
/// Every boundary vertex of the other mesh moves as the nearest point of the modelled surface with the
/// same tag does in the design, and the interior follows. So a design on a coarse mesh is simulated on a
/// fine one, or cast from it. The meshes have to share their tags.
#[derive(clap::Args)]
pub struct Arguments {
    /// The designed mesh, with the boundary facets of the modelled one
    designed: PathBuf,
    /// The tagged mesh that the design began with
    #[arg(long, value_name = "MODELLED")]
    from: PathBuf,
    /// Another tagged mesh of the same body, as modelled
    #[arg(long, value_name = "OTHER")]
    onto: PathBuf,
    /// The other mesh with the designed shape
    #[arg(short, long)]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { designed, from, onto, output } = arguments;
    let read = |path: &PathBuf| mesh::io::read_tets(path);
    let (modelled, mut other) = (read(from)?, read(onto)?);
    let modelled = Body::new(modelled.mesh, modelled.tags);
    let body = Body::new(other.mesh.clone(), other.tags.clone());
    let carried = carry(&modelled, &read(designed)?.mesh, &body)
        .with_context(|| format!("{} onto {}", designed.display(), onto.display()))?;
    other.mesh.vertices = carried.vertices;
    mesh::io::write_tets(output, &other.mesh, &other.tags)?;
    log::info!(
        "{}: {} tetrahedra moved by up to {:.3} mm; surfaces as modelled at most {:.4} mm apart",
        output.display(),
        other.mesh.tets.len(),
        1e3 * carried.motion,
        1e3 * carried.apart
    );
    Ok(())
}
