//! The page on which a person names faces of a body by clicking, and gets `tags.toml`.

pub mod body;
pub mod document;
pub mod found;
pub mod given;

use std::path::Path;

use anyhow::Result;
use mesh::io::write_atomic;
use serde_json::json;

use crate::store::Store;
use body::Body;
use given::Given;

/// Metres to millimetres, the unit of the page.
pub(crate) const MM: f64 = 1e3;

/// What went into a page.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Faces that can be chosen.
    pub faces: usize,
    /// Closed chambers that are proposed.
    pub chambers: usize,
    /// The tags with which it begins.
    pub given: Option<Given>,
    /// Size of the page [bytes].
    pub bytes: usize,
}

/// What a page is made of.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Folder with `model.json`, `model.stl` and `patches`.
    pub folder: &'a Path,
    /// A `tags.toml` with which the page begins.
    pub tags: Option<&'a Path>,
    /// What stands at the top of the page, by default the name of the file that was modelled.
    pub title: Option<&'a str>,
}

/// Writes a page to `output`.
pub fn write(source: &Source<'_>, output: &Path) -> Result<Summary> {
    let body = Body::read(source.folder)?;
    let title = source.title.unwrap_or(&body.source);
    let given = source.tags.map(|path| Given::read(path, &body)).transpose()?;
    let mut store = Store::default();
    let found = found::of(&body);
    let chambers = found["chambers"].as_array().map_or(0, Vec::len);
    let data = json!({
        "title": title,
        "folder": source.folder.display().to_string(),
        "split": body.split,
        "body": body.packed(&mut store),
        "found": found,
        "given": given,
    });
    let page = document::assemble(title, &data, &store);
    write_atomic(output, |out| out.write_all(page.as_bytes()))?;
    let faces = body.faces.iter().filter(|face| face.file.is_some()).count();
    Ok(Summary { faces, chambers, given, bytes: page.len() })
}
