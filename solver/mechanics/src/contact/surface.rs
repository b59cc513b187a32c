//! The surface that collides: the skin of the bodies as flat triangles, and
//! rigid obstacles.
//!
//! x_c = W (ΠX + u)        for the bodies, f = Wᵀ f_c
//! x_c = R W (ΠX + u) + s  for their mirror images, f = Wᵀ R f_c
//! x_c = X_c + D(X_c, t)   for obstacles
//!
//! W   values of the displacement basis at the collision vertices: every
//!     boundary facet is split into a regular pattern of `split`² triangles. With
//!     `split` equal to the degree the collision vertices are the nodes of the
//!     boundary, and W selects them.
//! R, s  reflection in planes of symmetry: the surface is that of the whole, of which each
//!     copy has the same share of the energy. Points in a plane are their own image
//! D   prescribed displacement [m] at the time t
//!
//! Contact is exact for the flat triangles, which differ from curved facets by
//! O(h²). Topology never changes; rest shape and displacement are arguments.
//!
//! Source: Ferguson et al. 2023, "High-Order Incremental Potential Contact for
//! Elastodynamic Simulation on Curved Meshes", doi:10.1145/3588432.3591488.

use std::collections::BTreeMap;

use mesh::{SurfaceMesh, Vec3};

use super::images::{Image, Images, share};
use super::pairs::{Features, Pair};
use crate::element::{self, FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, Mat12};
use crate::symmetry::Plane;

/// Displacement [m] of a point of an obstacle, given its rest position [m] and
/// the load t.
pub type Motion = dyn Fn(Vec3, f64) -> Vec3 + Send + Sync;

/// A rigid surface that is no finite-element body.
pub struct Obstacle {
    /// The triangles.
    pub surface: SurfaceMesh,
    /// How it moves; none where it is at rest.
    pub motion: Option<Box<Motion>>,
}

/// What one body does to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyForce {
    /// The two bodies, the first not after the second.
    pub bodies: [usize; 2],
    /// Force on the first body [N]; none within one body.
    pub force: Vec3,
    /// Sum of the magnitudes of the forces on the vertices of the first body [N].
    pub magnitude: f64,
}

/// The collision surface.
pub struct Surface {
    /// Rows of W: nodes and weights, empty for vertices of obstacles.
    rows: Vec<Vec<(usize, f64)>>,
    /// The collision vertex of which each is the image, and how.
    images: Vec<Image>,
    /// Share of the bodies in the whole of which the surface is.
    share: f64,
    body: Vec<usize>,
    movable: Vec<bool>,
    features: Features,
    obstacles: Vec<Obstacle>,
}

impl Surface {
    /// The surface of boundary facets (vertex ids, oriented out of the solid), each of the body of the same entry of
    /// `bodies`, and of obstacles. Where planes of symmetry cut the bodies, it is that of the whole; obstacles are whole.
    /// `fixed` marks displacements that do not change when a step is solved for.
    ///
    /// # Panics
    /// When `split` is zero, `facets` and `bodies` differ in length, or a facet
    /// is none of the space.
    pub fn new(
        planes: &[Plane],
        space: &FunctionSpace,
        facets: &[[usize; 3]],
        bodies: &[usize],
        obstacles: Vec<Obstacle>,
        split: usize,
        fixed: &[bool],
    ) -> Self {
        assert!(split > 0 && facets.len() == bodies.len(), "one body for each facet");
        let mut lattice = Lattice { space, split, ids: BTreeMap::new(), rows: Vec::new() };
        let (mut triangles, mut body) = (Vec::new(), Vec::new());
        for (&facet, &b) in facets.iter().zip(bodies) {
            triangles.extend(lattice.split(facet));
            body.resize(lattice.rows.len(), b);
        }
        let corners = lattice.ids.into_iter().map(|(key, id)| {
            (id, key.into_iter().filter(|corner| corner.1 > 0).map(|corner| corner.0).collect())
        });
        let (mut rows, own) = (lattice.rows, triangles.len());
        let mut images = Images::new(planes, corners.collect());
        for copy in 1..images.copies() {
            for t in 0..own {
                triangles.push(images.mirror(triangles[t], copy));
            }
        }
        let mut images = images.all;
        let origins: Vec<usize> = images[rows.len()..].iter().map(|image| image.of).collect();
        rows.extend(origins.iter().map(|&v| rows[v].clone()).collect::<Vec<_>>());
        body.extend(origins.iter().map(|&v| body[v]).collect::<Vec<_>>());
        let is_free = |row: &Vec<(usize, f64)>| {
            row.iter().any(|&(n, _)| fixed[3 * n..3 * n + 3].contains(&false))
        };
        let mut movable: Vec<bool> = rows.iter().map(is_free).collect();
        let first = bodies.iter().max().map_or(0, |b| b + 1);
        for (k, obstacle) in obstacles.iter().enumerate() {
            let offset = rows.len();
            rows.resize(offset + obstacle.surface.vertices.len(), Vec::new());
            body.resize(rows.len(), first + k);
            triangles.extend(obstacle.surface.triangles.iter().map(|t| t.map(|v| v + offset)));
        }
        movable.resize(rows.len(), false);
        images.extend((images.len()..rows.len()).map(Image::itself));
        let (share, features) = (share(planes), Features::new(&triangles));
        Self { rows, images, share, body, movable, features, obstacles }
    }

