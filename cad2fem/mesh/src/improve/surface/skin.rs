//! Tetrahedra and their boundary facets under change.

use std::collections::{BTreeMap, BTreeSet};

use super::super::complex::Complex;
use super::super::flip::without_boundary_edge;
use super::super::inside::Inside;
use super::super::resample::contracted;
use super::super::shape::shape;
use super::super::smooth::relocate;
use crate::bvh::SurfaceBvh;
use crate::measure::triangle_normal;
use crate::topology::{TET_EDGES, directed_edges};
use crate::{SurfaceMesh, TetMesh, Vec3, facet_key};

/// A change must make the worst tetrahedron concerned better by this factor.
const GAIN: f64 = 1.05;
/// Least cosine between the normal of a new facet and of the old surface beside it.
const LEAST_COSINE: f64 = 0.5;
/// Parts of the way to a better place that are tried.
const WAYS: [f64; 3] = [1.0, 0.5, 0.25];

/// A boundary facet.
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    /// The corners, counter-clockwise from outside.
    pub corners: [usize; 3],
    /// The tag.
    pub tag: Option<u32>,
    /// Whether it may change.
    pub moves: bool,
}

/// The surface as it was.
pub struct Old {
    pub surface: SurfaceMesh,
    tree: SurfaceBvh,
    tolerance: f64,
}

impl Old {
    /// To be kept within `tolerance` [m].
    pub fn new(surface: SurfaceMesh, tolerance: f64) -> Self {
        Self { tree: SurfaceBvh::new(&surface), surface, tolerance }
    }

    fn closest(&self, p: &Vec3) -> Vec3 {
        self.tree.closest(p).point
    }

    /// Whether a triangle lies along the surface: its corners, the middles of its edges and its
    /// centroid are near, and it faces the same side.
    fn carries(&self, corners: [Vec3; 3]) -> bool {
        let [a, b, c] = corners;
        let center = (a + b + c) / 3.0;
        let points = [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, center];
        let near = |p: &Vec3| self.tree.closest(p).distance <= self.tolerance;
        let beside = self.surface.corners(self.tree.closest(&center).triangle);
        let [p, q, r] = beside;
        let cosine = triangle_normal(a, b, c).dot(&triangle_normal(p, q, r));
        cosine >= LEAST_COSINE && points.iter().all(near)
    }
}

/// A mesh whose boundary may change along the old surface.
pub struct Skin<'a> {
    pub complex: Complex,
    facets: BTreeMap<[usize; 3], Facet>,
    /// Keys of the boundary facets about each vertex.
    about: Vec<BTreeSet<[usize; 3]>>,
    old: &'a Old,
}

impl<'a> Skin<'a> {
    pub fn new(
        mesh: &TetMesh,
        inside: &Inside,
        facets: BTreeMap<[usize; 3], Facet>,
        old: &'a Old,
    ) -> Self {
        let mut about = vec![BTreeSet::new(); mesh.vertices.len()];
        for key in facets.keys() {
            key.iter().for_each(|&v| {
                about[v].insert(*key);
            });
        }
        Self { complex: Complex::new(mesh, inside), facets, about, old }
    }

    /// The mesh, what stays inside it, and its facets, by the new numbers of the vertices.
    pub fn into_mesh(self) -> (TetMesh, Inside, BTreeMap<[usize; 3], Facet>) {
        let (mesh, inside, number) = self.complex.into_compact_mesh();
        let new = |v: usize| number[v].expect("a vertex of a tetrahedron");
        let renumbered = |facet: Facet| {
            let corners = facet.corners.map(new);
            (facet_key(corners), Facet { corners, ..facet })
        };
        (mesh, inside, self.facets.into_values().map(renumbered).collect())
    }

    /// Edges of a tetrahedron on the boundary, inside a tag that moves.
    pub fn free_edges(&self, tet: [usize; 4]) -> Vec<[usize; 2]> {
        let edges = TET_EDGES.iter().map(|e| e.map(|k| tet[k]));
        edges.filter(|&edge| self.beside(edge).is_some()).collect()
    }

    /// Length of an edge [m].
    pub fn length(&self, [a, b]: [usize; 2]) -> f64 {
        (self.complex.points[a] - self.complex.points[b]).norm()
    }

    /// The two facets on an edge, that with the edge in its order first, if both move and have
    /// the same tag.
    fn beside(&self, [a, b]: [usize; 2]) -> Option<[Facet; 2]> {
        let mut both = self.about[a].intersection(&self.about[b]).map(|key| &self.facets[key]);
        let (first, second) = (both.next()?, both.next()?);
        if both.next().is_some() || !first.moves || !second.moves || first.tag != second.tag {
            return None;
        }
        let forward = directed_edges(first.corners).contains(&[a, b]);
        let (first, second) = (first.clone(), second.clone());
        Some(if forward { [first, second] } else { [second, first] })
    }

    /// Whether a vertex is on the boundary, inside a tag that moves, and on no facet that stays.
    fn is_free(&self, v: usize) -> bool {
        if self.complex.is_held(v) {
            return false;
        }
        let mut facets = self.about[v].iter().map(|key| &self.facets[key]);
        let Some(first) = facets.next() else { return false };
        first.moves && facets.all(|facet| facet.moves && facet.tag == first.tag)
    }

    fn carries(&self, facets: &[[usize; 3]]) -> bool {
        facets.iter().all(|facet| self.old.carries(facet.map(|v| self.complex.points[v])))
    }

    /// Whether facets that are not on the boundary may become its part.
    fn can_become(&self, facets: &[[usize; 3]]) -> bool {
        let is_new =
            |&facet| !self.facets.contains_key(&facet_key(facet)) && !self.complex.is_kept(facet);
        facets.iter().all(is_new) && self.carries(facets)
    }

