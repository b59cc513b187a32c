//! Wavefront OBJ: positions (`v`) and faces (`f`); all else is skipped.

use std::io::{self, Write};

use super::Parsed;
use crate::{SurfaceMesh, Vec3};

/// Faces with more than three corners become fans from their first corner.
pub fn parse(bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let text = std::str::from_utf8(bytes).map_err(|e| format!("not a text file: {e}"))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text); // a byte-order mark
    let mut surface = SurfaceMesh::default();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let parsed = match words.next() {
            Some("v") => position(words).map(|v| surface.vertices.push(v)),
            Some("f") => face(words, surface.vertices.len()).map(|corners| {
                let fan = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
                surface.triangles.extend(fan);
            }),
            _ => Ok(()),
        };
        parsed.map_err(|m| format!("line {}: {m}: {line:?}", i + 1))?;
    }
    Ok(surface)
}

fn position<'a>(mut words: impl Iterator<Item = &'a str>) -> Parsed<Vec3> {
    let mut position = Vec3::zeros();
    for x in position.iter_mut() {
        let word = words.next().ok_or("a vertex needs three coordinates")?;
        *x = word.parse().map_err(|_| format!("{word:?} is not a number"))?;
    }
    Ok(position)
}

/// Corners as indices from zero. A corner is `v`, `v/vt`, `v//vn` or `v/vt/vn`;
/// v counts from 1, or backwards from the latest vertex if negative.
fn face<'a>(words: impl Iterator<Item = &'a str>, vertices: usize) -> Parsed<Vec<usize>> {
    let mut corners = Vec::with_capacity(3);
    for word in words {
        let index = word.split('/').next().unwrap_or(word);
        let index: i64 = index.parse().map_err(|_| format!("{word:?} is not a vertex index"))?;
        let from_start = if index < 0 { index + vertices as i64 } else { index - 1 };
        let corner = usize::try_from(from_start).ok().filter(|&v| index > 0 || v < vertices);
        corners.push(corner.ok_or_else(|| {
            format!("there is no vertex {index}, {vertices} vertices precede this line")
        })?);
    }
    if corners.len() < 3 {
        return Err(format!("a face needs at least 3 corners, this has {}", corners.len()));
    }
    Ok(corners)
}

pub fn write(surface: &SurfaceMesh, out: &mut dyn Write) -> io::Result<()> {
    for v in &surface.vertices {
        writeln!(out, "v {:?} {:?} {:?}", v.x, v.y, v.z)?;
    }
    for [a, b, c] in surface.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}
