//! Meshes of a design on disk.

use std::path::Path;

use anyhow::Result;
use mechanics::body::Body;
use scene::Scene;

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
