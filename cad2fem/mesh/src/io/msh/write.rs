//! Writes Gmsh format 2.2 ASCII.

use std::io::{self, Write};
use std::path::Path;

use super::BODY;
use crate::io::{IoError, require_finite, write_atomic};
use crate::{Tags, TetMesh, Volumes};

/// Writes a tetrahedral mesh with its tags as physical groups of triangles, and its volumes as
/// those of tetrahedra.
///
/// Coordinates are written with as many digits as it takes to read back the same
/// bits. All tag names are kept, also those without facets.
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
    let Volumes { names, of } = &tags.volumes;
    if !names.is_empty() && (of.len() != mesh.tets.len() || of.iter().any(|&i| i >= names.len())) {
        let (known, named, all) = (of.len(), names.len(), mesh.tets.len());
        return Err(format!("volumes of {known} tetrahedra by {named} names, there are {all}"));
    }
    match tags.names.iter().chain(names).find(|name| name.contains(['"', '\n', '\r'])) {
        Some(name) => Err(format!("the tag name {name:?} contains a quote or a line end")),
        None => Ok(()),
    }
}

fn write(mesh: &TetMesh, tags: &Tags, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat")?;
    let body = [BODY.to_owned()];
    let Volumes { names: volumes, of } = &tags.volumes;
    let volumes = if volumes.is_empty() { &body } else { &volumes[..] };
    writeln!(out, "$PhysicalNames\n{}", tags.names.len() + volumes.len())?;
    for (name, id) in tags.names.iter().zip(1..) {
        writeln!(out, "2 {id} \"{name}\"")?;
    }
    for (name, id) in volumes.iter().zip(1..) {
        writeln!(out, "3 {id} \"{name}\"")?;
    }
    writeln!(out, "$EndPhysicalNames")?;
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
    for (t, (tet, number)) in mesh.tets.iter().zip(tags.facets.len() + 1..).enumerate() {
        let [a, b, c, d] = tet.map(|v| v + 1);
        let id = of.get(t).map_or(1, |volume| volume + 1);
        writeln!(out, "{number} 4 2 {id} {id} {a} {b} {c} {d}")?;
    }
    writeln!(out, "$EndElements")
}
