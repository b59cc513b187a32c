//! Paths as people and files have them.

use std::io;
use std::path::{Component, Path, PathBuf};

/// The absolute path with links followed. On Windows it begins with a drive where that is possible, and not with the
/// `\\?\` that few programs understand.
pub fn canonical(path: &Path) -> io::Result<PathBuf> {
    dunce::canonicalize(path)
}

/// A path as it is written to files and pages, which other systems read too: with `/` between its parts.
pub fn portable(path: &Path) -> String {
    let mut text = String::new();
    for part in path.components() {
        if !text.is_empty() && !text.ends_with('/') && part != Component::RootDir {
            text.push('/');
        }
        match part {
            Component::RootDir => text.push('/'),
            part => text.push_str(&part.as_os_str().to_string_lossy()),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_written_the_same_on_every_system() {
        let join = |parts: &[&str]| parts.iter().collect::<PathBuf>();
        assert_eq!(portable(&join(&["..", "a b", "c.msh"])), "../a b/c.msh");
        assert_eq!(portable(Path::new("/a/b")), "/a/b");
        assert_eq!(portable(Path::new("/")), "/");
        assert_eq!(portable(Path::new(".")), ".");
        assert_eq!(portable(Path::new("")), "");
        #[cfg(windows)]
        assert_eq!(portable(Path::new(r"C:\a\b")), "C:/a/b");
    }
}
