//! The whole of which a body or a result is a part: it and its mirror image, joined in the
//! plane.
//!
//! What is given keeps its place and numbers; images follow, in the same order. Two corners
//! of each image are exchanged, so that volumes stay positive.

use mechanics::element::node_indices;
use mechanics::symmetry::Plane;
use mesh::io::vtu::{CellType, Field, Grid};
use mesh::{Tags, TetMesh, Vec3, facet_key};

/// Distance from the plane at which a point of a grid counts as in it, in diagonals of
/// the grid [1].
const OFF_PLANE: f64 = 1e-12;

/// A mesh with its mirror image. Vertices of the cut are shared, and its tags vanish.
pub fn mirror_body(mesh: &TetMesh, tags: &Tags, plane: &Plane) -> (TetMesh, Tags) {
    let (vertices, image) = with_images(&mesh.vertices, |v| plane.contains(v), |x| plane.mirror(x));
    let mut tets = mesh.tets.clone();
    tets.extend(mesh.tets.iter().map(|&[a, b, c, d]| [b, a, c, d].map(|v| image[v])));
    let kept: Vec<&String> = tags.names.iter().filter(|name| !plane.tags.contains(name)).collect();
    let mut whole = Tags::new(kept.into_iter().cloned().collect());
    for (&facet, &id) in &tags.facets {
        if let Some(id) = whole.id(&tags.names[id as usize - 1]) {
            whole.set(facet, id);
            whole.set(facet_key(facet.map(|v| image[v])), id);
        }
    }
    whole.volumes = tags.volumes.clone();
    whole.volumes.of.extend(&tags.volumes.of);
    (TetMesh { vertices, tets }, whole)
}

/// A grid with its mirror image in the plane across an axis at `level` [m]. Points in it
/// are shared; vectors and tensors are mirrored.
pub fn mirror_grid(grid: &Grid, axis: usize, level: f64) -> Grid {
    let near = OFF_PLANE * mesh::measure::diagonal(&grid.points);
    let in_plane = |p: usize| (grid.points[p][axis] - level).abs() <= near;
    let (points, image) = with_images(&grid.points, in_plane, |mut x| {
        x[axis] = 2.0 * level - x[axis];
        x
    });
    let order = exchanged(grid.cell_type);
    let mut cells = grid.cells.clone();
    for cell in grid.cells.chunks_exact(order.len()) {
        cells.extend(order.iter().map(|&i| image[cell[i]]));
    }
    let images: Vec<usize> = (0..image.len()).filter(|&p| image[p] != p).collect();
    let all: Vec<usize> = (0..grid.cell_count()).collect();
    let mirrored = |fields: &[Field], of: &[usize]| -> Vec<Field> {
        fields.iter().map(|field| mirror_field(field, of, axis)).collect()
    };
    Grid {
        points,
        cells,
        cell_type: grid.cell_type,
        point_fields: mirrored(&grid.point_fields, &images),
        cell_fields: mirrored(&grid.cell_fields, &all),
    }
}

/// Points with the images of those that are not in the plane, and of each point the index
/// of its image.
fn with_images(
    points: &[Vec3],
    in_plane: impl Fn(usize) -> bool,
    mirror: impl Fn(Vec3) -> Vec3,
) -> (Vec<Vec3>, Vec<usize>) {
    let mut all = points.to_vec();
    let image = (0..points.len()).map(|p| {
        if in_plane(p) {
            return p;
        }
        all.push(mirror(points[p]));
        all.len() - 1
    });
    let image = image.collect();
    (all, image)
}

/// A field with the mirror images of some of its entries.
fn mirror_field(field: &Field, of: &[usize], axis: usize) -> Field {
    let n = field.components;
    // a component changes its sign once for each of its indices that is the axis
    let sign = |i: usize| match n {
        3 if i == axis => -1.0,
        9 if (i / 3 == axis) != (i % 3 == axis) => -1.0,
        _ => 1.0,
    };
    let mut values = field.values.clone();
    for &entry in of {
        values.extend((0..n).map(|i| sign(i) * field.values[n * entry + i]));
    }
    Field { values, ..field.clone() }
}

/// Nodes of a cell whose first two corners are exchanged, in the order of its type.
fn exchanged(cell_type: CellType) -> Vec<usize> {
    let degree = match cell_type {
        CellType::Tri3 | CellType::Tet4 => 1,
        CellType::Tri6 | CellType::Tet10 => 2,
        CellType::Tet20 => 3,
    };
    // our order of nodes is that of VTK
    let nodes = node_indices(cell_type.corners(), degree);
    let image = |node: &Vec<usize>| {
        let mut image = node.clone();
        image.swap(0, 1);
        nodes.iter().position(|other| *other == image).expect("a cell is its own mirror image")
    };
    nodes.iter().map(image).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::body::Body;
    use mechanics::element::FunctionSpace;
    use mechanics::testing::cube;

    use super::super::results;
    use super::*;

    /// A cube with a tag on x = 0 and one on z = 0.
    fn body() -> Body {
        let mesh = cube(2, 0.2);
        let mut tags = Tags::new(vec!["cut".to_owned(), "seat".to_owned()]);
        for facet in mesh::topology::boundary(&mesh).facets {
            let c = facet.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0;
            if let Some(id) = [c.x, c.z].iter().position(|d| d.abs() < 1e-12) {
                tags.set(facet, id as u32 + 1);
            }
        }
        Body::new(mesh, tags).cut_by(&[vec!["cut".to_owned()]]).unwrap()
    }

    /// A linear field is its own mirror image on all nodes of all degrees: where the order of
    /// the nodes in a cell is wrong, the mirrored grid is not that of the mirrored body.
    #[test]
    fn a_mirrored_grid_is_the_grid_of_the_mirrored_body() {
        let half = body();
        let (whole, _) = mirror_body(&half.mesh, &half.tags, &half.planes[0]);
        for degree in 1..=3 {
            let grid = |mesh: &TetMesh| {
                let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
                let nodes = space.node_positions(&mesh.vertices);
                let u = nodes.iter().flat_map(|x| [0.3 * x.x, 0.1 * x.z, x.x.abs()]);
                results::grid(&space, &mesh.vertices, &u.collect::<Vec<f64>>())
            };
            let (mirrored, expected) = (mirror_grid(&grid(&half.mesh), 0, 0.0), grid(&whole));
            assert_eq!(mirrored.points.len(), expected.points.len());
            let at = |grid: &Grid, i: usize| {
                let (p, u) = (grid.cells[i], &grid.point_fields[0].values);
                (grid.points[p], Vec3::from_column_slice(&u[3 * p..3 * p + 3]))
            };
            for i in 0..expected.cells.len() {
                let ((x, u), (y, v)) = (at(&mirrored, i), at(&expected, i));
                assert!((x - y).norm() < 1e-15 && (u - v).norm() < 1e-15, "{degree} {i}");
            }
            let ratios = mirrored.cell_fields[0].values.iter().zip(&expected.cell_fields[0].values);
            assert!(ratios.into_iter().all(|(a, b)| (a - b).abs() < 1e-14));
        }
    }
}
