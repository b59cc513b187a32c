//! Who can change a file or folder: what others may have put there is neither run nor removed.

use std::fs::Metadata;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use system::{is_changed_by_others, is_sticky, owner, user};
use tempfile::TempDir;

/// A new folder for temporary files, which only this user may enter, with a name that nobody can guess.
pub fn temporary_folder(prefix: &str) -> Result<TempDir> {
    let above = std::env::temp_dir();
    let found = std::fs::metadata(&above).with_context(|| above.display().to_string())?;
    ensure!(
        !is_changed_by_others(&found) || is_sticky(&found),
        "{}: others may exchange what lies in this folder; set TMPDIR to a folder of your own",
        above.display()
    );
    let mut builder = tempfile::Builder::new();
    if let Some(private) = system::permissions(0o700) {
        builder.permissions(private);
    }
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
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    #[test]
    fn what_others_can_change_is_not_ours() {
        let above = temporary_folder("puffer-").unwrap();
        assert_eq!(std::fs::metadata(above.path()).unwrap().mode() & 0o777, 0o700);
        let folder = above.path().join("folder");
        let link = above.path().join("link");
        create_dir(&folder).unwrap();
        symlink(&folder, &link).unwrap();
        for (mode, ours) in [(0o700, true), (0o755, true), (0o775, true), (0o777, false)] {
            set_permissions(&folder, Permissions::from_mode(mode)).unwrap();
            assert_eq!(is_own_folder(&folder), ours, "{mode:o}");
            assert_eq!(is_as_safe_as_program(&folder), ours, "{mode:o}");
            assert_eq!(is_as_safe_as_program(&link), ours, "{mode:o}");
            assert!(!is_own_folder(&link));
        }
        // everybody may add files there, although nobody may rename those of others
        set_permissions(&folder, Permissions::from_mode(0o1777)).unwrap();
        assert!(!is_as_safe_as_program(&folder) && !is_own_folder(&folder));
        assert!(!is_as_safe_as_program(&above.path().join("nothing")));
    }

    #[test]
    fn a_folder_of_another_user_is_not_ours() {
        let above = tempfile::tempdir().unwrap();
        let path = above.path().join("theirs");
        create_dir(&path).unwrap();
        // only root can give a folder away
        if std::os::unix::fs::chown(&path, Some(65534), None).is_ok() {
            assert!(!is_own_folder(&path) && !is_as_safe_as_program(&path));
        }
    }
}
