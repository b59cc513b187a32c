//! A tetrahedral mesh under change: local replacements that keep its region.

use std::collections::BTreeMap;

use super::inside::Inside;
use super::shape::shape;
use crate::topology::{TET_EDGES, TET_FACETS, boundary};
use crate::{TetMesh, Vec3, facet_key};

/// Takes the place of a tetrahedron that has been removed.
const REMOVED: [usize; 4] = [usize::MAX; 4];

/// Tetrahedra with the list of those about each vertex.
///
/// Any set of tetrahedra may be replaced by another with the same boundary if all
/// the new ones are positive: both then cover the same points exactly once. Sets that a facet which
/// stays would be lost in are not replaced.
pub(super) struct Complex {
    pub points: Vec<Vec3>,
    /// Vertices of the boundary and of facets that stay.
    frozen: Vec<bool>,
    /// Facets inside that stay, with their tags.
    kept: BTreeMap<[usize; 3], Option<u32>>,
    /// Vertices of those.
    held: Vec<bool>,
    tets: Vec<[usize; 4]>,
    /// The volume of each tetrahedron.
    volumes: Vec<usize>,
    shapes: Vec<f64>,
    /// Tetrahedra about each vertex; none once a vertex has been removed.
    stars: Vec<Vec<usize>>,
    removed_tets: Vec<usize>,
    /// Changes so far, and their number when something about a vertex last changed.
    changes: usize,
    changed: Vec<usize>,
    /// Interior vertices that can be removed before a boundary vertex has a
    /// number beyond their count.
    spare_vertices: usize,
}

impl Complex {
    pub fn new(mesh: &TetMesh, inside: &Inside) -> Self {
        let mut held = vec![false; mesh.vertices.len()];
        for &v in inside.facets.keys().flatten() {
            held[v] = true;
        }
        let mut frozen = held.clone();
        for v in boundary(mesh).facets.into_iter().flatten() {
            frozen[v] = true;
        }
        let mut complex = Self {
            points: mesh.vertices.clone(),
            spare_vertices: frozen.iter().rev().take_while(|&&f| !f).count(),
            frozen,
            kept: inside.facets.clone(),
            held,
            volumes: Vec::with_capacity(mesh.tets.len()),
            tets: Vec::with_capacity(mesh.tets.len()),
            shapes: Vec::with_capacity(mesh.tets.len()),
            stars: vec![Vec::new(); mesh.vertices.len()],
            removed_tets: Vec::new(),
            changes: 0,
            changed: vec![0; mesh.vertices.len()],
        };
        for (&tet, &volume) in mesh.tets.iter().zip(&inside.volumes) {
            complex.add(tet, volume);
        }
        complex
    }

    /// The mesh without what has been removed, and the volume of each tetrahedron, in ascending
    /// order. Vertices of the boundary and of facets that stay keep their numbers, the others close
    /// the gaps in order.
    pub fn into_mesh(mut self) -> (TetMesh, Vec<usize>) {
        let interior: Vec<usize> = (0..self.points.len()).filter(|&v| !self.frozen[v]).collect();
        let used = interior.iter().copied().filter(|&v| !self.stars[v].is_empty());
        let mut number: Vec<usize> = (0..self.points.len()).collect();
        for (&to, from) in interior.iter().zip(used) {
            number[from] = to;
            self.points[to] = self.points[from];
        }
        let (tets, volumes) = self.by_volumes(|v| number[v]);
        self.points.truncate(tets.iter().flatten().max().map_or(0, |&v| v + 1));
        (TetMesh { vertices: self.points, tets }, volumes)
    }

    /// The tetrahedra that are left, with new numbers, in the order of their volumes.
    fn by_volumes(&self, number: impl Fn(usize) -> usize) -> (Vec<[usize; 4]>, Vec<usize>) {
        let left = (0..self.tets.len()).filter(|&t| self.tets[t] != REMOVED);
        let mut left: Vec<usize> = left.collect();
        left.sort_by_key(|&t| self.volumes[t]);
        let tet = |&t: &usize| (self.tets[t].map(&number), self.volumes[t]);
        left.iter().map(tet).unzip()
    }

