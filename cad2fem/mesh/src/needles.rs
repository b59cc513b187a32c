//! Needles, triangles thinner than a file resolves, taken out where they cross others.
//!
//! Rounding can move the corner of a needle across its longest edge, so that it lies
//! upside down on its neighbour. A needle with a short edge is taken out by merging the
//! ends of that edge; one whose corner lies on its longest edge by joining that corner to
//! the one opposite instead (an edge flip). Either moves the surface by no more than the
//! needle is thick, and leaves everything else as it is.

use std::collections::BTreeSet;

use crate::SurfaceMesh;
use crate::crossings::self_intersecting_pairs;
use crate::measure::longest_edge;
use crate::topology::directed_edges;

/// Rounds, at most: what is left of a needle may be one.
const ROUNDS: usize = 50;

/// Takes out needles no thicker than `thin` until no triangles cross and all have areas, or
/// until that is of no use. `source`, one entry for each triangle, loses those of the triangles
/// that go.
pub fn take_out(surface: &mut SurfaceMesh, source: &mut Vec<usize>, thin: f64) {
    for _ in 0..ROUNDS {
        let needles = offending(surface, thin);
        if needles.is_empty() || !Round::new(surface, thin).take_out(&needles, source) {
            return;
        }
    }
}

/// The needles without area and those that cross other triangles, the thinnest first.
fn offending(surface: &SurfaceMesh, thin: f64) -> Vec<usize> {
    let flat = (0..surface.triangles.len()).filter(|&t| thickness(surface, t) <= 0.0);
    let crossing = self_intersecting_pairs(surface).into_iter().flat_map(|(s, t)| [s, t]);
    let found: BTreeSet<usize> = flat.chain(crossing).collect();
    let measured = found.into_iter().map(|t| (thickness(surface, t), t));
    let mut needles: Vec<(f64, usize)> = measured.filter(|needle| needle.0 <= thin).collect();
    needles.sort_by(|a, b| a.0.total_cmp(&b.0));
    needles.into_iter().map(|needle| needle.1).collect()
}

/// Height of a triangle over its longest edge.
fn thickness(surface: &SurfaceMesh, t: usize) -> f64 {
    match longest_edge(surface.corners(t)) {
        0.0 => 0.0,
        longest => 2.0 * surface.area(t) / longest,
    }
}

/// One pass over the needles, which leaves alone what it has touched.
struct Round<'a> {
    surface: &'a mut SurfaceMesh,
    /// Longest edge whose ends become one.
    thin: f64,
    /// The triangles at each vertex when the round began.
    stars: Vec<Vec<usize>>,
    touched: BTreeSet<usize>,
    gone: BTreeSet<usize>,
}

