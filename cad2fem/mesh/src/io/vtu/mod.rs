//! VTK unstructured grids (`.vtu`) and their time series (`.pvd`), for ParaView.
//!
//! Nodes of quadratic cells are in VTK's order: the corners, then the middles of
//! the edges listed by [`CellType::edges`]. Those of cubic cells: the corners,
//! the thirds of these edges from their first end to their second, then the
//! centres of the faces 013, 123, 023, 012.

mod lower;
mod read;
mod write;

use crate::{Vec3, facet_key};

pub use read::read_vtu;
pub use write::{write_pvd, write_vtu};

/// Shape of the cells; the value is VTK's number for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellType {
    /// Triangle.
    Tri3 = 5,
    /// Tetrahedron.
    Tet4 = 10,
    /// Triangle with a node on every edge.
    Tri6 = 22,
    /// Tetrahedron with a node on every edge.
    Tet10 = 24,
    /// Tetrahedron with two nodes on every edge and one on every face
    /// (VTK_LAGRANGE_TETRAHEDRON of degree 3).
    Tet20 = 71,
}

impl CellType {
    const ALL: [Self; 5] = [Self::Tri3, Self::Tet4, Self::Tri6, Self::Tet10, Self::Tet20];

    /// Number of corners.
    pub fn corners(self) -> usize {
        match self {
            Self::Tri3 | Self::Tri6 => 3,
            Self::Tet4 | Self::Tet10 | Self::Tet20 => 4,
        }
    }

    /// The corners at the ends of the edges that have nodes inside, in the order
    /// of these nodes; empty for cells without such nodes.
    pub fn edges(self) -> &'static [[usize; 2]] {
        match self {
            Self::Tri3 | Self::Tet4 => &[],
            Self::Tri6 => &[[0, 1], [1, 2], [2, 0]],
            Self::Tet10 | Self::Tet20 => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        }
    }

    /// Number of nodes.
    pub fn nodes(self) -> usize {
        let inside =
            if self == Self::Tet20 { 2 * self.edges().len() + 4 } else { self.edges().len() };
        self.corners() + inside
    }
}

/// Corners of the facets of a tetrahedron seen from outside, then the nodes on their sides where a quadratic one has
/// them.
pub const TET_FACETS: [[usize; 6]; 4] =
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [0, 3, 2, 7, 9, 6], [1, 2, 3, 5, 9, 8]];

/// The facets that only one of some tetrahedra of 4 or 10 nodes has: the number of that cell, and which of its
/// [`TET_FACETS`], in the order of cells.
pub fn outer_facets(cells: &[&[usize]]) -> Vec<(usize, usize)> {
    let mut keys = Vec::with_capacity(4 * cells.len());
    for (c, cell) in cells.iter().enumerate() {
        for (f, facet) in TET_FACETS.iter().enumerate() {
            keys.push((facet_key([cell[facet[0]], cell[facet[1]], cell[facet[2]]]), c, f));
        }
    }
    keys.sort_unstable();
    let single = keys.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let mut outer: Vec<(usize, usize)> = single.map(|side| (side[0].1, side[0].2)).collect();
    outer.sort_unstable();
    outer
}

/// Named numbers at points or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, without unit.
    pub name: String,
    /// Unit, empty if it has none. In the file it is an attribute of the array.
    pub unit: String,
    /// Numbers per point or cell: 1 scalar, 3 vector, 9 tensor by rows.
    pub components: usize,
    /// The numbers of the first point or cell, of the second, and so on.
    pub values: Vec<f64>,
}

impl Field {
    /// Numbers with a name and a unit.
    pub fn new(name: &str, unit: &str, components: usize, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), components, values }
    }
}

/// Points, cells of one shape, and fields on both.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Positions [m].
    pub points: Vec<Vec3>,
    /// Points of all cells, [`CellType::nodes`] each, in VTK's order.
    pub cells: Vec<usize>,
    /// Shape of all cells.
    pub cell_type: CellType,
    /// Fields at the points.
    pub point_fields: Vec<Field>,
    /// Fields of the cells.
    pub cell_fields: Vec<Field>,
}

impl Grid {
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / self.cell_type.nodes()
    }
}

#[cfg(test)]
mod tests;
