//! `fab mold`: a tagged volume mesh → printable mold parts and `mold.json`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use mesh::SurfaceMesh;
use mesh::io::{read_tets, write_surface};

use crate::config::Config;
use crate::export::printable;
use crate::frame::Turn;
use crate::mold::{Mold, Piece};
use crate::output;
use crate::report::{CAST, FILE, Input, OUTSIDE, Report, Role};
use crate::skin::Skin;

/// Arguments of `fab mold`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tagged tetrahedral mesh (.msh) [m]
    pub mesh: PathBuf,
    /// How to mold it (mold.toml); without it, the defaults
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Folder for the parts
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// If the mesh or the configuration cannot be used, no mold can be made, or a
/// file cannot be written; then no file of a mold is left in the folder.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let config = args.config.as_deref().map_or_else(|| Config::parse(""), Config::read)?;
    let msh = read_tets(&args.mesh)?;
    let name = || args.mesh.display().to_string();
    let skin = Skin::new(&msh, &config.cavity).with_context(name)?;
    let mold = Mold::new(&skin, &config).with_context(name)?;
    let input = Input::new(&args.mesh, &args.output, &config.cavity)?;
    let set = Set::new(&mold, input, &config)?;
    for note in &set.report.findings {
        log::warn!("{}: {}", note.rule, note.message);
    }
    set.write(&args.output)?;
    log::info!(
        "{} parts, {:.2} mL of silicone, {:.1} s: {}",
        set.report.parts.len(),
        set.report.cast.silicone_ml,
        start.elapsed().as_secs_f64(),
        args.output.display()
    );
    Ok(())
}

/// A mold as it is written.
struct Set {
    surfaces: Vec<SurfaceMesh>,
    report: Report,
}

impl Set {
    fn new(mold: &Mold, input: Input, config: &Config) -> Result<Self> {
        let upright = Turn::lowering(-mesh::Vec3::z());
        let cast = printable(CAST, &mold.cast, upright)?;
        let mut report = Report::new(mold, input, config, &cast);
        let mut surfaces = Vec::new();
        let mut add = |piece: &Piece, role: Role| -> Result<()> {
            // Printed as it leaves the mold downward: its outside on the printer's bed.
            let turn = Turn::lowering(piece.leaves);
            let surface = printable(&piece.name, &piece.solid, turn)?;
            report.add_part(piece, role, turn, &surface);
            surfaces.push(surface);
            Ok(())
        };
        mold.shells.iter().try_for_each(|piece| add(piece, Role::Shell))?;
        mold.cores.iter().try_for_each(|piece| add(piece, Role::Core))?;
        surfaces.push(cast);
        surfaces.push(printable(OUTSIDE, &mold.outside, upright)?);
        Ok(Self { surfaces, report })
    }

    /// Replaces the mold in `folder`; the report comes last and vouches for the rest.
    fn write(&self, folder: &Path) -> Result<()> {
        if let Ok(old) = Report::read(folder) {
            remove(folder, &old)?;
        }
        let written = self
            .report
            .files()
            .zip(&self.surfaces)
            .try_for_each(|(file, surface)| write_surface(&folder.join(file), surface))
            .and_then(|()| output::write(folder, &self.report, &self.surfaces))
            .and_then(|()| self.report.write(folder));
        if let Err(error) = written {
            // The first error is the one to tell.
            let _ = remove(folder, &self.report);
            return Err(error.into());
        }
        Ok(())
    }
}

/// Removes the files of a mold.
fn remove(folder: &Path, report: &Report) -> Result<()> {
    let others = output::files(report);
    let others = others.iter().map(String::as_str);
    for file in [FILE].into_iter().chain(report.files()).chain(others) {
        let path = folder.join(file);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(e).with_context(|| format!("{}: cannot remove", path.display()));
            }
            _ => {}
        }
    }
    Ok(())
}
