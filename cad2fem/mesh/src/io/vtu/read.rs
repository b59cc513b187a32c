//! Reads VTU as [`write_vtu`](super::write_vtu) writes it.

use std::path::Path;

use super::{CellType, Field, Grid};
use crate::Vec3;
use crate::io::bytes::Cursor;
use crate::io::{IoError, Parsed, read_bytes};

/// Reads a grid from a file with appended raw little-endian data and one kind of
/// cells, as this crate writes it.
///
/// # Errors
/// If the file cannot be read, is truncated, stores its data otherwise, or its
/// counts disagree.
pub fn read_vtu(path: &Path) -> Result<Grid, IoError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|m| IoError::content(path, m))
}

pub(super) fn parse(bytes: &[u8]) -> Parsed<Grid> {
    const APPENDED: &[u8] = b"<AppendedData encoding=\"raw\">";
    let mut cursor = Cursor::new(bytes);
    if !cursor.skip_past(APPENDED) || !cursor.skip_past(b"_") {
        return Err("no raw appended data; only grids written by this program are read".into());
    }
    let data_start = bytes.len() - cursor.remaining();
    let xml = std::str::from_utf8(&bytes[..data_start])
        .map_err(|e| format!("the XML header is not UTF-8: {e}"))?;
    let data = &bytes[data_start..];

    let mut arrays = Vec::new();
    let mut group = "";
    let mut counts = None;
    for tag in xml.split('<').skip(1) {
        match tag.split([' ', '>']).next().unwrap_or("") {
            name @ ("PointData" | "CellData" | "Points" | "Cells") => group = name,
            "Piece" => {
                counts = Some((number(tag, "NumberOfPoints")?, number(tag, "NumberOfCells")?));
            }
            "DataArray" => arrays.push(Array::parse(group, tag, data)?),
            _ => {}
        }
    }
    let (points, cells) = counts.ok_or("there is no Piece")?;
    assemble(&arrays, points, cells)
}

struct Array<'a> {
    group: &'a str,
    label: String,
    unit: String,
    components: usize,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    fn parse(group: &'a str, tag: &str, data: &'a [u8]) -> Parsed<Self> {
        let label = attribute(tag, "Name").ok_or("a DataArray has no Name")?;
        let components = attribute(tag, "NumberOfComponents").map_or(Ok(1), |n| {
            n.parse().map_err(|_| format!("array {label:?}: {n:?} components"))
        })?;
        let unit = attribute(tag, "Unit").unwrap_or_default();
        let needed = match (group, label.as_str()) {
            ("Cells", "types") => "UInt8",
            ("Cells", _) => "Int64",
            _ => "Float64",
        };
        let kind = attribute(tag, "type").unwrap_or_default();
        if kind != needed {
            return Err(format!("array {label:?} is {kind:?}; {needed} is needed"));
        }
        let offset = number(tag, "offset")?;
        let mut cursor = Cursor::new(data.get(offset..).ok_or("the file is truncated")?);
        let size = u64::from_le_bytes(cursor.array()?) as usize;
        let data = cursor.take(size).map_err(|m| format!("array {label:?}: {m}"))?;
        Ok(Self { group, label, unit, components, data })
    }

    fn floats(&self) -> Vec<f64> {
        let chunks = self.data.chunks_exact(8);
        chunks.map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect()
    }

    fn field(&self, count: usize) -> Parsed<Field> {
        let values = self.floats();
        if count.checked_mul(self.components) != Some(values.len()) {
            let (label, n, parts) = (&self.label, values.len(), self.components);
            return Err(format!("array {label:?} has {n} values, not {count} × {parts}"));
        }
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(format!("array {:?} is {} at index {i}", self.label, values[i]));
        }
        let (name, unit) = (self.label.clone(), self.unit.clone());
        Ok(Field { name, unit, components: self.components, values })
    }
}

fn assemble(arrays: &[Array], points: usize, cells: usize) -> Parsed<Grid> {
    let find = |group: &str, label: &str| {
        arrays
            .iter()
            .find(|a| a.group == group && a.label == label)
            .ok_or_else(|| format!("there is no array {label:?} in {group}"))
    };
    let positions = find("Points", "Points")?.field(points)?;
    if positions.components != 3 {
        return Err(format!("points have {} components, not 3", positions.components));
    }
    let positions = positions.values;
    let types = find("Cells", "types")?.data;
    let cell_type = match types.first() {
        None => CellType::Tet4,
        Some(&first) => CellType::ALL
            .into_iter()
            .find(|&t| types.iter().all(|&other| other == first) && t as u8 == first)
            .ok_or_else(|| {
                format!("cells must be all of one type, 5, 10, 22, 24 or 71; found {first}")
            })?,
    };
    let connectivity = find("Cells", "connectivity")?.data.chunks_exact(8);
    let connectivity: Vec<usize> = connectivity
        .map(|b| i64::from_le_bytes(b.try_into().expect("8 bytes")))
        .map(|i| usize::try_from(i).ok().filter(|&i| i < points))
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
        points: positions.chunks_exact(3).map(Vec3::from_column_slice).collect(),
        cells: connectivity,
        cell_type,
        point_fields: fields("PointData", points)?,
        cell_fields: fields("CellData", cells)?,
    })
}

fn number(tag: &str, name: &str) -> Parsed<usize> {
    let text = attribute(tag, name).ok_or_else(|| format!("the attribute {name} is missing"))?;
    text.parse().map_err(|_| format!("{name} is {text:?}, not a number"))
}

/// The value of an attribute of an XML tag, with the escapes of the writer undone.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
    let (value, _) = rest.split_once('"')?;
    let plain = value
        .replace("&quot;", "\"")
        .replace("&gt;", ">")
        .replace("&lt;", "<")
        .replace("&amp;", "&");
    Some(plain)
}
