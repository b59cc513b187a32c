//! gmsh (Geuzaine and Remacle 2009, doi:10.1002/nme.2579) from the Python package
//! `gmsh`, GPL-2.0-or-later: run as a process, never linked.
//!
//! As CAD route it meshes the faces of a `.geo` script or a STEP file. As
//! tetrahedral mesher it keeps the triangles of the input surface, so these should
//! be well shaped; it is not dependable on marching-tetrahedra surfaces.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use mesh::io::{read_bytes, read_own_text};
use mesh::{SurfaceMesh, TetMesh};
use program::units::Unit;
use serde::Deserialize;
use serde_json::json;

use super::job::Job;
use super::python::{Package, Python};
use super::{Options, TetMesher};
use crate::mesher::layers::{Layers, require_conforming};
use crate::mesher::script::without_reach;

/// The mesher.
pub struct Gmsh;

impl TetMesher for Gmsh {
    fn name(&self) -> &'static str {
        "gmsh"
    }

    fn keeps_triangles(&self) -> bool {
        true
    }

    fn packages(&self) -> &'static [&'static str] {
        &["gmsh"]
    }

    fn script(&self) -> &'static str {
        concat!(include_str!("gmsh_import.py"), include_str!("gmsh_volume.py"))
    }

    fn mesh(
        &self,
        package: &Package,
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
        job.run(package.python, self.script(), &settings, timeout)?;
        Ok(TetMesh { vertices: job.points("points.npy")?, tets: job.indices("tets.npy")? })
    }
}

/// What gmsh can open as CAD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A script of gmsh, `.geo`.
    Script,
    /// STEP, which states its unit.
    Step,
    /// OpenCASCADE's own format, without a unit.
    Brep,
    /// IGES, which states its unit and often has surfaces only.
    Iges,
}

impl Kind {
    /// By the extension of a file name.
    pub fn of(file: &Path) -> Result<Self> {
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "geo" => Ok(Self::Script),
            "step" | "stp" => Ok(Self::Step),
            "brep" | "brp" => Ok(Self::Brep),
            "iges" | "igs" => Ok(Self::Iges),
            _ => bail!(
                "{}: neither a .geo script nor a .step, .brep or .iges file; `cad2fem import` \
                 reads .stl, .obj, .ply and .3mf",
                file.display()
            ),
        }
    }

    /// The name of a copy.
    fn name(self) -> &'static str {
        match self {
            Self::Script => "model.geo",
            Self::Step => "model.step",
            Self::Brep => "model.brep",
            Self::Iges => "model.iges",
        }
    }
}

/// The meshed faces of a CAD file, as gmsh orients them.
#[derive(Deserialize)]
pub struct Faces {
    /// All faces [m].
    #[serde(skip)]
    pub surface: SurfaceMesh,
    /// Patch names.
    pub names: Vec<String>,
    /// For each triangle its patch.
    pub patch: Vec<Option<usize>>,
    /// Whether each triangle is inside the body: between two volumes or embedded in one.
    pub inside: Vec<bool>,
    /// Names of physical volumes, and the triangles of their boundaries.
    pub volumes: Vec<(String, Vec<usize>)>,
    /// Names of the solids, and the triangles of their boundaries, if the file has several solids and no groups. A
    /// solid without a name has an empty one.
    pub solids: Vec<(String, Vec<usize>)>,
    /// What the faces of each patch are, such as `plane`; empty where they differ.
    pub kinds: Vec<String>,
    /// Patches that meet without an edge.
    pub tangent: Vec<[usize; 2]>,
    /// Largest distance of the triangles from their faces [m]; none where gmsh cannot say it.
    pub chord_error: Option<f64>,
}

/// How a CAD file is read.
#[derive(Clone, Debug)]
pub struct CadOptions {
    /// Unit of a `.geo` script or a `.brep` file; other files state their own.
    pub unit: Option<Unit>,
    /// Numbers to set in a script.
    pub numbers: BTreeMap<String, f64>,
    /// Longest edge [m].
    pub edge_length: Option<f64>,
    /// Largest distance of triangles from their faces that is wanted [m]; without it, triangles are as the file or gmsh
    /// wants them.
    pub chord: Option<f64>,
    /// Whether a script may run programs, and read and write files.
    pub trust: bool,
    /// Solids that are taken out of the others, by their names or their numbers from 1.
    pub subtract: Vec<String>,
    /// Longest time gmsh may take.
    pub timeout: Duration,
}