    /// The mesh without what has been removed, the boundary renumbered as well; what stays inside
    /// it; and the new number of each vertex that is left.
    pub fn into_compact_mesh(self) -> (TetMesh, Inside, Vec<Option<usize>>) {
        let mut points = Vec::new();
        let mut number = vec![None; self.points.len()];
        for v in (0..self.points.len()).filter(|&v| !self.stars[v].is_empty()) {
            number[v] = Some(points.len());
            points.push(self.points[v]);
        }
        let new = |v: usize| number[v].expect("a vertex of a tetrahedron");
        let (tets, volumes) = self.by_volumes(new);
        let facets = self.kept.iter().map(|(facet, tag)| (facet_key(facet.map(new)), *tag));
        let inside = Inside { facets: facets.collect(), volumes };
        (TetMesh { vertices: points, tets }, inside, number)
    }

    /// A new vertex on the boundary, without tetrahedra so far.
    pub fn add_boundary_vertex(&mut self, point: Vec3) -> usize {
        self.points.push(point);
        self.frozen.push(true);
        self.held.push(false);
        self.stars.push(Vec::new());
        self.changed.push(self.changes);
        self.points.len() - 1
    }

    /// The present time, counted in changes.
    pub fn now(&self) -> usize {
        self.changes
    }

    /// Whether a tetrahedron about `v` has changed since `time`.
    pub fn changed_since(&self, v: usize, time: usize) -> bool {
        self.changed[v] >= time
    }

    pub fn is_interior(&self, v: usize) -> bool {
        !self.frozen[v]
    }

    /// Whether a facet stays inside.
    pub fn is_kept(&self, facet: [usize; 3]) -> bool {
        !self.kept.is_empty() && self.kept.contains_key(&facet_key(facet))
    }

    /// Whether vertex `v` is one of a facet that stays inside.
    pub fn is_held(&self, v: usize) -> bool {
        self.held[v]
    }

