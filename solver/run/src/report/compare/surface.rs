//! Hausdorff distance of curved boundaries.
//!
//! d(A, B) = max(sup_{a∈A} inf_{b∈B} |a − b|, sup_{b∈B} inf_{a∈A} |a − b|)
//!
//! Facets of degree p are polynomial patches. Each is divided into triangles
//! whose edges are no longer than a spacing s; the suprema are taken over the
//! corners of one surface's triangles, the infima over all points of the
//! other's. A chord of a curve of radius R is off by s²/8R, and between two
//! corners a distance that is smooth where it is largest is missed by O(s²).
//! The result with a spacing of 2s shows how large that error is.

use std::collections::BTreeMap;

use mechanics::element::quadrature::Rule;
use mechanics::element::{FunctionSpace, Tabulation, tabulate};
use mechanics::parallel::map_merge;
use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};
use serde::Serialize;

/// A surface of polynomial patches.
pub struct Patches {
    degree: usize,
    /// Places of the nodes of each patch, corners first [m].
    nodes: Vec<Vec<Vec3>>,
}

/// A Hausdorff distance and its parts [m].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Distance {
    /// The larger of both sides.
    pub hausdorff: f64,
    /// Largest distance of a point of the reference from the other surface.
    pub from_reference: f64,
    /// Largest distance of a point of the other surface from the reference.
    pub to_reference: f64,
    /// Where the larger of both is found.
    pub at: [f64; 3],
    /// The Hausdorff distance by triangles twice as large.
    pub coarser: f64,
}

impl Patches {
    /// Facets of a space whose nodes are at `places` [m].
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]], places: &[Vec3]) -> Self {
        let patch = |&facet: &[usize; 3]| {
            space.facet_nodes(facet).iter().map(|&n| places[n]).collect::<Vec<_>>()
        };
        Self { degree: space.degree(), nodes: facets.iter().map(patch).collect() }
    }

    /// Triangles with corners on the patches and edges no longer than `spacing`
    /// [m], as far as the patches are not stretched along their inside.
    pub fn triangulate(&self, spacing: f64) -> SurfaceMesh {
        let mut grids: BTreeMap<usize, Grid> = BTreeMap::new();
        let mut surface = SurfaceMesh { vertices: Vec::new(), triangles: Vec::new() };
        for patch in &self.nodes {
            let cells = cells(patch, spacing);
            let grid = grids.entry(cells).or_insert_with(|| Grid::new(self.degree, cells));
            let first = surface.vertices.len();
            let place =
                |values: &Vec<f64>| -> Vec3 { patch.iter().zip(values).map(|(x, v)| x * *v).sum() };
            surface.vertices.extend(grid.table.values.iter().map(place));
            surface.triangles.extend(grid.triangles.iter().map(|t| t.map(|i| first + i)));
        }
        surface
    }
}

/// Parts into which the edges of a patch are divided.
fn cells(patch: &[Vec3], spacing: f64) -> usize {
    let edges = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| (patch[a] - patch[b]).norm());
    (edges.into_iter().fold(0.0, f64::max) / spacing).ceil().max(1.0) as usize
}

/// The unit triangle in equal cells, and the basis at their corners.
struct Grid {
    table: Tabulation,
    triangles: Vec<[usize; 3]>,
}

impl Grid {
    fn new(degree: usize, cells: usize) -> Self {
        let mut rule = Rule { weights: Vec::new(), points: Vec::new() };
        let mut triangles = Vec::new();
        for j in 0..=cells {
            for i in 0..=cells - j {
                let [s, t] = [i, j].map(|k| k as f64 / cells as f64);
                let here = rule.points.len();
                let above = here + cells + 1 - j;
                rule.points.push(vec![1.0 - s - t, s, t]);
                rule.weights.push(0.0);
                if i + j < cells {
                    triangles.push([here, here + 1, above]);
                }
                if i + j + 1 < cells {
                    triangles.push([here + 1, above + 1, above]);
                }
            }
        }
        Self { table: tabulate(degree, &rule), triangles }
    }
}

