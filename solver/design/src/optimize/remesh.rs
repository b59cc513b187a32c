//! Meshes of a cascade with their elements made better.

use anyhow::Result;
use mechanics::body::Body;
use mesh::improve::{SurfaceReport, improve_tagged, improve_with_surface, usual_tolerance};

/// Passes of the interior re-meshing.
const REMESH_PASSES: usize = 10;

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
