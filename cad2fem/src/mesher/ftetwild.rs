//! fTetWild (Hu et al. 2020, doi:10.1145/3386569.3392385) from the Python package
//! `wildmeshing`, MPL-2.0.
//!
//! Robust for any input; its boundary stays within an envelope of the input
//! surface and is not the input surface. Not deterministic: the order in which it
//! inserts triangles is random.

use std::time::Duration;

use anyhow::Result;
use mesh::measure::diagonal;
use mesh::{SurfaceMesh, TetMesh};
use serde_json::json;

use super::job::Job;
use super::python::Python;
use super::{Options, TetMesher};

/// The mesher.
pub struct FTetWild;

impl TetMesher for FTetWild {
    fn name(&self) -> &'static str {
        "ftetwild"
    }

    fn package(&self) -> &'static str {
        "wildmeshing"
    }

    fn script(&self) -> &'static str {
        include_str!("ftetwild.py")
    }

    fn mesh(
        &self,
        python: &Python,
        surface: &SurfaceMesh,
        options: &Options,
        timeout: Duration,
    ) -> Result<TetMesh> {
        let job = Job::new("fTetWild")?;
        job.put_surface(surface)?;
        let size = diagonal(&surface.vertices);
        let settings = json!({
            // It has absolute tolerances meant for sizes near one; a power of two
            // scales without rounding.
            "scale": (1.0 / size).log2().round().exp2(),
            "edge_length": options.edge_length,
            "refine": options.refine,
            "edge_length_r": options.edge_length / size,
            "epsilon": options.envelope / size,
            "stop_quality": options.stop_energy,
            "max_its": options.max_iterations,
            "coarsen": options.coarsen,
            "max_threads": options.threads,
        });
        job.run(python, self.script(), &settings, timeout)?;
        Ok(TetMesh { vertices: job.points("points.npy")?, tets: job.indices("tets.npy")? })
    }
}
