//! `fab mold`: a tagged volume mesh → printable mold parts and `mold.json`.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use mesh::io::{remove_litter, remove_output, write_surface};
use program::{FolderLock, Unusable, peak_rss_mb};

use super::proof::{MoldFiles, proved};
use super::{Planned, Task};
use crate::body::layer::Layer;
use crate::files::output;
use crate::files::page;
use crate::files::report::{FILE, MoldReport};
use crate::plan::Plan;
use crate::plan::report::{Entry, FILE as PLAN, PlanReport};

/// Arguments of `fab mold`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What is to be molded, and where to
    #[command(flatten)]
    pub task: Task,
    /// Name of the body on the sheet for casting, cast.html [default: that of the mesh]
    #[arg(long)]
    pub title: Option<String>,
}

/// Runs the verb: makes the molds and replaces older ones by them.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let task = &args.task;
    let (planned, molds) =
        task.plan().and_then(|planned| proved(task, planned)).inspect_err(|_| {
            if PlanReport::read(&task.output).is_ok() {
                log::warn!("{}: an older mold is still there", task.output.display());
            }
        })?;
    let Planned { layers, plan: Plan { report: planned, .. }, .. } = planned;
    let laid = |layer: &&Layer| {
        molds.iter().any(|(_, files)| files.report.layers.iter().any(|one| one.tag == layer.tag))
    };
    if let Some(layer) = layers.iter().find(|layer| !laid(layer)) {
        let message = format!(
            "layers: {:?} lies in none of the castings, but where they are glued: lay it in there, and \
             leave it out of `layers`",
            layer.tag
        );
        return task.named(Err(Unusable(message)));
    }
    let _lock = FolderLock::new(&task.output)?;
    remove_old(&task.output)?;
    for entry in &planned.molds {
        let folder = task.output.join(&entry.folder);
        remove_litter(&folder);
        remove_litter(&folder.join("reference"));
    }
    if let Err(error) = write_all(&molds, &planned, args) {
        // Only the first error is reported.
        for (entry, files) in &molds {
            let _ = remove(&task.output.join(&entry.folder), &files.report);
        }
        return Err(error);
    }
    for (entry, files) in &molds {
        for note in &files.report.findings {
            log::warn!("{}: {}: {}", entry.name, note.rule, note.message);
        }
    }
    let memory = peak_rss_mb().map_or(String::new(), |mb| format!(", {mb:.0} MB"));
    log::info!(
        "{} molds, {} parts, {:.2} mL of silicone, {:.1} s{memory}: {}",
        planned.molds.len(),
        molds.iter().map(|(_, files)| files.report.parts.len()).sum::<usize>(),
        molds.iter().map(|(_, files)| files.report.cast.silicone_ml).sum::<f64>(),
        start.elapsed().as_secs_f64(),
        task.output.display()
    );
    Ok(())
}

/// Writes the molds and the plan.
fn write_all(molds: &[(Entry, MoldFiles)], planned: &PlanReport, args: &Args) -> Result<()> {
    let output = &args.task.output;
    for (entry, files) in molds {
        files.write(&output.join(&entry.folder), !args.task.no_pictures)?;
    }
    let mesh = args.task.mesh.file_stem().unwrap_or_default().to_string_lossy();
    let reports = molds.iter().map(|(entry, files)| (entry, &files.report));
    page::write(output, planned, reports, args.title.as_deref().unwrap_or(&mesh))?;
    planned.write(output)
}

/// Removes the molds of an earlier plan, and the plan.
fn remove_old(output: &Path) -> Result<()> {
    let Ok(plan) = PlanReport::read(output) else { return Ok(()) };
    for entry in &plan.molds {
        let folder = output.join(&entry.folder);
        if let Ok(report) = MoldReport::read(&folder) {
            remove(&folder, &report)?;
        }
        if entry.folder != "." {
            // Folders that hold anything else stay.
            let _ = std::fs::remove_dir(folder.join("reference"));
            let _ = std::fs::remove_dir(folder);
        }
    }
    remove_output(&output.join(page::FILE))?;
    Ok(remove_output(&output.join(PLAN))?)
}

impl MoldFiles {
    /// Writes the mold into `folder`; the report comes last and vouches for the rest.
    fn write(&self, folder: &Path, pictures: bool) -> Result<()> {
        let Self { surfaces, report } = self;
        for (file, surface) in report.files().zip(surfaces) {
            write_surface(&folder.join(file), surface)?;
        }
        output::write(folder, report, surfaces)?;
        if pictures {
            output::draw(folder, report, surfaces)?;
        }
        report.write(folder)
    }
}

/// Removes the files of a mold.
fn remove(folder: &Path, report: &MoldReport) -> Result<()> {
    let others = output::files(report);
    let others = others.iter().map(String::as_str);
    let mut all = [FILE].into_iter().chain(report.files()).chain(others);
    Ok(all.try_for_each(|file| remove_output(&folder.join(file)))?)
}
