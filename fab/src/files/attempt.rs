//! A note in the folder of a mold that another is to replace it. It stays if the other is not
//! made, so that nobody takes the older mold for the one that was asked for last.

use std::path::Path;

use mesh::io::{IoError, read_own_text, remove_output, write_atomic};

use super::report;
use crate::plan::report as plan;

/// Name of the note in the top folder.
pub const FILE: &str = "replacing.txt";

/// Whether there are molds in a folder.
pub fn holds_mold(folder: &Path) -> bool {
    [plan::FILE, report::FILE].iter().any(|file| folder.join(file).exists())
}

/// Notes what is to replace the molds of a folder.
pub fn begin(folder: &Path, asked: &str) -> Result<(), IoError> {
    write_atomic(&folder.join(FILE), |out| writeln!(out, "{asked}"))
}

/// Removes the note: the molds of the folder, if any, are those that were asked for.
pub fn end(folder: &Path) -> Result<(), IoError> {
    remove_output(&folder.join(FILE))
}

/// What was to replace the molds of a folder and was not made.
pub fn failed(folder: &Path) -> Result<Option<String>, IoError> {
    let path = folder.join(FILE);
    let note = path.exists().then(|| read_own_text(&path)).transpose()?;
    Ok(note.map(|text| text.trim_end().to_owned()))
}
