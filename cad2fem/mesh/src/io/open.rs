//! The one place where files are opened.
//!
//! An input, as people name it, may be a link to a file. What lies in a folder of results may have
//! been put there by others: below such a folder no part of a path may be a link. Pipes, devices and
//! folders are never opened in place of files, so that nothing waits for a writer that never comes; the
//! pipes that a program was started with are (`/dev/stdin`, `<(...)`).

use std::collections::BTreeSet;
use std::fs::{DirBuilder, File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::IoError;

/// Folders of results of this process, as absolute paths.
static RESULTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// From now on `folder`, which may be a link itself, is a folder of results.
pub fn note_results(folder: &Path) {
    if let Ok(folder) = std::path::absolute(folder) {
        RESULTS.lock().unwrap_or_else(PoisonError::into_inner).insert(folder);
    }
}

/// Makes a folder of results if it is missing; [`note_results`].
///
/// # Errors
/// If it cannot be made.
pub fn make_results(folder: &Path) -> Result<(), IoError> {
    make_folder(folder)?;
    note_results(folder);
    Ok(())
}

/// Makes a folder, and those above that are missing.
pub(super) fn make_folder(folder: &Path) -> Result<(), IoError> {
    refuse_links(folder)?;
    let made = DirBuilder::new().recursive(true).create(folder);
    made.map_err(|cause| IoError::system(folder, "create the folder", cause))
}

/// Opens an input to be read.
///
/// # Errors
/// If it is no file, cannot be opened, or is reached by a link in a folder of results.
pub fn open_input(path: &Path) -> Result<File, IoError> {
    refuse_links(path)?;
    if is_inherited(path) && std::fs::metadata(path).is_ok_and(|found| kind(&found) == "a pipe") {
        let opened = OpenOptions::new().read(true).open(path);
        return opened.map_err(|cause| IoError::system(path, "read", cause));
    }
    open_file(path, OpenOptions::new().read(true), true, "read")
}

/// Opens a file that a program of ours has written, which is no link.
///
/// # Errors
/// If it is no file, cannot be opened, or is reached by a link in a folder of results.
pub fn open_own(path: &Path) -> Result<File, IoError> {
    refuse_links(path)?;
    open_file(path, OpenOptions::new().read(true), false, "read")
}

/// Opens a file to be read and written at its end; makes it if it is missing.
///
/// # Errors
/// If it is no file, has another name elsewhere, or cannot be opened.
pub fn open_to_append(path: &Path) -> Result<File, IoError> {
    refuse_links(path)?;
    let mut options = OpenOptions::new();
    let file = open_file(path, options.read(true).append(true).create(true), false, "open")?;
    refuse_other_names(path, &file)?;
    Ok(file)
}

/// Makes a file that was not there.
///
/// # Errors
/// If there is one, or it cannot be made.
pub fn create_new(path: &Path) -> Result<File, IoError> {
    refuse_links(path)?;
    let made = OpenOptions::new().write(true).create_new(true).open(path);
    made.map_err(|cause| IoError::system(path, "create", cause))
}

/// Opens a device or a pipe to be written: one that the program was started with, or below `/dev`.
/// `None` if `path` is a file or a folder, or not there.
pub(super) fn open_device(path: &Path) -> Result<Option<File>, IoError> {
    let is_device = |found: Metadata| !found.is_file() && !found.is_dir();
    if !is_inherited(path) && !path.starts_with("/dev") {
        return match std::fs::symlink_metadata(path) {
            Ok(found) if is_device(found.clone()) && !found.is_symlink() => {
                let message = format!(
                    "it is {}, and no file that can be replaced; give the output another name",
                    kind(&found)
                );
                Err(IoError::content(path, message))
            }
            _ => Ok(None),
        };
    }
    if !std::fs::metadata(path).is_ok_and(is_device) {
        return Ok(None);
    }
    let opened = OpenOptions::new().write(true).open(path);
    opened.map(Some).map_err(|cause| IoError::system(path, "open", cause))
}

/// Refuses a path on which something below a folder of results is a link.
fn refuse_links(path: &Path) -> Result<(), IoError> {
    refuse_link_above(path)?;
    refuse_link(path, path)
}

/// As [`refuse_links`], but `path` itself may be one: it is replaced or removed, not followed.
pub(super) fn refuse_link_above(path: &Path) -> Result<(), IoError> {
    let mut above = path.ancestors().skip(1).filter(|above| !above.as_os_str().is_empty());
    above.try_for_each(|above| refuse_link(above, path))
}

fn refuse_link(part: &Path, path: &Path) -> Result<(), IoError> {
    let Ok(full) = std::path::absolute(part) else { return Ok(()) };
    let results = RESULTS.lock().unwrap_or_else(PoisonError::into_inner);
    let below = |folder: &PathBuf| full != *folder && full.starts_with(folder);
    if results.iter().any(below) && part.is_symlink() {
        let which = if part == path { "it".to_owned() } else { part.display().to_string() };
        let message = format!(
            "{which} is a link, and none is followed in a folder of results: remove it, or take \
             another folder"
        );
        return Err(IoError::content(path, message));
    }
    Ok(())
}

/// Content of a file that has another name is that of someone else, perhaps.
fn refuse_other_names(path: &Path, file: &File) -> Result<(), IoError> {
    let names = system::names(file).map_err(|cause| IoError::system(path, "open", cause))?;
    if names > 1 {
        let message = "not changed: it has another name elsewhere (a hard link); remove it";
        return Err(IoError::content(path, message));
    }
    Ok(())
}

fn open_file(
    path: &Path,
    options: &mut OpenOptions,
    follow: bool,
    action: &'static str,
) -> Result<File, IoError> {
    let look = if follow { std::fs::metadata(path) } else { std::fs::symlink_metadata(path) };
    // nothing is done to a device, not even to open it
    if let Ok(found) = look {
        require_file(path, &found)?;
    }
    let fail = |cause: io::Error| IoError::system(path, action, cause);
    let file = system::opening(options, follow).open(path).map_err(fail)?;
    require_file(path, &file.metadata().map_err(fail)?)?;
    Ok(file)
}

fn require_file(path: &Path, found: &Metadata) -> Result<(), IoError> {
    if found.is_file() {
        return Ok(());
    }
    Err(IoError::content(path, format!("it is {}; a file is needed", kind(found))))
}

/// What something is that is no file.
fn kind(found: &Metadata) -> &'static str {
    system::special(found).unwrap_or(match found {
        found if found.is_dir() => "a folder",
        found if found.is_symlink() => "a link",
        _ => "a device",
    })
}

