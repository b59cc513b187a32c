//! `solver export`: a scene as an input deck of another finite-element program.

use std::path::PathBuf;

use anyhow::Result;

use super::SceneArguments;
use crate::export::{Deck, format_of};

/// Write a scene and its mesh as an input deck for CalculiX or FEBio
///
/// The ending of OUT says for which: .inp for CalculiX, .feb for FEBio 4. Nodes have the order of nodes.npy and
/// displacement.npy of `solver simulate`. What the other program cannot say is refused with its key, and where its
/// law has another energy, the deck and a warning say which.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    of: SceneArguments,
    /// The deck: OUT.inp or OUT.feb
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let format = format_of(&arguments.output)?;
    let scene = arguments.of.read()?;
    let deck = Deck::new(&scene)?;
    let text = scene.file.checked(|_| deck.text(format))?;
    mesh::io::write_atomic(&arguments.output, |out| out.write_all(text.as_bytes()))?;
    let (name, program) = (arguments.output.display(), format.program);
    log::info!("{name}: {} elements for {program}", scene.body.mesh.tets.len());
    Ok(())
}
