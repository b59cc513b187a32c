//! A body whose boundary is moved along its normals.
//!
//! Its vertices move as [`mesh::offset`] says: along the normal where the boundary is smooth,
//! and further at an edge, whose both sides move by the distance. What is inside follows
//! harmonically on the graph of edges.
//!
//! A part of a symmetric body is cut by planes. Its mirror images count at vertices there, so that they move as those of
//! the whole body, within the plane. The cut itself is no wall.

use std::collections::BTreeMap;

use mesh::offset::shifts;
use mesh::{TetMesh, Vec3, measure, topology};

/// Sweeps over the inside, at most, and the change at which they end, in parts of t.
const SWEEPS: usize = 2000;
const SETTLED: f64 = 1e-4;
/// Distance from a plane that is rounding, in parts of the mean edge.
const IN_PLANE: f64 = 1e-6;

/// A wall that cannot be moved so far.
#[derive(Debug, thiserror::Error)]
#[error(
    "moving the boundary by {distance_mm:.3} mm turns {inverted} of {tets} tetrahedra inside out: \
     study a smaller tolerance, or a mesh whose edges (now {edge_mm:.3} mm on average) are longer"
)]
pub struct OffsetError {
    distance_mm: f64,
    inverted: usize,
    tets: usize,
    edge_mm: f64,
}

/// A plane of symmetry across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// 0 to 2.
    pub axis: usize,
    /// Coordinate on it [m].
    pub level: f64,
}

impl Cut {
    /// The plane at a coordinate [m] on the axis x, y or z; none on another.
    pub fn new(axis: &str, level: f64) -> Option<Self> {
        let axis = ["x", "y", "z"].iter().position(|name| *name == axis)?;
        Some(Self { axis, level })
    }

    /// Whether a point is in the plane.
    fn has(&self, x: &Vec3, near: f64) -> bool {
        (x[self.axis] - self.level).abs() <= near
    }
}

/// The mesh with its boundary moved outward by `distance` [m], inward if it is negative; cuts stay in their planes.
pub fn offset(mesh: &TetMesh, distance: f64, cuts: &[Cut]) -> Result<TetMesh, OffsetError> {
    let facets = topology::boundary(mesh).facets;
    let near = IN_PLANE * measure::mean_edge(&mesh.vertices, &facets);
    let (mut x, mut walls) = (mesh.vertices.clone(), facets.clone());
    for cut in cuts {
        walls.retain(|facet| !facet.iter().all(|&v| cut.has(&x[v], near)));
        add_image(&mut x, &mut walls, cut, near);
    }
    let mut moves = shifts(&x, &walls);
    moves.retain(|&v, _| v < mesh.vertices.len());
    moves.values_mut().for_each(|d| *d *= distance);
    let held: Vec<(usize, usize)> = cuts
        .iter()
        .flat_map(|cut| {
            let on_cut = move |v: &usize| cut.has(&mesh.vertices[*v], near);
            (0..mesh.vertices.len()).filter(on_cut).map(|v| (v, cut.axis))
        })
        .collect();
    let inside = follow(mesh, &moves, &held, SETTLED * distance.abs());
    let vertices = mesh.vertices.iter().zip(&inside).map(|(p, d)| p + d).collect();
    let moved = TetMesh { vertices, tets: mesh.tets.clone() };
    let volume = |t: usize| {
        let [a, b, c, d] = moved.corners(t);
        measure::tet_volume(a, b, c, d)
    };
    let inverted = (0..moved.tets.len()).filter(|&t| volume(t) <= 0.0).count();
    if inverted > 0 {
        return Err(OffsetError {
            distance_mm: distance * 1e3,
            inverted,
            tets: moved.tets.len(),
            edge_mm: measure::mean_edge(&mesh.vertices, &facets) * 1e3,
        });
    }
    Ok(moved)
}

/// Adds the mirror image of facets, which shares the vertices in the plane.
fn add_image(x: &mut Vec<Vec3>, facets: &mut Vec<[usize; 3]>, cut: &Cut, near: f64) {
    let image: Vec<usize> = (0..x.len())
        .map(|v| {
            if cut.has(&x[v], near) {
                return v;
            }
            let mut place = x[v];
            place[cut.axis] = 2.0 * cut.level - place[cut.axis];
            x.push(place);
            x.len() - 1
        })
        .collect();
    let mirrored: Vec<_> = facets.iter().map(|&[a, b, c]| [a, c, b].map(|v| image[v])).collect();
    facets.extend(mirrored);
}