    /// Whether a facet that stays lies between two of these tetrahedra.
    fn are_divided(&self, tets: &[usize]) -> bool {
        if self.kept.is_empty() {
            return false;
        }
        let facets = |&t: &usize| TET_FACETS.map(|f| facet_key(f.map(|k| self.tets[t][k])));
        let mut kept: Vec<[usize; 3]> =
            tets.iter().flat_map(facets).filter(|facet| self.kept.contains_key(facet)).collect();
        kept.sort_unstable();
        kept.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// Whether vertex `v` may be removed without renumbering the boundary.
    pub fn can_remove(&self, v: usize) -> bool {
        self.is_interior(v) && self.spare_vertices > 0
    }

    /// Vertices of tetrahedron `t`, if it has not been removed.
    pub fn tet(&self, t: usize) -> Option<[usize; 4]> {
        (self.tets[t] != REMOVED).then_some(self.tets[t])
    }

    pub fn shape(&self, t: usize) -> f64 {
        self.shapes[t]
    }

    /// The smallest shape of some tetrahedra.
    pub fn worst(&self, tets: &[usize]) -> f64 {
        tets.iter().map(|&t| self.shapes[t]).fold(f64::INFINITY, f64::min)
    }

    /// The shape that a tetrahedron with these vertices would have.
    pub fn shape_of(&self, tet: [usize; 4]) -> f64 {
        shape(tet.map(|v| self.points[v]))
    }

    /// Tetrahedra with a shape below `limit`, worst first.
    pub fn worse_than(&self, limit: f64) -> Vec<usize> {
        let mut bad: Vec<usize> = (0..self.tets.len())
            .filter(|&t| self.tets[t] != REMOVED && self.shapes[t] < limit)
            .collect();
        bad.sort_by(|&s, &t| self.shapes[s].total_cmp(&self.shapes[t]).then(s.cmp(&t)));
        bad
    }

    /// Tetrahedra about vertex `v`.
    pub fn star(&self, v: usize) -> &[usize] {
        &self.stars[v]
    }

    /// Tetrahedra about the edge ab.
    pub fn edge_star(&self, a: usize, b: usize) -> Vec<usize> {
        self.stars[a].iter().copied().filter(|&t| self.tets[t].contains(&b)).collect()
    }

    /// The tetrahedron other than `t` on a facet of it that need not stay.
    pub fn across(&self, t: usize, [a, b, c]: [usize; 3]) -> Option<usize> {
        if self.is_kept([a, b, c]) {
            return None;
        }
        let shares =
            |&&s: &&usize| s != t && self.tets[s].contains(&b) && self.tets[s].contains(&c);
        self.stars[a].iter().find(shares).copied()
    }

    /// Facets opposite vertex `v` of the tetrahedra about it, facing `v`.
    pub fn link(&self, v: usize) -> Vec<[usize; 3]> {
        let opposite = |&t: &usize| {
            let tet = self.tets[t];
            let corner = (0..4).find(|&k| tet[k] == v).expect("a tetrahedron about v");
            let [a, b, c] = TET_FACETS[corner].map(|k| tet[k]);
            [a, c, b]
        };
        self.stars[v].iter().map(opposite).collect()
    }

    /// The corners of [`Self::link`].
    pub fn link_points(&self, v: usize) -> Vec<[Vec3; 3]> {
        self.link(v).into_iter().map(|facet| facet.map(|u| self.points[u])).collect()
    }

    /// Replaces the tetrahedra `old` by `new`, which must have the same boundary, if
    /// that makes the worst one better by the factor `gain`, leaves none inverted and every facet
    /// that stays.
    pub fn replace_if_better(&mut self, old: &[usize], new: &[[usize; 4]], gain: f64) -> bool {
        let limit = gain * self.worst(old).max(0.0);
        let better = new.iter().all(|&tet| self.shape_of(tet) > limit);
        let accepted = better && !self.are_divided(old) && !self.repeats(old, new);
        if accepted {
            self.replace(old, new);
        }
        accepted
    }

    /// Removes vertex `v`: replaces the tetrahedra about it by `new` if that makes
    /// the worst one better.
    pub fn remove_if_better(&mut self, v: usize, new: &[[usize; 4]]) -> bool {
        let old = self.stars[v].clone();
        let accepted = self.replace_if_better(&old, new, 1.0);
        self.spare_vertices -= usize::from(accepted);
        accepted
    }

    /// Adds a vertex: replaces the tetrahedra `old` by those between their boundary
    /// `facets` and `point` if that makes the worst one better by the factor `gain`.
    pub fn insert_if_better(
        &mut self,
        point: Vec3,
        old: &[usize],
        facets: &[[usize; 3]],
        gain: f64,
    ) -> bool {
        let v = self.points.len();
        self.points.push(point);
        self.frozen.push(false);
        self.held.push(false);
        self.stars.push(Vec::new());
        self.changed.push(self.changes);
        let new: Vec<_> = facets.iter().map(|&[a, b, c]| [a, b, c, v]).collect();
        // A rejected vertex has no tetrahedra and disappears with the removed ones.
        let accepted = self.replace_if_better(old, &new, gain);
        self.spare_vertices += usize::from(accepted);
        accepted
    }

    /// Whether an edge or a facet of `new` that `old` does not have exists already.
    /// That cannot be as long as all tetrahedra are positive.
    fn repeats(&self, old: &[usize], new: &[[usize; 4]]) -> bool {
        let old: Vec<[usize; 4]> = old.iter().map(|&t| self.tets[t]).collect();
        let is_old = |part: &[usize]| old.iter().any(|tet| part.iter().all(|v| tet.contains(v)));
        let exists = |part: &[usize]| {
            let has_all = |&t: &usize| part.iter().all(|v| self.tets[t].contains(v));
            self.stars[part[0]].iter().any(has_all)
        };
        let repeated = |part: &[usize]| !is_old(part) && exists(part);
        new.iter().any(|tet| {
            TET_EDGES.iter().any(|e| repeated(&e.map(|k| tet[k])))
                || TET_FACETS.iter().any(|f| repeated(&f.map(|k| tet[k])))
        })
    }

    fn replace(&mut self, old: &[usize], new: &[[usize; 4]]) {
        self.changes += 1;
        // they have a facet in common with another of them, and nothing divides them
        let volume = self.volumes[old[0]];
        for &t in old {
            for v in self.tets[t] {
                self.stars[v].retain(|&s| s != t);
            }
            self.tets[t] = REMOVED;
            self.removed_tets.push(t);
        }
        for &tet in new {
            self.add(tet, volume);
        }
    }

    /// Moves a vertex.
    pub fn move_vertex(&mut self, v: usize, point: Vec3) {
        self.points[v] = point;
        self.changes += 1;
        for &t in &self.stars[v] {
            self.shapes[t] = shape(self.tets[t].map(|u| self.points[u]));
            for u in self.tets[t] {
                self.changed[u] = self.changes;
            }
        }
    }

    fn add(&mut self, tet: [usize; 4], volume: usize) {
        let t = self.removed_tets.pop().unwrap_or(self.tets.len());
        if t == self.tets.len() {
            self.tets.push(tet);
            self.shapes.push(0.0);
            self.volumes.push(volume);
        }
        self.tets[t] = tet;
        self.volumes[t] = volume;
        self.shapes[t] = self.shape_of(tet);
        for v in tet {
            self.stars[v].push(t);
            self.changed[v] = self.changes;
        }
    }
}
