//! One line per accepted iteration, in `history.jsonl`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// The file in a folder.
pub struct History {
    path: PathBuf,
}

impl History {
    /// That of a folder.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self { path: folder.join("history.jsonl") }
    }

    /// Adds a line.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn append(&self, line: &Value) -> Result<()> {
        let write = || -> std::io::Result<()> {
            let mut file =
                std::fs::OpenOptions::new().create(true).append(true).open(&self.path)?;
            writeln!(file, "{line}")?;
            file.sync_all()
        };
        write().with_context(|| self.path.display().to_string())
    }

    /// Keeps the first `lines` lines.
    ///
    /// # Errors
    /// When there are fewer, or the file cannot be read or written.
    pub fn truncate(&self, lines: usize) -> Result<()> {
        let path = &self.path;
        let text = if path.exists() { mesh::io::read_text(path)? } else { String::new() };
        let found = text.lines().count();
        ensure!(
            found >= lines,
            "{}: {found} lines, but the checkpoint is at line {lines}; begin anew: --restart",
            path.display()
        );
        if found > lines {
            let kept: String = text.lines().take(lines).flat_map(|l| [l, "\n"]).collect();
            mesh::io::write_atomic(path, |out| out.write_all(kept.as_bytes()))?;
        }
        Ok(())
    }
}
