//! How a design moved a wall, at points beside its facets.
//!
//! The wall as modelled has facets with corners X_a, which the design moved by d_a, and normals n_a at corners, which it
//! turned into n'_a. A point x = p + s Σ_a N_a n_a, over a point p = Σ_a N_a X_a of a facet, is moved by
//!
//! d(x) = Σ_a N_a (d_a + s (n'_a − n_a)) + Σ_ab 4 N_a N_b e_ab,   e_ab = ⅛ (G_a − G_b) (X_b − X_a).
//!
//! N_a   hat functions. Normals that are interpolated make p and s continuous beside edges and corners, where the
//! nearest point jumps;
//!
//! e_ab   how far the displacement bends at the middle of an edge: as of second order, with the gradients at its ends.
//! It is limited to a part of the thickness of the facets beside it, so that none folds. An edge whose ends stay, stays;
//!
//! G_a = ∂d/∂X   at a corner, along the wall: by least squares with terms of second order over rings of facets,
//! within sharp edges.

use std::collections::{BTreeMap, BTreeSet};

use mesh::bvh::{Closest, SurfaceBvh, closest_on_triangle};
use mesh::measure::{triangle_area, triangle_normal};
use mesh::topology::edge_facets;
use mesh::{SurfaceMesh, TetMesh, Vec3};
use nalgebra::{DMatrix, Matrix3};

/// Neighbours that terms of second order need: nearly twice as many as these have unknowns.
const ENOUGH_FOR_SECOND_ORDER: usize = 9;

/// Rings of facets in which they are looked for.
const RINGS: usize = 4;

/// Cosine of the angle between facets at an edge that is sharp (65°): a narrow channel may have six sides.
const SHARP: f64 = 0.42;

/// Singular values below this part of the largest one are none.
const SINGULAR: f64 = 1e-6;

/// How much steeper than to the neighbours a displacement may be at a corner.
const STEEPEST: f64 = 2.0;

/// How far a displacement may bend at the middle of an edge, in the thickness of a facet beside it: with 1/4 the
/// facet folds.
const BENT: f64 = 0.1;

/// A hat function that is at least this is of a point in its facet: beyond a rim facets are continued.
const BEYOND: f64 = -0.5;

/// How much farther than the nearest point the point of a facet may be that a point is over.
const ASKEW: f64 = 2.0;

/// Hat functions and lengths in a facet that are less are rounding [1].
const HAT_ROUNDING: f64 = 1e-9;

/// Steps of Newton's method, which is at rounding after five.
const STEPS: usize = 8;

/// Facets of one wall as modelled, and how a design moved them.
pub struct Displacement {
    wall: SurfaceMesh,
    bvh: SurfaceBvh,
    /// For each vertex of the mesh [m].
    motion: Vec<Vec3>,
    /// For each facet the normals at its corners, before and after [1].
    normals: [Vec<[Vec3; 3]>; 2],
    /// For each facet how far the displacement bends at the middle of the edge from each corner to the next [m].
    bends: Vec<[Vec3; 3]>,
    /// The facets at each vertex.
    around: Vec<Vec<usize>>,
    /// Longest edge of each facet [m].
    longest: Vec<f64>,
}

/// The displacement of a point.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// By how much it moves [m].
    pub by: Vec3,
    /// How far it is from the wall as modelled [m].
    pub off: f64,
    /// Longest edge of the facet that it belongs to [m].
    pub facet: f64,
}

/// A facet that a point belongs to.
struct Over {
    facet: usize,
    /// Hat functions of its corners [1].
    parts: [f64; 3],
    /// How far the point is from it along the normal [m].
    height: f64,
}

impl Displacement {
    /// The displacement of `facets` between corners that the design moved by `motion`.
    pub fn new(vertices: &[Vec3], facets: Vec<[usize; 3]>, motion: &[Vec3]) -> Self {
        let wall = SurfaceMesh { vertices: vertices.to_vec(), triangles: facets };
        let longest = (0..wall.triangles.len()).map(|t| longest(wall.corners(t))).collect();
        let mut around = vec![Vec::new(); vertices.len()];
        for (t, facet) in wall.triangles.iter().enumerate() {
            facet.iter().for_each(|&v| around[v].push(t));
        }
        let after = vertices.iter().zip(motion).map(|(p, by)| p + by).collect();
        let moved = SurfaceMesh { vertices: after, triangles: wall.triangles.clone() };
        let corners = Corners::new(&wall, motion);
        let normals = [&wall, &moved].map(|surface| corners.normals(surface));
        let bends = corners.bends(&moved);
        let bvh = SurfaceBvh::new(&wall);
        Self { wall, bvh, motion: motion.to_vec(), normals, bends, around, longest }
    }

