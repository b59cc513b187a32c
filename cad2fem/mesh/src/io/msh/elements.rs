//! Element types of Gmsh.

use super::Raw;
use super::source::Source;
use crate::io::Parsed;

/// What of an element is kept.
#[derive(Clone, Copy)]
pub enum Shape {
    /// Points and lines: nothing.
    Ignored,
    Triangle,
    Tetrahedron,
}

/// Shape and number of nodes of an element type.
pub fn element_type(number: i32) -> Parsed<(Shape, usize)> {
    use Shape::{Ignored, Tetrahedron, Triangle};
    Ok(match number {
        15 => (Ignored, 1),
        1 => (Ignored, 2),
        8 => (Ignored, 3),
        26 => (Ignored, 4),
        27 => (Ignored, 5),
        28 => (Ignored, 6),
        2 => (Triangle, 3),
        9 => (Triangle, 6),
        20 => (Triangle, 9),
        21 => (Triangle, 10),
        22 => (Triangle, 12),
        23 => (Triangle, 15),
        24 => (Triangle, 15),
        25 => (Triangle, 21),
        4 => (Tetrahedron, 4),
        11 => (Tetrahedron, 10),
        29 => (Tetrahedron, 20),
        30 => (Tetrahedron, 35),
        31 => (Tetrahedron, 56),
        other => {
            let name = match other {
                3 | 10 | 16 => " (quadrangle)",
                5 | 12 | 17 => " (hexahedron)",
                6 | 13 | 18 => " (prism)",
                7 | 14 | 19 => " (pyramid)",
                _ => "",
            };
            return Err(format!(
                "an element of type {other}{name}; only points, lines, triangles and tetrahedra \
                 are understood, so mesh without recombination"
            ));
        }
    })
}

impl Raw {
    /// Keeps the corners of an element whose `nodes` follow in the source.
    pub fn add_element(
        &mut self,
        (shape, nodes): (Shape, usize),
        group: i32,
        mut node: impl FnMut() -> Parsed<u64>,
    ) -> Parsed<()> {
        let mut corners = [0; 4];
        for i in 0..nodes {
            let number = node()?;
            // Corners come first; nodes on edges and facets follow.
            if let Some(corner) = corners.get_mut(i) {
                *corner = number;
            }
        }
        let [a, b, c, d] = corners;
        match shape {
            Shape::Ignored => {}
            Shape::Triangle => self.triangles.push(([a, b, c], group)),
            Shape::Tetrahedron => self.tets.push(([a, b, c, d], group)),
        }
        Ok(())
    }
}

/// A node number of format 2.
pub fn node_number(source: &mut Source) -> Parsed<u64> {
    let number = source.int()?;
    u64::try_from(number).map_err(|_| format!("node number {number} is negative"))
}
