//! Meshes of a cascade: on disk, and with their elements made better.

use std::path::Path;

use anyhow::Result;
use mechanics::body::Body;
use mesh::improve::{SurfaceReport, improve_tagged, improve_with_surface, usual_tolerance};
use scene::Scene;

/// Passes of the interior re-meshing.
const REMESH_PASSES: usize = 10;

/// Writes a mesh file for each body of a scene, placed as the scene reads them.
pub fn write_bodies(folder: &Path, what: &str, scene: &Scene, body: &Body) -> Result<()> {
    for (part, (name, mut mesh, tags)) in scene.parts.iter().zip(body.separate()) {
        let shift = mesh::Vec3::from(part.config.translate);
        mesh.vertices.iter_mut().for_each(|v| *v -= shift);
        mesh::io::write_tets(&folder.join(mesh_file(what, name.as_deref())), &mesh, &tags)?;
    }
    Ok(())
}

/// Name of a mesh file, of one body of several if it has a name.
pub fn mesh_file(what: &str, body: Option<&str>) -> String {
    body.map_or_else(|| format!("{what}.msh"), |name| format!("{what}.{name}.msh"))
}

/// Improves the bodies that have facets `moving`: their interior, and those facets within a
/// `tolerance` [m] of where they are, [`usual_tolerance`] by default. Tags keep their
/// rims; facets inside with tags, and those between volumes, stay as they are.
pub(super) fn remesh(body: &Body, moving: &[[usize; 3]], tolerance: Option<f64>) -> Result<Body> {
    let tolerance = tolerance.unwrap_or_else(|| usual_tolerance(&body.mesh.vertices, moving));
    let mut bodies = body.separate();
    for (part, (_, mesh, tags)) in body.parts.iter().zip(&mut bodies) {
        let own = moving.iter().filter(|facet| part.vertices.contains(&facet[0]));
        let own: Vec<_> = own.map(|f| f.map(|v| v - part.vertices.start)).collect();
        if own.is_empty() {
            continue;
        }
        let (interior, surface) = match tolerance {
            0.0 => (improve_tagged(mesh, tags, REMESH_PASSES), SurfaceReport::default()),
            _ => improve_with_surface(mesh, tags, &own, tolerance, REMESH_PASSES),
        };
        log::info!(
            "re-meshed the interior: radius ratio min {:.3} -> {:.3}, first percentile {:.3} -> \
             {:.3}",
            interior.before.radius_ratio_min,
            interior.after.radius_ratio_min,
            interior.before.radius_ratio_p1,
            interior.after.radius_ratio_p1
        );
        if surface.changed() {
            log::info!(
                "re-meshed the surface: {} edges exchanged, {} contracted, {} split, {} vertices \
                 moved; at most {:.3} mm from where it was",
                surface.flips,
                surface.collapses,
                surface.splits,
                surface.moved,
                1e3 * surface.distance
            );
        }
    }
    Ok(Body::join(bodies).cut_by(&body.cuts())?)
}
