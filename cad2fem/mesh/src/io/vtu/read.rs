//! Reads VTU: as [`write_vtu`](super::write_vtu) writes it, and as ParaView, meshio and PyVista do.

use std::path::Path;

use super::array::{Array, attribute, number};
use super::encoded::{Base64, Layout, Stream};
use super::{CellType, Field, Grid};
use crate::Vec3;
use crate::io::bytes::Cursor;
use crate::io::{IoError, Parsed, read_bytes};

/// Reads a grid of one piece and one kind of cells. Numbers are in text, in base64 or appended, there raw or in
/// base64, whole or in blocks of zlib, and of any type.
///
/// # Errors
/// If the file cannot be read, is truncated, is compressed otherwise, has several pieces or kinds of cells, or its
/// counts disagree.
pub fn read_vtu(path: &Path) -> Result<Grid, IoError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|m| IoError::content(path, m))
}

pub(super) fn parse(bytes: &[u8]) -> Parsed<Grid> {
    let (xml, appended) = parts(bytes)?;
    let xml = std::str::from_utf8(xml).map_err(|e| format!("the XML header is not UTF-8: {e}"))?;
    let mut arrays = Vec::new();
    let (mut group, mut counts) = ("", None);
    let mut layout = Layout { word: 4, big_endian: false, compressed: false };
    let mut tags = xml.split('<').skip(1).peekable();
    while let Some(tag) = tags.next() {
        match name_of(tag) {
            "VTKFile" => layout = layout_of(tag)?,
            name @ ("PointData" | "CellData" | "Points" | "Cells" | "FieldData") => group = name,
            "Piece" if counts.is_some() => {
                return Err(
                    "there are several pieces; one is needed: in ParaView, Merge Blocks and \
                            Append Datasets make one"
                        .into(),
                );
            }
            "Piece" => {
                counts = Some((number(tag, "NumberOfPoints")?, number(tag, "NumberOfCells")?));
            }
            "DataArray" if group != "FieldData" => {
                // notes may stand before and between the numbers
                let mut text = content(tag).to_owned();
                while let Some(inner) = tags.next_if(|inner| is_note(name_of(inner))) {
                    text += if name_of(inner) == "/InformationKey" { content(inner) } else { "" };
                }
                arrays.push(Array::parse(group, (tag, &text), appended.as_ref(), layout)?);
            }
            _ => {}
        }
    }
    let (points, cells) = counts.ok_or("there is no Piece")?;
    assemble(&arrays, points, cells)
}

/// The XML of a file up to its appended data, and these.
fn parts(bytes: &[u8]) -> Parsed<(&[u8], Option<Stream<'_>>)> {
    let mut cursor = Cursor::new(bytes);
    if !cursor.skip_past(b"<AppendedData") {
        return Ok((bytes, None));
    }
    let xml = &bytes[..bytes.len() - cursor.remaining()];
    let rest = &bytes[xml.len()..];
    if !cursor.skip_past(b">") {
        return Err("the file is truncated".into());
    }
    let tag = String::from_utf8_lossy(&rest[..rest.len() - cursor.remaining()]);
    let encoding = attribute(&tag, "encoding").unwrap_or_default();
    if !cursor.skip_past(b"_") {
        return Err("the appended data do not begin with _".into());
    }
    let data = &bytes[bytes.len() - cursor.remaining()..];
    match encoding.as_str() {
        "raw" => Ok((xml, Some(Stream::Raw(data)))),
        "base64" => Ok((xml, Some(Stream::Base64(Base64::new(data))))),
        other => Err(format!("appended data in {other:?}; raw or base64 is needed")),
    }
}

/// The name of a tag, with a slash where it ends an element.
fn name_of(tag: &str) -> &str {
    let name = tag.split(|c: char| c.is_ascii_whitespace() || c == '>').next().unwrap_or("");
    name.strip_suffix('/').unwrap_or(name)
}

/// Whether an element inside of an array is no number.
fn is_note(name: &str) -> bool {
    ["InformationKey", "/InformationKey", "Value", "/Value"].contains(&name)
}

/// What follows a tag.
fn content(tag: &str) -> &str {
    tag.split_once('>').map_or("", |(_, text)| text)
}

fn layout_of(tag: &str) -> Parsed<Layout> {
    let found = |name: &str| attribute(tag, name).unwrap_or_default();
    if found("type") != "UnstructuredGrid" {
        return Err(format!("a grid of type {:?}; UnstructuredGrid is needed", found("type")));
    }
    let word = match found("header_type").as_str() {
        // what files had before there was the choice
        "" | "UInt32" => 4,
        "UInt64" => 8,
        other => return Err(format!("header_type {other:?}; UInt32 or UInt64 is needed")),
    };
    let compressed = match found("compressor").as_str() {
        "" => false,
        "vtkZLibDataCompressor" => true,
        other => {
            return Err(format!(
                "compressed by {other}; vtkZLibDataCompressor or no compression is needed: in ParaView, choose it as \
                 Compressor Type when saving; in meshio, compression=\"zlib\""
            ));
        }
    };
    Ok(Layout { word, big_endian: found("byte_order") == "BigEndian", compressed })
}

fn assemble(arrays: &[Array], points: usize, cells: usize) -> Parsed<Grid> {
    let find = |group: &str, label: &str| {
        arrays
            .iter()
            .find(|a| a.group == group && (a.label == label || group == "Points"))
            .ok_or_else(|| format!("there is no array {label:?} in {group}"))
    };
    let positions = find("Points", "Points")?.field(points)?;
    if positions.components != 3 {
        return Err(format!("points have {} components, not 3", positions.components));
    }
    let positions = positions.values;
    let types = find("Cells", "types")?.whole()?;
    let cell_type = cell_type(types)?;
    let connectivity = find("Cells", "connectivity")?.whole()?.iter();
    let connectivity: Vec<usize> = connectivity
        .map(|&i| usize::try_from(i).ok().filter(|&i| i < points))
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
    let point_fields: Vec<Field> = fields("PointData", points)?;
    Ok(Grid {
        points: positions.chunks_exact(3).map(Vec3::from_column_slice).collect(),
        cells: connectivity,
        cell_type,
        point_fields,
        cell_fields: fields("CellData", cells)?,
    })
}

/// The one shape of all cells.
fn cell_type(types: &[i64]) -> Parsed<CellType> {
    let Some(first) = types.first() else { return Ok(CellType::Tet4) };
    if let Some(other) = types.iter().find(|other| *other != first) {
        return Err(format!(
            "cells of types {first} and {other}; one type is needed: in ParaView, Extract Cells By Type leaves the \
             tetrahedra"
        ));
    }
    let known = CellType::ALL.into_iter().find(|&t| t as i64 == *first);
    known.ok_or_else(|| format!("cells are of type {first}; 5, 10, 22, 24 or 71 is needed"))
}
