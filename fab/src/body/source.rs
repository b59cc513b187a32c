//! From which file a body came, and which part of it is cast.

use std::path::{Component, Path, PathBuf};

use mesh::io::IoError;
use program::sha256_file;
use serde::{Deserialize, Serialize};

use super::orientation::Portion;
use crate::config::Chambers;

/// Where the body came from.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// The mesh, relative to the folder of this file.
    pub path: PathBuf,
    /// SHA-256 of its content.
    pub sha256: String,
    /// Tags of the walls of its chambers.
    pub chamber: Chambers,
    /// Which part of it is cast.
    pub part: CastPart,
}

/// What of the input is cast.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum CastPart {
    /// All of it.
    Whole,
    /// What is above a height in the mold's coordinates [mm].
    Above(f64),
    /// What is below a height in the mold's coordinates [mm].
    Below(f64),
    /// The input is no mesh in metres but the surface of a core, in the millimetres
    /// of the mold that holds it.
    Core,
}

impl CastPart {
    /// What a mold casts of a design.
    #[must_use]
    pub fn of(portion: Portion) -> Self {
        // The frame puts the cut at height 0.
        match portion {
            Portion::Whole => Self::Whole,
            Portion::Above(_) => Self::Above(0.0),
            Portion::Below(_) => Self::Below(0.0),
        }
    }
}

impl Input {
    /// Names and hashes the mesh at `path` for a report in `folder`.
    ///
    /// # Errors
    /// If the mesh cannot be read.
    pub fn new(
        path: &Path,
        folder: &Path,
        chamber: &Chambers,
        part: CastPart,
    ) -> Result<Self, IoError> {
        let sha256 = sha256_file(path)?;
        Ok(Self { path: relative(path, folder), sha256, chamber: chamber.clone(), part })
    }
}

/// `path` as seen from `folder`; unchanged if the two have no common root.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let (Ok(to), Ok(from)) = (std::path::absolute(path), std::path::absolute(folder)) else {
        return path.to_path_buf();
    };
    let common = to.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    up.chain(to.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_folder() {
        let path = relative(Path::new("/a/b/design.msh"), Path::new("/a/mold"));
        assert_eq!(path, Path::new("../b/design.msh"));
        let path = relative(Path::new("/a/mold/design.msh"), Path::new("/a/mold"));
        assert_eq!(path, Path::new("design.msh"));
    }
}
