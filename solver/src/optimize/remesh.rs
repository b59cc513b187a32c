//! Meshes of a cascade: on disk before they are used, and the interior made anew.

use std::path::PathBuf;

use anyhow::Result;

use super::Cascade;
use super::checkpoint::Checkpoint;
use crate::body::{Body, Part};

/// Passes of the interior re-meshing.
const REMESH_PASSES: usize = 10;

impl Cascade<'_> {
    /// The mesh that a level began with, or that its iteration `meshed_at` made.
    fn mesh_path(&self, at: &Checkpoint, part: &Part) -> PathBuf {
        let what = match at.meshed_at {
            0 => format!("level-{}", at.level + 1),
            iteration => format!("remeshed-{}-{iteration}", at.level + 1),
        };
        self.folder.join(mesh_file(&what, part.name.as_deref()))
    }

    pub(super) fn level_body(&self, checkpoint: &Checkpoint) -> Result<Body> {
        let part = |part: &Part| {
            let path = self.mesh_path(checkpoint, part);
            let file = mesh::io::read_tets(&path)?;
            Ok((part.name.clone(), file.mesh, file.tags))
        };
        let bodies = self.scene.body.parts.iter().map(part).collect::<Result<_>>()?;
        Body::join(bodies).cut_by(&self.scene.config.cuts())
    }

    /// Puts a mesh and the checkpoint before its first solve on disk.
    pub(super) fn begin_mesh(&self, body: &Body, mut checkpoint: Checkpoint) -> Result<Checkpoint> {
        for (part, (_, mesh, tags)) in body.parts.iter().zip(body.separate()) {
            let path = self.mesh_path(&checkpoint, part);
            mesh::io::write_tets(&path, &mesh, &tags)?;
            checkpoint.add_file(&path)?;
        }
        checkpoint.write(&self.folder)?;
        Ok(checkpoint)
    }
}

/// Name of a mesh file, of one body of several if it has a name.
#[must_use]
pub fn mesh_file(what: &str, body: Option<&str>) -> String {
    body.map_or_else(|| format!("{what}.msh"), |name| format!("{what}.{name}.msh"))
}

/// Improves the interior of the bodies that have moving facets; boundary vertices and
/// tags stay as they are. Where facets inside a body have tags, its interior stays, too.
pub(super) fn remesh(body: &Body, moving: &[[usize; 3]]) -> Result<Body> {
    let mut bodies = body.separate();
    for (part, (_, mesh, _)) in body.parts.iter().zip(&mut bodies) {
        if !moving.iter().any(|facet| part.vertices.contains(&facet[0])) {
            continue;
        }
        if body.has_tags_inside(part) {
            log::info!(
                "the interior is not re-meshed: facets inside the body have tags, or volumes meet there"
            );
            continue;
        }
        let report = mesh::improve::improve_interior(mesh, REMESH_PASSES);
        log::info!(
            "re-meshed the interior: radius ratio min {:.3} -> {:.3}, first percentile {:.3} -> \
             {:.3}",
            report.before.radius_ratio_min,
            report.after.radius_ratio_min,
            report.before.radius_ratio_p1,
            report.after.radius_ratio_p1
        );
    }
    Body::join(bodies).cut_by(&body.cuts())
}
