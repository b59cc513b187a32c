//! `solver compare`: runs on several meshes against a reference.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use program::Unusable;
use serde_json::json;

use run::report::compare::{Comparison, Run};

/// Spacings to the diagonal of the body, unless another is asked for.
const SPACINGS: f64 = 200.0;

/// Compare runs of one body on several meshes with a reference
///
/// All are folders of simulate. Writes for each run its degrees of freedom, the
/// time to its equilibrium, the Hausdorff distance of its deformed boundary from
/// the reference's, the same at rest, and the difference of the displacements.
#[derive(clap::Args)]
pub struct Arguments {
    /// The most accurate run
    reference: PathBuf,
    /// Runs to compare with it
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// JSON file to write
    #[arg(short, long)]
    output: PathBuf,
    /// Largest edge of the triangles that boundaries are divided into [m]; 1/200
    /// of the reference's diagonal if not given
    #[arg(long)]
    spacing: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let reference = Run::read(&arguments.reference)?;
    let spacing = arguments.spacing.unwrap_or(reference.diagonal() / SPACINGS);
    ensure!(
        spacing > 1e-5 * reference.diagonal() && spacing.is_finite(),
        "--spacing is {spacing} m: expected a length of at least {:.0e} m, 1e-5 of the diagonal",
        1e-5 * reference.diagonal()
    );
    let mut rows: Vec<Comparison> = Vec::new();
    for folder in &arguments.runs {
        let run = Run::read(folder)?;
        if run.problem != reference.problem {
            log::warn!(
                "{} has another material, support or load than {}",
                folder.display(),
                arguments.reference.display()
            );
        }
        let row = Comparison::new(&reference, &run, spacing);
        if row.displacement.volume_share == 0.0 {
            let message = format!(
                "{} and {} have no rest point in common",
                folder.display(),
                arguments.reference.display()
            );
            return Err(Unusable(message).into());
        }
        log::info!("{}", line(&row));
        rows.push(row);
    }
    let report = json!({
        "program": scene::PROGRAM,
        "reference": {
            "run": arguments.reference,
            "degree": reference.space.degree(),
            "tets": reference.space.tets().len(),
            "dofs": 3 * reference.space.node_count(),
            "time_s": reference.time,
            "largest_displacement": reference.largest_displacement(),
            "diagonal": reference.diagonal(),
        },
        "spacing": spacing,
        "runs": rows,
    });
    program::write_json(&arguments.output, &report)
}

fn line(row: &Comparison) -> String {
    format!(
        "{}: P{}, {} dofs, {:.2} s, Hausdorff {:.3e} m (at rest {:.1e} m, coarser sampling {:+.1} %), \
         displacement {:.3e} m at most, rms {:.3e} m",
        row.run,
        row.degree,
        row.dofs,
        row.time_s,
        row.surface.hausdorff,
        row.surface_at_rest.hausdorff,
        100.0 * (row.surface.coarser / row.surface.hausdorff.max(f64::MIN_POSITIVE) - 1.0),
        row.displacement.max,
        row.displacement.rms,
    )
}