/// Moves of all vertices: given ones, and the mean of the neighbours everywhere else. Those that are `held` do not move
/// along that axis.
fn follow(
    mesh: &TetMesh,
    given: &BTreeMap<usize, Vec3>,
    held: &[(usize, usize)],
    settled: f64,
) -> Vec<Vec3> {
    let edges = topology::tet_edges(&mesh.tets);
    let neighbours = topology::vertex_neighbours(mesh.vertices.len(), &edges);
    let mut moves = vec![Vec3::zeros(); mesh.vertices.len()];
    given.iter().for_each(|(&v, d)| moves[v] = *d);
    let hold = |moves: &mut [Vec3]| held.iter().for_each(|&(v, axis)| moves[v][axis] = 0.0);
    hold(&mut moves);
    let free: Vec<usize> =
        (0..moves.len()).filter(|v| !given.contains_key(v) && !neighbours[*v].is_empty()).collect();
    for _ in 0..SWEEPS {
        let mut change = 0.0_f64;
        for &v in &free {
            let sum: Vec3 = neighbours[v].iter().map(|&n| moves[n]).sum();
            let mean = sum / neighbours[v].len() as f64;
            change = change.max((mean - moves[v]).amax());
            moves[v] = mean;
        }
        hold(&mut moves);
        if change <= settled {
            break;
        }
    }
    moves
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A cube of side 2 from 2 × 2 × 2 smaller ones, each cut into six.
    fn cube() -> TetMesh {
        let vertex = |x: usize, y: usize, z: usize| (z * 3 + y) * 3 + x;
        let mut mesh = TetMesh::default();
        let at = |i: usize| Vec3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64);
        mesh.vertices = (0..27).map(at).collect();
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        for cell in 0..8 {
            let [x, y, z] = [cell % 2, cell / 2 % 2, cell / 4];
            for (n, order) in orders.iter().enumerate() {
                let mut corner = [0; 3];
                let mut tet = [vertex(x, y, z); 4];
                for (step, &axis) in order.iter().enumerate() {
                    corner[axis] = 1;
                    tet[step + 1] = vertex(x + corner[0], y + corner[1], z + corner[2]);
                }
                if n >= 3 {
                    tet.swap(1, 2);
                }
                mesh.tets.push(tet);
            }
        }
        mesh
    }

    #[test]
    fn both_sides_of_an_edge_move_by_the_distance() {
        for t in [0.1, -0.2] {
            let moved = offset(&cube(), t, &[]).unwrap();
            let side = 2.0 + 2.0 * t;
            assert!((measure::volume(&moved) - side.powi(3)).abs() < 1e-12);
            let (low, high) = measure::bounds(&moved.vertices);
            assert!((low - Vec3::repeat(-t)).amax() < 1e-12, "{low}");
            assert!((high - Vec3::repeat(2.0 + t)).amax() < 1e-12, "{high}");
            // The middle stays, as all around it moves apart alike.
            assert!((moved.vertices[13] - Vec3::repeat(1.0)).norm() < 1e-3);
        }
    }

    /// The cube is cut at x = 0 and z = 2.
    #[test]
    fn cuts_stay_in_their_planes() {
        let cuts = [Cut { axis: 0, level: 0.0 }, Cut { axis: 2, level: 2.0 }];
        let moved = offset(&cube(), 0.1, &cuts).unwrap();
        let (low, high) = measure::bounds(&moved.vertices);
        assert!((low - Vec3::new(0.0, -0.1, -0.1)).amax() < 1e-12, "{low}");
        assert!((high - Vec3::new(2.1, 2.1, 2.0)).amax() < 1e-12, "{high}");
        assert!((measure::volume(&moved) - 2.1 * 2.2 * 2.1).abs() < 1e-12);
    }

    #[test]
    fn too_far_is_refused_with_numbers() {
        let message = offset(&cube(), -1.5, &[]).unwrap_err().to_string();
        assert!(message.contains("48 of 48 tetrahedra"), "{message}");
    }
}
