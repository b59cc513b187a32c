//! The verbs of `solver`.

pub mod check;
pub mod compare;
pub mod fit;
pub mod gradient;
pub mod import;
pub mod list;
pub mod optimize;
pub mod plot;
pub mod simulate;

use std::path::PathBuf;

/// A mesh in place of a scene's, and the name of its body if there are several.
pub type OtherMesh = (Option<String>, PathBuf);

/// `path`, or `body=path`.
pub fn other_mesh(text: &str) -> Result<OtherMesh, String> {
    match text.split_once('=') {
        Some((body, path)) if !body.is_empty() && !path.is_empty() => {
            Ok((Some(body.to_owned()), PathBuf::from(path)))
        }
        Some(_) => Err("needed is a path, or body=path".to_owned()),
        None => Ok((None, PathBuf::from(text))),
    }
}
