//! Files that appear complete or not at all.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::IoError;

/// Writes a file so that `path` holds either its old content or all of the new:
/// a temporary file beside it is filled, flushed to the disk and renamed. If
/// anything fails, the temporary file is removed and `path` is untouched.
/// Missing parent directories are created. Devices and pipes such as
/// `/dev/stdout` cannot be replaced and are written to directly.
///
/// # Errors
/// If a directory or file cannot be created, or `fill` or the disk fails.
pub fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    let fail = |action| move |cause| IoError::system(path, action, cause);
    if is_device(path) {
        let device = OpenOptions::new().write(true).open(path).map_err(fail("open"))?;
        let mut out = BufWriter::new(device);
        return fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"));
    }
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(fail("create its folder"))?;
    let mut builder = tempfile::Builder::new();
    // Private by default; a result file gets the usual mode of a new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let temporary =
        builder.prefix(".incomplete-").tempfile_in(folder).map_err(fail("create a file beside"))?;
    let mut out = BufWriter::with_capacity(1 << 16, temporary);
    fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"))?;
    let temporary = out.into_inner().map_err(|e| fail("write")(e.into_error()))?;
    temporary.as_file().sync_all().map_err(fail("flush to disk"))?;
    temporary.persist(path).map_err(|e| fail("rename the finished file")(e.error))?;
    Ok(())
}

/// Whether `path` exists and is neither a file nor a folder.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}
