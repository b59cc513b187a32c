//! fTetWild (Hu et al. 2020, doi:10.1145/3386569.3392385) from the Python package
//! `wildmeshing`, or from `pytetwild` where that has no wheel; both are under the MPL-2.0.
//!
//! Robust for any input; its boundary stays within an envelope of the input
//! surface and is not the input surface. The order in which it inserts triangles is
//! random; `fixed_seed.py` gives it a seed, so that the same input gives the same mesh.

use std::time::Duration;

use anyhow::Result;
use mesh::inside::WindingNumber;
use mesh::measure::diagonal;
use mesh::{SurfaceMesh, TetMesh, Vec3};
use serde_json::json;

use super::job::Job;
use super::python::Package;
use super::{Options, TetMesher};
use crate::mesher::layers::Layers;

/// The mesher.
pub struct FTetWild;

impl TetMesher for FTetWild {
    fn name(&self) -> &'static str {
        "ftetwild"
    }

    fn packages(&self) -> &'static [&'static str] {
        &["wildmeshing", "pytetwild"]
    }

    fn script(&self) -> &'static str {
        concat!(include_str!("load.py"), include_str!("fixed_seed.py"), include_str!("ftetwild.py"))
    }

    fn mesh(
        &self,
        package: &Package,
        surface: &SurfaceMesh,
        layers: &Layers,
        options: &Options,
        timeout: Duration,
    ) -> Result<TetMesh> {
        let job = Job::new("fTetWild")?;
        let (all, inside) = layers.beside(surface);
        job.put_surface(&all)?;
        let size = diagonal(&surface.vertices);
        let settings = json!({
            "package": package.name,
            "inside": inside > 0,
            // It has absolute tolerances meant for sizes near one; a power of two
            // scales without rounding.
            "scale": (1.0 / size).log2().round().exp2(),
            "edge_length": options.edge_length,
            "refine": options.refine,
            "relative_edge_length": options.edge_length / size,
            "envelope": options.envelope / size,
            "stop_energy": options.stop_energy,
            "max_iterations": options.max_iterations,
            "coarsen": options.coarsen,
            "threads": options.threads,
            "seed": options.seed,
        });
        job.run(package.python, self.script(), &settings, timeout)?;
        if job.file("unseeded").exists() {
            log::warn!("fTetWild takes no seed on this machine: another run gives another mesh");
        }
        let mesh = TetMesh { vertices: job.points("points.npy")?, tets: job.indices("tets.npy")? };
        Ok(if inside > 0 { in_body(&mesh, surface) } else { mesh })
    }
}

/// The tetrahedra whose centroids a closed surface encloses, with the vertices that they use.
fn in_body(mesh: &TetMesh, surface: &SurfaceMesh) -> TetMesh {
    let winding = WindingNumber::new(surface);
    let inside = |t: &usize| winding.contains(&(mesh.corners(*t).iter().sum::<Vec3>() / 4.0));
    let tets: Vec<[usize; 4]> = (0..mesh.tets.len()).filter(inside).map(|t| mesh.tets[t]).collect();
    mesh.with_tets(&tets)
}
