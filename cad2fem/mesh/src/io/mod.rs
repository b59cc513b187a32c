//! File formats, one per file, and the rules they share.
//!
//! Readers reject what cannot be used: truncated files, counts that disagree,
//! indices out of range, coordinates that are not finite, empty meshes. Writers
//! go through [`write_atomic`], so that a reader never sees half a file.

mod atomic;
mod bytes;
mod inputs;
pub mod msh;
pub mod npy;
mod obj;
mod open;
mod ply;
mod stl;
mod text;
pub mod threemf;
mod unfinished;
pub mod vtu;

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

pub use atomic::write_atomic;
pub use inputs::{remove_output, remove_output_folder};
pub use msh::{MshFile, read_tets, read_tets_of_any_unit, tagged_mesh, write_tets};
pub use open::{create_new, make_folder, open_input, open_to_append};
pub use text::{read_own_text, read_text};
pub use unfinished::{Unfinished, remove_litter, remove_unfinished};

use crate::SurfaceMesh;

/// Why a file could not be read or written. The message names the file, what
/// was found and what was needed.
#[derive(Debug, thiserror::Error)]
pub enum IoError {
    /// The operating system refused.
    #[error("{}: cannot {action}: {cause}", path.display())]
    System {
        /// The file.
        path: PathBuf,
        /// What was attempted.
        action: &'static str,
        /// What the operating system said.
        cause: io::Error,
    },
    /// The content is not what the format or its use needs.
    #[error("{}: {message}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What was found and what was needed.
        message: String,
    },
}

impl IoError {
    fn system(path: &Path, action: &'static str, cause: io::Error) -> Self {
        Self::System { path: path.to_path_buf(), action, cause }
    }

    /// An error about the content of `path`.
    pub fn content(path: &Path, message: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), message: message.into() }
    }
}

/// What a parser found: a value or a message to which the path is added.
type Parsed<T> = Result<T, String>;

/// A surface format.
pub struct Format {
    /// File name extension, lower case.
    pub extension: &'static str,
    /// What a reader of `--help` should know.
    pub about: &'static str,
    parse: fn(&[u8]) -> Parsed<SurfaceMesh>,
    write: fn(&SurfaceMesh, &mut dyn Write) -> io::Result<()>,
}

/// The surface formats, chosen by extension.
pub const FORMATS: &[Format] = &[
    Format {
        extension: "stl",
        about: "STL, binary or ASCII; written binary with 32-bit coordinates",
        parse: stl::parse,
        write: stl::write,
    },
    Format {
        extension: "obj",
        about: "Wavefront OBJ, positions and faces only; written with full precision",
        parse: obj::parse,
        write: obj::write,
    },
    Format {
        extension: "ply",
        about: "Stanford PLY; written binary with 64-bit coordinates",
        parse: ply::parse,
        write: ply::write,
    },
];

/// The format that the end of a file's name tells, in lower case.
pub fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// The surface format of a file name.
fn format_of(path: &Path) -> Result<&'static Format, IoError> {
    let extension = extension(path);
    FORMATS.iter().find(|f| f.extension == extension).ok_or_else(|| {
        let known: Vec<&str> = FORMATS.iter().map(|f| f.extension).collect();
        let known = known.join(", ");
        IoError::content(path, format!("unknown surface format {extension:?}; known: {known}"))
    })
}

/// Reads a surface; the format follows from the extension, see [`FORMATS`].
///
/// STL repeats the corners of every triangle: bit-equal corners become one vertex.
pub fn read_surface(path: &Path) -> Result<SurfaceMesh, IoError> {
    let format = format_of(path)?;
    let bytes = read_bytes(path)?;
    let surface = (format.parse)(&bytes).map_err(|m| IoError::content(path, m))?;
    require_sound(&surface).map_err(|m| IoError::content(path, m))?;
    Ok(surface)
}

/// Reads a surface whose lengths are metres, and warns where their size hints at another unit.
pub fn read_surface_in_metres(path: &Path) -> Result<SurfaceMesh, IoError> {
    let surface = read_surface(path)?;
    if let Some(remark) = crate::measure::unlikely_size(&surface.vertices) {
        log::warn!("{}: {remark}", path.display());
    }
    Ok(surface)
}

/// Writes a surface; the format follows from the extension, see [`FORMATS`].
pub fn write_surface(path: &Path, surface: &SurfaceMesh) -> Result<(), IoError> {
    let format = format_of(path)?;
    require_sound(surface).map_err(|m| IoError::content(path, format!("not written: {m}")))?;
    write_atomic(path, |out| (format.write)(surface, out))
}

/// Whether a surface can be used: not empty, finite, indices in range.
fn require_sound(surface: &SurfaceMesh) -> Parsed<()> {
    let n = surface.vertices.len();
    if surface.triangles.is_empty() {
        return Err(format!("the mesh is empty: {n} vertices, no triangles"));
    }
    require_finite(&surface.vertices)?;
    for (t, triangle) in surface.triangles.iter().enumerate() {
        if let Some(v) = triangle.iter().find(|&&v| v >= n) {
            return Err(format!("triangle {t} refers to vertex {v}, but there are {n} vertices"));
        }
    }
    Ok(())
}

/// The largest coordinate [unit of the file]: a thousand kilometres in millimetres. Powers of such
/// numbers are far from the end of f64.
const FARTHEST: f64 = 1e9;

/// Whether all coordinates are finite, and none is so large that powers of it may not be.
fn require_finite(points: &[crate::Vec3]) -> Parsed<()> {
    refuse_points(points, "not finite", |x| !x.is_finite())?;
    refuse_points(points, &format!("beyond {FARTHEST:e}"), |x| x.abs() > FARTHEST)
}

fn refuse_points(points: &[crate::Vec3], what: &str, is_bad: impl Fn(f64) -> bool) -> Parsed<()> {
    let bad = |p: &crate::Vec3| p.iter().any(|&x| is_bad(x));
    let Some(first) = points.iter().position(bad) else { return Ok(()) };
    let count = points.iter().filter(|&p| bad(p)).count();
    let [x, y, z] = points[first].into();
    Err(format!(
        "{count} of {} vertices are {what}, the first is vertex {first} at ({x}, {y}, {z})",
        points.len()
    ))
}

/// The largest file that is read as a whole [bytes]; a mesh of 20 million tetrahedra has a quarter.
const LARGEST: u64 = 4 << 30;

/// Reads an input of the program, which is then never overwritten by it.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, IoError> {
    let bytes = read_own_bytes(path)?;
    inputs::note_read(path);
    Ok(bytes)
}

/// Reads a file that a program of ours wrote, in an earlier run perhaps, and that this one may write again.
fn read_own_bytes(path: &Path) -> Result<Vec<u8>, IoError> {
    let fail = |cause| IoError::system(path, "read", cause);
    let too_large = |size: String| {
        IoError::content(path, format!("it has {size} bytes; up to {LARGEST} are read"))
    };
    let file = open_input(path)?;
    let announced = file.metadata().map_err(fail)?.len();
    if announced > LARGEST {
        return Err(too_large(announced.to_string()));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(announced as usize).map_err(|_| {
        IoError::content(path, format!("its {announced} bytes do not fit into memory"))
    })?;
    // pipes announce nothing
    let read = file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(fail)?;
    if read as u64 > LARGEST { Err(too_large(format!("more than {LARGEST}"))) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests;
