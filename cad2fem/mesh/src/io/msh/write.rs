//! Writes Gmsh format 2.2 ASCII.

use std::io::{self, Write};
use std::path::Path;

use crate::io::{IoError, require_finite, write_atomic};
use crate::{Tags, TetMesh};

/// Writes a tetrahedral mesh with its tags as physical groups of triangles.
///
/// Coordinates are written with as many digits as it takes to read back the same
/// bits. All tag names are kept, also those without facets.
///
/// # Errors
/// If the mesh is empty, a coordinate is not finite, an index is out of range, a
/// name contains a quote or a line end, or the file cannot be written.
pub fn write_tets(path: &Path, mesh: &TetMesh, tags: &Tags) -> Result<(), IoError> {
    require_sound(mesh, tags).map_err(|m| IoError::content(path, format!("not written: {m}")))?;
    write_atomic(path, |out| write(mesh, tags, out))
}

fn require_sound(mesh: &TetMesh, tags: &Tags) -> Result<(), String> {
    let n = mesh.vertices.len();
    if mesh.tets.is_empty() {
        return Err(format!("the mesh is empty: {n} vertices, no tetrahedra"));
    }
    require_finite(&mesh.vertices)?;
    if let Some(t) = mesh.tets.iter().position(|tet| tet.iter().any(|&v| v >= n)) {
        return Err(format!("tetrahedron {t} is {:?}, but there are {n} vertices", mesh.tets[t]));
    }
    for (facet, &id) in &tags.facets {
        if facet[2] >= n || id == 0 || id as usize > tags.names.len() {
            let names = tags.names.len();
            return Err(format!(
                "facet {facet:?} has tag {id}; there are {n} vertices and {names} tag names"
            ));
        }
    }
    match tags.names.iter().find(|name| name.contains(['"', '\n', '\r'])) {
        Some(name) => Err(format!("the tag name {name:?} contains a quote or a line end")),
        None => Ok(()),
    }
}

fn write(mesh: &TetMesh, tags: &Tags, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat")?;
    writeln!(out, "$PhysicalNames\n{}", tags.names.len() + 1)?;
    for (name, id) in tags.names.iter().zip(1..) {
        writeln!(out, "2 {id} \"{name}\"")?;
    }
    writeln!(out, "3 1 \"body\"\n$EndPhysicalNames")?;
    writeln!(out, "$Nodes\n{}", mesh.vertices.len())?;
    for (v, number) in mesh.vertices.iter().zip(1..) {
        writeln!(out, "{number} {:?} {:?} {:?}", v.x, v.y, v.z)?;
    }
    writeln!(out, "$EndNodes\n$Elements\n{}", tags.facets.len() + mesh.tets.len())?;
    // Each element: number, type, two tags (physical group and entity), nodes.
    for ((facet, id), number) in tags.facets.iter().zip(1..) {
        let [a, b, c] = facet.map(|v| v + 1);
        writeln!(out, "{number} 2 2 {id} {id} {a} {b} {c}")?;
    }
    for (tet, number) in mesh.tets.iter().zip(tags.facets.len() + 1..) {
        let [a, b, c, d] = tet.map(|v| v + 1);
        writeln!(out, "{number} 4 2 1 1 {a} {b} {c} {d}")?;
    }
    writeln!(out, "$EndElements")
}
