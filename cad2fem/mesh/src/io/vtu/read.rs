//! Reads VTU: as [`write_vtu`](super::write_vtu) writes it, and as ParaView does unless it is told otherwise.

use std::path::Path;

use super::{CellType, Field, Grid};
use crate::Vec3;
use crate::io::bytes::Cursor;
use crate::io::{IoError, Parsed, read_bytes};

/// Reads a grid of one piece and one kind of cells. Numbers are of any type, and appended to the XML as they are.
pub fn read_vtu(path: &Path) -> Result<Grid, IoError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|m| IoError::content(path, m))
}

pub(super) fn parse(bytes: &[u8]) -> Parsed<Grid> {
    let mut cursor = Cursor::new(bytes);
    let appended = cursor.skip_past(b"<AppendedData");
    let (xml, rest) = bytes.split_at(bytes.len() - cursor.remaining());
    let tag = rest.split(|&b| b == b'>').next().unwrap_or_default();
    if !appended
        || attribute(&String::from_utf8_lossy(tag), "encoding").as_deref() != Some("raw")
        || !cursor.skip_past(b"_")
    {
        return Err(OTHERWISE.into());
    }
    let data = &bytes[bytes.len() - cursor.remaining()..];
    let xml = std::str::from_utf8(xml).map_err(|e| format!("the XML header is not UTF-8: {e}"))?;
    let mut arrays = Vec::new();
    let (mut group, mut counts, mut word) = ("", None, 4);
    for tag in xml.split('<').skip(1) {
        let name = tag.split(|c: char| c.is_ascii_whitespace() || c == '>').next().unwrap_or("");
        match name.trim_end_matches('/') {
            "VTKFile" => word = word_of(tag)?,
            name @ ("PointData" | "CellData" | "Points" | "Cells" | "FieldData") => group = name,
            "Piece" if counts.is_some() => {
                return Err("there are several pieces; one is needed: in ParaView, Merge Blocks and Append Datasets \
                            make one"
                    .into());
            }
            "Piece" => {
                counts = Some((number(tag, "NumberOfPoints")?, number(tag, "NumberOfCells")?));
            }
            "DataArray" if group != "FieldData" => {
                arrays.push(Array::parse(group, tag, data, word)?);
            }
            _ => {}
        }
    }
    let (points, cells) = counts.ok_or("there is no Piece")?;
    assemble(&arrays, points, cells)
}

const OTHERWISE: &str = "its numbers are not appended as they are: in ParaView, save it with the data mode Appended, \
                         without encoding and compression";

/// Bytes of the sizes in front of data.
fn word_of(tag: &str) -> Parsed<usize> {
    let found = |name: &str| attribute(tag, name).unwrap_or_default();
    if found("type") != "UnstructuredGrid" {
        return Err(format!("a grid of type {:?}; UnstructuredGrid is needed", found("type")));
    }
    if !found("compressor").is_empty() || found("byte_order") == "BigEndian" {
        return Err(OTHERWISE.into());
    }
    Ok(if found("header_type") == "UInt64" { 8 } else { 4 })
}

/// Numbers of an array, with what its tag says.
struct Array<'a> {
    /// The element that it is in: `Points`, `Cells`, `PointData` or `CellData`.
    group: &'a str,
    field: Field,
}

impl<'a> Array<'a> {
    /// From its tag and the appended data of the file.
    fn parse(group: &'a str, tag: &str, data: &[u8], word: usize) -> Parsed<Self> {
        let name = attribute(tag, "Name").ok_or("a DataArray has no Name")?;
        let fail = |m: String| format!("array {name:?}: {m}");
        if attribute(tag, "format").as_deref() != Some("appended") {
            return Err(fail(OTHERWISE.into()));
        }
        let mut cursor = Cursor::new(data);
        let read = |cursor: &mut Cursor| {
            cursor.take(number(tag, "offset")?)?;
            let size = cursor.take(word)?.iter().rev().fold(0_u64, |n, &b| n << 8 | u64::from(b));
            let size = usize::try_from(size).map_err(|_| format!("{size} bytes of an array"))?;
            numbers(&attribute(tag, "type").unwrap_or_default(), cursor.take(size)?)
        };
        let values = read(&mut cursor).map_err(fail)?;
        let components = match attribute(tag, "NumberOfComponents") {
            Some(_) => number(tag, "NumberOfComponents").map_err(fail)?,
            None => 1,
        };
        let unit = attribute(tag, "Unit").unwrap_or_default();
        Ok(Self { group, field: Field { name, unit, components, values } })
    }

