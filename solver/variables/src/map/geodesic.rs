//! Distances along a triangle surface from a set of vertices.
//!
//! A triangle whose corners p and q are at distances d_p and d_q is laid into
//! the plane together with the point s at these distances from p and q on the
//! far side of pq; its third corner is then at |v − s|, provided that the
//! segment from s to v crosses pq. The corner opposite to the triangle's own
//! edges is reached along them otherwise. Vertices are settled in order of
//! distance, as in fast marching, and taken up again when a shorter path to
//! them turns up later; this makes the result independent of obtuse angles,
//! which break the order.
//!
//! Exact on a plane from one source, up to a relative 10⁻⁹ per vertex, whatever
//! the triangulation. On curved surfaces, and where fronts of several sources
//! meet, first order in the edge length.
//!
//! Source: Novotni and Klein 2002, "Computing geodesic distances on triangular
//! meshes" (circular fronts); Kimmel and Sethian 1998,
//! doi:10.1073/pnas.95.15.8431 (fast marching on triangles).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use mesh::SurfaceMesh;

/// Relative gain below which a settled vertex is left alone [1].
const GAIN: f64 = 1e-9;

/// A triangle with the corner that it may give a shorter distance.
#[derive(Clone, Copy)]
struct Sector {
    target: usize,
    /// The other two corners.
    base: [usize; 2],
    /// Lengths of the edges from the target to them [m].
    sides: [f64; 2],
    /// Length of the edge between them [m].
    width: f64,
}

/// A triangle surface prepared for distances along it.
pub struct Geodesics {
    sectors: Vec<Sector>,
    /// For each vertex the sectors with it in their base.
    around: Vec<Vec<usize>>,
}

impl Geodesics {
    /// Prepares a surface.
    pub fn new(surface: &SurfaceMesh) -> Self {
        let length = |a: usize, b: usize| (surface.vertices[a] - surface.vertices[b]).norm();
        let mut sectors = Vec::with_capacity(3 * surface.triangles.len());
        let mut around = vec![Vec::new(); surface.vertices.len()];
        for &triangle in &surface.triangles {
            for k in 0..3 {
                let [target, p, q] = [triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
                around[p].push(sectors.len());
                around[q].push(sectors.len());
                let sides = [length(target, p), length(target, q)];
                sectors.push(Sector { target, base: [p, q], sides, width: length(p, q) });
            }
        }
        Self { sectors, around }
    }

    /// Distance of every vertex to the nearest of `sources` [m]; infinite on
    /// components without a source.
    pub fn distances(&self, sources: &[usize]) -> Vec<f64> {
        self.within(sources, f64::INFINITY)
    }

    /// Distances of vertices up to `reach` [m]; those beyond are infinitely far.
    pub fn within(&self, sources: &[usize], reach: f64) -> Vec<f64> {
        let mut distance = vec![f64::INFINITY; self.around.len()];
        let mut queue = BinaryHeap::new();
        for &vertex in sources {
            distance[vertex] = 0.0;
            queue.push(Front { distance: 0.0, vertex });
        }
        while let Some(front) = queue.pop() {
            if front.distance > distance[front.vertex] {
                continue;
            }
            for &s in &self.around[front.vertex] {
                let sector = &self.sectors[s];
                let through = sector.through(&distance);
                if through > reach {
                    continue;
                }
                if through < distance[sector.target] * (1.0 - GAIN)
                    || (through.is_finite() && distance[sector.target].is_infinite())
                {
                    distance[sector.target] = through;
                    queue.push(Front { distance: through, vertex: sector.target });
                }
            }
        }
        distance
    }
}

impl Sector {
    /// Length of the shortest path to the target that enters by this sector.
    fn through(&self, distance: &[f64]) -> f64 {
        let [dp, dq] = self.base.map(|v| distance[v]);
        let along_edges = (dp + self.sides[0]).min(dq + self.sides[1]);
        if dp.is_infinite() || dq.is_infinite() {
            return along_edges;
        }
        // p at the origin, q on the x axis, the target above, s below
        let across = |a: f64, b: f64| {
            let x = (a * a - b * b + self.width * self.width) / (2.0 * self.width);
            (x, a * a - x * x)
        };
        let (sx, depth2) = across(dp, dq);
        let (vx, height2) = across(self.sides[0], self.sides[1]);
        if !(depth2 >= 0.0 && height2 > 0.0) {
            return along_edges;
        }
        let (depth, height) = (depth2.sqrt(), height2.sqrt());
        let crossing = sx + (vx - sx) * depth / (depth + height);
        if crossing < 0.0 || crossing > self.width {
            return along_edges;
        }
        along_edges.min((vx - sx).hypot(depth + height))
    }
}

/// A vertex whose distance has changed; the nearest comes first, then the one
/// with the smaller id.
#[derive(PartialEq)]
struct Front {
    distance: f64,
    vertex: usize,
}

impl Eq for Front {}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::{sphere, square};
    use mesh::Vec3;

    use super::*;

    #[test]
    fn planes_are_exact_whatever_the_triangles() {
        // shear makes most angles obtuse, up to 160 degrees
        for (jitter, shear) in [(0.0, 0.0), (0.2, 0.0), (0.2, 3.0)] {
            let mut plane = square(20, jitter);
            plane.vertices.iter_mut().for_each(|v| v.x += shear * v.y);
            let source = 10 * 21 + 7;
            // the sheared square is convex: the straight line lies inside
            let distance = Geodesics::new(&plane).distances(&[source]);
            for (v, d) in plane.vertices.iter().zip(&distance) {
                let exact = (v - plane.vertices[source]).norm();
                assert!((d - exact).abs() < 1e-7, "shear {shear}: {d} {exact}");
            }
        }
    }

    #[test]
    fn spheres_converge_and_other_components_are_infinite() {
        // largest error near the far pole, in half circumferences; edges 0.2, 0.1
        let mut errors = Vec::new();
        for levels in [3, 4] {
            let ball = sphere(levels);
            let n = ball.vertices.len();
            let mut two = ball.clone();
            two.vertices.extend(ball.vertices.iter().map(|v| v + 5.0 * Vec3::x()));
            two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
            let distance = Geodesics::new(&two).distances(&[0]);
            assert!(distance[n..].iter().all(|d| d.is_infinite()));
            let error = |v: usize| {
                let angle = ball.vertices[v].dot(&ball.vertices[0]).clamp(-1.0, 1.0).acos();
                (distance[v] - angle).abs()
            };
            errors.push((0..n).map(error).fold(0.0, f64::max) / std::f64::consts::PI);
        }
        assert!(errors[0] < 0.05 && errors[1] < 0.65 * errors[0], "{errors:?}");
    }

    #[test]
    fn several_sources_give_the_nearest() {
        let plane = square(20, 0.2);
        let sources = [0, 20, 230];
        let distance = Geodesics::new(&plane).distances(&sources);
        for (v, d) in plane.vertices.iter().zip(&distance) {
            let each = sources.map(|s| (v - plane.vertices[s]).norm());
            let exact = each.into_iter().fold(f64::INFINITY, f64::min);
            // where fronts meet, half an edge
            assert!((d - exact).abs() < 0.5 / 20.0, "{d} {exact}");
        }
    }
}
