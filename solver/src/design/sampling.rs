//! Points spread evenly over a triangle surface.
//!
//! Farthest-point sampling: each point is the vertex farthest, along the
//! surface, from the rim and all points before it. Sweeps then spread them more
//! evenly, a few times over:
//!
//! re-pick   every point in turn is taken out and placed again as the vertex
//!           farthest from all others, as in the published programs
//! Lloyd     every point goes to the vertex c of its geodesic Voronoi cell that
//!           lowers Σ A_v d(c, v)² over the cell's vertices v with areas A_v, as
//!           in the paper; the rim has a cell, too, and stays
//!
//! Ties go to the smaller vertex id, so that the result depends on the mesh
//! alone. A component that no source reaches is infinitely far and gets a point
//! first.
//!
//! Sources: Gjoka et al. 2024, section 4.5; Lloyd 1982, doi:10.1109/TIT.1982.1056489.

use mechanics::symmetry::Plane;
use mesh::{SurfaceMesh, topology};
use scene::config::Spread;

use super::Geodesics;

/// Times that every point is placed again, at most.
const SWEEPS: usize = 5;

/// More points were asked for than there are vertices off the rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{wanted} handles were asked for, but the surface has only {available} vertices off its rim; \
     ask for at most {available}"
)]
pub struct TooManyHandles {
    /// Points asked for.
    pub wanted: usize,
    /// Vertices off the rim.
    pub available: usize,
}

/// Vertex ids on the rim of a surface, ascending.
pub fn rim(surface: &SurfaceMesh) -> Vec<usize> {
    let mut rim: Vec<usize> = topology::boundary_edges(&surface.triangles).concat();
    rim.sort_unstable();
    rim.dedup();
    rim
}

