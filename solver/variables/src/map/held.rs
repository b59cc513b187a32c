//! What of a patch may not move, or only along a plane.

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::symmetry::{OFF_PLANE, Plane};
use mesh::measure::mean_edge;
use mesh::{SurfaceMesh, Vec3};
use program::{KeyPath, Misfit};
use scene::config::KeepConfig;

use super::geodesic::Geodesics;
use super::sampling::rim;

/// Sine of the angle up to which two planes count as parallel [1].
const PARALLEL: f64 = 1e-9;

/// A flat face that stays in its plane n·x = h.
#[derive(Clone, Debug)]
pub struct Flat {
    /// n, of length 1.
    normal: Vec3,
    /// Vertices in the plane, ascending.
    vertices: Vec<usize>,
}

impl Flat {
    /// The vertices of the facets that move in a plane.
    pub fn find(keep: &KeepConfig, body: &Body, moving: &[[usize; 3]]) -> Result<Self> {
        let rest = &body.mesh.vertices;
        let tolerance = OFF_PLANE * mean_edge(rest, moving);
        let (normal, level) = match keep {
            KeepConfig::Across { axis, at } => (Vec3::ith(*axis as usize, 1.0), *at),
            KeepConfig::Plane { normal, at } => (Vec3::from(*normal).normalize(), *at),
            KeepConfig::Face(tag) => plane_of(body, tag, tolerance)?,
        };
        let off = |v: usize| (normal.dot(&rest[v]) - level).abs();
        let within = |facet: &&[usize; 3]| facet.iter().all(|&v| off(v) <= tolerance);
        let nearest = moving.iter().flatten().map(|&v| off(v)).fold(f64::INFINITY, f64::min);
        ensure!(
            moving.iter().any(|facet| within(&facet)),
            refused(format!(
                "no facet that moves lies in {keep}; the nearest vertex is {:.3} mm off it",
                1e3 * nearest
            ))
        );
        let mut vertices: Vec<usize> =
            moving.iter().flatten().copied().filter(|&v| off(v) <= tolerance).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Ok(Self { normal, vertices })
    }
}

fn refused(what: String) -> Misfit {
    KeyPath::table("shape").key("keep").told(format!("[shape] keep: {what}"))
}

/// Normal and level of the plane that a tag's facets lie in.
fn plane_of(body: &Body, tag: &str, tolerance: f64) -> Result<(Vec3, f64)> {
    let facets = body.facets(tag)?;
    let rest = &body.mesh.vertices;
    let area = |f: &[usize; 3]| (rest[f[1]] - rest[f[0]]).cross(&(rest[f[2]] - rest[f[0]]));
    let normal = facets.iter().map(area).sum::<Vec3>();
    let normal = normal
        .try_normalize(0.0)
        .ok_or_else(|| refused(format!("the areas of \"{tag}\" cancel: expected a flat face")))?;
    let height = |v: &usize| normal.dot(&rest[*v]);
    let heights = || facets.iter().flatten().map(height);
    let (low, high) = heights()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    ensure!(
        high - low <= 2.0 * tolerance,
        refused(format!(
            "\"{tag}\" is not flat: its vertices are {:.3} mm apart across it; expected at most {:.1e} mm",
            1e3 * (high - low),
            2e3 * tolerance
        ))
    );
    Ok((normal, (low + high) / 2.0))
}

/// What holds the vertices of a patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held<'a> {
    /// Planes of symmetry that may cut it: what lies in one moves along it.
    pub planes: &'a [Plane],
    /// Flat faces.
    pub flats: &'a [Flat],
    /// Nothing nearer to the rim than this, along the surface, moves [m].
    pub margin: f64,
}

impl Held<'_> {
    /// Unit normals of all planes, parallel ones once.
    pub fn normals(&self) -> Vec<Vec3> {
        let across = self.planes.iter().map(|plane| Vec3::ith(plane.axis, 1.0));
        let mut normals: Vec<Vec3> = Vec::new();
        for normal in across.chain(self.flats.iter().map(|flat| flat.normal)) {
            if !normals.iter().any(|other| are_parallel(other, &normal)) {
                normals.push(normal);
            }
        }
        normals
    }

    /// Whether a vertex of the body does not move along a normal.
    pub fn along(&self, vertex: usize, normal: &Vec3) -> bool {
        let by_plane =
            |p: &Plane| are_parallel(&Vec3::ith(p.axis, 1.0), normal) && p.contains(vertex);
        let by_flat =
            |f: &Flat| are_parallel(&f.normal, normal) && f.vertices.binary_search(&vertex).is_ok();
        self.planes.iter().any(by_plane) || self.flats.iter().any(by_flat)
    }

    /// Orthonormal directions in which a vertex of the body does not move, and those in which it
    /// does.
    pub fn directions(&self, vertex: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        let normals = self.normals();
        let held = normals.into_iter().filter(|normal| self.along(vertex, normal));
        let mut all: Vec<Vec3> = Vec::new();
        for normal in held {
            let across = off(&all, &normal);
            all.extend(across.try_normalize(PARALLEL));
        }
        let fixed = all.len();
        while all.len() < 3 {
            let axes = (0..3).map(|k| off(&all, &Vec3::ith(k, 1.0)));
            // the first of the longest
            let longest = axes.reduce(|a, b| if b.norm() > a.norm() + PARALLEL { b } else { a });
            all.extend(longest.map(|axis| axis.normalize()));
        }
        let free = all.split_off(fixed);
        (all, free)
    }

    /// The vertices of a patch that do not move at all, ascending; `ids` are its vertices in the
    /// body.
    pub fn rim(&self, surface: &SurfaceMesh, ids: &[usize]) -> Vec<usize> {
        // what lies in a plane of symmetry is open
        let in_one =
            |edge: &[usize; 2], plane: &Plane| edge.iter().all(|&v| plane.contains(ids[v]));
        let rim = rim(surface, |edge| self.planes.iter().any(|plane| in_one(edge, plane)));
        if self.margin == 0.0 || rim.is_empty() {
            return rim;
        }
        let distances = Geodesics::new(surface).within(&rim, self.margin);
        (0..ids.len()).filter(|&v| distances[v] < self.margin).collect()
    }
}

