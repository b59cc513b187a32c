//! `fab plan`: how a body is to be molded, and why.

use std::path::PathBuf;

use anyhow::{Context, Result};
use mesh::io::read_tets;

use crate::collar;
use crate::config::Config;
use crate::plan::Plan;
use crate::plan::report::{Entry, Material, Report};
use crate::progress::Progress;
use crate::report::{CastPart, Input};
use crate::skin::Skin;

/// Arguments of `fab plan`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tagged tetrahedral mesh (.msh) [m]
    pub mesh: PathBuf,
    /// What is asked for (mold.toml); without it, what is measured decides
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Folder for plan.json
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// If the mesh or the configuration cannot be used, the body cannot be molded, or
/// plan.json cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let config = args.config.as_deref().map_or_else(|| Config::parse(""), Config::read)?;
    let name = || args.mesh.display().to_string();
    let skin = Skin::new(&read_tets(&args.mesh)?, &config.cavity).with_context(name)?;
    let progress = Progress::new(skin.cast.triangles.len());
    progress.step(&format!("measuring a body of {} triangles", skin.cast.triangles.len()));
    let (skin, _) = collar::fit(skin, &config).with_context(name)?;
    let plan = Plan::new(&skin, &config).with_context(name)?;
    let input = Input::new(&args.mesh, &args.output, &config.cavity, CastPart::Whole)?;
    let cores = skin.cores.len();
    let report = Report::new(&plan, input, entries(&plan, cores));
    report.write(&args.output)?;
    log::info!("{}", plan.reason);
    Ok(())
}

/// The molds of a plan, cores of wax first.
#[must_use]
pub fn entries(plan: &Plan, cores: usize) -> Vec<Entry> {
    let mut entries = Vec::new();
    if plan.method == crate::method::Method::Wax {
        for i in 0..cores {
            let name = if cores == 1 { "core".into() } else { format!("core{}", i + 1) };
            entries.push(Entry { folder: format!("{name}-mold"), name, casts: Material::Wax });
        }
    }
    let single = entries.is_empty() && plan.castings.len() == 1;
    entries.extend(plan.castings.iter().map(|casting| Entry {
        folder: if single { ".".into() } else { format!("{}-mold", casting.name) },
        name: casting.name.clone(),
        casts: Material::Silicone,
    }));
    entries
}
