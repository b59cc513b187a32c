//! Files that appear complete or not at all.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::IoError;
use super::inputs::{note_written, refuse_input};
use super::open::{make_folder, open_device};
use super::unfinished::{PREFIX, Unfinished};

/// Writes a file so that `path` holds either its old content or all of the new:
/// a temporary file beside it is filled, flushed to the disk and renamed. If
/// anything fails, the temporary file is removed and `path` is untouched.
/// Missing parent directories are created. A link is replaced, not followed. Devices and pipes below `/dev` are written to directly.
pub fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    let fail = |action| move |cause| IoError::system(path, action, cause);
    refuse_input(path)?;
    if let Some(device) = open_device(path)? {
        let mut out = BufWriter::new(device);
        return fill(&mut out).and_then(|()| out.flush()).map_err(fail("write"));
    }
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    make_folder(folder)?;
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
