//! What is left open of a wall, and closed by a cap.
//!
//! A rim is a loop of edges. Where it lies in a plane of symmetry nothing is left open: the
//! mirror image of the wall goes on there. What remains between such places is an arc, whose
//! ends are in planes, and its images complete it to a loop.
//!
//! The cap is the cone from the mean c of the loop's vertices; of an arc that of its vertices
//! and their images, so its ends count half, and c lies in the planes of the ends.

use mesh::Vec3;
use mesh::topology::boundary_loops;

use crate::symmetry::Plane;

/// A loop or an arc of edges that a cap closes.
#[derive(Clone, Debug)]
pub struct Rim {
    /// Vertex ids in the direction of the facets' edges.
    pub vertices: Vec<usize>,
    /// Axis and level [m] of the planes in which an arc ends; none of a loop.
    ends: Vec<(usize, f64)>,
    is_loop: bool,
}

/// The rims of facets that are oriented out of the solid.
pub fn rims(facets: &[[usize; 3]], planes: &[Plane]) -> Vec<Rim> {
    boundary_loops(facets).into_iter().flat_map(|vertices| cut(vertices, planes)).collect()
}

/// The parts of a loop that are in no plane.
fn cut(vertices: Vec<usize>, planes: &[Plane]) -> Vec<Rim> {
    let n = vertices.len();
    let in_plane = |i: usize| {
        let ends = [vertices[i % n], vertices[(i + 1) % n]];
        planes.iter().any(|plane| ends.iter().all(|&v| plane.contains(v)))
    };
    let Some(first) = (0..n).find(|&i| in_plane(i)) else {
        return vec![Rim { vertices, ends: Vec::new(), is_loop: true }];
    };
    let mut arcs: Vec<Vec<usize>> = Vec::new();
    let mut open = false;
    for i in first + 1..first + n {
        if in_plane(i) {
            open = false;
            continue;
        }
        if !open {
            arcs.push(vec![vertices[i % n]]);
        }
        open = true;
        arcs.last_mut().expect("an arc is open").push(vertices[(i + 1) % n]);
    }
    arcs.into_iter().map(|vertices| Rim::arc(vertices, planes)).collect()
}

impl Rim {
    fn arc(vertices: Vec<usize>, planes: &[Plane]) -> Self {
        let ends = [vertices[0], vertices[vertices.len() - 1]];
        let touched = planes.iter().filter(|plane| ends.iter().any(|&v| plane.contains(v)));
        let ends = touched.map(|plane| (plane.axis, plane.level)).collect();
        Self { vertices, ends, is_loop: false }
    }

    /// The edges as vertex ids.
    pub fn edges(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let n = self.vertices.len();
        (0..self.count()).map(move |i| [self.vertices[i], self.vertices[(i + 1) % n]])
    }

    /// Number of its edges, and of its vertices where the two ends of an arc are one.
    fn count(&self) -> usize {
        if self.is_loop { self.vertices.len() } else { self.vertices.len() - 1 }
    }

    /// The apex c of the cap [m].
    pub fn apex(&self, x: impl Fn(usize) -> Vec3) -> Vec3 {
        let mut sum: Vec3 = self.vertices.iter().map(|&v| x(v)).sum();
        if let (false, [first, .., last]) = (self.is_loop, &self.vertices[..]) {
            sum -= 0.5 * (x(*first) + x(*last));
        }
        let mut apex = sum / self.count() as f64;
        self.ends.iter().for_each(|&(axis, level)| apex[axis] = level);
        apex
    }

    /// `scale` (∂c/∂x_v)ᵀ `bar` of each of its vertices.
    pub fn apex_vjp(&self, scale: f64, mut bar: Vec3) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let n = self.vertices.len();
        self.ends.iter().for_each(|&(axis, _)| bar[axis] = 0.0);
        let of = move |i: usize| {
            let is_end = !self.is_loop && (i == 0 || i == n - 1);
            let share = if is_end { 0.5 } else { 1.0 };
            share * (scale / self.count() as f64) * bar
        };
        self.vertices.iter().enumerate().map(move |(i, &v)| (v, of(i)))
    }
}
