//! Lengths, areas, volumes and the quality of elements.

use std::fmt;

use nalgebra::Matrix3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bvh::SurfaceBvh;
use crate::topology::{TET_EDGES, tet_edges};
use crate::{SurfaceMesh, TetMesh, Vec3};

/// Area of a triangle [m²].
pub fn triangle_area(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// Length of the longest edge of a triangle [m].
pub fn longest_edge([a, b, c]: [Vec3; 3]) -> f64 {
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

/// Shape of a triangle, 4√3 area over the sum of the squared edges: 1 if it is regular, 0 if it is flat [1].
pub fn triangle_shape([a, b, c]: [Vec3; 3]) -> f64 {
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    4.0 * 3.0_f64.sqrt() * triangle_area(a, b, c) / squares
}

/// Whether a triangle has no area: its height is at most a 10¹²-th of its longest edge, so that 64 bits lose its
/// normal, with a margin of 10⁴.
pub fn is_flat(a: Vec3, b: Vec3, c: Vec3) -> bool {
    let longest = longest_edge([a, b, c]);
    2.0 * triangle_area(a, b, c) <= 1e-12 * longest * longest
}

/// Unit normal of a triangle, pointing to where it is counter-clockwise; zero
/// for a triangle without area.
pub fn triangle_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

/// Area of a surface [m²].
pub fn area(surface: &SurfaceMesh) -> f64 {
    (0..surface.triangles.len()).map(|t| surface.area(t)).sum()
}

/// Signed volume inside a closed surface [m³], positive if its triangles are
/// counter-clockwise from outside: Σ det(a, b, c) / 6 by the divergence theorem.
pub fn enclosed_volume(surface: &SurfaceMesh) -> f64 {
    // Any reference point is right; one of the surface keeps the terms small.
    let Some(&origin) = surface.vertices.first() else { return 0.0 };
    (0..surface.triangles.len())
        .map(|t| surface.corners(t))
        .map(|[a, b, c]| tet_volume(origin, a, b, c))
        .sum()
}

/// Signed volume of a tetrahedron [m³]: det(b−a, c−a, d−a) / 6.
pub fn tet_volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    Matrix3::from_columns(&[b - a, c - a, d - a]).determinant() / 6.0
}

/// Gradient of [`tet_volume`] by each corner [m²]: a sixth of the cross product of
/// two edges of the opposite face; that of the first corner is minus the sum of
/// the others.
pub fn tet_volume_gradient(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [Vec3; 4] {
    let (p, q, s) = (b - a, c - a, d - a);
    let by = [q.cross(&s), s.cross(&p), p.cross(&q)].map(|n| n / 6.0);
    [-(by[0] + by[1] + by[2]), by[0], by[1], by[2]]
}

/// Mean length of the edges of triangles [m]; NaN without any.
pub fn mean_edge(vertices: &[Vec3], triangles: &[[usize; 3]]) -> f64 {
    let edges = crate::topology::edge_facets(triangles);
    let total: f64 = edges.keys().map(|&[a, b]| (vertices[a] - vertices[b]).norm()).sum();
    total / edges.len() as f64
}

/// Volume of a tetrahedral mesh [m³].
pub fn volume(mesh: &TetMesh) -> f64 {
    (0..mesh.tets.len()).map(|t| mesh.volume(t)).sum()
}

/// Lowest and highest corner of the axis-aligned bounding box [m]; (+∞, −∞) for
/// no points.
pub fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let empty = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.iter().fold(empty, |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Length of the diagonal of the bounding box [m]; zero for no points.
pub fn diagonal(points: &[Vec3]) -> f64 {
    if points.is_empty() {
        return 0.0;
    }
    let (low, high) = bounds(points);
    (high - low).norm()
}

/// Diagonals of bodies that are cast of silicone [m], with a wide margin.
const LIKELY: std::ops::RangeInclusive<f64> = 1e-4..=5.0;

/// What to say of points [m] that are as far apart as if their unit were another: bodies of
/// 80 mm become bodies of 80 m.
pub fn unlikely_size(points: &[Vec3]) -> Option<String> {
    let size = diagonal(points);
    (size > 0.0 && !LIKELY.contains(&size)).then(|| {
        let millimetres =
            (size > *LIKELY.end()).then(|| format!(": {size:.4} mm if they are millimetres"));
        format!(
            "{size:.4} m from corner to corner: lengths are read as metres. Is the unit another{}? \
             `cad2fem import` converts it",
            millimetres.unwrap_or_default()
        )
    })
}

/// Radius ratio 3 r/R of a tetrahedron, r the radius of the inscribed and R of
/// the circumscribed sphere: 1 if regular, 0 if flat, negative if inverted.
///
/// With the edges p, q, s at one corner, r = 3V / ΣA and
/// R = |p²(q×s) + q²(s×p) + s²(p×q)| / 12|V|.
pub fn radius_ratio(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let (p, q, s) = (b - a, c - a, d - a);
    let volume = tet_volume(a, b, c, d);
    let areas =
        [[a, b, c], [a, b, d], [a, c, d], [b, c, d]].map(|[x, y, z]| triangle_area(x, y, z));
    let spread = p.norm_squared() * q.cross(&s)
        + q.norm_squared() * s.cross(&p)
        + s.norm_squared() * p.cross(&q);
    let scale = areas.iter().sum::<f64>() * spread.norm();
    if scale > 0.0 { 108.0 * volume * volume.abs() / scale } else { 0.0 }
}

/// Dihedral angles of a tetrahedron [deg] along its edges in the order of
/// [`TET_EDGES`], in 0..180 whatever its orientation.
///
/// At an edge e with the other two corners at x and y from its start the angle
/// is that between e×x and e×y, taken with atan2 so that it is accurate near 0
/// and 180.
pub fn dihedral_angles(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [f64; 6] {
    let corners = [a, b, c, d];
    // The corners that are not on edge k are those of edge 5 - k.
    std::array::from_fn(|k| {
        let [i, j] = TET_EDGES[k].map(|v| corners[v]);
        let [x, y] = TET_EDGES[5 - k].map(|v| corners[v] - i);
        let edge = j - i;
        let (m, n) = (edge.cross(&x), edge.cross(&y));
        m.cross(&n).norm().atan2(m.dot(&n)).to_degrees()
    })
}

/// Quality of a tetrahedral mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Smallest dihedral angle [deg].
    pub min_dihedral: f64,
    /// Largest dihedral angle [deg].
    pub max_dihedral: f64,
    /// Smallest radius ratio, negative if a tetrahedron is inverted [1].
    pub radius_ratio_min: f64,
    /// First percentile of the radius ratio [1].
    pub radius_ratio_p1: f64,
    /// Mean radius ratio [1].
    pub radius_ratio_mean: f64,
    /// Shortest edge [m].
    pub edge_min: f64,
    /// Mean edge [m].
    pub edge_mean: f64,
    /// Longest edge [m].
    pub edge_max: f64,
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "radius ratio min {:.3}  p1 {:.3}  mean {:.3}; dihedral {:.1}..{:.1} deg; edges \
             {:.2} / {:.2} / {:.2} mm",
            self.radius_ratio_min,
            self.radius_ratio_p1,
            self.radius_ratio_mean,
            self.min_dihedral,
            self.max_dihedral,
            self.edge_min * 1e3,
            self.edge_mean * 1e3,
            self.edge_max * 1e3
        )
    }
}

/// Quality of a mesh; all zero if it has no tetrahedra.
pub fn quality(mesh: &TetMesh) -> Quality {
    if mesh.tets.is_empty() {
        return Quality::default();
    }
    let tets = (0..mesh.tets.len()).map(|t| mesh.corners(t));
    let (angle_min, angle_max) = tets
        .clone()
        .flat_map(|[a, b, c, d]| dihedral_angles(a, b, c, d))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let mut ratios: Vec<f64> = tets.map(|[a, b, c, d]| radius_ratio(a, b, c, d)).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let mut edges: Vec<f64> = tet_edges(&mesh.tets)
        .iter()
        .map(|&[a, b]| (mesh.vertices[b] - mesh.vertices[a]).norm())
        .collect();
    edges.sort_unstable_by(f64::total_cmp);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    Quality {
        min_dihedral: angle_min,
        max_dihedral: angle_max,
        radius_ratio_min: ratios[0],
        radius_ratio_p1: ratios[ratios.len() / 100],
        radius_ratio_mean: mean(&ratios),
        edge_min: edges[0],
        edge_mean: mean(&edges),
        edge_max: edges[edges.len() - 1],
    }
}

/// One-sided Hausdorff distance [m]: the largest distance from a point of `from`
/// to `to`, over the vertices of `from` and about `samples` points spread evenly
/// over its area. It is a lower bound that converges as samples are added.
pub fn hausdorff(from: &SurfaceMesh, to: &SurfaceMesh, samples: usize) -> f64 {
    if from.triangles.is_empty() {
        return 0.0;
    }
    farthest(from, to, samples).map_or(f64::INFINITY, |(distance, _)| distance)
}

/// One-sided Hausdorff distance [m] of [`hausdorff`], and the point of `from` that has it. `None` if a
/// surface is empty.
pub fn farthest(from: &SurfaceMesh, to: &SurfaceMesh, samples: usize) -> Option<(f64, Vec3)> {
    if from.triangles.is_empty() || to.triangles.is_empty() {
        return None;
    }
    let target = SurfaceBvh::new(to);
    let mut points = from.vertices.clone();
    points.extend(spread(from, samples));
    let distances = points.par_iter().map(|p| (target.closest(p).distance, *p));
    distances.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// About `count` points spread evenly by area.
pub fn spread(surface: &SurfaceMesh, count: usize) -> Vec<Vec3> {
    // Roberts' R2 sequence: powers of the plastic number fill the unit square evenly.
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let density = count as f64 / area(surface);
    let mut points = Vec::with_capacity(count + 1);
    let mut due = 0.0;
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        due += density * triangle_area(a, b, c);
        while points.len() as f64 + 1.0 <= due {
            let i = points.len() as f64;
            let (u, v) = ((i * STEP[0]).fract(), (i * STEP[1]).fract());
            // The half of the square beyond the diagonal is folded back.
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            points.push(a + (b - a) * u + (c - a) * v);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few roundings of numbers of order one.
    const FEW_ROUNDINGS: f64 = 1e-14;

    fn regular_tet() -> [Vec3; 4] {
        [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from)
    }

    fn octahedron() -> SurfaceMesh {
        let axes = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
        SurfaceMesh {
            vertices: axes.to_vec(),
            triangles: vec![
                [0, 2, 4],
                [2, 1, 4],
                [1, 3, 4],
                [3, 0, 4],
                [2, 0, 5],
                [1, 2, 5],
                [3, 1, 5],
                [0, 3, 5],
            ],
        }
    }

    /// The volume is linear in the place of each corner.
    #[test]
    fn a_volume_grows_by_its_gradient() {
        let corners = [[0.3, 0.1, -0.2], [1.1, 0.2, 0.1], [0.2, 0.9, 0.3], [0.1, -0.1, 1.2]];
        let corners = corners.map(Vec3::from);
        let volume = |[a, b, c, d]: [Vec3; 4]| tet_volume(a, b, c, d);
        let [a, b, c, d] = corners;
        let by = Vec3::new(0.4, -0.7, 0.5);
        for (k, gradient) in tet_volume_gradient(a, b, c, d).iter().enumerate() {
            let mut moved = corners;
            moved[k] += by;
            assert!((volume(moved) - volume(corners) - gradient.dot(&by)).abs() < FEW_ROUNDINGS);
        }
    }

    #[test]
    fn a_regular_tetrahedron_has_the_known_measures() {
        let [a, b, c, d] = regular_tet();
        // Edge 2√2: volume s³/(6√2) = 8/3, facets √3 s²/4 = 2√3.
        assert!((tet_volume(a, b, c, d) - 8.0 / 3.0).abs() < FEW_ROUNDINGS);
        assert!((triangle_area(a, b, c) - 2.0 * 3.0_f64.sqrt()).abs() < FEW_ROUNDINGS);
        assert!((radius_ratio(a, b, c, d) - 1.0).abs() < FEW_ROUNDINGS);
        assert!((radius_ratio(a, b, d, c) + 1.0).abs() < FEW_ROUNDINGS);
        let known = (1.0_f64 / 3.0).acos().to_degrees();
        assert!((known - 70.5288).abs() < 1e-4);
        for angle in dihedral_angles(a, b, c, d) {
            assert!((angle - known).abs() < 100.0 * FEW_ROUNDINGS);
        }
    }

    #[test]
    fn angles_of_slivers_are_accurate() {
        // A square whose opposite corners are lifted by h: the angles at its sides
        // are about √2 h, far below what an arc cosine resolves.
        let h = 1e-9;
        let [a, b] = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
        let [c, d] = [Vec3::new(0.0, -1.0, h), Vec3::new(0.0, 1.0, h)];
        let smallest = dihedral_angles(a, b, c, d).into_iter().fold(180.0, f64::min);
        let known = (2.0_f64.sqrt() * h).to_degrees();
        assert!((smallest / known - 1.0).abs() < 1e-6);
        assert_eq!(radius_ratio(a, b, b, d), 0.0);
    }

    #[test]
    fn an_octahedron_has_the_known_measures_far_from_the_origin() {
        let mut surface = octahedron();
        assert!((enclosed_volume(&surface) - 4.0 / 3.0).abs() < FEW_ROUNDINGS);
        assert!((area(&surface) - 4.0 * 3.0_f64.sqrt()).abs() < FEW_ROUNDINGS);
        surface.vertices.iter_mut().for_each(|v| *v += Vec3::repeat(1024.0));
        // The shift is exact, and so are the differences the volume is made of.
        assert!((enclosed_volume(&surface) - 4.0 / 3.0).abs() < FEW_ROUNDINGS);
        surface.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!((enclosed_volume(&surface) + 4.0 / 3.0).abs() < FEW_ROUNDINGS);
        assert!((diagonal(&surface.vertices) - 12.0_f64.sqrt()).abs() < FEW_ROUNDINGS);
    }

    #[test]
    fn quality_sums_up_all_tetrahedra() {
        let mut vertices = regular_tet().to_vec();
        vertices.extend([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]);
        let found = quality(&TetMesh { vertices, tets: vec![[0, 1, 2, 3], [4, 5, 6, 7]] });
        let worst = 3.0_f64.sqrt() - 1.0;
        assert!((found.radius_ratio_min - worst).abs() < FEW_ROUNDINGS);
        assert!((found.radius_ratio_mean - f64::midpoint(1.0, worst)).abs() < FEW_ROUNDINGS);
        assert!((found.max_dihedral - 90.0).abs() < 100.0 * FEW_ROUNDINGS);
        assert!((found.edge_min - 1.0).abs() < FEW_ROUNDINGS);
        assert!((found.edge_max - 8.0_f64.sqrt()).abs() < FEW_ROUNDINGS);
    }

    #[test]
    fn hausdorff_is_one_sided_and_sees_inside_triangles() {
        let patch = |z: f64, size: f64| SurfaceMesh {
            vertices: vec![
                Vec3::new(0.0, 0.0, z),
                Vec3::new(size, 0.0, z),
                Vec3::new(0.0, size, z),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let (small, large) = (patch(0.0, 1.0), patch(0.5, 3.0));
        assert!((hausdorff(&small, &large, 100) - 0.5).abs() < FEW_ROUNDINGS);
        // From the far corners: 2 along the plane and 0.5 across.
        assert!((hausdorff(&large, &small, 100) - 4.25_f64.sqrt()).abs() < FEW_ROUNDINGS);
        // A roof whose vertices all lie on the target, but its middle does not.
        let gap = SurfaceMesh {
            vertices: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.0, -1.0]]
                .map(Vec3::from)
                .to_vec(),
            triangles: vec![[0, 3, 2], [3, 1, 2]],
        };
        let lid = SurfaceMesh { triangles: vec![[0, 1, 2]], ..gap.clone() };
        // The middle of the open side is 0.5/√1.5 from both faces of the groove.
        // 1000 samples are some 0.02 apart, and the distance has slope below 1.
        let known = 0.5 / 1.5_f64.sqrt();
        let found = hausdorff(&lid, &gap, 1000);
        assert!(found <= known && found > known - 0.02, "{found} {known}");
    }

    #[test]
    fn dihedral_angles_belong_to_their_edges() {
        // The corner of a cube: right angles at the three edges from the origin.
        let [o, x, y, z] = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let slanted = (1.0 / 3.0_f64.sqrt()).acos().to_degrees();
        let known = [90.0, 90.0, 90.0, slanted, slanted, slanted];
        for (angle, known) in dihedral_angles(o, x, y, z).into_iter().zip(known) {
            assert!((angle - known).abs() < 100.0 * FEW_ROUNDINGS);
        }
        // Circumradius √3/2, inscribed radius 1/(3+√3): 3 r/R = 2√3/(3+√3) = √3 − 1.
        assert!((radius_ratio(o, x, y, z) - (3.0_f64.sqrt() - 1.0)).abs() < FEW_ROUNDINGS);
    }
}