    /// Vertices, edges and triangles.
    pub fn features(&self) -> &Features {
        &self.features
    }

    /// Share of the bodies in the whole of which the surface is: 1, or a half for each plane of
    /// symmetry.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Number of collision vertices, those of obstacles last.
    pub fn vertex_count(&self) -> usize {
        self.rows.len()
    }

    /// Nodes on which a collision vertex depends, with weights.
    pub fn row(&self, vertex: usize) -> &[(usize, f64)] {
        &self.rows[vertex]
    }

    /// Body of a collision vertex; obstacles count after the bodies.
    pub fn body(&self, vertex: usize) -> usize {
        self.body[vertex]
    }

    /// Whether both features of a pair are of one body that is no obstacle.
    pub fn within_one_body(&self, pair: &Pair) -> bool {
        let corners = pair.corners();
        let [first, second] = [corners[0], corners[3]];
        self.body[first] == self.body[second] && !self.is_obstacle(first)
    }

    /// Whether a collision vertex belongs to an obstacle.
    pub fn is_obstacle(&self, vertex: usize) -> bool {
        self.rows[vertex].is_empty()
    }

    /// Whether all of these collision vertices stay where they are.
    pub fn immovable(&self, vertices: &[usize]) -> bool {
        vertices.iter().all(|&v| !self.movable[v])
    }

    /// Rest positions of the collision vertices [m].
    pub fn rest(&self, space: &FunctionSpace, rest: &[Vec3]) -> Vec<Vec3> {
        let nodes = space.node_positions(rest);
        let mut x = self.interpolate(|n| nodes[n]);
        x.iter_mut().zip(&self.images).for_each(|(x, image)| *x += image.shift);
        self.for_each_obstacle_vertex(|v, place, _| x[v] = place);
        x
    }

    /// Positions of the collision vertices [m] at nodal displacements `u` and a
    /// load.
    pub fn positions(
        &self,
        space: &FunctionSpace,
        rest: &[Vec3],
        u: &[f64],
        time: f64,
    ) -> Vec<Vec3> {
        let moved = self.trace(u);
        let mut x = self.rest(space, rest);
        x.iter_mut().zip(&moved).for_each(|(x, u)| *x += u);
        self.for_each_obstacle_vertex(|v, place, motion| {
            x[v] += motion.map_or_else(Vec3::zeros, |m| m(place, time));
        });
        x
    }

    /// What obstacles move between two loads [m], zero elsewhere.
    pub fn motion(&self, from: f64, to: f64) -> Vec<Vec3> {
        let mut moved = vec![Vec3::zeros(); self.rows.len()];
        self.for_each_obstacle_vertex(|v, place, motion| {
            moved[v] = motion.map_or_else(Vec3::zeros, |m| m(place, to) - m(place, from));
        });
        moved
    }

    /// W of a nodal field; zero on obstacles.
    pub fn trace(&self, nodal: &[f64]) -> Vec<Vec3> {
        self.interpolate(|n| at(nodal, n))
    }

    /// Adds Wᵀ of vectors on the collision vertices to a nodal field.
    pub fn add_to_nodes(&self, vectors: &[Vec3], out: &mut [f64]) {
        for ((row, image), vector) in self.rows.iter().zip(&self.images).zip(vectors) {
            let vector = vector.component_mul(&image.signs);
            for &(node, weight) in row {
                add_at(out, node, &(weight * vector));
            }
        }
    }

