//! Files that appear complete or not at all.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::IoError;
use super::inputs::{note_written, refuse_input};
use super::open::{make_folder, open_device, refuse_link_above};
use super::standard::is_standard;
use super::unfinished::{PREFIX, Unfinished, remove_forgotten};

/// Writes a file so that `path` holds either its old content or all of the new:
/// a temporary file beside it is filled, flushed to the disk and renamed. If
/// anything fails, the temporary file is removed and `path` is untouched.
/// Missing parent directories are created. A link is replaced, not followed. Devices below `/dev`, pipes
/// such as `/dev/stdout`, and standard output as `stl:-` are written to directly.
///
/// # Errors
/// If `path` was read as an input of this process, is a pipe or a socket, or lies behind a link in a folder of
/// results; if a directory or file cannot be created, or `fill` or the disk fails.
pub fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    let fail = |action| move |cause| IoError::system(path, action, cause);
    refuse_input(path)?;
    if is_standard(path)? {
        let mut out = BufWriter::new(io::stdout().lock());
        return fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"));
    }
    refuse_link_above(path)?;
    if let Some(device) = open_device(path)? {
        let mut out = BufWriter::new(device);
        return fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"));
    }
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    make_folder(folder)?;
    remove_forgotten(folder);
    let mut builder = tempfile::Builder::new();
    // Private by default; a result file gets the usual mode of a new file.
    if let Some(usual) = system::permissions(0o666) {
        builder.permissions(usual);
    }
    let make = || builder.prefix(PREFIX).tempfile_in(folder);
    let (temporary, _unfinished) = Unfinished::new(make, |file| file.path().to_owned())
        .map_err(fail("create a file beside"))?;
    let mut out = BufWriter::with_capacity(1 << 16, temporary);
    fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"))?;
    let temporary = out.into_inner().map_err(|e| fail("write")(e.into_error()))?;
    temporary.as_file().sync_all().map_err(fail("flush to disk"))?;
    temporary.persist(path).map_err(|e| fail("rename the finished file")(e.error))?;
    note_written(path);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files_in(folder: &Path) -> usize {
        std::fs::read_dir(folder).expect("the folder exists").count()
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deep/result.txt");
        write_atomic(&path, |out| write!(out, "old")).expect("a fresh file");
        let full = write_atomic(&path, |out| {
            write!(out, "half of the new")?;
            out.flush()?;
            Err(io::ErrorKind::StorageFull.into())
        });
        let message = full.expect_err("the closure failed").to_string();
        assert!(message.contains("result.txt") && message.contains("cannot write"), "{message}");
        assert_eq!(std::fs::read_to_string(&path).expect("the old file"), "old");
        assert_eq!(files_in(&folder.path().join("deep")), 1);
        write_atomic(&path, |out| write!(out, "new")).expect("the folder is writable");
        assert_eq!(std::fs::read_to_string(&path).expect("the new file"), "new");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_is_written_to_and_not_replaced() {
        let path = Path::new("/dev/full");
        let full = write_atomic(path, |out| write!(out, "x")).expect_err("it is always full");
        assert!(full.to_string().contains("No space left"), "{full}");
        assert!(!std::fs::metadata(path).expect("there").is_file());
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let taken = folder.path().join("taken");
        std::fs::create_dir(&taken).expect("a folder");
        let error = write_atomic(&taken, |out| write!(out, "x")).expect_err("it is a folder");
        assert!(error.to_string().contains("taken"), "{error}");
        assert_eq!(files_in(folder.path()), 1);
    }

    #[test]
    #[cfg(target_os = "linux")]
    #[ignore = "mounts a file system, which needs root"]
    fn a_full_disk_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mount = |program: &str, arguments: &[&str]| {
            let mut command = std::process::Command::new(program);
            command.args(arguments).arg(folder.path()).status().is_ok_and(|s| s.success())
        };
        assert!(mount("mount", &["-t", "tmpfs", "-o", "size=64k", "tmpfs"]), "cannot mount");
        let path = folder.path().join("large.bin");
        let result = write_atomic(&path, |out| out.write_all(&[0; 1 << 20]));
        let left = files_in(folder.path());
        assert!(mount("umount", &[]), "cannot unmount");
        let message = result.expect_err("1 MiB does not fit into 64 KiB").to_string();
        assert!(message.contains("large.bin") && message.contains("No space left"), "{message}");
        assert_eq!(left, 0);
    }
}
