//! `solver import`: scenes of PolyFEM translated to ours.

use std::path::PathBuf;

use anyhow::Result;
use polyfem::{self, Options};
use scene::config::ContactForm;

/// Translate a scene of PolyFEM (JSON) into a folder with sim.toml
///
/// Every key that has no part in it is named in a warning with the reason; import.report.json
/// lists them all.
#[derive(clap::Args)]
pub struct Arguments {
    /// A state_*.json
    scene: PathBuf,
    /// Folder for sim.toml and the tagged meshes
    #[arg(short)]
    output: PathBuf,
    /// Form of the contact potential, whatever the file says: convergent (weighted by areas), even (by areas, nearly all of
    /// it by vertices and triangles) or plain (every pair alike)
    #[arg(long, value_parser = form)]
    form: Option<ContactForm>,
    /// Thickness of the slabs that a plane scene becomes [m]; a tenth of the mean
    /// edge of its finest body if not given
    #[arg(long)]
    thickness: Option<f64>,
}

fn form(text: &str) -> Result<ContactForm, String> {
    match text {
        "convergent" => Ok(ContactForm::Convergent),
        "even" => Ok(ContactForm::Even),
        "plain" => Ok(ContactForm::Plain),
        _ => Err("expected convergent, even or plain".to_owned()),
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let options = Options { form: arguments.form, thickness: arguments.thickness };
    let imported = polyfem::read(&arguments.scene, &options)?;
    for warning in imported.warnings() {
        log::warn!("{warning}");
    }
    imported.write(&arguments.output)?;
    log::info!("wrote {}", arguments.output.join("sim.toml").display());
    Ok(())
}
