//! STL: triangles with their corners, no indices.
//!
//! Binary is 80 bytes of header, a 32-bit count, and for each triangle a normal,
//! three corners (32-bit floats) and 16 unused bits.

use std::collections::HashMap;
use std::io::{self, Write};

use super::Parsed;
use super::bytes::Cursor;
use crate::measure::triangle_normal;
use crate::{SurfaceMesh, Vec3};

const HEADER: usize = 84;
const RECORD: usize = 50;

pub fn parse(bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let announced = bytes
        .get(80..HEADER)
        .map(|n| u32::from_le_bytes(n.try_into().expect("the range has four bytes")) as usize);
    let size = announced.map(|n| HEADER + RECORD * n);
    let looks_ascii = bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0);
    if size != Some(bytes.len()) && looks_ascii {
        return parse_ascii(bytes);
    }
    match (announced, size) {
        (Some(count), Some(size)) if size == bytes.len() => parse_binary(&bytes[HEADER..], count),
        (Some(count), Some(size)) => Err(format!(
            "neither ASCII STL nor complete binary STL: {count} triangles announced need {size} \
             bytes, the file has {}",
            bytes.len()
        )),
        _ => Err(format!("the file has {} bytes; an STL header needs {HEADER}", bytes.len())),
    }
}

fn parse_binary(records: &[u8], count: usize) -> Parsed<SurfaceMesh> {
    let mut weld = Weld::with_capacity(count);
    for record in records.chunks_exact(RECORD) {
        let number = |i: usize| {
            let bytes = record[4 * i..4 * i + 4].try_into().expect("four bytes");
            f64::from(f32::from_le_bytes(bytes))
        };
        // Numbers 0 to 2 are the normal.
        weld.add([3, 6, 9].map(|i| Vec3::new(number(i), number(i + 1), number(i + 2))));
    }
    Ok(weld.finish())
}

fn parse_ascii(bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let mut cursor = Cursor::new(bytes);
    let mut weld = Weld::with_capacity(0);
    let mut complete = false;
    loop {
        match cursor.word() {
            Some("facet") => weld.add(ascii_facet(&mut cursor)?),
            // The name of the solid follows, which may be any text.
            Some(word @ ("solid" | "endsolid")) => {
                complete = word == "endsolid";
                cursor.line();
            }
            None if complete => return Ok(weld.finish()),
            other => return Err(unexpected(&cursor, "facet or endsolid", other)),
        }
    }
}

/// The corners of a facet whose first word was read.
fn ascii_facet(cursor: &mut Cursor) -> Parsed<[Vec3; 3]> {
    expect(cursor, "normal")?;
    // Exporters write anything for the normal, even nan; it is not used.
    for _ in 0..3 {
        cursor.word();
    }
    expect(cursor, "outer")?;
    expect(cursor, "loop")?;
    let mut corners = [Vec3::zeros(); 3];
    for corner in &mut corners {
        expect(cursor, "vertex")?;
        for x in corner.iter_mut() {
            let word = cursor.word();
            *x = word
                .and_then(|w| w.parse().ok())
                .ok_or_else(|| unexpected(cursor, "a coordinate", word))?;
        }
    }
    expect(cursor, "endloop")?;
    expect(cursor, "endfacet")?;
    Ok(corners)
}

fn expect(cursor: &mut Cursor, keyword: &str) -> Parsed<()> {
    match cursor.word() {
        Some(word) if word == keyword => Ok(()),
        other => Err(unexpected(cursor, keyword, other)),
    }
}

fn unexpected(cursor: &Cursor, needed: &str, found: Option<&str>) -> String {
    let found = found.map_or("the end of the file".into(), |w| format!("{w:?}"));
    format!("line {}: found {found} where ASCII STL needs {needed}", cursor.line_number())
}

/// Makes one vertex of bit-equal corners.
struct Weld {
    surface: SurfaceMesh,
    ids: HashMap<[u64; 3], usize>,
    collapsed: usize,
}

impl Weld {
    fn with_capacity(triangles: usize) -> Self {
        let mut surface = SurfaceMesh::default();
        surface.triangles.reserve(triangles);
        Self { surface, ids: HashMap::with_capacity(triangles / 2), collapsed: 0 }
    }

    fn add(&mut self, corners: [Vec3; 3]) {
        let [a, b, c] = corners.map(|corner| self.vertex(corner));
        if a == b || b == c || c == a {
            self.collapsed += 1;
        } else {
            self.surface.triangles.push([a, b, c]);
        }
    }

    fn vertex(&mut self, corner: Vec3) -> usize {
        // Adding zero turns -0 into +0, which is the same place.
        let key = [corner.x, corner.y, corner.z].map(|x| (x + 0.0).to_bits());
        let vertices = &mut self.surface.vertices;
        *self.ids.entry(key).or_insert_with(|| {
            vertices.push(corner);
            vertices.len() - 1
        })
    }

    fn finish(self) -> SurfaceMesh {
        if self.collapsed > 0 {
            log::warn!("STL: left out {} triangles with two equal corners", self.collapsed);
        }
        self.surface
    }
}

pub fn write(surface: &SurfaceMesh, out: &mut dyn Write) -> io::Result<()> {
    let count = u32::try_from(surface.triangles.len())
        .map_err(|_| io::Error::other("more than 2^32 triangles do not fit into STL"))?;
    // The header must not begin with "solid", which would announce ASCII.
    let mut header = [b' '; 80];
    let text = b"binary STL";
    header[..text.len()].copy_from_slice(text);
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    for t in 0..surface.triangles.len() {
        // The normal of the rounded corners, so that a file read and written again
        // is the same file.
        let [a, b, c] = surface.corners(t).map(|corner| corner.map(|x| f64::from(x as f32)));
        let mut record = [0; RECORD];
        let numbers = [triangle_normal(a, b, c), a, b, c].into_iter().flat_map(<[f64; 3]>::from);
        for (i, x) in numbers.enumerate() {
            if !x.is_finite() {
                return Err(io::Error::other("coordinates beyond 3.4e38 do not fit into STL"));
            }
            record[4 * i..4 * i + 4].copy_from_slice(&(x as f32).to_le_bytes());
        }
        out.write_all(&record)?;
    }
    Ok(())
}
