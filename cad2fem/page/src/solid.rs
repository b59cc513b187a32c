//! A mesh of tetrahedra for the page: nodes, the boundary with its tags, and the inside, so
//! that a cut shows what is there.
//!
//! A quadratic facet is given by its corners and the middles of its sides; the page divides it
//! into four triangles, and a quadratic tetrahedron into eight. What lies inside is left out
//! of large meshes: a cut through them shows the walls.

use std::collections::HashMap;

use mesh::io::MshFile;
use mesh::io::vtu::{Field, Grid, TET_FACETS, outer_facets};
use mesh::{Vec3, triangle_key};
use serde_json::{Value, json};

use crate::store::Store;

/// Nodes of the largest mesh whose inside is in the page.
const LARGEST: usize = 150_000;

/// Tags by places of facets.
#[derive(Clone, Debug, Default)]
pub struct TagsByPlace {
    names: Vec<String>,
    of: HashMap<[[u64; 3]; 3], usize>,
}

impl TagsByPlace {
    /// Adds the tags of a mesh that was moved by `shift` [m]; those of a body that has a name
    /// are called `body.tag`, as scenes do.
    pub fn add(&mut self, file: &MshFile, body: Option<&str>, shift: &Vec3) {
        let first = self.names.len();
        let full = |tag: &String| body.map_or_else(|| tag.clone(), |body| format!("{body}.{tag}"));
        self.names.extend(file.tags.names.iter().map(full));
        for (facet, &id) in &file.tags.facets {
            let place = triangle_key(&facet.map(|v| file.mesh.vertices[v] + shift));
            self.of.insert(place, first + id as usize - 1);
        }
    }
}

/// A mesh, ready to be packed.
#[derive(Clone, Debug)]
pub struct Solid {
    /// All points of the file, used or not [m].
    points: Vec<Vec3>,
    /// Nodes per cell, 4 or 10, and all cells.
    cells: (usize, Vec<usize>),
    /// Nodes per facet, 3 or 6, and the facets of the boundary.
    facets: (usize, Vec<usize>),
    /// The cell behind each facet.
    behind: Vec<usize>,
    /// The points that the page has, ascending.
    kept: Vec<usize>,
    /// Whether the page has the cells.
    inside: bool,
}

impl Solid {
    /// The solid of a grid; none if its cells are not tetrahedra.
    pub fn of_grid(grid: &Grid) -> Option<Self> {
        let nodes = grid.cell_type.nodes();
        let is_known = grid.cell_type.corners() == 4 && nodes <= 10;
        is_known.then(|| Self::new(grid.points.clone(), nodes, grid.cells.clone()))
    }

    /// The solid of a mesh.
    pub fn of_mesh(file: &MshFile) -> Self {
        let cells = file.mesh.tets.iter().flatten().copied().collect();
        Self::new(file.mesh.vertices.clone(), 4, cells)
    }

    fn new(points: Vec<Vec3>, nodes: usize, cells: Vec<usize>) -> Self {
        let (facets, behind) = boundary(nodes, &cells);
        let per_facet = if nodes == 10 { 6 } else { 3 };
        let inside = points.len() <= LARGEST;
        let mut kept = if inside { cells.clone() } else { facets.clone() };
        kept.sort_unstable();
        kept.dedup();
        Self { points, cells: (nodes, cells), facets: (per_facet, facets), behind, kept, inside }
    }

    /// Numbers that each state of this solid has in the page, for one point field of a vector.
    pub fn nodes(&self) -> usize {
        self.kept.len()
    }

    /// Whether another grid has the same cells and points.
    pub fn is_of(&self, grid: &Grid) -> bool {
        self.cells.1 == grid.cells && self.points == grid.points
    }

    /// All points of the file [m].
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Nodes per facet, 3 or 6, and those of all facets of the boundary, corners first.
    pub fn boundary(&self) -> (usize, &[usize]) {
        (self.facets.0, &self.facets.1)
    }

    /// Nodes of all sides of all cells, as many for each as a facet has; none where the page has no cells.
    pub fn sides_of_cells(&self) -> Option<Vec<usize>> {
        let nodes = self.facets.0;
        let side = |cell: &[usize], side: &[usize; 6]| side.map(|i| cell[i.min(cell.len() - 1)]);
        let sides =
            |cell| TET_FACETS.iter().flat_map(move |s| side(cell, s).into_iter().take(nodes));
        self.inside.then(|| self.cells.1.chunks_exact(self.cells.0).flat_map(sides).collect())
    }

    /// The numbers that nodes have in the page.
    pub fn numbers_of(&self, nodes: &[usize]) -> Vec<usize> {
        // kept is ascending
        nodes.iter().map(|v| self.kept.partition_point(|kept| kept < v)).collect()
    }

    /// Nodes, facets, tags, and cells where the page has them.
    #[must_use = "the page finds the blobs by what is returned"]
    pub fn packed(&self, tags: &TagsByPlace, store: &mut Store) -> Value {
        let nodes: Vec<f64> =
            self.kept.iter().flat_map(|&v| [0, 1, 2].map(|c| self.points[v][c])).collect();
        let facets = store.indices(&self.numbers_of(&self.facets.1), self.facets.0);
        let of_facet: Vec<usize> =
            self.facets.1.chunks_exact(self.facets.0).map(|f| self.tag(tags, f)).collect();
        let mut packed = json!({
            "nodes": store.numbers(&nodes, 3),
            "facets": facets,
            "tags": tags.names,
            "tagOfFacet": store.indices(&of_facet, 1),
        });
        if self.inside {
            packed["cells"] = store.indices(&self.numbers_of(&self.cells.1), self.cells.0);
            packed["cellOfFacet"] = store.indices(&self.behind, 1);
        }
        packed
    }

