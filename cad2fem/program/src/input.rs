//! Files that results were made from, as reports name them.

use std::path::{Component, Path, PathBuf};

use anyhow::{Result, bail};
use mesh::io::IoError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use system::{canonical, portable};

use crate::sha256_file;

/// A file that a result was made from.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct InputFile {
    /// In a report relative to the report's folder, so that it is found from everywhere.
    pub path: PathBuf,
    /// SHA-256 of its content.
    pub sha256: String,
}

impl InputFile {
    /// The file at `path`, for a report in `folder`.
    pub fn new(path: &Path, folder: &Path) -> Result<Self, IoError> {
        Ok(Self { path: relative(path, folder), sha256: sha256_file(path)? })
    }

    /// This input for a report in `folder`.
    pub fn seen_from(&self, folder: &Path) -> Self {
        Self { path: relative(&self.path, folder), sha256: self.sha256.clone() }
    }

    /// Where it is, as named by a report in `folder`.
    pub fn find(&self, folder: &Path) -> Result<PathBuf> {
        let path = folder.join(&self.path);
        let found = sha256_file(&path)?;
        if found != self.sha256 {
            bail!(
                "{} is not what this result was made from (sha256 {found}, it was {}): make it again",
                path.display(),
                self.sha256
            );
        }
        Ok(path)
    }
}

/// `path` as seen from `folder`, as files keep it: with `/` between its parts. Unchanged if the two have no common root.
pub fn relative(path: &Path, folder: &Path) -> PathBuf {
    let (Some(to), Some(from)) = (full(path), full(folder)) else { return path.to_path_buf() };
    let common = to.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    let seen: PathBuf = up.chain(to.components().skip(common)).collect();
    PathBuf::from(if seen.as_os_str().is_empty() { ".".to_owned() } else { portable(&seen) })
}

/// The absolute path, links and `..` followed if it is there.
fn full(path: &Path) -> Option<PathBuf> {
    canonical(path).or_else(|_| std::path::absolute(path)).ok()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_folder() {
        let from = |path: &str, folder: &str| relative(Path::new(path), Path::new(folder));
        assert_eq!(from("/a/b/design.msh", "/a/mold"), Path::new("../b/design.msh"));
        assert_eq!(from("/a/mold/design.msh", "/a/mold"), Path::new("design.msh"));
        assert_eq!(from("/a/mold", "/a/mold"), Path::new("."));
    }

    #[test]
    fn a_file_is_found_unless_it_changed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("results")).unwrap();
        std::fs::write(at("body.msh"), "a").unwrap();
        let input = InputFile::new(&at("results/../body.msh"), &at("results")).unwrap();
        assert_eq!(input.path, Path::new("../body.msh"));
        assert!(input.find(&at("results")).unwrap().ends_with("results/../body.msh"));
        std::fs::write(at("body.msh"), "b").unwrap();
        let message = input.find(&at("results")).unwrap_err().to_string();
        assert!(message.contains("body.msh is not what this result was made from"), "{message}");
        std::fs::remove_file(at("body.msh")).unwrap();
        let message = format!("{:#}", input.find(&at("results")).unwrap_err());
        assert!(message.contains("body.msh"), "{message}");
    }
}
