//! VTK unstructured grids (`.vtu`) and their time series (`.pvd`), for ParaView.
//!
//! Nodes of quadratic cells are in VTK's order: the corners, then the middles of
//! the edges listed by [`CellType::edges`]. Those of cubic cells: the corners,
//! the thirds of these edges from their first end to their second, then the
//! centres of the faces 013, 123, 023, 012.

mod lower;
mod read;
mod write;

use crate::Vec3;

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
