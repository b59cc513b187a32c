//! The surface of a model, carried along as a design moved the walls of its mesh.
//!
//! Every vertex of a wall that moved gets the displacement of that wall over which it is. Edges that are longer than
//! half of the facets beside them are divided first, or a quarter where the displacement bends. Walls with a tag of
//! which nothing moved stay bit for bit, with their rims; points are added on rims that are divided.
//!
//! A wall that is pressed together makes slivers, whose corners may end on the wrong side of their longest edges. Their
//! edges are exchanged before and after, where that moves the surface by less than it is compared with.

use std::collections::BTreeMap;

use mesh::measure::triangle_normal;
use mesh::needles::take_out;
use mesh::topology::{boundary, edge_facets};
use mesh::{SurfaceMesh, TetMesh, Vec3};
use rayon::prelude::*;

use super::displacement::{self, Displacement, Moved};
use super::slivers::exchange;

/// How far an exchange of edges may move the surface, and how thick needles are that are taken out: the least with which
/// it does not fold [m].
const THIN: [f64; 3] = [5e-6, 1e-5, 2e-5];

/// Longest edge of a model that is carried, in the longest edge of the facet beside it.
const LONGEST: f64 = 0.5;

/// Longest edge where the displacement bends at its middle, in the longest edge of the facet beside it. An edge a quarter
/// as long bends by a sixteenth of what the facet does, at a kink by a quarter.
const LONGEST_BENT: f64 = 0.25;

/// Bends that are less do not matter: a fifth of what the mold may be off the CAD [m].
const BEND: f64 = 1e-5;

/// Triangles at an edge are folded on each other where the cosine between their normals is less.
const FOLDED: f64 = -0.8;

/// Times that edges are divided, at most: a facet is not longer than the body.
const ROUNDS: usize = 16;

/// A mesh as modelled, and what a design made of it.
pub struct Walls<'a> {
    /// The mesh as modelled.
    pub modelled: &'a TetMesh,
    /// The design.
    pub design: &'a TetMesh,
    /// The boundary facets of both.
    pub facets: &'a [[usize; 3]],
    /// The number of the tag of each facet, if it has one.
    pub tags: &'a [Option<usize>],
}

/// A model that was carried.
#[derive(Debug)]
pub struct Carried {
    /// The surface [m].
    pub surface: SurfaceMesh,
    /// For each of its triangles the one of the model that it was a part of.
    pub origin: Vec<usize>,
}

/// Why a model cannot be carried.
#[derive(Debug, thiserror::Error)]
pub enum CarryError {
    /// The boundary of the design is another one.
    #[error(
        "the design has {design} facets on its boundary, and not those of the mesh as modelled with {modelled}: its \
         surface was meshed again"
    )]
    Facets {
        /// Facets of the design.
        design: usize,
        /// Facets of the mesh as modelled.
        modelled: usize,
    },
    /// The design presses a wall together so much that the surface folds.
    #[error(
        "its surface folds at {count} edges, the first at ({x:.2}, {y:.2}, {z:.2}) mm",
        x = at.x, y = at.y, z = at.z
    )]
    Folded {
        /// How many edges.
        count: usize,
        /// The middle of the first [mm].
        at: Vec3,
    },
}

/// Carries a model whose triangles have the given tags.
pub fn carry(
    model: &SurfaceMesh,
    tags: &[Option<usize>],
    walls: &Walls,
) -> Result<Carried, CarryError> {
    let Walls { modelled, design, facets, .. } = walls;
    let found = boundary(design).facets;
    if found != *facets {
        return Err(CarryError::Facets { design: found.len(), modelled: facets.len() });
    }
    let motion = displacement::motion(modelled, design);
    let mut of: BTreeMap<Option<usize>, Vec<[usize; 3]>> = BTreeMap::new();
    for (facet, tag) in facets.iter().zip(walls.tags) {
        of.entry(*tag).or_default().push(*facet);
    }
    let moving = of.into_iter().map(|(tag, facets)| {
        let wall = Displacement::new(&modelled.vertices, facets, &motion);
        (tag, wall)
    });
    let moving: BTreeMap<_, _> = moving.filter(|(_, wall)| !wall.is_still()).collect();
    let mut fine = Fine::new(model, tags, &moving);
    for _ in 0..ROUNDS {
        if !fine.divide() {
            break;
        }
    }
    fine.carried()
}

