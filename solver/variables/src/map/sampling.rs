//! Points spread evenly over a triangle surface.
//!
//! Farthest-point sampling: each point is the vertex farthest, along the
//! surface, from the rim and all points before it. Sweeps then spread them more
//! evenly, a few times over: every point in turn is taken out and placed again as
//! the vertex farthest from all others, as in the published programs.
//!
//! Ties go to the smaller vertex id, so that the result depends on the mesh
//! alone. A component that no source reaches is infinitely far and gets a point
//! first.
//!
//! Source: Gjoka et al. 2024, section 4.5.

use anyhow::{Result, ensure};
use mesh::{SurfaceMesh, topology};

use super::geodesic::Geodesics;

/// Times that every point is placed again.
const SWEEPS: usize = 5;

/// Vertices on the rim of a surface, ascending; edges that are `open` are none of it.
pub fn rim(surface: &SurfaceMesh, open: impl Fn(&[usize; 2]) -> bool) -> Vec<usize> {
    let mut edges = topology::boundary_edges(&surface.triangles);
    edges.retain(|edge| !open(edge));
    let mut rim = edges.concat();
    rim.sort_unstable();
    rim.dedup();
    rim
}

/// `count` vertices of a surface, none on its rim. Each has `images`, which are sources of distances as it is; the images of
/// a vertex are none where nothing is symmetric.
pub fn spread_points(
    surface: &SurfaceMesh,
    rim: &[usize],
    count: usize,
    images: &dyn Fn(usize) -> Vec<usize>,
) -> Result<Vec<usize>> {
    let available = surface.vertices.len() - rim.len();
    ensure!(
        count <= available,
        "{count} handles were asked for, but the surface has only {available} vertices off its rim; ask for at most \
         {available}"
    );
    let mut sampling = Sampling::new(surface, rim, images);
    for i in 0..count {
        let first = if i == 0 && rim.is_empty() { lowest(surface) } else { sampling.farthest() };
        sampling.add(i, first);
    }
    if count + rim.len() > 1 {
        for i in (0..SWEEPS).flat_map(|_| 0..count) {
            sampling.remove(i);
            let farthest = sampling.farthest();
            sampling.add(i, farthest);
        }
    }
    Ok(sampling.points)
}

/// The vertex with the smallest coordinates, x before y before z.
fn lowest(surface: &SurfaceMesh) -> usize {
    let key = |v: &usize| surface.vertices[*v];
    let before = |a: &usize, b: &usize| {
        let (a, b) = (key(a), key(b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    };
    (0..surface.vertices.len()).min_by(before).unwrap_or(0)
}

/// Which source is nearest to a vertex.
#[derive(Clone, Copy, PartialEq)]
enum Source {
    Rim,
    Point(usize),
}

struct Sampling<'a> {
    geodesics: Geodesics,
    images: &'a dyn Fn(usize) -> Vec<usize>,
    from_rim: Vec<f64>,
    points: Vec<usize>,
    /// Distances from each point.
    from_point: Vec<Vec<f64>>,
    /// Distance to the nearest source, and that source.
    nearest: Vec<(f64, Source)>,
}

impl<'a> Sampling<'a> {
    fn new(surface: &SurfaceMesh, rim: &[usize], images: &'a dyn Fn(usize) -> Vec<usize>) -> Self {
        let geodesics = Geodesics::new(surface);
        let from_rim = geodesics.distances(rim);
        let nearest = from_rim.iter().map(|&d| (d, Source::Rim)).collect();
        Self { geodesics, images, from_rim, points: Vec::new(), from_point: Vec::new(), nearest }
    }

    /// A vertex with its images.
    fn orbit(&self, vertex: usize) -> Vec<usize> {
        [vec![vertex], (self.images)(vertex)].concat()
    }

    fn farthest(&self) -> usize {
        let mut best = 0;
        for (v, (distance, _)) in self.nearest.iter().enumerate() {
            if *distance > self.nearest[best].0 {
                best = v;
            }
        }
        best
    }

    /// Puts point `i`, the next one or one taken out, at a vertex.
    fn add(&mut self, i: usize, vertex: usize) {
        let distances = self.geodesics.distances(&self.orbit(vertex));
        for (nearest, &d) in self.nearest.iter_mut().zip(&distances) {
            if d < nearest.0 {
                *nearest = (d, Source::Point(i));
            }
        }
        if i == self.points.len() {
            self.points.push(vertex);
            self.from_point.push(distances);
        } else {
            self.points[i] = vertex;
            self.from_point[i] = distances;
        }
    }

    fn remove(&mut self, i: usize) {
        self.from_point[i].fill(f64::INFINITY);
        for v in 0..self.nearest.len() {
            if self.nearest[v].1 != Source::Point(i) {
                continue;
            }
            let mut nearest = (self.from_rim[v], Source::Rim);
            for (j, distances) in self.from_point.iter().enumerate() {
                if distances[v] < nearest.0 {
                    nearest = (distances[v], Source::Point(j));
                }
            }
            self.nearest[v] = nearest;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::testing::{cap, sphere, square};
    use mesh::Vec3;

    use super::*;

    fn alone(_: usize) -> Vec<usize> {
        Vec::new()
    }

    /// No vertex is much farther from the points than these are from each
    /// other: the two radii that an even sampling balances.
    #[test]
    fn points_are_spread_evenly_off_the_rim() {
        let surface = cap(4);
        for count in [4, 16, 50] {
            let points = spread_points(&surface, &rim(&surface, |_| false), count, &alone).unwrap();
            let rim = rim(&surface, |_| false);
            assert!(points.iter().all(|p| !rim.contains(p)));
            let geodesics = Geodesics::new(&surface);
            let sources = [points.clone(), rim.clone()].concat();
            let covering = geodesics.distances(&sources).into_iter().fold(0.0, f64::max);
            let packing = points
                .iter()
                .map(|p| {
                    let others: Vec<usize> = sources.iter().copied().filter(|q| q != p).collect();
                    geodesics.distances(&others)[*p]
                })
                .fold(f64::INFINITY, f64::min);
            assert!(packing > 0.9 * covering, "{count}: {packing} {covering}");
        }
    }

    #[test]
    fn every_component_gets_a_point_and_closed_surfaces_work() {
        let ball = sphere(2);
        let n = ball.vertices.len();
        let mut two = ball.clone();
        two.vertices.extend(ball.vertices.iter().map(|v| v + 5.0 * Vec3::x()));
        two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
        let points = spread_points(&two, &rim(&two, |_| false), 2, &alone).unwrap();
        assert!((points[0] < n) != (points[1] < n));
        assert_eq!(
            spread_points(&ball, &rim(&ball, |_| false), 1, &alone).unwrap(),
            vec![lowest(&ball)]
        );
    }

    #[test]
    fn more_points_than_vertices_are_refused() {
        let plane = square(3, 0.0);
        assert_eq!(spread_points(&plane, &rim(&plane, |_| false), 4, &alone).unwrap().len(), 4);
        let error =
            spread_points(&plane, &rim(&plane, |_| false), 5, &alone).unwrap_err().to_string();
        assert!(error.contains("only 4 vertices off its rim"), "{error}");
    }
}
