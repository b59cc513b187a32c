//! Areas of the features of a collision surface, which weight their contacts.
//!
//! A_v = ⅓ Σ areas of the triangles at a vertex,   A_e = ⅓ Σ those at an edge [m²]
//!
//! They are of the rest shape, so they change with the design:
//! ∂A/∂X_i = ½ n × (X_{i+2} − X_{i+1}) for a triangle with unit normal n.
//!
//! Triangles of an obstacle may be as large as a floor. The area of its features
//! counts only up to the mean one of the bodies', as if it were meshed like them.
//!
//! Source: Li et al. 2023, arXiv:2307.15908.

use mesh::{Vec3, topology};

use super::surface::Surface;

/// Neighbours of vertices and edges of a collision surface.
pub struct Adjacency {
    /// Edges as in [`Features`](super::pairs::Features).
    edges: Vec<[usize; 2]>,
    triangles: Vec<[usize; 3]>,
    triangle_edges: Vec<[usize; 3]>,
    edges_of: Vec<Vec<usize>>,
    opposite: Vec<Vec<usize>>,
    rim: Vec<bool>,
    /// Whether vertices, then edges, belong to an obstacle.
    obstacle: Vec<bool>,
}

impl Adjacency {
    /// The neighbours on a surface.
    pub fn new(surface: &Surface) -> Self {
        let (features, count) = (surface.features(), surface.vertex_count());
        let mut adjacency = Self {
            edges: features.edges.clone(),
            triangles: features.triangles.clone(),
            triangle_edges: Vec::new(),
            edges_of: vec![Vec::new(); count],
            opposite: vec![Vec::new(); features.edges.len()],
            rim: vec![false; count],
            obstacle: (0..count).map(|v| surface.is_obstacle(v)).collect(),
        };
        for &[a, b, c] in &features.triangles {
            let edges = [[a, b], [b, c], [c, a]].map(|[p, q]| adjacency.edge([p, q]));
            edges.iter().zip([c, a, b]).for_each(|(&e, v)| adjacency.opposite[e].push(v));
            adjacency.triangle_edges.push(edges);
        }
        for (e, &[a, b]) in features.edges.iter().enumerate() {
            adjacency.edges_of[a].push(e);
            adjacency.edges_of[b].push(e);
            adjacency.obstacle.push(surface.is_obstacle(a));
        }
        for edge in topology::boundary_edges(&features.triangles) {
            edge.into_iter().for_each(|v| adjacency.rim[v] = true);
        }
        adjacency
    }

    /// The vertices of an edge.
    pub fn ends(&self, edge: usize) -> [usize; 2] {
        self.edges[edge]
    }

    /// The edge between two vertices.
    ///
    /// # Panics
    /// When there is none.
    pub fn edge(&self, [a, b]: [usize; 2]) -> usize {
        let found = self.edges.binary_search(&[a.min(b), a.max(b)]);
        found.expect("an edge of the surface")
    }

    /// Edges at a vertex.
    pub fn edges_of(&self, vertex: usize) -> &[usize] {
        &self.edges_of[vertex]
    }

    /// Third vertices of the triangles at an edge.
    pub fn opposite(&self, edge: usize) -> &[usize] {
        &self.opposite[edge]
    }

    /// Whether a vertex lies on the rim of an open surface.
    pub fn on_rim(&self, vertex: usize) -> bool {
        self.rim[vertex]
    }

    /// Whether two vertices have an edge in common.
    pub fn neighbours(&self, a: usize, b: usize) -> bool {
        self.edges_of[a].iter().any(|&e| self.edges[e].contains(&b))
    }

    /// Index of an edge's area.
    pub fn area_of_edge(&self, edge: usize) -> usize {
        self.rim.len() + edge
    }

    /// Number of areas: of vertices and edges.
    pub fn area_count(&self) -> usize {
        self.obstacle.len()
    }

    /// Areas of the vertices, then of the edges, at rest positions of the
    /// collision vertices [m²].
    pub fn areas(&self, rest: &[Vec3]) -> Vec<f64> {
        let mut areas = self.own_areas(rest);
        let limits = self.limits(&areas);
        for (i, area) in areas.iter_mut().enumerate().filter(|(i, _)| self.obstacle[*i]) {
            *area = area.min(limits[self.kind(i)].0);
        }
        areas
    }

    /// Adds Σ `by_area` ∂A/∂X on the collision vertices of the bodies.
    pub fn add_gradient(&self, rest: &[Vec3], by_area: &[f64], out: &mut [Vec3]) {
        let areas = self.own_areas(rest);
        let limits = self.limits(&areas);
        // what an area limits belongs to all triangles of the bodies
        let mut common = 0.0;
        for i in (0..areas.len()).filter(|&i| self.obstacle[i]) {
            let (limit, count) = limits[self.kind(i)];
            if limit < areas[i] {
                common += by_area[i] / count;
            }
        }
        for (triangle, edges) in self.triangles.iter().zip(&self.triangle_edges) {
            if self.obstacle[triangle[0]] {
                continue;
            }
            let own = triangle.iter().copied().chain(edges.iter().map(|&e| self.area_of_edge(e)));
            let by = own.map(|i| by_area[i]).sum::<f64>() / 3.0 + common;
            let x = triangle.map(|v| rest[v]);
            let normal = (x[1] - x[0]).cross(&(x[2] - x[0])).normalize();
            for i in 0..3 {
                out[triangle[i]] += 0.5 * by * normal.cross(&(x[(i + 2) % 3] - x[(i + 1) % 3]));
            }
        }
    }

    /// 0 for vertices, 1 for edges.
    fn kind(&self, i: usize) -> usize {
        usize::from(i >= self.rim.len())
    }

    fn own_areas(&self, rest: &[Vec3]) -> Vec<f64> {
        let mut areas = vec![0.0; self.area_count()];
        for (triangle, edges) in self.triangles.iter().zip(&self.triangle_edges) {
            let [a, b, c] = triangle.map(|v| rest[v]);
            let third = mesh::measure::triangle_area(a, b, c) / 3.0;
            triangle.iter().for_each(|&v| areas[v] += third);
            edges.iter().for_each(|&e| areas[self.area_of_edge(e)] += third);
        }
        areas
    }

    /// Mean areas of the bodies' vertices and edges, and their numbers.
    fn limits(&self, areas: &[f64]) -> [(f64, f64); 2] {
        let mut sums = [(0.0, 0.0); 2];
        for (i, area) in areas.iter().enumerate().filter(|(i, _)| !self.obstacle[*i]) {
            let sum = &mut sums[self.kind(i)];
            *sum = (sum.0 + area, sum.1 + 1.0);
        }
        sums.map(|(sum, count)| (sum / count, count))
    }
}
