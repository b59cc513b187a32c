//! Stanford PLY: elements `vertex` (x, y, z) and `face` (a list of indices).

use std::io::{self, Write};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{PropertyAccess, PropertyAccessResult};

use super::Parsed;
use crate::{SurfaceMesh, Vec3};

/// Faces with more than three corners become fans from their first corner.
pub fn parse(bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| format!("the PLY header is malformed: {e}"))?;
    let mut surface = SurfaceMesh::default();
    for (name, element) in &header.elements {
        let (count, size) = (element.count, bytes.len());
        if count > size {
            return Err(format!(
                "PLY element {name:?}: {count} announced, the file has {size} bytes"
            ));
        }
        let fail = |e| format!("PLY element {name:?}, {count} announced: {e}");
        match name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fail)?;
                surface.vertices = vertices.into_iter().map(|v| v.0).collect();
            }
            _ => {
                let faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fail)?;
                for face in faces.into_iter().filter(|_| name == "face") {
                    add_fan(&mut surface, &face)?;
                }
            }
        }
    }
    Ok(surface)
}

fn add_fan(surface: &mut SurfaceMesh, face: &Face) -> Parsed<()> {
    let t = surface.triangles.len();
    if face.0.len() < 3 {
        return Err(format!("the face after {t} triangles has {} corners, not 3", face.0.len()));
    }
    let corners: Vec<usize> = face
        .0
        .iter()
        .map(|&i| usize::try_from(i).map_err(|_| format!("vertex index {i} is negative")))
        .collect::<Result<_, _>>()?;
    surface.triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
    Ok(())
}

/// A position; missing coordinates stay NaN, which every reader rejects.
struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Vec3::repeat(f64::NAN))
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        self.set_double(name, f64::from(value))
    }

    fn set_double(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|&axis| axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = value;
        PropertyAccessResult::Set
    }
}

/// Corner indices of a face; any integer type is allowed in the file.
struct Face(Vec<i64>);

impl Face {
    fn set<I: Into<i64>>(&mut self, name: &str, value: Vec<I>) -> PropertyAccessResult {
        // Both spellings are in use.
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        self.0 = value.into_iter().map(Into::into).collect();
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_list_char(&mut self, name: &str, value: Vec<i8>) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_list_uchar(&mut self, name: &str, value: Vec<u8>) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_list_short(&mut self, name: &str, value: Vec<i16>) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_list_ushort(&mut self, name: &str, value: Vec<u16>) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_list_int(&mut self, name: &str, value: Vec<i32>) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_list_uint(&mut self, name: &str, value: Vec<u32>) -> PropertyAccessResult {
        self.set(name, value)
    }
}

pub fn write(surface: &SurfaceMesh, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", surface.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    writeln!(out, "element face {}", surface.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;
    for x in surface.vertices.iter().flatten() {
        out.write_all(&x.to_le_bytes())?;
    }
    for triangle in &surface.triangles {
        out.write_all(&[3])?;
        for &v in triangle {
            let id = i32::try_from(v)
                .map_err(|_| io::Error::other("more than 2^31 vertices do not fit into PLY"))?;
            out.write_all(&id.to_le_bytes())?;
        }
    }
    Ok(())
}
