//! `fab mold`: a tagged volume mesh → printable mold parts and `mold.json`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use mesh::io::{remove_litter, remove_output, write_surface};
use mesh::{SurfaceMesh, Vec3};
use program::{FolderLock, Progress, Unusable, peak_rss_mb};

use super::proof::{MoldFiles, proved};
use super::{Planned, Task};
use crate::body::boundary::Boundary;
use crate::body::layer::Layer;
use crate::body::orientation::Portion;
use crate::body::source::{CastPart, Input};
use crate::config::method::Method;
use crate::config::{Config, SprueConfig};
use crate::files::attempt;
use crate::files::output;
use crate::files::page;
use crate::files::report::{FILE, MoldReport};
use crate::geometry::MM;
use crate::mold::Mold;
use crate::plan::report::{Entry, Material};
use crate::plan::{self, Casting};
use crate::verify::Against;

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

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let folder = &args.task.output;
    // A folder without molds is not made before the input is known to be good.
    let lock = || FolderLock::new(folder);
    let older = attempt::holds_mold(folder).then(lock).transpose()?;
    if older.is_some() {
        attempt::begin(folder, &args.task.asked())?;
    }
    let made = args.task.plan().and_then(|planned| {
        let _new = older.is_none().then(lock).transpose()?;
        make(args, planned, start)
    });
    if made.is_err() && older.is_some() && attempt::holds_mold(folder) {
        log::warn!(
            "{}: an older mold is still there; fab verify refuses it as long as {} is there, too",
            folder.display(),
            attempt::FILE
        );
        return made;
    }
    let ended = attempt::end(folder);
    made.and(ended.map_err(Into::into))
}

/// Makes the molds and replaces older ones by them.
fn make(args: &Args, planned: Planned, start: Instant) -> Result<()> {
    let task = &args.task;
    let (planned, molds) = proved(task, planned)?;
    let Planned { config, layers, report: planned, progress, .. } = planned;
    let folder = |entry: &Entry| task.output.join(&entry.folder);
    for entry in &planned.molds {
        remove_litter(&folder(entry));
        remove_litter(&folder(entry).join("reference"));
    }
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
    progress.step("writing");
    remove_old(&task.output)?;
    let written = write_all(&molds, &folder, &planned, &config, args, progress);
    if let Err(error) = written {
        // Only the first error is reported.
        let _ = remove_molds(&task.output, &planned);
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

/// Writes the molds of silicone, those of cores that are cast of wax, and the plan.
fn write_all(
    molds: &[(Entry, MoldFiles)],
    folder: &impl Fn(&Entry) -> PathBuf,
    planned: &plan::report::PlanReport,
    config: &Config,
    args: &Args,
    progress: Progress,
) -> Result<()> {
    let pictures = !args.task.no_pictures;
    for (entry, files) in molds {
        files.write(&folder(entry), pictures)?;
    }
    for entry in planned.molds.iter().filter(|entry| entry.casts == Material::Wax) {
        let (body, files) = molds.first().expect("a body is cast around the core");
        let file = format!("{}.stl", entry.name);
        let file = folder(body).join(file);
        let mold =
            wax_mold(&file, files.surface(&entry.name), &folder(entry), planned.method, config)?;
        let against = Against { design: Some(&file), ..Against::default() };
        mold.prove(&entry.name, against, planned, progress)?;
        mold.write(&folder(entry), pictures)?;
    }
    let mesh = args.task.mesh.file_stem().unwrap_or_default().to_string_lossy();
    page::write(&args.task.output, planned, args.title.as_deref().unwrap_or(&mesh))?;
    planned.write(&args.task.output)?;
    Ok(())
}

/// The mold of a core, given by its file and surface [mm]. It stands with its stub up,
/// through which the wax is poured.
fn wax_mold(
    file: &Path,
    core: &SurfaceMesh,
    folder: &Path,
    method: Method,
    config: &Config,
) -> Result<MoldFiles> {
    let vertices = core.vertices.iter().map(|p| p / MM).collect();
    let surface = SurfaceMesh { vertices, triangles: core.triangles.clone() };
    let boundary = Boundary::of_surface(surface)?;
    let config = Config {
        shrinkage: Some(0.0),
        parting: Config::default().parting,
        fitting: None,
        sprue: SprueConfig { at: None, ..config.sprue.clone() },
        ..config.clone()
    };
    let casting = Casting::new("core", &boundary.filled, -Vec3::z(), Portion::Whole, &config)?;
    let mold = Mold::new(&boundary, &casting.orientation, method, &config)?;
    let input = Input::new(file, folder, &config.chamber, CastPart::Core)?;
    MoldFiles::new(&mold, input, &config)
}

/// Removes the molds of an earlier plan.
fn remove_old(output: &Path) -> Result<()> {
    if let Ok(old) = plan::report::PlanReport::read(output) {
        remove_molds(output, &old)?;
    }
    Ok(())
}

/// Removes the molds of a plan, and the plan.
fn remove_molds(output: &Path, plan: &plan::report::PlanReport) -> Result<()> {
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
    Ok(remove_output(&output.join(plan::report::FILE))?)
}

impl MoldFiles {
    /// The written surface of a part [mm].
    fn surface(&self, name: &str) -> &SurfaceMesh {
        let index = self.report.parts.iter().position(|part| part.name == name);
        &self.surfaces[index.expect("a core has its name")]
    }

    /// Replaces the mold in `folder`; the report comes last and vouches for the rest.
    fn write(&self, folder: &Path, pictures: bool) -> Result<()> {
        if let Ok(old) = MoldReport::read(folder) {
            remove(folder, &old)?;
        }
        let written = self
            .report
            .files()
            .zip(&self.surfaces)
            .try_for_each(|(file, surface)| write_surface(&folder.join(file), surface))
            .and_then(|()| output::write(folder, &self.report, &self.surfaces))
            .and_then(|()| match pictures {
                true => output::draw(folder, &self.report, &self.surfaces),
                false => Ok(()),
            })
            .and_then(|()| self.report.write(folder));
        if let Err(error) = written {
            // Only the first error is reported.
            let _ = remove(folder, &self.report);
            return Err(error.into());
        }
        Ok(())
    }
}

/// Removes the files of a mold.
fn remove(folder: &Path, report: &MoldReport) -> Result<()> {
    let others = output::files(report);
    let others = others.iter().map(String::as_str);
    let mut all = [FILE].into_iter().chain(report.files()).chain(others);
    Ok(all.try_for_each(|file| remove_output(&folder.join(file)))?)
}
