//! Curved cells as small straight ones.
//!
//! Quadratic triangles have nodes 0–2 at the corners and 3, 4, 5 on the sides
//! 01, 12, 20; quadratic tetrahedra 0–3 at the corners and 4–9 on the edges
//! 01, 12, 20, 03, 13, 23 (VTK order).

use std::collections::BTreeMap;

use mesh::Vec3;

use super::shape::Triangle;

/// Edges of a tetrahedron in the order of its nodes 4–9.
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
const TRI_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Quadratic shape functions at barycentric coordinates: λ(2λ − 1) at the
/// corners, 4 λ_a λ_b on the edges.
fn shape(barycentric: &[f64], edges: &[[usize; 2]]) -> Vec<f64> {
    let corners = barycentric.iter().map(|l| l * (2.0 * l - 1.0));
    corners.chain(edges.iter().map(|&[a, b]| 4.0 * barycentric[a] * barycentric[b])).collect()
}

/// A quadratic triangle.
#[derive(Clone, Copy, Debug)]
pub struct Curved {
    /// The nodes.
    pub nodes: [usize; 6],
    /// Field value at each node; NaN for none.
    pub values: [f64; 6],
    /// Colour where there is no field value.
    pub color: super::color::Rgb,
}

/// Splits every side into `n` and every triangle into n² straight ones that
/// meet at common points.
pub fn flatten(nodes: &[Vec3], curved: &[Curved], n: usize) -> (Vec<Vec3>, Vec<Triangle>) {
    let mut points = Vec::new();
    let mut known: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    let mut triangles = Vec::new();
    for cell in curved {
        let grid = |i: usize, j: usize| [n - i - j, i, j];
        let mut ids = BTreeMap::new();
        let mut values = BTreeMap::new();
        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
            let weights = shape(&grid(i, j).map(|s| s as f64 / n as f64), &TRI_EDGES);
            let place = || weights.iter().zip(cell.nodes).map(|(w, v)| *w * nodes[v]).sum::<Vec3>();
            let mut add = || {
                points.push(place());
                points.len() - 1
            };
            let id = match key(cell, grid(i, j), n) {
                Some(key) => *known.entry(key).or_insert_with(add),
                None => add(),
            };
            ids.insert((i, j), id);
            values.insert((i, j), weights.iter().zip(cell.values).map(|(w, v)| w * v).sum::<f64>());
        }
        for corners in small_triangles(n) {
            let outer = |a: (usize, usize), b: (usize, usize)| {
                let (a, b) = (grid(a.0, a.1), grid(b.0, b.1));
                (0..3).any(|k| a[k] == 0 && b[k] == 0)
            };
            let edges = (0..3).filter(|&k| outer(corners[k], corners[(k + 1) % 3]));
            triangles.push(Triangle {
                points: corners.map(|c| ids[&c]),
                values: corners.map(|c| values[&c]),
                color: cell.color,
                edges: edges.map(|k| 1 << k).sum(),
            });
        }
    }
    (points, triangles)
}

/// What a grid point on the border of a triangle is called by all triangles
/// that share it: lower node, higher node, steps from the lower one.
fn key(cell: &Curved, steps: [usize; 3], n: usize) -> Option<[usize; 3]> {
    if let Some(k) = steps.iter().position(|&s| s == n) {
        return Some([cell.nodes[k], cell.nodes[k], 0]);
    }
    let k = steps.iter().position(|&s| s == 0)?;
    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
    let (low, high) = if cell.nodes[a] < cell.nodes[b] { (a, b) } else { (b, a) };
    Some([cell.nodes[low], cell.nodes[high], steps[high]])
}

