//! Gmsh meshes: reads formats 2.0 to 2.2 and 4.1, ASCII and binary; writes 2.2
//! ASCII, which every tool reads. A file may be compressed by gzip.
//!
//! Only tetrahedra and triangles are kept, of those of higher order the corners.

mod assemble;
mod elements;
mod source;
mod v2;
mod v4;
mod write;

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use self::source::Source;
use super::{IoError, LARGEST, Parsed, read_bytes};
use crate::measure::unlikely_size;
use crate::{Tags, TetMesh};

pub use write::write_tets;

/// What a file of gzip begins with.
const GZIP: [u8; 2] = [0x1f, 0x8b];

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

/// Reads a tetrahedral mesh whose lengths are metres from a Gmsh file, and warns where its size hints at
/// another unit.
pub fn read_tets(path: &Path) -> Result<MshFile, IoError> {
    let file = read_tets_of_any_unit(path)?;
    if let Some(remark) = unlikely_size(&file.mesh.vertices) {
        log::warn!("{}: {remark}", path.display());
    }
    Ok(file)
}

/// Reads a tetrahedral mesh from a Gmsh file.
///
/// Vertices keep the order of the file; those that no tetrahedron uses are left
/// out with a warning. Tetrahedra of negative volume are turned. The physical
/// groups of triangles become tags in the order of their numbers, called by
/// their physical name or else by their number, and those of tetrahedra volumes,
/// unless all are in one group without a name, or called [`BODY`].
pub fn read_tets_of_any_unit(path: &Path) -> Result<MshFile, IoError> {
    let fail = |message| IoError::content(path, message);
    let bytes = unzipped(read_bytes(path)?).map_err(fail)?;
    let (file, notes) = parse(&bytes).and_then(assemble::assemble).map_err(fail)?;
    for note in notes {
        log::warn!("{}: {note}", path.display());
    }
    Ok(file)
}

/// A mesh whose tags and volumes are lists of facets and of tetrahedra, with the checks of a file.
pub fn tagged_mesh(
    mesh: &TetMesh,
    tags: &[(String, Vec<[usize; 3]>)],
    volumes: &[(String, Vec<usize>)],
) -> Result<MshFile, String> {
    let node = |vertex: usize| vertex as u64;
    let mut raw = Raw {
        nodes: mesh.vertices.iter().enumerate().map(|(i, &x)| (node(i), x)).collect(),
        tets: mesh.tets.iter().map(|tet| (tet.map(node), 0)).collect(),
        ..Raw::default()
    };
    for ((name, facets), group) in tags.iter().zip(1..) {
        raw.names.push((group, name.clone()));
        raw.triangles.extend(facets.iter().map(|facet| (facet.map(node), group)));
    }
    for ((name, tets), group) in volumes.iter().zip(1..) {
        raw.volume_names.push((group, name.clone()));
        for &tet in tets {
            let count = mesh.tets.len();
            let of = raw.tets.get_mut(tet).ok_or_else(|| {
                format!("volume {name:?} has tetrahedron {tet}, but there are {count}")
            })?;
            of.1 = group;
        }
    }
    let (file, _) = assemble::assemble(raw)?;
    let left_out = mesh.vertices.len() - file.mesh.vertices.len();
    match left_out {
        0 => Ok(file),
        _ => Err(format!(
            "{left_out} of {} vertices are no corner of a tetrahedron",
            mesh.vertices.len()
        )),
    }
}

/// What a file of gzip holds, known by its first bytes; of another file its bytes.
fn unzipped(bytes: Vec<u8>) -> Parsed<Vec<u8>> {
    if !bytes.starts_with(&GZIP) {
        return Ok(bytes);
    }
    let mut inside = Vec::new();
    let read = MultiGzDecoder::new(&bytes[..]).take(LARGEST + 1).read_to_end(&mut inside);
    match read {
        Err(cause) => Err(format!("it is compressed by gzip, and damaged: {cause}")),
        Ok(size) if size as u64 > LARGEST => {
            Err(format!("it has more than {LARGEST} bytes decompressed; up to these are read"))
        }
        Ok(_) => Ok(inside),
    }
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