    /// The tag of a facet by number, its number of names for none.
    fn tag(&self, tags: &TagsByPlace, facet: &[usize]) -> usize {
        let corners = [facet[0], facet[1], facet[2]].map(|v| self.points[v]);
        tags.of.get(&triangle_key(&corners)).copied().unwrap_or(tags.names.len())
    }

    /// A field at the points that the page has.
    #[must_use = "the page finds the blob by what is returned"]
    pub fn point_field(&self, field: &Field, store: &mut Store) -> Value {
        self.field(field, "nodes", &self.kept, store)
    }

    /// A field of the cells, or of those behind the facets where the page has no cells.
    #[must_use = "the page finds the blob by what is returned"]
    pub fn cell_field(&self, field: &Field, store: &mut Store) -> Value {
        let all: Vec<usize> = (0..self.cells.1.len() / self.cells.0).collect();
        let shown = if self.inside { &all } else { &self.behind };
        self.field(field, if self.inside { "cells" } else { "facets" }, shown, store)
    }

    fn field(&self, field: &Field, at: &str, shown: &[usize], store: &mut Store) -> Value {
        let n = field.components;
        let values: Vec<f64> =
            shown.iter().flat_map(|&i| &field.values[i * n..(i + 1) * n]).copied().collect();
        json!({ "name": field.name, "unit": field.unit, "at": at, "values": store.numbers(&values, n) })
    }
}

/// The facets that only one cell has, seen from outside, and that cell of each.
fn boundary(nodes: usize, cells: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let cells: Vec<&[usize]> = cells.chunks_exact(nodes).collect();
    let outer = outer_facets(&cells);
    let per_facet = if nodes == 10 { 6 } else { 3 };
    let facets =
        outer.iter().flat_map(|&(c, f)| TET_FACETS[f][..per_facet].iter().map(move |&i| (c, i)));
    (facets.map(|(c, i)| cells[c][i]).collect(), outer.iter().map(|o| o.0).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use mesh::io::vtu::CellType;
    use mesh::{Tags, TetMesh};

    use super::*;

    /// Two tetrahedra that share a facet, and a point that none uses.
    fn pair() -> MshFile {
        let vertices =
            vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(1.0, 1.0, 1.0)];
        let mut tags = Tags::new(vec!["floor".into(), "cavity".into()]);
        tags.set([0, 1, 2], 2);
        MshFile { mesh: TetMesh { vertices, tets: vec![[0, 1, 2, 3], [1, 2, 3, 4]] }, tags }
    }

    #[test]
    fn the_boundary_faces_outward_and_leaves_shared_facets_out() {
        let file = pair();
        let solid = Solid::of_mesh(&file);
        assert_eq!((solid.facets.1.len(), solid.behind.len()), (6 * 3, 6));
        let middle = |cell: usize| file.mesh.corners(cell).iter().sum::<Vec3>() / 4.0;
        for (facet, &cell) in solid.facets.1.chunks_exact(3).zip(&solid.behind) {
            let [a, b, c] = [0, 1, 2].map(|i| file.mesh.vertices[facet[i]]);
            assert!((b - a).cross(&(c - a)).dot(&(a - middle(cell))) > 0.0);
        }
    }

    #[test]
    fn tags_are_found_by_place_in_a_file_with_other_numbers() {
        let file = pair();
        let mut tags = TagsByPlace::default();
        tags.add(&file, None, &Vec3::zeros());
        // the same points in the opposite order, after one that no cell uses
        let points: Vec<Vec3> =
            file.mesh.vertices.iter().rev().chain([&Vec3::zeros()]).copied().collect();
        let cells: Vec<usize> = vec![4, 3, 2, 1, 3, 2, 1, 0];
        let grid = Grid {
            points,
            cells,
            cell_type: CellType::Tet4,
            point_fields: vec![],
            cell_fields: vec![],
        };
        let solid = Solid::of_grid(&grid).unwrap();
        assert_eq!(solid.nodes(), 5);
        let found: Vec<usize> =
            solid.facets.1.chunks_exact(3).map(|f| solid.tag(&tags, f)).collect();
        assert_eq!(found.iter().filter(|&&t| t == 1).count(), 1);
        assert_eq!(found.iter().filter(|&&t| t == 2).count(), 5, "no tag");
        assert!(solid.is_of(&grid));

        let shift = Vec3::new(0.1, 0.2, 0.3);
        let moved = Grid { points: grid.points.iter().map(|p| p + shift).collect(), ..grid };
        let mut tags = TagsByPlace::default();
        tags.add(&file, Some("arm"), &shift);
        let solid = Solid::of_grid(&moved).unwrap();
        let tagged = solid.facets.1.chunks_exact(3).filter(|f| solid.tag(&tags, f) == 1);
        assert_eq!((tagged.count(), &tags.names[1][..]), (1, "arm.cavity"));
    }
}