/// Whether a path names what the program was started with.
fn is_inherited(path: &Path) -> bool {
    let folders = ["/dev/fd", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc/self/fd"];
    folders.iter().any(|folder| path.starts_with(folder))
}

#[cfg(test)]
#[cfg(unix)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs::{create_dir, hard_link, read_to_string, write};
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;

    use nix::sys::stat::Mode;
    use nix::unistd::mkfifo;

    use super::super::{
        read_bytes, read_own_text, remove_output, remove_output_folder, write_atomic,
    };
    use super::*;

    fn refused<T>(result: Result<T, IoError>) -> String {
        result.err().unwrap().to_string()
    }

    #[test]
    fn an_input_may_be_a_link_and_our_own_file_may_not() {
        let top = tempfile::tempdir().unwrap();
        let at = |name: &str| top.path().join(name);
        write(at("file"), "content").unwrap();
        symlink(at("file"), at("link")).unwrap();
        assert_eq!(read_bytes(&at("link")).unwrap(), b"content");
        assert!(refused(read_own_text(&at("link"))).contains("it is a link; a file is needed"));
        assert!(refused(open_to_append(&at("link"))).contains("it is a link; a file is needed"));
        symlink(at("nothing"), at("loose")).unwrap();
        assert!(open_to_append(&at("loose")).is_err() && create_new(&at("loose")).is_err());
        assert!(!at("nothing").exists());
        hard_link(at("file"), at("twin")).unwrap();
        assert!(refused(open_to_append(&at("twin"))).contains("another name elsewhere"));
    }

    #[test]
    fn what_is_no_file_is_neither_waited_for_nor_written_to() {
        let top = tempfile::tempdir().unwrap();
        let at = |name: &str| top.path().join(name);
        mkfifo(&at("pipe"), Mode::S_IRWXU).unwrap();
        create_dir(at("folder")).unwrap();
        let _listener = UnixListener::bind(at("socket")).unwrap();
        symlink(at("pipe"), at("link")).unwrap();
        symlink("/dev/full", at("device")).unwrap();
        for (name, what) in [
            ("pipe", "a pipe"),
            ("link", "a pipe"),
            ("folder", "a folder"),
            ("socket", "a socket"),
            ("device", "a device"),
        ] {
            let needed = format!("{name}: it is {what}; a file is needed");
            assert!(refused(read_bytes(&at(name))).contains(&needed), "{name}");
            assert!(open_own(&at(name)).is_err() && open_to_append(&at(name)).is_err(), "{name}");
        }
        for name in ["pipe", "socket"] {
            let message = refused(write_atomic(&at(name), |out| write!(out, "new")));
            assert!(message.contains("no file that can be replaced"), "{message}");
        }
        // what a link leads to stays as it is
        for name in ["link", "device"] {
            write_atomic(&at(name), |out| write!(out, "new")).unwrap();
            assert!(at(name).symlink_metadata().unwrap().is_file(), "{name}");
        }
    }

    #[test]
    fn no_link_is_followed_in_a_folder_of_results() {
        let top = tempfile::tempdir().unwrap();
        let at = |name: &str| top.path().join(name);
        for folder in ["disk", "theirs", "theirs/inner"] {
            create_dir(at(folder)).unwrap();
        }
        write(at("theirs/inner/victim"), "precious").unwrap();
        symlink(at("disk"), at("results")).unwrap(); // which is its user's decision
        make_results(&at("results")).unwrap();
        symlink(at("theirs"), at("results/pictures")).unwrap();
        symlink(at("theirs/inner/victim"), at("results/report")).unwrap();
        let through = at("results/pictures/inner/victim");
        let is_refused = |message: String| {
            assert!(message.contains("none is followed in a folder of results"), "{message}");
        };
        is_refused(refused(read_bytes(&at("results/report"))));
        is_refused(refused(read_bytes(&through)));
        is_refused(refused(read_own_text(&through)));
        is_refused(refused(open_to_append(&through)));
        is_refused(refused(create_new(&at("results/pictures/new"))));
        is_refused(refused(write_atomic(&through, |out| write!(out, "new"))));
        is_refused(refused(write_atomic(&at("results/pictures/a/b"), |out| write!(out, "new"))));
        is_refused(refused(remove_output(&through)));
        is_refused(refused(remove_output_folder(&at("results/pictures/inner"))));
        is_refused(refused(make_results(&at("results/pictures/more"))));
        // the link itself is replaced and removed
        write_atomic(&at("results/report"), |out| write!(out, "new")).unwrap();
        remove_output_folder(&at("results/pictures")).unwrap();
        write_atomic(&at("results/pictures/a"), |out| write!(out, "new")).unwrap();
        assert_eq!(read_to_string(at("theirs/inner/victim")).unwrap(), "precious");
        assert_eq!(std::fs::read_dir(at("theirs")).unwrap().count(), 1);
        assert_eq!(read_to_string(at("disk/report")).unwrap(), "new");
    }
}