    /// Exchanges facets of one tag for others.
    fn exchange(&mut self, old: &[Facet], new: &[[usize; 3]]) {
        let Facet { tag, moves, .. } = old[0];
        for facet in old {
            let key = facet_key(facet.corners);
            self.facets.remove(&key);
            key.iter().for_each(|&v| {
                self.about[v].remove(&key);
            });
        }
        for &corners in new {
            let key = facet_key(corners);
            self.facets.insert(key, Facet { corners, tag, moves });
            key.iter().for_each(|&v| {
                self.about[v].insert(key);
            });
        }
    }

    /// Exchanges an edge for that between the corners opposite it. A tetrahedron that has both
    /// facets on the edge is taken off.
    pub fn flip(&mut self, [a, b]: [usize; 2]) -> bool {
        let Some(old) = self.beside([a, b]) else { return false };
        let [c, d] = [0, 1].map(|side| opposite(old[side].corners, [a, b]));
        let new = [[a, d, c], [b, c, d]];
        let joined = self.about[c].intersection(&self.about[d]).next().is_some();
        if joined || !self.can_become(&new) {
            return false;
        }
        let star = self.complex.edge_star(a, b);
        let Some(tets) = without_boundary_edge(&self.complex, &star, [a, b], [c, d]) else {
            return false;
        };
        if !self.complex.replace_if_better(&star, &tets, GAIN) {
            return false;
        }
        self.exchange(&old, &new);
        true
    }

    /// Moves vertex `v` onto its neighbour `w`, whereupon they are one.
    pub fn collapse(&mut self, v: usize, w: usize) -> bool {
        if !self.is_free(v) {
            return false;
        }
        let around =
            |v: usize| -> BTreeSet<usize> { self.about[v].iter().flatten().copied().collect() };
        // the two ends, and the corners opposite
        if around(v).intersection(&around(w)).count() != 4 {
            return false;
        }
        let old: Vec<Facet> = self.about[v].iter().map(|key| self.facets[key].clone()).collect();
        let stay = old.iter().filter(|facet| !facet.corners.contains(&w));
        let new: Vec<[usize; 3]> =
            stay.map(|facet| facet.corners.map(|u| if u == v { w } else { u })).collect();
        let star = self.complex.star(v).to_vec();
        let tets = contracted(&self.complex, v, w);
        let reached = || {
            let place = self.complex.points[v];
            let corners = |facet: &[usize; 3]| facet.map(|u| self.complex.points[u]);
            let distance =
                |facet| (crate::bvh::closest_on_triangle(&place, &corners(facet)) - place).norm();
            new.iter().map(distance).fold(f64::INFINITY, f64::min) <= self.old.tolerance
        };
        if !self.can_become(&new)
            || !reached()
            || !self.complex.replace_if_better(&star, &tets, GAIN)
        {
            return false;
        }
        self.exchange(&old, &new);
        true
    }

    /// Splits an edge in its middle.
    pub fn split(&mut self, [a, b]: [usize; 2]) -> bool {
        let Some(old) = self.beside([a, b]) else { return false };
        let star = self.complex.edge_star(a, b);
        let middle = (self.complex.points[a] + self.complex.points[b]) / 2.0;
        // one that is not accepted has no tetrahedra and goes with the others that were removed
        let m = self.complex.add_boundary_vertex(middle);
        self.about.resize(m + 1, BTreeSet::new());
        let with = |corner: usize| move |v: usize| if v == corner { m } else { v };
        let old_tets = star.iter().filter_map(|&t| self.complex.tet(t));
        let tets: Vec<[usize; 4]> =
            old_tets.flat_map(|tet| [tet.map(with(a)), tet.map(with(b))]).collect();
        if !self.complex.replace_if_better(&star, &tets, GAIN) {
            return false;
        }
        let new: Vec<[usize; 3]> =
            old.iter().flat_map(|f| [f.corners.map(with(a)), f.corners.map(with(b))]).collect();
        self.exchange(&old, &new);
        true
    }

    /// Moves a vertex along the old surface, towards the middle of its neighbours or to where the
    /// tetrahedra about it are best.
    pub fn slide(&mut self, v: usize) -> bool {
        if !self.is_free(v) {
            return false;
        }
        let here = self.complex.points[v];
        let ring: BTreeSet<usize> =
            self.about[v].iter().flatten().copied().filter(|&u| u != v).collect();
        let middle = ring.iter().map(|&u| self.complex.points[u]).sum::<Vec3>() / ring.len() as f64;
        let link = self.complex.link_points(v);
        let limit = GAIN * self.complex.worst(self.complex.star(v));
        let best = relocate(&link, here);
        let places = [best, middle]
            .map(|goal| WAYS.map(|way| self.old.closest(&(here + way * (goal - here)))));
        let facets: Vec<[usize; 3]> =
            self.about[v].iter().map(|key| self.facets[key].corners).collect();
        let fits = |place: &&Vec3| {
            let at = |u: usize| if u == v { **place } else { self.complex.points[u] };
            link.iter().all(|&[a, b, c]| shape([a, b, c, **place]) > limit)
                && facets.iter().all(|facet| self.old.carries(facet.map(at)))
        };
        let Some(&place) = places.as_flattened().iter().find(fits) else { return false };
        self.complex.move_vertex(v, place);
        true
    }
}

/// The corner of a facet that is no end of an edge.
fn opposite(corners: [usize; 3], edge: [usize; 2]) -> usize {
    corners.into_iter().find(|v| !edge.contains(v)).expect("an edge of the facet")
}
