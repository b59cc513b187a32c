//! The page on which a person names faces of a body by clicking, and gets `tags.toml`.
//!
//! - [`body`]: faces of a folder that `cad2fem model` or `cad2fem import` wrote, and where they meet
//! - [`found`]: what the page proposes: chambers, flat sides, planes in which the body mirrors itself
//! - [`document`]: the page from its parts

pub mod body;
pub mod document;
pub mod found;

use std::path::Path;

use anyhow::Result;
use mesh::io::write_atomic;
use serde_json::json;

use crate::store::Store;
use body::Body;

/// Metres to millimetres, the unit of the page.
pub(crate) const MM: f64 = 1e3;

/// What went into a page.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// Faces that can be chosen.
    pub faces: usize,
    /// Closed chambers that are proposed.
    pub chambers: usize,
    /// Size of the page [bytes].
    pub bytes: usize,
}

/// Writes the page of a folder with `model.json`, `model.stl` and `patches` to `output`; `title`, by
/// default the name of the file that was modelled, stands at its top.
///
/// # Errors
/// If the folder is not complete, its files do not belong together, or the page cannot be written.
pub fn write(folder: &Path, output: &Path, title: Option<&str>) -> Result<Summary> {
    let body = Body::read(folder)?;
    let title = title.unwrap_or(&body.source);
    let mut store = Store::default();
    let found = found::of(&body);
    let chambers = found["chambers"].as_array().map_or(0, Vec::len);
    let data = json!({
        "title": title,
        "folder": folder.display().to_string(),
        "body": body.packed(&mut store),
        "found": found,
    });
    let page = document::assemble(title, &data, &store);
    write_atomic(output, |out| out.write_all(page.as_bytes()))?;
    let faces = body.faces.iter().filter(|face| face.file.is_some()).count();
    Ok(Summary { faces, chambers, bytes: page.len() })
}
