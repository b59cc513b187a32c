//! Gmsh meshes: reads formats 2.0 to 2.2 and 4.1, ASCII and binary; writes 2.2
//! ASCII, which every tool reads.
//!
//! Only tetrahedra and triangles are kept, of those of higher order the corners.

mod assemble;
mod elements;
mod source;
mod v2;
mod v4;
mod write;

use std::path::Path;

use self::source::Source;
use super::{IoError, Parsed, read_bytes};
use crate::measure::unlikely_size;
use crate::{Tags, TetMesh};

pub use write::write_tets;

/// Name of the tetrahedra that are in no volume with another name.
pub const BODY: &str = "body";

/// What a Gmsh file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MshFile {
    /// The tetrahedra, all of positive volume; vertices in the order of the file.
    pub mesh: TetMesh,
    /// Physical groups of triangles, and of tetrahedra; empty if there are none.
    pub tags: Tags,
}

/// Reads a tetrahedral mesh from a Gmsh file.
///
/// Vertices keep the order of the file; those that no tetrahedron uses are left
/// out with a warning. Tetrahedra of negative volume are turned. The physical
/// groups of triangles become tags in the order of their numbers, called by
/// their physical name or else by their number, and those of tetrahedra volumes,
/// unless all are in one group without a name, or called [`BODY`].
///
/// # Errors
/// If the file cannot be read, is truncated or malformed, has coordinates that
/// are not finite, elements that are neither points, lines, triangles nor
/// tetrahedra, no tetrahedra, or tagged triangles that belong to no tetrahedron
/// or to two groups.
pub fn read_tets(path: &Path) -> Result<MshFile, IoError> {
    let bytes = read_bytes(path)?;
    let fail = |message| IoError::content(path, message);
    let (file, notes) = parse(&bytes).and_then(assemble::assemble).map_err(fail)?;
    for note in notes {
        log::warn!("{}: {note}", path.display());
    }
    if let Some(remark) = unlikely_size(&file.mesh.vertices) {
        log::warn!("{}: {remark}", path.display());
    }
    Ok(file)
}

/// A file's content before it is interpreted.
#[derive(Default)]
struct Raw {
    /// Node number and position.
    nodes: Vec<(u64, crate::Vec3)>,
    /// Corner node numbers and physical group of each triangle.
    triangles: Vec<([u64; 3], i32)>,
    /// Corner node numbers and physical group of each tetrahedron.
    tets: Vec<([u64; 4], i32)>,
    /// Number and name of the physical groups of dimension 2.
    names: Vec<(i32, String)>,
    /// Number and name of the physical groups of dimension 3.
    volume_names: Vec<(i32, String)>,
}

fn parse(bytes: &[u8]) -> Parsed<Raw> {
    let mut source = Source::new(bytes);
    let version = source.header()?;
    let mut raw = Raw::default();
    let mut groups = v4::Groups::default();
    while let Some(section) = source.next_section()? {
        let read = match (section.as_str(), version) {
            ("PhysicalNames", _) => {
                source.physical_names().map(|names| [raw.names, raw.volume_names] = names)
            }
            ("Nodes", 2) => v2::nodes(&mut source).map(|nodes| raw.nodes = nodes),
            ("Elements", 2) => v2::elements(&mut source, &mut raw),
            ("Entities", 4) => v4::entities(&mut source).map(|found| groups = found),
            ("Nodes", 4) => v4::nodes(&mut source).map(|nodes| raw.nodes = nodes),
            ("Elements", 4) => v4::elements(&mut source, &groups, &mut raw),
            _ => {
                source.skip_section(&section)?;
                continue;
            }
        };
        read.and_then(|()| source.end_section(&section))
            .map_err(|m| format!("in section ${section}: {m}"))?;
    }
    Ok(raw)
}

#[cfg(test)]
mod tests;
