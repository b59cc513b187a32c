//! A finished run, as `solver simulate` left it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mechanics::element::{FunctionSpace, at};
use mesh::Vec3;
use mesh::io::npy;
use reports::{Simulation, Status};
use serde_json::{Value, json};

use super::Patches;

/// A displacement field on a body, and what it took to find it.
pub struct Run {
    /// Where it was read from.
    pub folder: PathBuf,
    /// Where the displacement lives.
    pub space: FunctionSpace,
    /// Vertices at rest [m].
    pub rest: Vec<Vec3>,
    /// Boundary facets as vertex ids.
    pub boundary: Vec<[usize; 3]>,
    /// Displacement [m], three components per node.
    pub u: Vec<f64>,
    /// Time from the rest shape to the equilibrium [s].
    pub time: f64,
    /// What was solved: the scene without its mesh, degree and numerical settings.
    pub problem: Value,
}

impl Run {
    /// Reads the folder of a finished `solver simulate`, and its mesh from where that found it.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("report.json");
        let report: Simulation = serde_json::from_str(&mesh::io::read_text(&path)?)
            .with_context(|| path.display().to_string())?;
        let found = Self::assemble(folder, report);
        found.with_context(|| path.display().to_string())
    }

    fn assemble(folder: &Path, report: Simulation) -> Result<Self> {
        let status = report.status;
        let end = report.end.filter(|_| status == Status::Ok);
        let end = end.with_context(|| {
            format!("status is {}, expected a run with an equilibrium", json!(status))
        })?;
        let degree = report.config["degree"].as_u64().unwrap_or(0) as usize;
        ensure!((1..=3).contains(&degree), "config.degree is {degree}: 1, 2 and 3 exist");
        let [input] = report.inputs.mesh.all() else { bail!("several meshes; expected one") };
        let mesh = mesh::io::read_tets(&input.find(folder)?)?.mesh;
        let boundary = mesh::topology::boundary(&mesh).facets;
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let file = folder.join("displacement.npy");
        let (u, shape) = npy::read_f64(&file)?;
        let nodes = space.node_count();
        ensure!(
            shape == [nodes, 3],
            "{} has shape {shape:?}, the mesh has {nodes} nodes of degree {degree}",
            file.display()
        );
        Ok(Self {
            folder: folder.to_path_buf(),
            space,
            rest: mesh.vertices,
            boundary,
            u,
            time: end.equilibrium_s,
            problem: problem(report.config),
        })
    }

    /// The boundary at rest.
    pub fn at_rest(&self) -> Patches {
        Patches::new(&self.space, &self.boundary, &self.space.node_positions(&self.rest))
    }

    /// The boundary under load.
    pub fn deformed(&self) -> Patches {
        let rest = self.space.node_positions(&self.rest);
        let places: Vec<Vec3> = rest.iter().enumerate().map(|(i, x)| x + at(&self.u, i)).collect();
        Patches::new(&self.space, &self.boundary, &places)
    }

    /// Diagonal of the bounding box at rest [m].
    pub fn diagonal(&self) -> f64 {
        mesh::measure::diagonal(&self.rest)
    }

    /// Largest displacement of a node [m].
    pub fn largest_displacement(&self) -> f64 {
        (0..self.space.node_count()).map(|i| at(&self.u, i).norm()).fold(0.0, f64::max)
    }
}

/// A scene without what may differ between runs of one problem.
fn problem(mut config: Value) -> Value {
    if let Value::Object(keys) = &mut config {
        for key in ["mesh", "degree", "quadrature", "solver"] {
            keys.remove(key);
        }
    }
    config
}