impl<'a> Round<'a> {
    fn new(surface: &'a mut SurfaceMesh, thin: f64) -> Self {
        let mut stars = vec![Vec::new(); surface.vertices.len()];
        for (t, triangle) in surface.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| stars[v].push(t));
        }
        Self { surface, thin, stars, touched: BTreeSet::new(), gone: BTreeSet::new() }
    }

    /// Whether any could be taken out.
    fn take_out(mut self, needles: &[usize], source: &mut Vec<usize>) -> bool {
        for &t in needles {
            let edges = directed_edges(self.surface.triangles[t]);
            let length =
                |[a, b]: [usize; 2]| (self.surface.vertices[a] - self.surface.vertices[b]).norm();
            let by_length = |e: &&[usize; 2], f: &&[usize; 2]| length(**e).total_cmp(&length(**f));
            let shortest = *edges.iter().min_by(by_length).expect("there are three");
            let longest = *edges.iter().max_by(by_length).expect("there are three");
            if length(shortest) > self.thin || !self.merge(shortest) {
                self.flip(t, longest);
            }
        }
        let kept: Vec<usize> =
            (0..self.surface.triangles.len()).filter(|t| !self.gone.contains(t)).collect();
        self.surface.triangles = kept.iter().map(|&t| self.surface.triangles[t]).collect();
        *source = kept.iter().map(|&t| source[t]).collect();
        !self.touched.is_empty()
    }

    /// Makes one vertex of the ends of an edge, if only the triangles at it have both as
    /// neighbours: otherwise sheets would touch.
    fn merge(&mut self, [kept, lost]: [usize; 2]) -> bool {
        let around = |v: usize| -> BTreeSet<usize> {
            let corners = self.stars[v].iter().flat_map(|&t| self.surface.triangles[t]);
            corners.filter(|&w| w != v).collect()
        };
        let common = around(kept).intersection(&around(lost)).count();
        let star: BTreeSet<usize> =
            self.stars[kept].iter().chain(&self.stars[lost]).copied().collect();
        if common != 2 || !self.touch(&star) {
            return false;
        }
        for t in star {
            let triangle = &mut self.surface.triangles[t];
            if triangle.contains(&kept) && triangle.contains(&lost) {
                self.gone.insert(t);
            }
            triangle.iter_mut().filter(|v| **v == lost).for_each(|v| *v = kept);
        }
        // The vertex that is lost stays in the list: welding leaves it out.
        true
    }

    /// Exchanges the edge ab of the triangle abc and of its neighbour bad for cd, unless
    /// there is such an edge.
    fn flip(&mut self, t: usize, [a, b]: [usize; 2]) {
        let apex = |t: usize| self.surface.triangles[t].into_iter().find(|&v| v != a && v != b);
        let across = |s: &usize| *s != t && self.surface.triangles[*s].contains(&b);
        let Some(s) = self.stars[a].iter().copied().find(across) else { return };
        let (Some(c), Some(d)) = (apex(t), apex(s)) else { return };
        let joined = self.stars[c].iter().any(|&r| self.surface.triangles[r].contains(&d));
        if joined || !self.touch(&BTreeSet::from([s, t])) {
            return;
        }
        self.surface.triangles[t] = [a, d, c];
        self.surface.triangles[s] = [d, b, c];
    }

    /// Marks triangles, unless one of them or of their neighbours is marked.
    fn touch(&mut self, triangles: &BTreeSet<usize>) -> bool {
        let corners: BTreeSet<usize> =
            triangles.iter().flat_map(|&t| self.surface.triangles[t]).collect();
        let near: BTreeSet<usize> =
            corners.into_iter().flat_map(|v| self.stars[v].iter().copied()).collect();
        if !near.is_disjoint(&self.touched) {
            return false;
        }
        self.touched.extend(near);
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{Round, SurfaceMesh, directed_edges};
    use crate::Vec3;
    use crate::check::check_surface;
    use crate::measure::enclosed_volume;
    use crate::solid::Solid;

    const THIN: f64 = 1e-4;

    /// Takes out, and checks that all triangles but those that went keep their sources.
    fn take_out(surface: &mut SurfaceMesh) {
        let mut source: Vec<usize> = (0..surface.triangles.len()).collect();
        super::take_out(surface, &mut source, THIN);
        assert_eq!(source.len(), surface.triangles.len());
    }

    /// A cube of 10 mm in whose top the middle m of a diagonal is a vertex, moved by `shift`.
    fn cube_with_a_needle(shift: Vec3) -> SurfaceMesh {
        let mut surface = Solid::cube(&Vec3::zeros(), &Vec3::repeat(10.0)).to_surface();
        let on_top = |t: &[usize; 3]| t.iter().all(|&v| surface.vertices[v].z == 10.0);
        let top: Vec<[usize; 3]> = surface.triangles.iter().copied().filter(on_top).collect();
        surface.triangles.retain(|t| !top.contains(t));
        let shared: Vec<usize> = top[0].into_iter().filter(|v| top[1].contains(v)).collect();
        let middle = (surface.vertices[shared[0]] + surface.vertices[shared[1]]) / 2.0 + shift;
        let m = surface.vertices.len();
        surface.vertices.push(middle);
        // The first triangle in three, of which one is a needle; the second as it is.
        let edges = directed_edges(top[0]);
        surface.triangles.extend(edges.map(|[a, b]| [a, b, m]));
        surface.triangles.push(top[1]);
        surface
    }

    #[test]
    fn a_corner_on_or_beyond_the_longest_edge_is_joined_to_the_other_side() {
        let whole = cube_with_a_needle(Vec3::zeros());
        let outward = {
            let top: Vec<&Vec3> = whole.vertices.iter().filter(|p| p.z == 10.0).collect();
            (top[0] - top[4]).cross(&Vec3::z()).normalize()
        };
        for shift in [0.0, 4e-6, -4e-6, 9e-5, -9e-5] {
            let mut surface = cube_with_a_needle(outward * shift);
            let before = check_surface(&surface).len();
            take_out(&mut surface);
            assert!(check_surface(&surface).is_empty(), "{shift}: {:?}", check_surface(&surface));
            assert!((enclosed_volume(&surface) - 1e3).abs() < 1e-9);
            assert!(before > 0 || shift != 0.0, "a triangle without area is found");
        }
    }

    #[test]
    fn ends_of_a_short_edge_become_one() {
        let mut surface = cube_with_a_needle(Vec3::zeros());
        // The new vertex next to a corner of the cube.
        let corner = surface.triangles[surface.triangles.len() - 2][0];
        let m = surface.vertices.len() - 1;
        surface.vertices[m] = surface.vertices[corner] + Vec3::new(0.0, 0.0, 5e-5);
        let count = surface.triangles.len();
        assert!(Round::new(&mut surface, THIN).merge([corner, m]));
        let mut merged = surface.clone();
        let gone =
            merged.triangles.iter().filter(|t| t.iter().filter(|&&v| v == corner).count() > 1);
        assert_eq!(gone.count(), 2);
        merged.triangles.retain(|t| t.iter().filter(|&&v| v == corner).count() < 2);
        assert_eq!(merged.triangles.len(), count - 2);
        assert!(check_surface(&merged).is_empty());
    }

    #[test]
    fn a_thick_triangle_is_left_alone() {
        let mut surface = cube_with_a_needle(Vec3::new(0.0, 0.0, 1.0));
        let before = surface.clone();
        take_out(&mut surface);
        assert_eq!(surface, before);
    }
}