fn are_parallel(a: &Vec3, b: &Vec3) -> bool {
    a.cross(b).norm() < PARALLEL
}

/// A vector without its parts along some orthonormal ones.
pub(super) fn off(directions: &[Vec3], vector: &Vec3) -> Vec3 {
    directions.iter().fold(*vector, |rest, d| rest - d * d.dot(&rest))
}

#[cfg(test)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{check_gradient, cube};
    use scene::config::{HandleMotion, Moves};

    use super::*;
    use crate::map::patch::Patch;

    fn flat(normal: [f64; 3], vertices: &[usize]) -> Flat {
        Flat { normal: Vec3::from(normal).normalize(), vertices: vertices.to_vec() }
    }

    #[test]
    fn what_lies_in_planes_moves_along_all_of_them() {
        let flats = [
            flat([0.0, 0.0, 1.0], &[1, 2, 3]),
            flat([0.0, 0.0, -2.0], &[5]),
            flat([1.0, 0.0, 1.0], &[2, 4]),
        ];
        let held = Held { flats: &flats, ..Held::default() };
        assert_eq!(held.normals().len(), 2, "parallel planes count once");
        for (vertex, count) in [(0, 3), (1, 2), (2, 1), (3, 2), (4, 2), (5, 2)] {
            let (fixed, free) = held.directions(vertex);
            assert_eq!((fixed.len(), free.len()), (3 - count, count), "vertex {vertex}");
            let all = [fixed, free.clone()].concat();
            for (i, a) in all.iter().enumerate() {
                for (j, b) in all.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((a.dot(b) - expected).abs() < 1e-15, "{a:?} {b:?}");
                }
            }
            for flat in flats.iter().filter(|flat| flat.vertices.contains(&vertex)) {
                assert!(free.iter().all(|d| d.dot(&flat.normal).abs() < 1e-15));
            }
        }
        // across an axis the others are the axes, bit for bit
        assert_eq!(held.directions(1).1, [Vec3::x(), Vec3::y()]);
        assert_eq!(held.directions(0).1, [Vec3::x(), Vec3::y(), Vec3::z()]);
    }

    /// A cube that was turned, without its lowest face: two faces that meet in an edge stay flat.
    #[test]
    fn flat_faces_at_an_angle_stay_in_their_planes_and_gradients_are_exact() {
        let turn = nalgebra::Rotation3::new(Vec3::new(0.3, -0.5, 0.9));
        let mut mesh = cube(3, 0.0);
        let lowest = |f: &[usize; 3]| f.iter().all(|&v| mesh.vertices[v].z < 1e-9);
        let mut facets = mesh::topology::boundary(&mesh).facets;
        facets.retain(|f| !lowest(f));
        mesh.vertices.iter_mut().for_each(|x| *x = turn * *x);
        let body = Body::new(mesh, mesh::Tags::default());
        let rest = &body.mesh.vertices;
        let normals = [turn * Vec3::z(), turn * Vec3::x()];
        let flats = normals.map(|n| {
            let keep = KeepConfig::Plane { normal: (2.0 * n).into(), at: 1.0 };
            Flat::find(&keep, &body, &facets).expect("a face lies there")
        });
        let held = Held { flats: &flats, ..Held::default() };
        for moves in [Moves::Vertices, Moves::Handles(5, HandleMotion::Rigid)] {
            let patch = Patch::new(rest, &facets, held, moves, &[]).expect("a patch");
            let theta: Vec<f64> =
                Random::new(3).numbers(patch.variables()).iter().map(|t| 0.1 * t).collect();
            let moved = patch.apply(&theta, rest);
            let mut on_edge = 0;
            for (&v, x) in patch.vertices().iter().zip(&moved) {
                let held: Vec<&Vec3> = (0..2)
                    .filter(|&i| flats[i].vertices.contains(&v))
                    .map(|i| &normals[i])
                    .collect();
                on_edge += usize::from(held.len() == 2 && (x - rest[v]).norm() > 1e-3);
                assert!(held.iter().all(|n| n.dot(&(x - rest[v])).abs() < 1e-15), "{moves:?}: {v}");
            }
            assert!(on_edge > 0, "{moves:?}: the edge moves along itself");
            let along = Random::new(4).numbers(3 * moved.len());
            let along: Vec<Vec3> = along.chunks_exact(3).map(Vec3::from_column_slice).collect();
            let value = |theta: &[f64]| -> f64 {
                let moved = patch.apply(theta, rest);
                moved.iter().zip(&along).map(|(x, a)| x.dot(a) + 0.5 * x.norm_squared()).sum()
            };
            let bar: Vec<Vec3> = moved.iter().zip(&along).map(|(x, a)| a + x).collect();
            check_gradient(&theta, &patch.vjp(&theta, rest, &bar), 1e-2, value);
        }
    }
}
