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
use crate::layers::{Layers, require_conforming};

/// The mesher.
pub struct Gmsh;

impl TetMesher for Gmsh {
    fn name(&self) -> &'static str {
        "gmsh"
    }

    fn package(&self) -> &'static str {
        "gmsh"
    }

    fn script(&self, _inside: bool) -> &'static str {
        concat!(include_str!("gmsh_import.py"), include_str!("gmsh_volume.py"))
    }

    fn mesh(
        &self,
        python: &Python,
        surface: &SurfaceMesh,
        layers: &Layers,
        options: &Options,
        timeout: Duration,
    ) -> Result<TetMesh> {
        let job = Job::new("gmsh")?;
        let (all, inside) = layers.beside(surface);
        if inside > 0 {
            require_conforming(&all)?;
        }
        job.put_surface(&all)?;
        let settings = json!({
            "inside": inside,
            "threads": options.threads,
            "edge_length": options.edge_length,
            "refine": options.refine,
        });
        job.run(python, self.script(inside > 0), &settings, timeout)?;
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
    /// Whether each triangle is inside the body: between two volumes or embedded in one.
    pub inside: Vec<bool>,
    /// Names of physical volumes, and the triangles of their boundaries.
    pub volumes: Vec<(String, Vec<usize>)>,
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
    let names = |file: &str| -> Result<Vec<String>> {
        Ok(serde_json::from_str(&std::fs::read_to_string(job.file(file))?)?)
    };
    let column =
        |file: &str| -> Result<Vec<f64>> { Ok(mesh::io::npy::read_f64(&job.file(file))?.0) };
    let triangles_of = |(i, name): (usize, String)| {
        let rows = column(&format!("volume-{i}.npy"))?;
        Ok((name, rows.into_iter().map(|row| row as usize).collect()))
    };
    let volumes = names("volumes.json")?.into_iter().enumerate().map(triangles_of);
    Ok(Faces {
        surface: SurfaceMesh {
            vertices: job.points("points.npy")?,
            triangles: job.indices("triangles.npy")?,
        },
        names: names("patches.json")?,
        patch: column("patch.npy")?.into_iter().map(|p| (p >= 0.0).then_some(p as usize)).collect(),
        inside: column("inside.npy")?.into_iter().map(|flag| flag > 0.0).collect(),
        volumes: volumes.collect::<Result<_>>()?,
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
