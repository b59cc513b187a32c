//! One page of HTML for all that the programs have left in a folder.
//!
//! The page is one file that needs neither a server nor a network: geometry is quantised,
//! compressed and written into it, and so is three.js, which draws it. What can be read
//! without drawing (tables, checks, the casting sheet, pictures) is plain HTML and needs no
//! script at all.
//!
//! Only files are read, those that users see: this crate knows no solver and no molds.

pub mod contents;
pub mod design;
pub mod document;
pub mod facts;
pub mod mold;
pub mod pick;
pub mod prose;
pub mod reported;
pub mod run;
pub mod script;
pub mod solid;
pub mod store;
pub mod survey;
pub mod threads;
pub mod validation;
pub mod wall;

use std::path::Path;

use anyhow::Result;
use mesh::io::write_atomic;
use serde_json::json;

use store::Store;
use survey::Survey;

/// What went into a page.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// Simulations, optimisations and molds.
    pub parts: [usize; 3],
    /// Size of the page [bytes].
    pub bytes: usize,
}

/// Which states and shapes a page has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// The states of all steps, and the shapes of all levels.
    All,
    /// The last of each simulation and of each optimisation: a page for mail.
    Last,
}

/// Writes the page of `folder` to `output`; `title` stands at its top.
pub fn write(folder: &Path, output: &Path, title: &str, shown: Shown) -> Result<Summary> {
    let survey = Survey::of(folder)?;
    let mut store = Store::default();
    let walls = wall::all(&survey);
    let runs = run::all(&survey, &walls, shown, &mut store)?;
    let mut designs = Vec::new();
    for found in &survey.designs {
        designs.push(design::packed(found, shown, &mut store)?);
    }
    let mut molds = Vec::new();
    for found in &survey.molds {
        molds.extend(mold::packed(found, &walls, &mut store)?);
    }
    let parts = [runs.len(), designs.len(), molds.len()];
    let data = json!({ "title": title, "runs": runs, "designs": designs, "molds": molds });
    let page = document::assemble(title, &survey, shown, &data, &store, output)?;
    write_atomic(output, |out| out.write_all(page.as_bytes()))?;
    Ok(Summary { parts, bytes: page.len() })
}
