//! Writes VTU with appended raw data, and PVD.

use std::io::{self, Write};
use std::path::Path;

use super::{Field, Grid};
use crate::io::{IoError, write_atomic};

/// Writes a grid, its numbers as binary 64-bit values.
pub fn write_vtu(path: &Path, grid: &Grid) -> Result<(), IoError> {
    require_sound(grid).map_err(|m| IoError::content(path, format!("not written: {m}")))?;
    write_atomic(path, |out| write(grid, out))
}

fn require_sound(grid: &Grid) -> Result<(), String> {
    let (points, nodes) = (grid.points.len(), grid.cell_type.nodes());
    if !grid.cells.len().is_multiple_of(nodes) {
        return Err(format!("{} cell nodes do not divide into {nodes}", grid.cells.len()));
    }
    if let Some(i) = grid.cells.iter().position(|&p| p >= points) {
        let (cell, point) = (i / nodes, grid.cells[i]);
        return Err(format!("cell {cell} refers to point {point} of {points}"));
    }
    crate::io::require_finite(&grid.points)?;
    let at_points = grid.point_fields.iter().map(|field| (field, points));
    let at_cells = grid.cell_fields.iter().map(|field| (field, grid.cell_count()));
    for (field, count) in at_points.chain(at_cells) {
        let (name, values, parts) = (&field.name, field.values.len(), field.components);
        if values != count * parts {
            return Err(format!("field {name:?} has {values} values, not {count} × {parts}"));
        }
        if let Some(i) = field.values.iter().position(|x| !x.is_finite()) {
            return Err(format!("field {name:?} is {} at index {i}", field.values[i]));
        }
    }
    Ok(())
}

/// An array of the file: its XML attributes and bytes.
struct Array {
    attributes: String,
    data: Vec<u8>,
}

impl Array {
    fn floats<'a>(label: &str, components: usize, values: impl Iterator<Item = &'a f64>) -> Self {
        let mut attributes = format!("type=\"Float64\" Name=\"{}\"", escape(label));
        // One component is the default; named, some readers make it a column.
        if components > 1 {
            attributes += &format!(" NumberOfComponents=\"{components}\"");
        }
        Self { attributes, data: values.flat_map(|x| x.to_le_bytes()).collect() }
    }

    fn field(field: &Field) -> Self {
        let mut array = Self::floats(&field.name, field.components, field.values.iter());
        // Beside the name, so that scripts find the field by its name alone.
        if !field.unit.is_empty() {
            array.attributes += &format!(" Unit=\"{}\"", escape(&field.unit));
        }
        array
    }

    fn integers(name: &str, values: impl Iterator<Item = usize>) -> Self {
        Self {
            attributes: format!("type=\"Int64\" Name=\"{name}\""),
            data: values.flat_map(|i| (i as i64).to_le_bytes()).collect(),
        }
    }
}

fn write(grid: &Grid, out: &mut dyn Write) -> io::Result<()> {
    let (points, cells, nodes) = (grid.points.len(), grid.cell_count(), grid.cell_type.nodes());
    let types = Array {
        attributes: "type=\"UInt8\" Name=\"types\"".into(),
        data: vec![grid.cell_type as u8; cells],
    };
    let groups = [
        ("PointData", grid.point_fields.iter().map(Array::field).collect()),
        ("CellData", grid.cell_fields.iter().map(Array::field).collect()),
        ("Points", vec![Array::floats("Points", 3, grid.points.iter().flatten())]),
        (
            "Cells",
            vec![
                Array::integers("connectivity", grid.cells.iter().copied()),
                Array::integers("offsets", (1..=cells).map(|i| i * nodes)),
                types,
            ],
        ),
    ];
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    let size = |array: &Array| size_of::<u64>() + array.data.len();
    let arrays = || groups.iter().flat_map(|(_, arrays)| arrays);
    // The data stand in reverse order. meshio moves the arrays one after the other as they
    // stand, and looks each up by its offset, the first of that in the header. In any other order
    // that might be one it has moved already, whose new offset is by chance the same.
    let mut offset: usize = arrays().map(size).sum();
    for (name, arrays) in &groups {
        writeln!(out, "<{name}>")?;
        for array in arrays {
            offset -= size(array);
            let attributes = &array.attributes;
            writeln!(out, "<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>")?;
        }
        writeln!(out, "</{name}>")?;
    }
    write!(out, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_")?;
    for Array { data, .. } in arrays().rev() {
        out.write_all(&(data.len() as u64).to_le_bytes())?;
        out.write_all(data)?;
    }
    write!(out, "\n</AppendedData>\n</VTKFile>\n")
}

/// Writes a time series: pairs of time [s] and file name relative to `path`.
pub fn write_pvd(path: &Path, steps: &[(f64, String)]) -> Result<(), IoError> {
    write_atomic(path, |out| {
        writeln!(out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">")?;
        writeln!(out, "<Collection>")?;
        for (time, file) in steps {
            let file = escape(file);
            writeln!(out, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>")?;
        }
        writeln!(out, "</Collection>\n</VTKFile>")
    })
}

/// Text as an XML attribute.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