    /// Whether nothing of it moved.
    pub fn is_still(&self) -> bool {
        self.wall.triangles.iter().all(|facet| stays(facet, &self.motion))
    }

    /// The displacement of a point of a surface that has a normal there.
    pub fn at(&self, x: &Vec3, normal: &Vec3) -> Moved {
        let nearest = self.facing(x, normal);
        let Over { facet, parts, height } = self.over(x, &nearest);
        let corners = self.wall.triangles[facet];
        let by = |i: usize| {
            let v = corners[i];
            let turn = self.normals[1][facet][i] - self.normals[0][facet][i];
            let bend = self.bends[facet][i] * (4.0 * parts[(i + 1) % 3]);
            (self.motion[v] + turn * height + bend) * parts[i]
        };
        let by = match stays(&corners, &self.motion) {
            true => Vec3::zeros(),
            false => (0..3).map(by).sum(),
        };
        Moved { by, off: nearest.distance, facet: self.longest[facet] }
    }

    /// The facet over which a point is: of those around the nearest one that in which it is, or least beyond it.
    fn over(&self, x: &Vec3, nearest: &Closest) -> Over {
        let least = |over: &Over| over.parts.into_iter().fold(0.0, f64::min);
        let own = self.over_facet(x, nearest.triangle).filter(|over| least(over) > -HAT_ROUNDING);
        if let Some(own) = own {
            return own;
        }
        let corners = self.wall.triangles[nearest.triangle];
        let near: BTreeSet<usize> =
            corners.iter().flat_map(|&v| &self.around[v]).copied().collect();
        // Facets beyond a sharp edge may be under the point, too, but far below.
        let high = ASKEW * nearest.distance + HAT_ROUNDING * self.longest[nearest.triangle];
        let over = near.into_iter().filter_map(|t| self.over_facet(x, t));
        let found = over.filter(|over| over.height.abs() <= high).max_by(|a, b| {
            least(a).total_cmp(&least(b)).then(b.height.abs().total_cmp(&a.height.abs()))
        });
        found.filter(|over| least(over) >= BEYOND).unwrap_or_else(|| {
            let [a, b, c] = self.wall.corners(nearest.triangle);
            let (p, area) = (nearest.point, triangle_area(a, b, c));
            let parts = [(b, c), (c, a), (a, b)].map(|(q, r)| triangle_area(p, q, r) / area);
            let height = (x - p).dot(&triangle_normal(a, b, c));
            Over { facet: nearest.triangle, parts, height }
        })
    }

    /// The point of a facet over which x is, by Newton's method.
    fn over_facet(&self, x: &Vec3, facet: usize) -> Option<Over> {
        let [a, b, c] = self.wall.corners(facet);
        let [l, m, n] = self.normals[0][facet];
        let mut at = Vec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0);
        for _ in 0..STEPS {
            let (normal, s) = (l + (m - l) * at.x + (n - l) * at.y, at.z);
            let off = a + (b - a) * at.x + (c - a) * at.y + normal * s - x;
            let columns = [b - a + (m - l) * s, c - a + (n - l) * s, normal];
            at -= Matrix3::from_columns(&columns).try_inverse()? * off;
        }
        let [u, v, height] = at.into();
        let there = at.iter().all(|x| x.is_finite()) && height.abs() < self.longest[facet];
        there.then_some(Over { facet, parts: [1.0 - u - v, u, v], height })
    }

    /// The nearest point on a facet that faces the same way, if there is one about as near as the nearest facet:
    /// walls may be near each other.
    fn facing(&self, x: &Vec3, normal: &Vec3) -> Closest {
        let nearest = self.bvh.closest(x);
        let faces = |t: usize| {
            let [a, b, c] = self.wall.corners(t);
            triangle_normal(a, b, c).dot(normal) > 0.0
        };
        if faces(nearest.triangle) {
            return nearest;
        }
        let reach = Vec3::repeat(nearest.distance + self.longest[nearest.triangle]);
        let near = self.bvh.overlaps(&(x - reach), &(x + reach)).into_iter().filter(|&t| faces(t));
        let closest = near.map(|triangle| {
            let point = closest_on_triangle(x, &self.wall.corners(triangle));
            Closest { point, triangle, distance: (point - x).norm() }
        });
        closest.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap_or(nearest)
    }
}

