//! STL: triangles with their corners, no indices.
//!
//! Binary is 80 bytes of header, a 32-bit count, and for each triangle a normal,
//! three corners (32-bit floats) and 16 unused bits. Written with `stl_io`; read
//! here, because that crate rounds ASCII files to 32 bits and takes a binary file
//! that begins with "solid" for an ASCII one.

use std::io::{self, Write};

use super::Parsed;
use super::bytes::Cursor;
use crate::measure::triangle_normal;
use crate::{SurfaceMesh, Vec3, welded};

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
        (_, Some(size)) if size == bytes.len() => Ok(parse_binary(&bytes[HEADER..])),
        (Some(count), Some(size)) => Err(format!(
            "neither ASCII STL nor complete binary STL: {count} triangles announced need {size} \
             bytes, the file has {}",
            bytes.len()
        )),
        _ => Err(format!("the file has {} bytes; an STL header needs {HEADER}", bytes.len())),
    }
}

fn parse_binary(records: &[u8]) -> SurfaceMesh {
    let corners = |record: &[u8]| {
        let number = |i: usize| {
            let bytes = record[4 * i..4 * i + 4].try_into().expect("four bytes");
            f64::from(f32::from_le_bytes(bytes))
        };
        // Numbers 0 to 2 are the normal.
        [3, 6, 9].map(|i| Vec3::new(number(i), number(i + 1), number(i + 2)))
    };
    of_corners(&records.chunks_exact(RECORD).map(corners).collect::<Vec<_>>())
}

fn parse_ascii(bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let mut cursor = Cursor::new(bytes);
    let mut facets = Vec::new();
    let mut complete = false;
    loop {
        match cursor.word() {
            Some("facet") => facets.push(ascii_facet(&mut cursor)?),
            // The name of the solid follows, which may be any text.
            Some(word @ ("solid" | "endsolid")) => {
                complete = word == "endsolid";
                cursor.line();
            }
            None if complete => return Ok(of_corners(&facets)),
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

/// One vertex of bit-equal corners, without the triangles that have two of them.
fn of_corners(corners: &[[Vec3; 3]]) -> SurfaceMesh {
    let mut surface = welded(corners);
    surface.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    let collapsed = corners.len() - surface.triangles.len();
    if collapsed > 0 {
        log::warn!("STL: left out {collapsed} triangles with two equal corners");
    }
    surface
}

pub fn write(surface: &SurfaceMesh, out: &mut dyn Write) -> io::Result<()> {
    let facets = (0..surface.triangles.len()).map(|t| facet(surface.corners(t)));
    stl_io::write_stl(&mut &mut *out, facets.collect::<io::Result<Vec<_>>>()?.iter())
}

/// A facet with the normal of its rounded corners, so that a file read and
/// written again is the same file. The corner opposite the longest edge comes
/// first: readers compare the normal with their own, computed in single
/// precision from that corner, and there it loses the fewest digits.
fn facet(corners: [Vec3; 3]) -> io::Result<stl_io::Triangle> {
    let rounded = corners.map(|corner| corner.map(|x| x as f32));
    if rounded.iter().any(|v| v.iter().any(|x| !x.is_finite())) {
        return Err(io::Error::other("coordinates beyond 3.4e38 do not fit into STL"));
    }
    let exact = rounded.map(|v| v.map(f64::from));
    let opposite = |i: usize| (exact[(i + 1) % 3] - exact[(i + 2) % 3]).norm_squared();
    let longer = |best: usize, i: usize| if opposite(i) > opposite(best) { i } else { best };
    let first = [1, 2].into_iter().fold(0, longer);
    let [a, b, c] = [0, 1, 2].map(|k| exact[(first + k) % 3]);
    let single = |v: Vec3| stl_io::Vector(<[f64; 3]>::from(v).map(|x| x as f32));
    Ok(stl_io::Triangle {
        normal: single(triangle_normal(a, b, c)),
        vertices: [a, b, c].map(single),
    })
}
