//! Directions of fibres that are not a formula: from a file, a unit vector for each element.

use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::energy::Directions;
use mesh::Vec3;
use mesh::io::npy::read_f64;
use mesh::io::vtu::{Field, Grid, read_vtu};
use program::misfit;

use super::FibreConfig;
use crate::term::Ground;

/// Where the fibres of a family lead, in the elements that it is in.
pub(super) fn directions_of(
    fibre: &FibreConfig,
    ground: &Ground,
    elements: Range<usize>,
) -> Result<Directions> {
    let body = ground.body;
    let tets = &body.mesh.tets[elements.clone()];
    if let Some(formula) = fibre.leads()? {
        return Ok(formula);
    }
    let key = fibre.title().key("file");
    let path = ground.path.with_file_name(fibre.file.as_deref().unwrap_or(Path::new("")));
    let vectors = read(&path, fibre.field.as_deref(), body, elements);
    let vectors = vectors.with_context(|| key.clone())?;
    let unit = |(vector, tet): (Vec3, &[usize; 4])| {
        let (length, at) = (vector.norm(), centre(body, tet));
        ensure!(
            length > 0.0 && length.is_finite(),
            misfit!(
                key.clone(),
                ": no direction in the element at ({:.6}, {:.6}, {:.6}) m, where the vector is [{}, {}, {}]; \
                 expected one of a positive, finite length in each element",
                at.x,
                at.y,
                at.z,
                vector.x,
                vector.y,
                vector.z
            )
        );
        Ok(vector / length)
    };
    let units: Result<Vec<Vec3>> = vectors.into_iter().zip(tets).map(unit).collect();
    Ok(Directions::Elements(units?.into()))
}

fn centre(body: &Body, tet: &[usize; 4]) -> Vec3 {
    tet.iter().map(|&v| body.mesh.vertices[v]).sum::<Vec3>() / 4.0
}

/// The vectors of some elements in a file.
fn read(
    path: &Path,
    field: Option<&str>,
    body: &Body,
    elements: Range<usize>,
) -> Result<Vec<Vec3>> {
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npy"));
    let rows = if is_table {
        let (values, shape) = read_f64(path)?;
        ensure!(
            shape.len() == 2 && shape[1] == 3,
            "{}: an array of shape {shape:?}; expected three columns, [n, 3]",
            path.display()
        );
        vectors(&values)
    } else {
        of_grid(path, &read_vtu(path)?, field)?
    };
    let Body { mesh, .. } = body;
    if rows.len() == mesh.tets.len() {
        return Ok(rows[elements].to_vec());
    }
    if rows.len() == elements.len() {
        return Ok(rows);
    }
    ensure!(
        rows.len() == mesh.vertices.len(),
        "{}: {} vectors; expected one for each of the {} tetrahedra of the mesh in its order, of the {} of this family, \
         or of the {} vertices",
        path.display(),
        rows.len(),
        mesh.tets.len(),
        elements.len(),
        mesh.vertices.len()
    );
    Ok(mesh.tets[elements].iter().map(|tet| mean(tet.map(|v| rows[v]))).collect())
}

fn vectors(values: &[f64]) -> Vec<Vec3> {
    values.chunks_exact(3).map(Vec3::from_column_slice).collect()
}

/// The vectors of the cells of a grid; those of points as means over the corners of cells.
fn of_grid(path: &Path, grid: &Grid, name: Option<&str>) -> Result<Vec<Vec3>> {
    let is_vector = |field: &&Field| field.components == 3;
    let find = |fields: &[Field]| {
        let mut vectors = fields.iter().filter(is_vector);
        vectors.find(|field| Some(field.name.as_str()) == name).map(vectors_of)
    };
    if let Some(cells) = find(&grid.cell_fields) {
        return Ok(cells);
    }
    let Some(points) = find(&grid.point_fields) else {
        let all = grid.cell_fields.iter().chain(&grid.point_fields).filter(is_vector);
        let known: Vec<&str> = all.map(|field| field.name.as_str()).collect();
        anyhow::bail!(
            "{}: no vectors called \"{}\"; expected field = one of: {}",
            path.display(),
            name.unwrap_or(""),
            if known.is_empty() { "(the file has none)".to_owned() } else { known.join(", ") }
        )
    };
    ensure!(
        grid.cell_type.corners() == 4,
        "{}: cells with {} corners; expected tetrahedra",
        path.display(),
        grid.cell_type.corners()
    );
    let cells = grid.cells.chunks_exact(grid.cell_type.nodes());
    Ok(cells.map(|cell| mean([0, 1, 2, 3].map(|k| points[cell[k]]))).collect())
}

fn vectors_of(field: &Field) -> Vec<Vec3> {
    vectors(&field.values)
}

/// The mean of vectors whose sense does not count.
fn mean(vectors: [Vec3; 4]) -> Vec3 {
    let sense = |v: &Vec3| if v.dot(&vectors[0]) < 0.0 { -1.0 } else { 1.0 };
    vectors.iter().map(|v| sense(v) * v).sum()
}