fn stays(facet: &[usize], motion: &[Vec3]) -> bool {
    facet.iter().all(|&v| motion[v] == Vec3::zeros())
}

/// Longest edge of a triangle.
fn longest([a, b, c]: [Vec3; 3]) -> f64 {
    [a - b, b - c, c - a].map(|edge| edge.norm()).into_iter().fold(0.0, f64::max)
}

/// The facets around corners.
struct Corners<'a> {
    wall: &'a SurfaceMesh,
    motion: &'a [Vec3],
    /// The facets at each edge.
    edges: BTreeMap<[usize; 2], Vec<usize>>,
    /// The facets beyond the edges of a facet that are not sharp.
    beyond: Vec<Vec<usize>>,
}

impl<'a> Corners<'a> {
    fn new(wall: &'a SurfaceMesh, motion: &'a [Vec3]) -> Self {
        let mut beyond = vec![Vec::new(); wall.triangles.len()];
        let normal = |t: usize| {
            let [a, b, c] = wall.corners(t);
            triangle_normal(a, b, c)
        };
        let edges = edge_facets(&wall.triangles);
        for pair in edges.values() {
            let [a, b] = pair[..] else { continue };
            if normal(a).dot(&normal(b)) >= SHARP {
                beyond[a].push(b);
                beyond[b].push(a);
            }
        }
        Self { wall, motion, edges, beyond }
    }

    /// How far the displacement of each facet bends at the middles of its edges; `moved` is the wall after it.
    fn bends(&self, moved: &SurfaceMesh) -> Vec<[Vec3; 3]> {
        let gradients = self.gradients();
        let thickness = |t: usize| {
            let corners = moved.corners(t);
            let [a, b, c] = corners;
            2.0 * triangle_area(a, b, c) / longest(corners)
        };
        let corner = |t: usize, v: usize| self.wall.triangles[t].iter().position(|&w| w == v);
        let of_edge = |&[a, b]: &[usize; 2], facets: &Vec<usize>| {
            if stays(&[a, b], self.motion) {
                return Vec3::zeros();
            }
            let along = (self.wall.vertices[b] - self.wall.vertices[a]) / 8.0;
            let bend = |&t: &usize| {
                let at = |v: usize| corner(t, v).map_or_else(Matrix3::zeros, |i| gradients[t][i]);
                (at(a) - at(b)) * along
            };
            let bend = facets.iter().map(bend).sum::<Vec3>() / facets.len() as f64;
            let limit = facets.iter().map(|&t| thickness(t)).fold(f64::INFINITY, f64::min) * BENT;
            bend.cap_magnitude(limit)
        };
        let bends: BTreeMap<_, _> =
            self.edges.iter().map(|(edge, facets)| (*edge, of_edge(edge, facets))).collect();
        let of_facet = |&[a, b, c]: &[usize; 3]| {
            [[a, b], [b, c], [c, a]].map(|[v, w]| bends[&[v.min(w), v.max(w)]])
        };
        self.wall.triangles.iter().map(of_facet).collect()
    }

    /// For each facet the gradients at its corners.
    fn gradients(&self) -> Vec<[Matrix3<f64>; 3]> {
        self.at_corners(|v, fan| self.gradient(v, fan))
    }

    /// For each facet of the wall, or of it after its motion, the normals at its corners.
    fn normals(&self, wall: &SurfaceMesh) -> Vec<[Vec3; 3]> {
        self.at_corners(|_, fan| mean_normal(wall, fan))
    }

    /// For each facet what is found at its corners from the facets around them, within sharp edges.
    fn at_corners<T: Copy + Default>(
        &self,
        find: impl Fn(usize, &BTreeSet<usize>) -> T,
    ) -> Vec<[T; 3]> {
        let triangles = &self.wall.triangles;
        let mut all = vec![[None; 3]; triangles.len()];
        for t in 0..all.len() {
            for i in 0..3 {
                if all[t][i].is_some() {
                    continue;
                }
                let v = triangles[t][i];
                let fan = self.fan(t, v);
                let found = find(v, &fan);
                for f in fan {
                    let corner = triangles[f].iter().position(|&w| w == v);
                    all[f][corner.expect("a facet at the vertex")] = Some(found);
                }
            }
        }
        all.into_iter().map(|corners| corners.map(Option::unwrap_or_default)).collect()
    }