/// The Hausdorff distance of two surfaces, sampled with a `spacing` [m].
pub fn hausdorff(reference: &Patches, other: &Patches, spacing: f64) -> Distance {
    let mut distance = sampled(reference, other, spacing);
    distance.coarser = sampled(reference, other, 2.0 * spacing).hausdorff;
    distance
}

fn sampled(reference: &Patches, other: &Patches, spacing: f64) -> Distance {
    let [a, b] = [reference, other].map(|patches| patches.triangulate(spacing));
    let (from, from_at) = one_sided(&a, &SurfaceBvh::new(&b));
    let (to, to_at) = one_sided(&b, &SurfaceBvh::new(&a));
    let at = if from > to { from_at } else { to_at };
    let hausdorff = from.max(to);
    Distance {
        hausdorff,
        from_reference: from,
        to_reference: to,
        at: at.into(),
        coarser: hausdorff,
    }
}

/// The largest distance of a vertex of `from` from a surface, and that vertex.
fn one_sided(from: &SurfaceMesh, to: &SurfaceBvh) -> (f64, Vec3) {
    let mut largest = (0.0, Vec3::zeros());
    let farthest = |range: std::ops::Range<usize>| {
        let distances = from.vertices[range].iter().map(|p| (to.closest(p).distance, *p));
        distances.fold((0.0, Vec3::zeros()), |m, d| if d.0 > m.0 { d } else { m })
    };
    map_merge(from.vertices.len(), farthest, |_, part| {
        if part.0 > largest.0 {
            largest = part;
        }
    });
    largest
}

#[cfg(test)]
mod tests {
    use mechanics::testing;

    use super::*;

    /// A ball's boundary with its nodes of a degree put on the sphere of radius r.
    fn sphere(levels: usize, degree: usize, r: f64) -> Patches {
        let surface = testing::sphere(levels);
        let centre = surface.vertices.len();
        let tets = surface.triangles.iter().map(|&[a, b, c]| [centre, a, b, c]).collect();
        let mut rest = surface.vertices.clone();
        rest.push(Vec3::zeros());
        let space = FunctionSpace::new(degree, rest.len(), tets);
        let onto = |x: &Vec3| if x.norm() > 0.3 { r * x.normalize() } else { *x };
        let places: Vec<Vec3> = space.node_positions(&rest).iter().map(onto).collect();
        Patches::new(&space, &surface.triangles, &places)
    }

    #[test]
    fn concentric_spheres_are_the_difference_of_their_radii_apart() {
        // cubic patches of 1/8 of a right angle are off the sphere by 1e-5
        for (r, s) in [(1.0, 1.2), (1.2, 1.0)] {
            let d = hausdorff(&sphere(3, 3, r), &sphere(3, 3, s), 0.04);
            for side in [d.from_reference, d.to_reference] {
                // the chords of a spacing of 0.04 are off by 0.04²/8 = 2e-4
                assert!((side - 0.2).abs() < 3e-4, "{d:?}");
            }
            // four times the error of the finer one
            assert!((d.coarser - 0.2).abs() < 1.2e-3, "{d:?}");
        }
    }

    /// A part of a surface is no distance from the whole, but not the reverse.
    #[test]
    fn both_sides_count() {
        let whole = sphere(3, 1, 1.0);
        let high = |patch: &&Vec<Vec3>| patch.iter().all(|x| x.z > -1e-9);
        let nodes = whole.nodes.iter().filter(high).cloned().collect();
        let half = Patches { degree: 1, nodes };
        let d = hausdorff(&whole, &half, 0.05);
        assert!(d.to_reference < 1e-15, "{d:?}");
        // from the south pole to the middle of the chords of the equator, 32 of them
        let middle = (std::f64::consts::PI / 32.0).cos();
        assert!((d.from_reference - 1.0_f64.hypot(middle)).abs() < 1e-12, "{d:?}");
        assert!((Vec3::from(d.at) + Vec3::z()).norm() < 1e-12, "{d:?}");
    }
}
