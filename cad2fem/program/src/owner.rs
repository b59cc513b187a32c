//! Who can change a file or folder: what others may have put there is neither run nor removed.

use std::fs::Metadata;
use std::path::Path;

use anyhow::{Context as _, Result};
use system::{is_changed_by_others, owner, user};
use tempfile::TempDir;

/// A new folder for temporary files, which only this user may enter, with a name that nobody can guess.
pub fn temporary_folder(prefix: &str) -> Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    if let Some(private) = system::permissions(0o700) {
        builder.permissions(private);
    }
    let above = std::env::temp_dir();
    let made = builder.prefix(prefix).tempdir_in(&above);
    made.with_context(|| format!("{}: cannot create a temporary folder", above.display()))
}

/// Whether `path` is a folder, no link to one, that this user alone can change.
pub fn is_own_folder(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|found| {
        found.is_dir() && owner(&found) == user() && !is_changed_by_others(&found)
    })
}

/// Whether only root, this user and the owner of the running program can change a file or folder, and where it
/// is a link, also what it leads to.
pub fn is_as_safe_as_program(path: &Path) -> bool {
    let program = std::env::current_exe().and_then(std::fs::metadata).ok();
    let of_program = program.as_ref().and_then(owner);
    let trusted = |found: &Metadata| {
        let owner = owner(found);
        owner.is_none() || owner == Some(0) || owner == user() || owner == of_program
    };
    let link = std::fs::symlink_metadata(path);
    let target = std::fs::metadata(path);
    link.is_ok_and(|link| trusted(&link))
        && target.is_ok_and(|target| trusted(&target) && !is_changed_by_others(&target))
}

#[cfg(test)]
#[cfg(unix)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs::{Permissions, create_dir, set_permissions};
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn what_others_can_change_is_not_ours() {
        let above = temporary_folder("puffer-").unwrap();
        let (folder, link) = (above.path().join("folder"), above.path().join("link"));
        create_dir(&folder).unwrap();
        symlink(&folder, &link).unwrap();
        for (mode, ours) in [(0o700, true), (0o775, true), (0o777, false), (0o1777, false)] {
            set_permissions(&folder, Permissions::from_mode(mode)).unwrap();
            assert_eq!(is_own_folder(&folder), ours, "{mode:o}");
            assert_eq!(is_as_safe_as_program(&link), ours, "{mode:o}");
            assert!(!is_own_folder(&link));
        }
    }
}