/// The n² small triangles of a triangular grid.
fn small_triangles(n: usize) -> Vec<[(usize, usize); 3]> {
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
        triangles.push([(i, j), (i + 1, j), (i, j + 1)]);
        if i + j + 1 < n {
            triangles.push([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
        }
    }
    triangles
}

/// A small straight tetrahedron inside a quadratic one.
pub struct SmallTet {
    /// Corner positions.
    pub points: [Vec3; 4],
    /// Field value at each corner.
    pub values: [f64; 4],
    /// Bit i: the face opposite to corner i lies on a face of the large one.
    pub faces: u8,
}

/// Splits a quadratic tetrahedron into 64 small ones.
pub fn split_tet(nodes: &[Vec3], values: &[f64]) -> Vec<SmallTet> {
    let corner = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
    let mut small: Vec<[[f64; 4]; 4]> = vec![[0, 1, 2, 3].map(corner)];
    for _ in 0..2 {
        small = small.iter().flat_map(eighths).collect();
    }
    small
        .iter()
        .map(|corners| {
            let weights = corners.map(|c| shape(&c, &TET_EDGES));
            let on_face =
                |k: usize| (0..4).any(|f| (0..4).filter(|&c| c != k).all(|c| corners[c][f] == 0.0));
            SmallTet {
                points: [0, 1, 2, 3]
                    .map(|c| weights[c].iter().zip(nodes).map(|(w, p)| *w * p).sum()),
                values: [0, 1, 2, 3]
                    .map(|c| weights[c].iter().zip(values).map(|(w, v)| w * v).sum()),
                faces: (0..4).filter(|&k| on_face(k)).map(|k| 1 << k).sum(),
            }
        })
        .collect()
}

/// Red refinement: four corner tetrahedra and the octahedron between them in four.
fn eighths(t: &[[f64; 4]; 4]) -> Vec<[[f64; 4]; 4]> {
    let middle = |a: usize, b: usize| std::array::from_fn(|i| 0.5 * (t[a][i] + t[b][i]));
    let [m01, m12, m20, m03, m13, m23] = TET_EDGES.map(|[a, b]| middle(a, b));
    vec![
        [t[0], m01, m20, m03],
        [m01, t[1], m12, m13],
        [m20, m12, t[2], m23],
        [m03, m13, m23, t[3]],
        [m01, m12, m20, m13],
        [m01, m20, m03, m13],
        [m20, m12, m23, m13],
        [m20, m23, m03, m13],
    ]
}

#[cfg(test)]
mod tests {
    use super::super::color::palette;
    use super::*;

    /// A quadratic octant of the unit sphere, edge nodes on the sphere.
    fn octant() -> (Vec<Vec3>, Curved) {
        let corners = [Vec3::x(), Vec3::y(), Vec3::z()];
        let middles = TRI_EDGES.map(|[a, b]| (corners[a] + corners[b]).normalize());
        let nodes = [corners, middles].concat();
        let values = [0, 1, 2, 3, 4, 5].map(|i| nodes[i].x);
        (nodes, Curved { nodes: [0, 1, 2, 3, 4, 5], values, color: palette(0) })
    }

    #[test]
    fn small_triangles_lie_on_the_curved_one() {
        let (nodes, cell) = octant();
        let (points, triangles) = flatten(&nodes, &[cell], 4);
        assert_eq!((points.len(), triangles.len()), (15, 16));
        assert_eq!(triangles.iter().map(|t| t.edges.count_ones()).sum::<u32>(), 12);
        for t in &triangles {
            let [a, b, c] = t.points.map(|p| points[p]);
            assert!((b - a).cross(&(c - a)).dot(&a) > 0.0, "orientation is kept");
            // the field is the x coordinate, which the map reproduces
            for (p, value) in [a, b, c].iter().zip(t.values) {
                assert!((p.x - value).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn neighbours_share_their_border_points() {
        let (mut nodes, cell) = octant();
        nodes.extend([
            -Vec3::x(),
            Vec3::new(-1.0, 1.0, 0.0).normalize(),
            Vec3::new(-1.0, 0.0, 1.0).normalize(),
        ]);
        // the mirrored octant, sharing the side from y (node 1) to z (node 2)
        let twin = Curved { nodes: [2, 1, 6, 4, 7, 8], ..cell };
        let (points, triangles) = flatten(&nodes, &[cell, twin], 3);
        assert_eq!(points.len(), 2 * 10 - 4);
        assert_eq!(triangles.len(), 18);
    }

    #[test]
    fn small_tetrahedra_fill_a_straight_one() {
        let corners = [Vec3::zeros(), Vec3::x(), 2.0 * Vec3::y(), 3.0 * Vec3::z()];
        let nodes: Vec<Vec3> = corners
            .iter()
            .copied()
            .chain(TET_EDGES.map(|[a, b]| 0.5 * (corners[a] + corners[b])))
            .collect();
        let values: Vec<f64> = nodes.iter().map(|p| p.y).collect();
        let small = split_tet(&nodes, &values);
        let volume = |t: &SmallTet| {
            let [a, b, c, d] = t.points;
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        assert_eq!(small.len(), 64);
        assert!(small.iter().all(|t| volume(t).abs() > 0.0));
        // 64 equal volumes, exact up to rounding
        assert!((small.iter().map(|t| volume(t).abs()).sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(small.iter().all(|t| (t.points[2].y - t.values[2]).abs() < 1e-14));
        // each of the four faces of the large one is covered by 16 small faces
        assert_eq!(small.iter().map(|t| t.faces.count_ones()).sum::<u32>(), 64);
    }
}