    /// Adds to rest vertices, three components each, what vectors by the rest positions of
    /// the collision vertices make of them: Πᵀ Wᵀ.
    pub fn add_to_rest(&self, space: &FunctionSpace, vectors: &[Vec3], out: &mut [f64]) {
        let mut nodal = vec![0.0; 3 * space.node_count()];
        self.add_to_nodes(vectors, &mut nodal);
        space.add_to_vertices(&nodal, out);
    }

    /// Adds a second derivative by four collision vertices to the nodes they depend on.
    pub fn add_block(&self, corners: &[usize; 4], block: &Mat12, out: &mut BlockMatrix) {
        for (i, &a) in corners.iter().enumerate() {
            for (j, &b) in corners.iter().enumerate() {
                let block = block.fixed_view::<3, 3>(3 * i, 3 * j);
                if block.iter().all(|v| *v == 0.0) {
                    continue;
                }
                let [r, s] = [a, b].map(|v| &self.images[v].signs);
                let block = Mat3::from_fn(|k, l| r[k] * block[(k, l)] * s[l]);
                for &(row, by_row) in self.row(a) {
                    for &(column, by_column) in self.row(b) {
                        out.add_lower(row, column, &(block * (by_row * by_column)));
                    }
                }
            }
        }
    }

    /// Pairs of nodes (row > column) on which corners of one stencil depend,
    /// sorted, each once.
    pub fn couplings(&self, stencils: &[[usize; 4]]) -> Vec<[usize; 2]> {
        let mut couplings = Vec::new();
        for stencil in stencils {
            let nodes = || stencil.iter().flat_map(|&v| self.row(v)).map(|&(node, _)| node);
            for a in nodes() {
                couplings.extend(nodes().filter(|&b| b < a).map(|b| [a, b]));
            }
        }
        couplings.sort_unstable();
        couplings.dedup();
        couplings
    }

    /// Forces on corners of stencils, summed for each two bodies, in their order; those on images
    /// are mirrored back.
    pub fn body_forces(&self, forces: &[([usize; 4], [Vec3; 4])]) -> Vec<BodyForce> {
        let mut on_vertices = BTreeMap::<[usize; 2], BTreeMap<usize, Vec3>>::new();
        for (corners, forces) in forces {
            let bodies = corners.map(|v| self.body[v]);
            let key = [*bodies.iter().min().unwrap_or(&0), *bodies.iter().max().unwrap_or(&0)];
            let sums = on_vertices.entry(key).or_default();
            for (&v, force) in corners.iter().zip(forces).filter(|(v, _)| self.body[**v] == key[0])
            {
                let Image { of, signs, .. } = &self.images[v];
                *sums.entry(*of).or_insert_with(Vec3::zeros) += force.component_mul(signs);
            }
        }
        let total = |(bodies, sums): ([usize; 2], BTreeMap<usize, Vec3>)| BodyForce {
            bodies,
            force: sums.values().sum(),
            magnitude: sums.values().map(Vec3::norm).sum(),
        };
        on_vertices.into_iter().map(total).collect()
    }

    fn interpolate(&self, nodal: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
        let one = |(row, image): (&Vec<(usize, f64)>, &Image)| {
            let own: Vec3 = row.iter().map(|&(n, w)| w * nodal(n)).sum();
            own.component_mul(&image.signs)
        };
        self.rows.iter().zip(&self.images).map(one).collect()
    }

    fn for_each_obstacle_vertex(&self, mut f: impl FnMut(usize, Vec3, Option<&Motion>)) {
        let count: usize = self.obstacles.iter().map(|o| o.surface.vertices.len()).sum();
        let mut v = self.rows.len() - count;
        for obstacle in &self.obstacles {
            for &place in &obstacle.surface.vertices {
                f(v, place, obstacle.motion.as_deref());
                v += 1;
            }
        }
    }
}

/// Points of a regular pattern on facets, those on common edges shared.
struct Lattice<'a> {
    space: &'a FunctionSpace,
    split: usize,
    /// Id of a point by the vertices it lies between, each with its share.
    ids: BTreeMap<[(usize, usize); 3], usize>,
    rows: Vec<Vec<(usize, f64)>>,
}

