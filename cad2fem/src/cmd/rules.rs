//! `cad2fem rules`: what the Makefile of a body includes.

use std::io::Write as _;

use anyhow::{Context, Result, ensure};

use crate::installation::{SPECIAL, rules};

/// Prints the path of the rules for make that belong to this program; the Makefile of a body includes them
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the verb.
pub fn run(_: &Args) -> Result<()> {
    let rules = rules().context(
        "there are no rules for make beside this program (share/puffer/folder.mk) and it lies in no checkout: \
         pip install softpuffer, or use the program of a checkout",
    )?;
    let path = rules.display().to_string();
    let special = path.chars().find(|c| SPECIAL.contains(*c));
    ensure!(
        special.is_none(),
        "{path}: make takes the {:?} in it for its own: install the programs into a folder whose path has letters, \
         digits, - . _ and / alone",
        special.unwrap_or_default()
    );
    writeln!(program::stdout(), "{path}").context("standard output")
}