    /// The facets at a vertex that are connected with facet `t` across edges which are not sharp.
    fn fan(&self, t: usize, v: usize) -> BTreeSet<usize> {
        let (mut fan, mut stack) = (BTreeSet::new(), vec![t]);
        while let Some(f) = stack.pop() {
            if fan.insert(f) {
                let at_vertex = |g: &&usize| self.wall.triangles[**g].contains(&v);
                stack.extend(self.beyond[f].iter().filter(at_vertex));
            }
        }
        fan
    }

    /// The gradient of the displacement at a vertex, by the facets of its fan and those beside them, as many rings of
    /// them as are needed.
    fn gradient(&self, v: usize, fan: &BTreeSet<usize>) -> Matrix3<f64> {
        let mut near = fan.clone();
        let mut vertices = BTreeSet::new();
        for _ in 0..RINGS {
            let beside: Vec<usize> = near.iter().flat_map(|&f| &self.beyond[f]).copied().collect();
            near.extend(beside);
            let triangles = near.iter().map(|&f| self.wall.triangles[f]);
            vertices = triangles.flatten().filter(|&w| w != v).collect();
            if vertices.len() >= ENOUGH_FOR_SECOND_ORDER {
                break;
            }
        }
        let normal = mean_normal(self.wall, fan);
        if normal == Vec3::zeros() {
            return Matrix3::zeros();
        }
        let steps: Vec<[Vec3; 2]> = vertices
            .into_iter()
            .map(|w| {
                let step = self.wall.vertices[w] - self.wall.vertices[v];
                [step, self.motion[w] - self.motion[v]]
            })
            .collect();
        fitted(&steps, &normal)
    }
}

/// The mean normal of triangles; zero if there is none.
fn mean_normal(surface: &SurfaceMesh, triangles: &BTreeSet<usize>) -> Vec3 {
    let doubled = |&t: &usize| {
        let [a, b, c] = surface.corners(t);
        (b - a).cross(&(c - a))
    };
    triangles.iter().map(doubled).sum::<Vec3>().try_normalize(0.0).unwrap_or_default()
}

/// The gradient along a plane of a displacement whose change over each step is known, by least squares with weights
/// 1/r².
fn fitted(steps: &[[Vec3; 2]], normal: &Vec3) -> Matrix3<f64> {
    let mut axis = Vec3::zeros();
    axis[normal.iamin()] = 1.0;
    let first = normal.cross(&axis).normalize();
    let second = normal.cross(&first);
    let size = steps.iter().map(|[step, _]| step.norm()).sum::<f64>() / steps.len().max(1) as f64;
    let unknowns = if steps.len() >= ENOUGH_FOR_SECOND_ORDER { 5 } else { 2 };
    let row = |[step, _]: &[Vec3; 2]| {
        let (x, y) = (step.dot(&first) / size, step.dot(&second) / size);
        [x, y, x * x / 2.0, x * y, y * y / 2.0].map(|term| term * size / step.norm())
    };
    let rows: Vec<[f64; 5]> = steps.iter().map(row).collect();
    let matrix = DMatrix::from_fn(steps.len(), unknowns, |i, j| rows[i][j]);
    let change = |[step, by]: &[Vec3; 2]| by / step.norm();
    let changes: Vec<Vec3> = steps.iter().map(change).collect();
    let right = DMatrix::from_fn(steps.len(), 3, |i, k| changes[i][k]);
    let svd = matrix.svd(true, true);
    let least = SINGULAR * svd.singular_values.max();
    let Ok(terms) = svd.solve(&right, least) else { return Matrix3::zeros() };
    let mut slopes = [0, 1].map(|i| Vec3::from_fn(|k, _| terms[(i, k)]));
    let steepness = slopes[0].norm().max(slopes[1].norm());
    let limit = STEEPEST * changes.iter().map(Vec3::norm).fold(0.0, f64::max);
    if steepness > limit {
        slopes = slopes.map(|slope| slope * (limit / steepness));
    }
    let [a, b] = slopes;
    a * first.transpose() + b * second.transpose()
}

/// How a design of the same boundary moved each vertex of a mesh.
pub fn motion(modelled: &TetMesh, design: &TetMesh) -> Vec<Vec3> {
    let pairs = modelled.vertices.iter().zip(&design.vertices);
    let mut all: Vec<Vec3> = pairs.map(|(before, after)| after - before).collect();
    // An interior that was meshed again has other vertices.
    all.resize(modelled.vertices.len(), Vec3::zeros());
    all
}