/// A model that becomes finer.
struct Fine<'a> {
    surface: SurfaceMesh,
    /// The triangle of the model that each one is a part of.
    origin: Vec<usize>,
    tags: &'a [Option<usize>],
    moving: &'a BTreeMap<Option<usize>, Displacement>,
    /// The displacement of each vertex.
    moved: Vec<Moved>,
}

impl<'a> Fine<'a> {
    fn new(
        model: &SurfaceMesh,
        tags: &'a [Option<usize>],
        moving: &'a BTreeMap<Option<usize>, Displacement>,
    ) -> Self {
        let origin = (0..model.triangles.len()).collect();
        let mut fine = Self { surface: model.clone(), origin, tags, moving, moved: Vec::new() };
        fine.exchange(THIN[0]);
        let mut around = vec![Vec::new(); model.vertices.len()];
        for (t, triangle) in fine.surface.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| around[v].push(t));
        }
        let at = |(p, around): (&Vec3, &Vec<usize>)| fine.at(p, around);
        fine.moved = model.vertices.par_iter().zip(&around).map(at).collect();
        fine
    }

    /// The displacement of a point between triangles: none beside a wall that stays, else that of the wall which is
    /// nearest.
    fn at(&self, p: &Vec3, triangles: &[usize]) -> Moved {
        let still = Moved { by: Vec3::zeros(), off: 0.0, facet: f64::INFINITY };
        let normal = |&t: &usize| {
            let [a, b, c] = self.surface.corners(t);
            triangle_normal(a, b, c)
        };
        let normal: Vec3 = triangles.iter().map(normal).sum();
        let walls = triangles.iter().map(|&t| self.moving.get(&self.tags[self.origin[t]]));
        let Some(walls) = walls.collect::<Option<Vec<_>>>() else { return still };
        let found = walls.into_iter().map(|wall| wall.at(p, &normal));
        found.min_by(|a, b| a.off.total_cmp(&b.off)).unwrap_or(still)
    }

    /// Divides edges along which a wall moves, and says whether there were any.
    fn divide(&mut self) -> bool {
        let edges: Vec<_> = edge_facets(&self.surface.triangles).into_iter().collect();
        let divided = |([a, b], beside): ([usize; 2], Vec<usize>)| {
            let [p, q] = [a, b].map(|v| self.surface.vertices[v]);
            let moves = |&&t: &&usize| self.moving.contains_key(&self.tags[self.origin[t]]);
            // A rim is divided as the wall beside it that moves.
            let own: Vec<usize> = beside.iter().filter(moves).copied().collect();
            if own.is_empty() {
                return None;
            }
            let middle = (p + q) / 2.0;
            let facet = self.at(&middle, &own).facet;
            let moved = self.at(&middle, &beside);
            let bend = (moved.by - (self.moved[a].by + self.moved[b].by) / 2.0).norm();
            let longest = if bend > BEND { LONGEST_BENT } else { LONGEST };
            ((q - p).norm() > longest * facet).then_some(([a, b], middle, moved))
        };
        let found: Vec<_> = edges.into_par_iter().filter_map(divided).collect();
        let mut middles = BTreeMap::new();
        for (edge, middle, moved) in &found {
            middles.insert(*edge, self.surface.vertices.len());
            self.surface.vertices.push(*middle);
            self.moved.push(*moved);
        }
        self.split(&middles);
        !middles.is_empty()
    }

    /// Divides triangles at the middles of their edges.
    fn split(&mut self, middles: &BTreeMap<[usize; 2], usize>) {
        let mut all = Vec::new();
        let mut origin = Vec::new();
        for (&triangle, &from) in self.surface.triangles.iter().zip(&self.origin) {
            let parts = self.parts(triangle, middles);
            origin.extend(parts.iter().map(|_| from));
            all.extend(parts);
        }
        self.surface.triangles = all;
        self.origin = origin;
    }

    fn parts(
        &self,
        [a, b, c]: [usize; 3],
        middles: &BTreeMap<[usize; 2], usize>,
    ) -> Vec<[usize; 3]> {
        let middle = |p: usize, q: usize| middles.get(&[p.min(q), p.max(q)]).copied();
        match [middle(a, b), middle(b, c), middle(c, a)] {
            [None, None, None] => vec![[a, b, c]],
            [Some(m), Some(n), Some(o)] => vec![[a, m, o], [m, b, n], [o, n, c], [m, n, o]],
            [Some(m), None, None] => vec![[a, m, c], [m, b, c]],
            [Some(m), Some(n), None] => {
                let mut parts = vec![[m, b, n]];
                parts.extend(self.halves([a, m, n, c]));
                parts
            }
            // Turned until the first edge is divided, and the last is not unless all are.
            _ => self.parts([b, c, a], middles),
        }
    }

    /// A quadrilateral, divided along its shorter diagonal.
    fn halves(&self, [a, b, c, d]: [usize; 4]) -> [[usize; 3]; 2] {
        let length = |v: usize, w: usize| {
            (self.surface.vertices[w] - self.surface.vertices[v]).norm_squared()
        };
        match length(a, c) <= length(b, d) {
            true => [[a, b, c], [a, c, d]],
            false => [[a, b, d], [b, c, d]],
        }
    }

    /// Exchanges edges of slivers within walls that move.
    fn exchange(&mut self, tolerance: f64) {
        let Self { surface, origin, tags, moving, .. } = self;
        let wall = |t: usize| {
            let tag = tags[origin[t]];
            moving.contains_key(&tag).then_some(tag)
        };
        exchange(surface, wall, tolerance);
    }

    /// Edges at which triangles are folded on each other.
    fn folds(&self) -> Vec<[usize; 2]> {
        let normal = |t: usize| {
            let [a, b, c] = self.surface.corners(t);
            triangle_normal(a, b, c)
        };
        let folded = |(edge, facets): ([usize; 2], Vec<usize>)| match facets[..] {
            [s, t] => (normal(s).dot(&normal(t)) < FOLDED).then_some(edge),
            _ => None,
        };
        edge_facets(&self.surface.triangles).into_iter().filter_map(folded).collect()
    }

    fn carried(mut self) -> Result<Carried, CarryError> {
        let before = self.folds().len();
        for (p, moved) in self.surface.vertices.iter_mut().zip(&self.moved) {
            *p += moved.by;
        }
        let mut folds = Vec::new();
        for thin in THIN {
            self.exchange(thin);
            take_out(&mut self.surface, &mut self.origin, thin);
            folds = self.folds();
            if folds.len() <= before {
                break;
            }
        }
        if folds.len() > before {
            let [a, b] = folds[0].map(|v| self.surface.vertices[v]);
            return Err(CarryError::Folded { count: folds.len() - before, at: (a + b) * 0.5e3 });
        }
        Ok(Carried { surface: self.surface, origin: self.origin })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeSet;

    use mesh::bvh::SurfaceBvh;
    use mesh::check::check_surface;
    use mesh::place_key;
    use mesh::solid::Solid;

    use super::*;

    /// Radius of a round chamber [m].
    const RADIUS: f64 = 0.01;

    /// A design: one side of a ball bulges by 2 mm and turns by 20°, the other side stays.
    fn design(p: &Vec3) -> Vec3 {
        let middle = Vec3::new(0.0, 0.0, RADIUS);
        let near = (1.0 - (p - middle).norm_squared() / (1.6 * RADIUS).powi(2)).max(0.0).powi(3);
        let (sin, cos) = (0.35 * near).sin_cos();
        let turned = Vec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x);
        turned + Vec3::new(0.0, 0.3, 1.0) * (2e-3 * near)
    }

    /// A ball of tetrahedra around its middle, whose boundary has `n` facets around.
    fn ball(n: usize) -> TetMesh {
        let surface = Solid::sphere(&Vec3::zeros(), RADIUS, n).to_surface();
        let middle = surface.vertices.len();
        let tets = surface.triangles.iter().map(|&[a, b, c]| [middle, a, b, c]).collect();
        let vertices = surface.vertices.iter().copied().chain([Vec3::zeros()]).collect();
        TetMesh { vertices, tets }
    }

    /// The walls of a ball and its design, whose boundary is one wall.
    fn carried(
        modelled: &TetMesh,
        design: &TetMesh,
        model: &SurfaceMesh,
    ) -> Result<Carried, CarryError> {
        let facets = boundary(modelled).facets;
        let tags = vec![Some(1); facets.len()];
        let walls = Walls { modelled, design, facets: &facets, tags: &tags };
        carry(model, &vec![Some(1); model.triangles.len()], &walls)
    }

    /// Largest distances from the exact shape of a fine model: of the facets of the design, and of the model as it is
    /// carried [m].
    fn measured(n: usize) -> [f64; 2] {
        let modelled = ball(n);
        let mut moved = modelled.clone();
        moved.vertices.iter_mut().for_each(|p| *p = design(p));
        let model = Solid::sphere(&Vec3::zeros(), RADIUS, 128).to_surface();
        let exact: Vec<Vec3> = model.vertices.iter().map(design).collect();
        let apart = |surface: &SurfaceMesh| {
            let bvh = SurfaceBvh::new(surface);
            exact.iter().map(|p| bvh.closest(p).distance).fold(0.0, f64::max)
        };
        let facets = boundary(&moved).surface(&moved).0;
        let carried = carried(&modelled, &moved, &model).unwrap().surface;
        assert!(check_surface(&carried).is_empty());
        // What did not move is as it was, bit for bit.
        let places: BTreeSet<[u64; 3]> = carried.vertices.iter().map(place_key).collect();
        let still = |p: &&Vec3| p.z < -0.9 * RADIUS;
        assert!(model.vertices.iter().filter(still).all(|p| places.contains(&place_key(p))));
        [apart(&facets), apart(&carried)]
    }

    /// The distance falls with the third power of the length of facets, that of the facets themselves with the second.
    #[test]
    fn a_carried_ball_is_nearer_to_the_exact_shape_than_facets() {
        let [coarse, fine] = [24, 48].map(measured);
        assert!(coarse[0] > 2.5e-4 && coarse[1] < 3e-5, "{coarse:?}");
        assert!(fine[0] > 6e-5 && fine[1] < 6e-6, "{fine:?}");
    }

    #[test]
    fn a_design_with_other_facets_is_refused() {
        let [some, others] = [16, 24].map(ball);
        let model = Solid::sphere(&Vec3::zeros(), RADIUS, 64).to_surface();
        let message = carried(&some, &others, &model).unwrap_err().to_string();
        assert!(message.contains("not those of the mesh as modelled"), "{message}");
    }

    /// One half of the ball is turned inside the other.
    #[test]
    fn a_wall_that_folds_is_refused() {
        let modelled = ball(24);
        let mut moved = modelled.clone();
        moved.vertices.iter_mut().filter(|p| p.z > 0.2 * RADIUS).for_each(|p| p.z *= -1.0);
        let model = Solid::sphere(&Vec3::zeros(), RADIUS, 64).to_surface();
        let message = carried(&modelled, &moved, &model).unwrap_err().to_string();
        assert!(message.contains("folds at"), "{message}");
    }
}