    /// The numbers of so many points or cells.
    fn field(&self, count: usize) -> Parsed<Field> {
        let Field { name, components, values, .. } = &self.field;
        if count.checked_mul(*components) != Some(values.len()) {
            let n = values.len();
            return Err(format!("array {name:?} has {n} values, not {count} × {components}"));
        }
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(format!("array {name:?} is {} at index {i}", values[i]));
        }
        Ok(self.field.clone())
    }
}

/// Numbers of a type of VTK; whole ones are exact up to 2⁵³.
fn numbers(kind: &str, bytes: &[u8]) -> Parsed<Vec<f64>> {
    fn all<const N: usize>(bytes: &[u8], number: fn([u8; N]) -> f64) -> Parsed<Vec<f64>> {
        let (numbers, rest) = bytes.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(format!("{} bytes do not divide into {N}", bytes.len()));
        }
        Ok(numbers.iter().map(|&bytes| number(bytes)).collect())
    }
    match kind {
        "Int8" => all(bytes, |b| f64::from(i8::from_le_bytes(b))),
        "UInt8" => all(bytes, |b| f64::from(u8::from_le_bytes(b))),
        "Int32" => all(bytes, |b| f64::from(i32::from_le_bytes(b))),
        "UInt32" => all(bytes, |b| f64::from(u32::from_le_bytes(b))),
        "Int64" => all(bytes, |b| i64::from_le_bytes(b) as f64),
        "UInt64" => all(bytes, |b| u64::from_le_bytes(b) as f64),
        "Float32" => all(bytes, |b| f64::from(f32::from_le_bytes(b))),
        "Float64" => all(bytes, f64::from_le_bytes),
        _ => Err(format!("{kind:?} is no type of numbers")),
    }
}

/// The whole number in an attribute.
fn number(tag: &str, name: &str) -> Parsed<usize> {
    let text = attribute(tag, name).ok_or_else(|| format!("the attribute {name} is missing"))?;
    text.parse().map_err(|_| format!("{name} is {text:?}, not a number"))
}

/// The value of an attribute of an XML tag, with the escapes of writers undone.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let begins = |&at: &usize| tag[..at].ends_with(|c: char| c.is_ascii_whitespace());
    let start = format!("{name}=\"");
    let at = tag.match_indices(&start).map(|(at, _)| at).find(begins)?;
    let (value, _) = tag[at + start.len()..].split_once('"')?;
    let escapes = [("&quot;", "\""), ("&gt;", ">"), ("&lt;", "<"), ("&amp;", "&")];
    Some(escapes.iter().fold(value.to_owned(), |text, (from, to)| text.replace(from, to)))
}

fn assemble(arrays: &[Array], points: usize, cells: usize) -> Parsed<Grid> {
    let find = |group: &str, name: &str| {
        arrays
            .iter()
            .find(|a| a.group == group && (a.field.name == name || group == "Points"))
            .ok_or_else(|| format!("there is no array {name:?} in {group}"))
    };
    let positions = find("Points", "Points")?.field(points)?;
    if positions.components != 3 {
        return Err(format!("points have {} components, not 3", positions.components));
    }
    let types = &find("Cells", "types")?.field.values;
    let cell_type = cell_type(types)?;
    let connectivity = find("Cells", "connectivity")?.field.values.iter();
    let connectivity: Vec<usize> = connectivity
        .map(|&i| (i >= 0.0 && i < points as f64).then_some(i as usize))
        .collect::<Option<_>>()
        .ok_or_else(|| format!("cells refer to points outside 0..{points}"))?;
    if cells.checked_mul(cell_type.nodes()) != Some(connectivity.len()) || types.len() != cells {
        return Err(format!(
            "{} cell nodes and {} types for {cells} cells of {} nodes",
            connectivity.len(),
            types.len(),
            cell_type.nodes()
        ));
    }
    let fields = |group: &str, count: usize| {
        arrays.iter().filter(|a| a.group == group).map(|a| a.field(count)).collect::<Parsed<_>>()
    };
    Ok(Grid {
        points: positions.values.chunks_exact(3).map(Vec3::from_column_slice).collect(),
        cells: connectivity,
        cell_type,
        point_fields: fields("PointData", points)?,
        cell_fields: fields("CellData", cells)?,
    })
}

/// The one shape of all cells.
fn cell_type(types: &[f64]) -> Parsed<CellType> {
    let Some(first) = types.first() else { return Ok(CellType::Tet4) };
    if let Some(other) = types.iter().find(|other| *other != first) {
        return Err(format!(
            "cells of types {first} and {other}; one type is needed: in ParaView, Extract Cells By Type leaves the \
             tetrahedra"
        ));
    }
    let known = CellType::ALL.into_iter().find(|&t| f64::from(t as u8) == *first);
    known.ok_or_else(|| format!("cells are of type {first}; 5, 10, 22, 24 or 71 is needed"))
}
