//! A mesh with tags.

use std::path::PathBuf;
use std::sync::Arc;

use mesh::io::MshFile;
use mesh::{TetMesh, Vec3};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::computing::compute;
use crate::error::{refused, refused_as};

/// A tetrahedral mesh whose facets and parts have names.
#[pyclass(frozen, module = "softpuffer._native")]
pub struct Body {
    pub file: Arc<MshFile>,
}

#[pymethods]
impl Body {
    /// From arrays: vertices (n, 3) [m], tetrahedra (m, 4), facets (k, 3) of each tag, tetrahedra of
    /// each volume.
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        tets: PyReadonlyArray2<'_, i64>,
        tags: Vec<(String, PyReadonlyArray2<'_, i64>)>,
        volumes: Vec<(String, PyReadonlyArray1<'_, i64>)>,
    ) -> PyResult<Self> {
        let mesh = TetMesh { vertices: points(&vertices)?, tets: indices(&tets, "tets")? };
        let facets = |(name, of): &(String, PyReadonlyArray2<'_, i64>)| {
            Ok((name.clone(), indices(of, &format!("tag \"{name}\""))?))
        };
        let tags = tags.iter().map(facets).collect::<PyResult<Vec<_>>>()?;
        let parts = |(name, of): &(String, PyReadonlyArray1<'_, i64>)| {
            let index = |&i: &i64| index(i, &format!("volume \"{name}\""));
            Ok((name.clone(), of.as_array().iter().map(index).collect::<PyResult<Vec<_>>>()?))
        };
        let volumes = volumes.iter().map(parts).collect::<PyResult<Vec<_>>>()?;
        let made = compute(py, || mesh::io::tagged_mesh(&mesh, &tags, &volumes))?;
        let file = made.map_err(refused_as)?;
        Ok(Self { file: Arc::new(file) })
    }

    /// Reads a mesh of Gmsh, as the tagger writes it.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = compute(py, || mesh::io::read_tets(&path))?.map_err(refused)?;
        Ok(Self { file: Arc::new(file) })
    }

    /// Writes it as a mesh of Gmsh.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let write = || mesh::io::write_tets(&path, &self.file.mesh, &self.file.tags);
        compute(py, write)?.map_err(refused)
    }

    /// Positions (n, 3) [m], a copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.file.mesh.vertices)
    }

    /// Vertices of each tetrahedron (m, 4), a copy.
    #[getter]
    fn tets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        table(py, &self.file.mesh.tets)
    }

    /// The facets (k, 3) of each tag by its name, copies.
    #[getter]
    fn tags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let tags = &self.file.tags;
        let found = PyDict::new(py);
        for name in &tags.names {
            let facets = tags.id(name).map(|id| tags.facets_of(id)).unwrap_or_default();
            found.set_item(name, table(py, &facets)?)?;
        }
        Ok(found)
    }

    /// The tetrahedra of each volume by its name, copies; empty without volumes.
    #[getter]
    fn volumes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let volumes = &self.file.tags.volumes;
        for (k, name) in volumes.names.iter().enumerate() {
            let own = volumes.of.iter().enumerate().filter(|(_, of)| **of == k);
            let own: Vec<i64> = own.map(|(tet, _)| tet as i64).collect();
            found.set_item(name, PyArray1::from_vec(py, own))?;
        }
        Ok(found)
    }
}

/// Rows of three numbers as points; none of them may be infinite or not a number.
pub fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec3>> {
    has_columns(array.shape(), 3, "vertices")?;
    let view = array.as_array();
    Ok(view.rows().into_iter().map(|row| Vec3::new(row[0], row[1], row[2])).collect())
}

fn has_columns(shape: &[usize], columns: usize, what: &str) -> PyResult<()> {
    if shape[1] == columns {
        return Ok(());
    }
    Err(refused_as(format!("{what}: an array of shape {shape:?}, needed (n, {columns})")))
}

fn indices<const N: usize>(
    array: &PyReadonlyArray2<'_, i64>,
    what: &str,
) -> PyResult<Vec<[usize; N]>> {
    has_columns(array.shape(), N, what)?;
    let view = array.as_array();
    let row = |row: numpy::ndarray::ArrayView1<'_, i64>| -> PyResult<[usize; N]> {
        let mut own = [0; N];
        for (to, &i) in own.iter_mut().zip(row) {
            *to = index(i, what)?;
        }
        Ok(own)
    };
    view.rows().into_iter().map(row).collect()
}

fn index(i: i64, what: &str) -> PyResult<usize> {
    usize::try_from(i).map_err(|_| refused_as(format!("{what}: index {i}, needed 0 or more")))
}

/// Points as rows of three numbers.
pub fn vectors<'py>(py: Python<'py>, points: &[Vec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    by_rows(py, points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(), 3)
}

/// Numbers in rows of a length.
pub fn by_rows<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let rows = numbers.len() / columns;
    numbers.into_pyarray(py).reshape([rows, columns])
}

fn table<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[usize; N]],
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    by_rows(py, rows.iter().flatten().map(|&i| i as i64).collect(), N)
}
