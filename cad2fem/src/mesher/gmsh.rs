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
use mesh::io::read_bytes;
use mesh::{SurfaceMesh, TetMesh};
use serde_json::json;

use super::job::Job;
use super::python::Python;
use super::{Options, TetMesher};
use crate::geo::without_reach;

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
/// gmsh gets a copy in a folder of its own, of a script what [`without_reach`] leaves: beside a
/// file `x.step` it would run a script `x.step.opt`. With `trust` it reads the file itself.
///
/// # Errors
/// If gmsh cannot run, or cannot read or mesh the file; if it is a script that reaches outside.
pub fn mesh_faces(
    python: &Python,
    file: &Path,
    numbers: &BTreeMap<String, f64>,
    edge_length: Option<f64>,
    trust: bool,
    timeout: Duration,
) -> Result<Faces> {
    let job = Job::new("gmsh")?;
    let opened = if trust { named_in_text(file)? } else { copied(&job, file)? };
    let settings = json!({
        "file": opened,
        "shown": file.display().to_string(),
        "numbers": numbers,
        "edge_length": edge_length,
    });
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

/// The absolute path, which has to be text to reach gmsh.
fn named_in_text(file: &Path) -> Result<String> {
    let shown = || file.display().to_string();
    let absolute = file.canonicalize().with_context(shown)?;
    let text = absolute.to_str().map(str::to_owned);
    text.with_context(|| format!("{}: its path is not UTF-8; rename it", absolute.display()))
}

/// Puts the file, a script as [`without_reach`] leaves it, into the folder of the job.
fn copied(job: &Job, file: &Path) -> Result<String> {
    let shown = || file.display().to_string();
    let is_script = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("geo"));
    let name = if is_script { "model.geo" } else { "model.step" };
    if is_script {
        let script = without_reach(&read_bytes(file)?).with_context(shown)?;
        std::fs::write(job.file(name), script).with_context(|| format!("cannot write {name}"))?;
    } else {
        std::fs::copy(file, job.file(name)).with_context(shown)?;
    }
    Ok(name.to_owned())
}
