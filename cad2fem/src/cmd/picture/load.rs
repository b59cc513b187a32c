//! Files → shapes.

use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use mesh::io::vtu::{Field, Grid, TET_FACETS, outer_facets, read_vtu};
use mesh::io::{extension, read_surface, read_tets};
use mesh::{SurfaceMesh, Vec3, topology};

use super::options::Component;
use render::color::{self, Rgb};
use render::quadratic::{Curved, flatten};
use render::shape::{Cells, Shape, Triangle, shade};

/// Facets that curved ones are divided into, about.
const SMOOTH: usize = 150_000;

/// How a file is coloured and deformed.
pub struct Paint<'a> {
    /// Colour where there is neither tag nor field.
    pub color: Rgb,
    /// Field of a `.vtu` that gives colours.
    pub field: Option<&'a Component>,
    /// Point field of a `.vtu` that moves points; `displacement` if absent.
    pub deform: Option<&'a str>,
    /// Factor on the deformation.
    pub magnify: f64,
    /// Whether tags have colours.
    pub tags: bool,
}

/// A file, ready to be drawn.
pub struct Loaded {
    /// What to draw.
    pub shape: Shape,
    /// Names of colours.
    pub names: Vec<(String, Rgb)>,
    /// Unit of the field, if the file has it.
    pub unit: Option<String>,
}

/// Reads a surface, a volume mesh or a result.
pub fn load(path: &Path, paint: &Paint) -> Result<Loaded> {
    let loaded = match extension(path).as_str() {
        "msh" => tagged(path, paint),
        "vtu" => result(&read_vtu(path)?.at_most_quadratic(), paint)
            .with_context(|| path.display().to_string()),
        _ => Ok(surface(&read_surface(path)?, paint)),
    }?;
    ensure!(!loaded.shape.facets.is_empty(), "{}: no triangle to draw", path.display());
    Ok(loaded)
}

fn triangle(points: [usize; 3], values: [f64; 3], color: Rgb) -> Triangle {
    Triangle { points, values, color, edges: 0b111 }
}

fn surface(surface: &SurfaceMesh, paint: &Paint) -> Loaded {
    let triangles: Vec<Triangle> =
        surface.triangles.iter().map(|&t| triangle(t, [f64::NAN; 3], paint.color)).collect();
    let shape = Shape {
        facets: shade(&surface.vertices, &triangles),
        cells: None,
        closed: topology::boundary_edges(&surface.triangles).is_empty(),
    };
    Loaded { shape, names: vec![], unit: None }
}

/// A volume mesh; every tag has a colour and a name.
fn tagged(path: &Path, paint: &Paint) -> Result<Loaded> {
    let file = read_tets(path)?;
    let named = paint.tags && !file.tags.facets.is_empty();
    let color = |facet: [usize; 3]| match file.tags.get(facet).filter(|_| named) {
        Some(id) => color::palette(id as usize - 1),
        None if named => color::untagged(),
        None => paint.color,
    };
    let boundary = topology::boundary(&file.mesh).facets;
    let triangles: Vec<Triangle> =
        boundary.iter().map(|&f| triangle(f, [f64::NAN; 3], color(f))).collect();
    let mut names: Vec<(String, Rgb)> = Vec::new();
    if named {
        let tags = file.tags.names.iter().enumerate();
        names.extend(tags.map(|(i, name)| (name.clone(), color::palette(i))));
        if boundary.iter().any(|&f| file.tags.get(f).is_none()) {
            names.push(("no tag".into(), color::untagged()));
        }
    }
    let volumes = &file.tags.volumes;
    let of_volume = |i: usize| color::palette(file.tags.names.len() + i);
    let inside = |t: usize| match volumes.of.get(t) {
        Some(&volume) if paint.tags => of_volume(volume),
        _ if named => color::untagged(),
        _ => paint.color,
    };
    if paint.tags {
        let volumes = volumes.names.iter().enumerate();
        names.extend(volumes.map(|(i, name)| (format!("{name} (volume)"), of_volume(i))));
    }
    let cells = Cells {
        nodes: file.mesh.tets.iter().map(|t| t.to_vec()).collect(),
        values: vec![vec![f64::NAN; 4]; file.mesh.tets.len()],
        colors: (0..file.mesh.tets.len()).map(inside).collect(),
        points: file.mesh.vertices,
    };
    let facets = shade(&cells.points, &triangles);
    Ok(Loaded { shape: Shape { facets, cells: Some(cells), closed: true }, names, unit: None })
}

