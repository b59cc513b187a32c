//! gmsh (Geuzaine and Remacle 2009, doi:10.1002/nme.2579) from the Python package
//! `gmsh`, GPL-2.0-or-later: run as a process, never linked.
//!
//! As CAD route it meshes the faces of a `.geo` script or a STEP file. As
//! tetrahedral mesher it keeps the triangles of the input surface, so these should
//! be well shaped; it is not dependable on marching-tetrahedra surfaces.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result};
use mesh::{SurfaceMesh, TetMesh};
use serde_json::json;

use super::job::Job;
use super::python::Python;
use super::{Options, TetMesher};

/// The mesher.
pub struct Gmsh;

impl TetMesher for Gmsh {
    fn name(&self) -> &'static str {
        "gmsh"
    }

    fn package(&self) -> &'static str {
        "gmsh"
    }

    fn script(&self) -> &'static str {
        concat!(include_str!("gmsh_import.py"), include_str!("gmsh_volume.py"))
    }

    fn mesh(
        &self,
        python: &Python,
        surface: &SurfaceMesh,
        options: &Options,
        timeout: Duration,
    ) -> Result<TetMesh> {
        let job = Job::new("gmsh")?;
        job.put_surface(surface)?;
        let settings = json!({
            "threads": options.threads,
            "edge_length": options.edge_length,
            "refine": options.refine,
        });
        job.run(python, self.script(), &settings, timeout)?;
        Ok(TetMesh { vertices: job.points("points.npy")?, tets: job.indices("tets.npy")? })
    }
}

/// The meshed faces of a CAD file, in the file's unit, as gmsh orients them.
pub struct Faces {
    /// All faces; metres for STEP, the script's unit for `.geo`.
    pub surface: SurfaceMesh,
    /// Patch names.
    pub names: Vec<String>,
    /// For each triangle its patch.
    pub patch: Vec<Option<usize>>,
}

/// Meshes the faces of a CAD file with `numbers` set in a script, and no edge
/// longer than `edge_length` if given [unit of the result].
///
/// # Errors
/// If gmsh cannot run, or cannot read or mesh the file.
pub fn mesh_faces(
    python: &Python,
    file: &Path,
    numbers: &BTreeMap<String, f64>,
    edge_length: Option<f64>,
    timeout: Duration,
) -> Result<Faces> {
    let job = Job::new("gmsh")?;
    let file = file.canonicalize().with_context(|| file.display().to_string())?;
    let settings = json!({ "file": file, "numbers": numbers, "edge_length": edge_length });
    let script = concat!(include_str!("gmsh_import.py"), include_str!("gmsh_surface.py"));
    job.run(python, script, &settings, timeout)?;
    let names = std::fs::read_to_string(job.file("patches.json"))?;
    let patch = mesh::io::npy::read_f64(&job.file("patch.npy"))?.0;
    Ok(Faces {
        surface: SurfaceMesh {
            vertices: job.points("points.npy")?,
            triangles: job.indices("triangles.npy")?,
        },
        names: serde_json::from_str(&names)?,
        patch: patch.into_iter().map(|p| (p >= 0.0).then_some(p as usize)).collect(),
    })
}
