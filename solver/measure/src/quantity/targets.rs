//! Target surfaces, from their files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context as _, Result, ensure};
use mesh::SurfaceMesh;

use super::{DistanceField, DistanceKind};

/// Distances to the surfaces in files, each of which is made once for all bodies.
#[derive(Clone, Default)]
pub struct Targets {
    folder: PathBuf,
    known: Arc<Mutex<Vec<(Wanted, DistanceField)>>>,
}

/// What a distance field is made of: file, spacing of the lattice [m], and kind.
type Wanted = (PathBuf, f64, DistanceKind);

impl Targets {
    /// Surfaces in files that are named from a folder.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), known: Arc::default() }
    }

    /// The distance to the surface in a file.
    pub fn field(&self, file: &Path, spacing: f64, kind: DistanceKind) -> Result<DistanceField> {
        let wanted = (self.folder.join(file), spacing, kind);
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, field)) = known.iter().find(|(made, _)| *made == wanted) {
            return Ok(field.clone());
        }
        let surface = mesh::io::read_surface(&wanted.0)?;
        check(&surface, kind).with_context(|| wanted.0.display().to_string())?;
        let field = DistanceField::new(&surface, spacing, kind);
        known.push((wanted, field.clone()));
        Ok(field)
    }
}

/// The signed distance needs an inside.
fn check(surface: &SurfaceMesh, distance: DistanceKind) -> Result<()> {
    let rim = mesh::topology::boundary_edges(&surface.triangles).len();
    ensure!(
        distance != DistanceKind::Signed || rim == 0,
        "{rim} edges on the rim of an open surface, which has no inside: distance = \"signed\" \
         needs a closed target; take \"squared\""
    );
    let volume = mesh::measure::enclosed_volume(surface);
    ensure!(
        distance != DistanceKind::Signed || volume > 0.0,
        "the triangles face inwards (volume {volume:.3e} m³): distance = \"signed\" needs a \
         target that faces outwards; turn its triangles around"
    );
    Ok(())
}