/// A result: deformed, coloured by a field, curved cells made of small ones.
fn result(grid: &Grid, paint: &Paint) -> Result<Loaded> {
    let points = deformed(grid, paint)?;
    let (values, unit) = values(grid, paint.field)?;
    let cells: Vec<&[usize]> = grid.cells.chunks_exact(grid.cell_type.nodes()).collect();
    let (cells_of, faces): (Option<Cells>, Vec<Face>) = if grid.cell_type.corners() == 4 {
        let solid = Cells {
            points: points.clone(),
            nodes: cells.iter().map(|c| c.to_vec()).collect(),
            values: values.clone(),
            colors: vec![paint.color; cells.len()],
        };
        (Some(solid), outer_faces(&cells, &values))
    } else {
        let face = |(c, v): (&&[usize], &Vec<f64>)| Face { nodes: c.to_vec(), values: v.clone() };
        (None, cells.iter().zip(&values).map(face).collect())
    };
    let (points, triangles) = triangulate(&points, &faces, paint.color);
    let corners: Vec<_> = triangles.iter().map(|t| t.points).collect();
    let closed = topology::boundary_edges(&corners).is_empty();
    let facets = shade(&points, &triangles);
    Ok(Loaded { shape: Shape { facets, cells: cells_of, closed }, names: vec![], unit })
}

fn deformed(grid: &Grid, paint: &Paint) -> Result<Vec<Vec3>> {
    if paint.deform == Some("none") {
        return Ok(grid.points.clone());
    }
    let name = paint.deform.unwrap_or("displacement");
    let Some(field) = grid.point_fields.iter().find(|f| f.name == name) else {
        ensure!(paint.deform.is_none(), "--deform {name}: no such point field; {}", fields(grid));
        return Ok(grid.points.clone());
    };
    ensure!(
        field.components == 3,
        "--deform {name}: the field has {} components, 3 are needed",
        field.components
    );
    let shifts = field.values.chunks_exact(3).map(|u| paint.magnify * Vec3::new(u[0], u[1], u[2]));
    Ok(grid.points.iter().zip(shifts).map(|(p, u)| p + u).collect())
}

fn fields(grid: &Grid) -> String {
    let names = |fields: &[Field]| {
        let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    format!("at points: {}; in cells: {}", names(&grid.point_fields), names(&grid.cell_fields))
}

/// Values at the nodes of every cell, and their unit.
fn values(grid: &Grid, wanted: Option<&Component>) -> Result<(Vec<Vec<f64>>, Option<String>)> {
    let cells = grid.cells.chunks_exact(grid.cell_type.nodes());
    let Some(wanted) = wanted else {
        return Ok((cells.map(|c| vec![f64::NAN; c.len()]).collect(), None));
    };
    let named = |f: &&Field| f.name == wanted.field;
    if let Some(field) = grid.point_fields.iter().find(named) {
        let at = scalars(field, wanted)?;
        let values = cells.map(|c| c.iter().map(|&v| at[v]).collect()).collect();
        return Ok((values, Some(field.unit.clone())));
    }
    if let Some(field) = grid.cell_fields.iter().find(named) {
        let at = scalars(field, wanted)?;
        let values = cells.zip(at).map(|(c, v)| vec![v; c.len()]).collect();
        return Ok((values, Some(field.unit.clone())));
    }
    bail!("--color {}: no such field; {}", wanted.field, fields(grid))
}

/// One number per point or cell: the component, or the length.
fn scalars(field: &Field, wanted: &Component) -> Result<Vec<f64>> {
    let per = field.values.chunks_exact(field.components);
    match wanted.index {
        Some(i) => {
            ensure!(
                i < field.components,
                "--color {wanted}: the field has {} components, numbered from 0",
                field.components
            );
            Ok(per.map(|v| v[i]).collect())
        }
        None if field.components == 1 => Ok(field.values.clone()),
        None => Ok(per.map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()),
    }
}

/// A triangle of 3 or 6 nodes with their values.
struct Face {
    nodes: Vec<usize>,
    values: Vec<f64>,
}

/// The faces of tetrahedra that only one of them has, in order of cells.
fn outer_faces(cells: &[&[usize]], values: &[Vec<f64>]) -> Vec<Face> {
    let count = if cells.first().is_some_and(|c| c.len() == 10) { 6 } else { 3 };
    let pick = |(c, f): (usize, usize)| Face {
        nodes: TET_FACETS[f][..count].iter().map(|&i| cells[c][i]).collect(),
        values: TET_FACETS[f][..count].iter().map(|&i| values[c][i]).collect(),
    };
    outer_facets(cells).into_iter().map(pick).collect()
}

fn triangulate(points: &[Vec3], faces: &[Face], color: Rgb) -> (Vec<Vec3>, Vec<Triangle>) {
    let curved: Vec<Curved> = faces
        .iter()
        .filter_map(|f| {
            let nodes = f.nodes[..].try_into().ok()?;
            Some(Curved { nodes, values: f.values[..].try_into().ok()?, color })
        })
        .collect();
    if curved.len() == faces.len() && !faces.is_empty() {
        let n = (2..=4).rev().find(|n| n * n * faces.len() <= SMOOTH).unwrap_or(2);
        return flatten(points, &curved, n);
    }
    let straight = |f: &Face| {
        let corners = [f.nodes[0], f.nodes[1], f.nodes[2]];
        triangle(corners, [f.values[0], f.values[1], f.values[2]], color)
    };
    (points.to_vec(), faces.iter().map(straight).collect())
}
