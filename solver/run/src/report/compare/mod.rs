//! How far runs of one body on several meshes are from a reference.
//!
//! Two measures. The Hausdorff distance of the deformed boundaries is what an
//! observer sees; it includes the facets of the rest shapes, wherever these
//! differ. The difference of the displacement fields at rest points that both
//! bodies have is free of facets.

mod field;
mod run;
mod surface;

use serde::Serialize;

pub use field::{Difference, difference};
pub use run::Run;
pub use surface::{Distance, Patches, hausdorff};

/// A run against the reference. Lengths [m], times [s].
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Folder of the run.
    pub run: String,
    /// Degree of the displacement.
    pub degree: usize,
    /// Number of tetrahedra.
    pub tets: usize,
    /// Degrees of freedom.
    pub dofs: usize,
    /// Time from the rest shape to the equilibrium.
    pub time_s: f64,
    /// Between the deformed boundaries.
    pub surface: Distance,
    /// Between the boundaries at rest: what is due to their facets.
    pub surface_at_rest: Distance,
    /// Between the displacement fields.
    pub displacement: Difference,
}

impl Comparison {
    /// Compares a run with the reference; boundaries are sampled with a
    /// `spacing` [m].
    pub fn new(reference: &Run, run: &Run, spacing: f64) -> Self {
        let [theirs, ours] = [reference, run].map(|r| [r.deformed(), r.at_rest()]);
        Self {
            run: run.folder.display().to_string(),
            degree: run.space.degree(),
            tets: run.space.tets().len(),
            dofs: 3 * run.space.node_count(),
            time_s: run.time,
            surface: hausdorff(&theirs[0], &ours[0], spacing),
            surface_at_rest: hausdorff(&theirs[1], &ours[1], spacing),
            displacement: difference(reference, run),
        }
    }
}