impl CadOptions {
    /// Metres per unit of what gmsh returns, and the unit that it is asked for: files that a script
    /// reads come in the unit of its numbers. What is to follow the faces comes in millimetres, in which OpenCASCADE's
    /// tolerances are meant.
    fn scale(&self, path: &Path) -> Result<(f64, Option<String>)> {
        match (Kind::of(path)?, self.unit) {
            (Kind::Script | Kind::Brep, Some(unit)) => Ok((unit.metres(), Some(unit.of_cad()))),
            (Kind::Script, None) => {
                bail!("{}: a .geo script has no unit; say --unit mm", path.display())
            }
            (Kind::Brep, None) => {
                bail!("{}: a .brep file has no unit; say --unit mm", path.display())
            }
            (Kind::Step, None) if self.chord.is_some() => {
                Ok((Unit::Mm.metres(), Some(Unit::Mm.of_cad())))
            }
            (Kind::Step, None) => Ok((1.0, Some(Unit::M.of_cad()))),
            (Kind::Iges, None) => Ok((Unit::Mm.metres(), None)),
            (Kind::Step | Kind::Iges, Some(_)) => {
                bail!("{}: a STEP or IGES file states its unit; leave out --unit", path.display())
            }
        }
    }
}

/// Meshes the faces of a CAD file.
///
/// gmsh gets a copy in a folder of its own, of a script what [`without_reach`] leaves: beside a
/// file `x.step` it would run a script `x.step.opt`. With `trust` it reads the file itself.
pub fn mesh_faces(file: &Path, options: &CadOptions) -> Result<Faces> {
    let (kind, (metres, unit)) = (Kind::of(file)?, options.scale(file)?);
    let (python, job) = (Python::find()?, Job::new("gmsh")?);
    let opened = if options.trust { named_in_text(file)? } else { copied(&job, file, kind)? };
    let settings = json!({
        "file": opened,
        "shown": file.display().to_string(),
        "numbers": options.numbers,
        "unit": unit,
        "edge_length": options.edge_length.map(|h| h / metres),
        "chord": options.chord.map(|chord| chord / metres),
        "metres": metres,
        "solids": kind != Kind::Script,
        "step": kind == Kind::Step,
        "subtract": options.subtract,
    });
    let script = concat!(
        include_str!("gmsh_import.py"),
        include_str!("gmsh_chord.py"),
        include_str!("gmsh_surface.py")
    );
    job.run(&python, script, &settings, options.timeout)?;
    let mut faces: Faces = serde_json::from_str(&read_own_text(&job.file("faces.json"))?)?;
    let vertices = job.points("points.npy")?.into_iter().map(|p| p * metres).collect();
    faces.surface = SurfaceMesh { vertices, triangles: job.indices("triangles.npy")? };
    faces.chord_error = faces.chord_error.map(|error| error * metres);
    Ok(faces)
}

/// The absolute path, which has to be text to reach gmsh.
fn named_in_text(file: &Path) -> Result<String> {
    let shown = || file.display().to_string();
    let absolute = system::canonical(file).with_context(shown)?;
    let text = absolute.to_str().map(str::to_owned);
    text.with_context(|| format!("{}: its path is not UTF-8; rename it", absolute.display()))
}

/// Puts the file, a script as [`without_reach`] leaves it, into the folder of the job.
fn copied(job: &Job, file: &Path, kind: Kind) -> Result<String> {
    let shown = || file.display().to_string();
    let name = kind.name();
    let bytes = read_bytes(file)?;
    let content =
        if kind == Kind::Script { without_reach(&bytes).with_context(shown)? } else { bytes };
    job.put(name, &content)?;
    Ok(name.to_owned())
}