/// The part of the rim of a patch that is in no plane of symmetry; `ids` are its vertices in
/// the body.
pub fn open_rim(surface: &SurfaceMesh, ids: &[usize], planes: &[Plane]) -> Vec<usize> {
    let mut edges = topology::boundary_edges(&surface.triangles);
    edges.retain(|edge| !planes.iter().any(|plane| edge.iter().all(|&v| plane.contains(ids[v]))));
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
    spread: Spread,
    images: &dyn Fn(usize) -> Vec<usize>,
) -> Result<Vec<usize>, TooManyHandles> {
    let available = surface.vertices.len() - rim.len();
    if count > available {
        return Err(TooManyHandles { wanted: count, available });
    }
    let mut sampling = Sampling::new(surface, rim, images);
    for i in 0..count {
        let first = if i == 0 && rim.is_empty() { lowest(surface) } else { sampling.farthest() };
        sampling.add(i, first);
    }
    match spread {
        Spread::RePick if count + rim.len() > 1 => {
            for i in (0..SWEEPS).flat_map(|_| 0..count) {
                sampling.remove(i);
                let farthest = sampling.farthest();
                sampling.add(i, farthest);
            }
        }
        Spread::RePick => {}
        Spread::Lloyd => {
            let cells = Cells::new(surface, rim);
            let moves = |_: &usize| sampling.center_all(&cells);
            let _ = (0..SWEEPS).take_while(moves).count();
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

/// What the middle of a cell depends on.
struct Cells {
    /// A third of the area of the triangles at each vertex [m²].
    areas: Vec<f64>,
    /// Vertices along edges, ascending.
    neighbours: Vec<Vec<usize>>,
    on_rim: Vec<bool>,
}

impl Cells {
    fn new(surface: &SurfaceMesh, rim: &[usize]) -> Self {
        let n = surface.vertices.len();
        let (mut areas, mut on_rim) = (vec![0.0; n], vec![false; n]);
        for &triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| surface.vertices[v]);
            let third = mesh::measure::triangle_area(a, b, c) / 3.0;
            triangle.iter().for_each(|&v| areas[v] += third);
        }
        rim.iter().for_each(|&v| on_rim[v] = true);
        let edges: Vec<[usize; 2]> =
            topology::edge_facets(&surface.triangles).into_keys().collect();
        let mut neighbours = topology::vertex_neighbours(n, &edges);
        neighbours.iter_mut().for_each(|list| list.sort_unstable());
        Self { areas, neighbours, on_rim }
    }
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

    /// Moves every point to the middle of its cell; whether any has moved.
    fn center_all(&mut self, cells: &Cells) -> bool {
        let mut own = vec![Vec::new(); self.points.len()];
        for (v, (_, source)) in self.nearest.iter().enumerate() {
            if let Source::Point(i) = source {
                own[*i].push(v);
            }
        }
        let middle = |i: usize| self.center(i, &own[i], cells);
        let middles: Vec<usize> = (0..own.len()).map(middle).collect();
        let moved: Vec<usize> = (0..own.len()).filter(|&i| middles[i] != self.points[i]).collect();
        for &i in &moved {
            self.remove(i);
            self.add(i, middles[i]);
        }
        !moved.is_empty()
    }

    /// The vertex of a cell from which no neighbour lowers Σ A d², by descent
    /// from its point.
    fn center(&self, i: usize, cell: &[usize], cells: &Cells) -> usize {
        let radius = cell.iter().map(|&v| self.nearest[v].0).fold(0.0, f64::max);
        // no two vertices of a cell are farther apart
        let reach = 2.0 * radius;
        let spread = |center: usize| -> f64 {
            let distances = self.geodesics.within(&self.orbit(center), reach);
            cell.iter().map(|&v| cells.areas[v] * distances[v].powi(2)).sum()
        };
        let mut tried = std::collections::BTreeSet::from([self.points[i]]);
        let mut best = (spread(self.points[i]), self.points[i]);
        loop {
            let before = best.1;
            for &v in &cells.neighbours[before] {
                let inside = cell.binary_search(&v).is_ok() && !cells.on_rim[v];
                if inside && tried.insert(v) {
                    let here = spread(v);
                    if here < best.0 {
                        best = (here, v);
                    }
                }
            }
            if best.1 == before {
                return before;
            }
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

    #[test]
    fn one_point_lies_in_the_middle_of_a_disk() {
        let plane = square(20, 0.0);
        let points = spread_points(&plane, &rim(&plane), 1, Spread::RePick, &alone).unwrap();
        assert!((plane.vertices[points[0]] - Vec3::new(0.5, 0.5, 0.0)).norm() < 1e-9);
    }

    /// No vertex is much farther from the points than these are from each
    /// other: the two radii that an even sampling balances.
    #[test]
    fn points_are_spread_evenly_off_the_rim() {
        let surface = cap(4);
        for count in [4, 16, 50] {
            let points =
                spread_points(&surface, &rim(&surface), count, Spread::RePick, &alone).unwrap();
            let rim = rim(&surface);
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

    /// The largest distance of a vertex to the nearest point or the rim.
    fn gap(surface: &SurfaceMesh, points: &[usize]) -> f64 {
        let sources = [points, &rim(surface)].concat();
        Geodesics::new(surface).distances(&sources).into_iter().fold(0.0, f64::max)
    }

    /// Σ A d² of all vertices that are nearer to a point than to the rim.
    fn spread(surface: &SurfaceMesh, points: &[usize]) -> f64 {
        let cells = Cells::new(surface, &rim(surface));
        let sources = [points, &rim(surface)].concat();
        let distances = Geodesics::new(surface).distances(&sources);
        distances.iter().zip(&cells.areas).map(|(d, a)| a * d * d).sum()
    }

    #[test]
    fn sweeps_of_lloyd_lower_what_they_should() {
        for (surface, count) in [(cap(4), 10), (sphere(4), 20)] {
            let mut greedy = Sampling::new(&surface, &rim(&surface), &alone);
            for i in 0..count {
                let anywhere = i == 0 && greedy.nearest[0].0.is_infinite();
                let next = if anywhere { lowest(&surface) } else { greedy.farthest() };
                greedy.add(i, next);
            }
            let points =
                spread_points(&surface, &rim(&surface), count, Spread::Lloyd, &alone).unwrap();
            assert_eq!(
                points,
                spread_points(&surface, &rim(&surface), count, Spread::Lloyd, &alone).unwrap()
            );
            let (before, after) = (spread(&surface, &greedy.points), spread(&surface, &points));
            assert!(after < before, "{after} {before}");
        }
    }

    /// From points that lie side by side in a corner.
    #[test]
    fn sweeps_of_lloyd_shrink_the_largest_gap() {
        let surface = square(20, 0.2);
        let rim = rim(&surface);
        let cells = Cells::new(&surface, &rim);
        let mut sampling = Sampling::new(&surface, &rim, &alone);
        let inside = (0..surface.vertices.len()).filter(|v| !cells.on_rim[*v]);
        inside.take(8).enumerate().for_each(|(i, v)| sampling.add(i, v));
        let start = gap(&surface, &sampling.points);
        let mut last = spread(&surface, &sampling.points);
        while sampling.center_all(&cells) {
            let now = spread(&surface, &sampling.points);
            assert!(now < last, "{now} {last}");
            last = now;
        }
        let end = gap(&surface, &sampling.points);
        assert!(end < 0.6 * start, "{end} {start}");
    }

    #[test]
    fn every_component_gets_a_point_and_closed_surfaces_work() {
        let ball = sphere(2);
        let n = ball.vertices.len();
        let mut two = ball.clone();
        two.vertices.extend(ball.vertices.iter().map(|v| v + 5.0 * Vec3::x()));
        two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
        let points = spread_points(&two, &rim(&two), 2, Spread::RePick, &alone).unwrap();
        assert!((points[0] < n) != (points[1] < n));
        assert_eq!(
            spread_points(&ball, &rim(&ball), 1, Spread::RePick, &alone).unwrap(),
            vec![lowest(&ball)]
        );
    }

    #[test]
    fn more_points_than_vertices_are_refused() {
        let plane = square(3, 0.0);
        assert_eq!(
            spread_points(&plane, &rim(&plane), 4, Spread::RePick, &alone).unwrap().len(),
            4
        );
        let error = spread_points(&plane, &rim(&plane), 5, Spread::RePick, &alone).unwrap_err();
        assert_eq!(error, TooManyHandles { wanted: 5, available: 4 });
    }
}