impl Lattice<'_> {
    /// The triangles of one facet, oriented as it is.
    fn split(&mut self, facet: [usize; 3]) -> Vec<[usize; 3]> {
        let n = self.split;
        let mut triangles = Vec::new();
        for j in 0..n {
            for i in 0..n - j {
                let mut id = |i: usize, j: usize| self.point(facet, [n - i - j, i, j]);
                triangles.push([id(i, j), id(i + 1, j), id(i, j + 1)]);
                if i + j + 1 < n {
                    triangles.push([id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
                }
            }
        }
        triangles
    }

    /// The point with barycentric coordinates `shares` / `split`.
    fn point(&mut self, facet: [usize; 3], shares: [usize; 3]) -> usize {
        let mut key = [0, 1, 2].map(|c| (if shares[c] > 0 { facet[c] } else { 0 }, shares[c]));
        key.sort_unstable();
        if let Some(&id) = self.ids.get(&key) {
            return id;
        }
        let values =
            element::values(self.space.degree(), &shares.map(|s| s as f64 / self.split as f64));
        // at a node the basis is one and zero up to rounding
        let exact = |v: f64| if (v - v.round()).abs() < 1e-12 { v.round() } else { v };
        let row = self.space.facet_nodes(facet).into_iter().zip(values.into_iter().map(exact));
        self.rows.push(row.filter(|&(_, value)| value != 0.0).collect());
        self.ids.insert(key, self.rows.len() - 1);
        self.rows.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{cube, flat, square};

    fn surface(degree: usize, split: usize) -> (Surface, FunctionSpace, mesh::TetMesh) {
        let mesh = cube(2, 0.2);
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let facets = mesh::topology::boundary(&mesh).facets;
        let floor =
            Obstacle { surface: square(1, 0.0), motion: Some(Box::new(|_, t| Vec3::z() * t)) };
        let mut fixed = vec![false; 3 * space.node_count()];
        for (i, x) in space.node_positions(&mesh.vertices).iter().enumerate() {
            fixed[3 * i..3 * i + 3].fill(x.z == 0.0);
        }
        let bodies = vec![0; facets.len()];
        (Surface::new(&[], &space, &facets, &bodies, vec![floor], split, &fixed), space, mesh)
    }

    /// 48 facets of a closed surface make 48 n² triangles with 24 n² + 2 vertices.
    #[test]
    fn facets_are_split_into_a_closed_surface_of_the_same_shape() {
        for (degree, split) in [(1, 1), (2, 2), (3, 3), (2, 1), (2, 3), (1, 4)] {
            let (surface, space, mesh) = surface(degree, split);
            let own = 24 * split * split + 2;
            assert_eq!(surface.vertex_count(), own + 4);
            let triangles = surface.features().triangles[..48 * split * split].to_vec();
            assert!(mesh::topology::is_manifold(&triangles));
            let skin = SurfaceMesh { vertices: surface.rest(&space, &mesh.vertices), triangles };
            let volume = mesh::measure::enclosed_volume(&skin);
            assert!((volume - 1.0).abs() < 1e-13, "{volume}");
            for v in 0..own {
                assert!(split != degree || surface.row(v).iter().all(|&(_, w)| w == 1.0));
                let low = skin.vertices[v].z < 1e-9;
                assert_eq!(surface.immovable(&[v]), low, "{degree} {split}");
                assert!(!surface.is_obstacle(v) && surface.body(v) == 0);
            }
            assert!(surface.is_obstacle(own) && surface.body(own + 3) == 1);
        }
    }

    #[test]
    fn linear_fields_are_exact_and_obstacles_move_by_themselves() {
        for (degree, split) in [(2, 2), (2, 3), (3, 2)] {
            let (surface, space, mesh) = surface(degree, split);
            let stretch = |x: &Vec3| Vec3::new(0.1 * x.y, 0.2 * x.z, x.x - x.y);
            let u: Vec<Vec3> = space.node_positions(&mesh.vertices).iter().map(stretch).collect();
            let rest = surface.rest(&space, &mesh.vertices);
            let moved = surface.positions(&space, &mesh.vertices, &flat(&u), 0.3);
            for v in 0..surface.vertex_count() {
                let by = if surface.is_obstacle(v) { Vec3::z() * 0.3 } else { stretch(&rest[v]) };
                assert!((moved[v] - rest[v] - by).norm() < 1e-14);
            }
            assert_eq!(surface.motion(0.1, 0.3)[rest.len() - 1], Vec3::z() * (0.3 - 0.1));
        }
    }
}
