//! Planar faces stay planar, and keep their rims.
//!
//! A mesher with an envelope leaves the vertices on the rim of a planar face up to
//! an envelope beside its plane and its rim. Where the input is planar to rounding
//! they are moved back, if their tetrahedra allow it: molds part and fittings seal
//! on such faces.

use mesh::bvh::SurfaceBvh;
use mesh::measure::{area, diagonal, radius_ratio};
use mesh::topology::{boundary, boundary_loops, edge_facets};
use mesh::{SurfaceMesh, TetMesh, Vec3};

/// A planar face must cover this part of the surface, or have a hole.
const MIN_AREA: f64 = 1e-3;
/// Vertices of a planar face are this close to its plane [diagonal]; binary STL
/// rounds to 6e-8.
const OFF_PLANE: f64 = 5e-7;
/// A tetrahedron may lose this part of its radius ratio.
const MAX_LOSS: f64 = 0.5;

/// Faces of a surface that are planar.
struct Faces {
    /// Unit normal and offset of each face.
    planes: Vec<(Vec3, f64)>,
    /// The planar face of each triangle.
    of: Vec<Option<usize>>,
    /// Edges between each face and what is not planar.
    rims: Vec<Vec<[Vec3; 2]>>,
}

/// Where a vertex of the mesh ought to be.
#[derive(Clone, Default)]
struct Target {
    /// On these planar faces.
    faces: Vec<usize>,
    /// Some of its facets are on no planar face.
    rim: bool,
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flattened {
    /// Vertices moved.
    pub moved: usize,
    /// Vertices left beside a plane, for the sake of their tetrahedra.
    pub left: usize,
}

/// Moves boundary vertices onto the planar faces of `input` to which their facets
/// belong, and to their rims, if that is no more than `reach` [m] in each direction.
pub fn flatten(mesh: &mut TetMesh, input: &SurfaceMesh, reach: f64) -> Flattened {
    let faces = Faces::of(input);
    let targets = faces.targets(mesh, input, reach);
    let mut tets_of = vec![Vec::new(); mesh.vertices.len()];
    for (t, tet) in mesh.tets.iter().enumerate() {
        tet.iter().for_each(|&v| tets_of[v].push(t));
    }
    let mut done = Flattened { moved: 0, left: 0 };
    for (v, target) in targets.iter().enumerate().filter(|(_, t)| !t.faces.is_empty()) {
        let old = mesh.vertices[v];
        let new = faces.place(old, target, reach);
        if new == old {
            continue;
        }
        let before: Vec<f64> = tets_of[v].iter().map(|&t| ratio(mesh, t)).collect();
        mesh.vertices[v] = new;
        let kept = |(&t, r): (&usize, &f64)| ratio(mesh, t) > MAX_LOSS * r;
        if tets_of[v].iter().zip(&before).all(kept) {
            done.moved += 1;
        } else {
            mesh.vertices[v] = old;
            done.left += 1;
        }
    }
    done
}

fn ratio(mesh: &TetMesh, t: usize) -> f64 {
    let [a, b, c, d] = mesh.corners(t);
    radius_ratio(a, b, c, d)
}

impl Faces {
    fn of(surface: &SurfaceMesh) -> Self {
        let areas: Vec<f64> = (0..surface.triangles.len()).map(|t| surface.area(t)).collect();
        // The largest triangles know their plane best.
        let mut seeds: Vec<usize> = (0..areas.len()).collect();
        seeds.sort_by(|&s, &t| areas[t].total_cmp(&areas[s]));
        let (edges, flat) =
            (edge_facets(&surface.triangles), OFF_PLANE * diagonal(&surface.vertices));
        let least = MIN_AREA * area(surface);
        let mut faces = Self { planes: Vec::new(), of: vec![None; areas.len()], rims: Vec::new() };
        let mut tried = vec![false; areas.len()];
        for seed in seeds {
            if tried[seed] {
                continue;
            }
            let [a, b, c] = surface.corners(seed);
            let normal = (b - a).cross(&(c - a)).normalize();
            let plane = (normal, normal.dot(&a));
            let face = flood(surface, &edges, &tried, seed, plane, flat);
            let wide = face.iter().map(|&t| areas[t]).sum::<f64>() >= least;
            if wide || has_hole(surface, &face) {
                for &t in &face {
                    tried[t] = true;
                    faces.of[t] = Some(faces.planes.len());
                }
                faces.planes.push(plane);
            }
            tried[seed] = true;
        }
        faces.rims = vec![Vec::new(); faces.planes.len()];
        for (&[a, b], sides) in &edges {
            if let [Some(face), None] | [None, Some(face)] =
                sides.iter().map(|&t| faces.of[t]).collect::<Vec<_>>()[..]
            {
                faces.rims[face].push([surface.vertices[a], surface.vertices[b]]);
            }
        }
        faces
    }

    /// Where each vertex of the mesh ought to be.
    fn targets(&self, mesh: &TetMesh, input: &SurfaceMesh, reach: f64) -> Vec<Target> {
        let nearest = SurfaceBvh::new(input);
        let mut targets = vec![Target::default(); mesh.vertices.len()];
        for facet in boundary(mesh).facets {
            let corners = facet.map(|v| mesh.vertices[v]);
            let centroid = corners.iter().sum::<Vec3>() / 3.0;
            let face = self.of[nearest.closest(&centroid).triangle];
            let face = face.filter(|&face| self.holds(face, corners, reach));
            for v in facet {
                match face {
                    None => targets[v].rim = true,
                    Some(face) if !targets[v].faces.contains(&face) => targets[v].faces.push(face),
                    Some(_) => {}
                }
            }
        }
        targets
    }

    /// Whether a facet lies along a face and within `reach` of its plane.
    fn holds(&self, face: usize, [a, b, c]: [Vec3; 3], reach: f64) -> bool {
        let (normal, offset) = self.planes[face];
        let along = (b - a).cross(&(c - a)).normalize().dot(&normal) > 0.7;
        along && [a, b, c].iter().all(|p| (normal.dot(p) - offset).abs() <= reach)
    }

    /// `p` moved to where it ought to be.
    fn place(&self, mut p: Vec3, target: &Target, reach: f64) -> Vec3 {
        // One plane needs one turn; edges and corners of a box converge at once,
        // oblique ones geometrically.
        for _ in 0..20 {
            for &face in &target.faces {
                let (normal, offset) = self.planes[face];
                p -= normal * (normal.dot(&p) - offset);
            }
        }
        let ([face], true) = (&target.faces[..], target.rim) else { return p };
        let on_rim = self.rims[*face].iter().map(|&edge| closest_on(edge, &p));
        on_rim
            .map(|q| ((q - p).norm(), q))
            .filter(|(distance, _)| *distance <= reach)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(p, |(_, q)| q)
    }
}

fn closest_on([a, b]: [Vec3; 2], p: &Vec3) -> Vec3 {
    let axis = b - a;
    a + axis * ((p - a).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0)
}

/// The triangles connected to `seed` that lie in `plane`.
fn flood(
    surface: &SurfaceMesh,
    edges: &std::collections::BTreeMap<[usize; 2], Vec<usize>>,
    taken: &[bool],
    seed: usize,
    (normal, offset): (Vec3, f64),
    flat: f64,
) -> Vec<usize> {
    let in_plane =
        |t: usize| surface.corners(t).iter().all(|p| (normal.dot(p) - offset).abs() <= flat);
    let mut face = vec![seed];
    let mut next = 0;
    let mut seen = std::collections::BTreeSet::from([seed]);
    while next < face.len() {
        let [a, b, c] = surface.triangles[face[next]];
        next += 1;
        for (a, b) in [(a, b), (b, c), (c, a)] {
            for &t in &edges[&[a.min(b), a.max(b)]] {
                if !taken[t] && in_plane(t) && seen.insert(t) {
                    face.push(t);
                }
            }
        }
    }
    face
}

/// Whether a face has a hole, as the end of a tube has. However small, it is no part of what bends,
/// and the rim of an inlet lies on it.
fn has_hole(surface: &SurfaceMesh, face: &[usize]) -> bool {
    let triangles: Vec<[usize; 3]> = face.iter().map(|&t| surface.triangles[t]).collect();
    boundary_loops(&triangles).len() > 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;

    /// The unit cube around its centre: 12 pyramids' halves, and its surface.
    fn cube() -> (TetMesh, SurfaceMesh) {
        let corner = |k: usize| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let mut vertices: Vec<Vec3> = (0..8).map(corner).collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[usize; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let surface = SurfaceMesh { vertices: vertices.clone(), triangles: triangles.clone() };
        vertices.push(Vec3::repeat(0.5));
        let tets = triangles.iter().map(|&[a, b, c]| [a, c, b, 8]).collect();
        (TetMesh { vertices, tets }, surface)
    }

    #[test]
    fn displaced_corners_return_to_all_their_planes() {
        let (mut mesh, surface) = cube();
        let exact = mesh.clone();
        assert!(mesh::measure::volume(&mesh) > 0.999);
        mesh.vertices[0] += Vec3::new(0.01, -0.008, 0.012);
        mesh.vertices[5] += Vec3::new(-0.01, 0.0, 0.0);
        let done = flatten(&mut mesh, &surface, 0.02);
        assert_eq!(done, Flattened { moved: 2, left: 0 });
        for (v, w) in mesh.vertices.iter().zip(&exact.vertices) {
            assert!((v - w).norm() < 1e-15, "{v} {w}");
        }
    }

    #[test]
    fn the_narrow_end_of_a_tube_is_a_face() {
        // A ball of 40 with a tube of 2.4 across, whose end of 2.5 is 2 % of a hundredth of all.
        let pipe = |low: f64, high: f64, radius: f64| {
            let (min, max) = (Vec3::new(-radius, -radius, low), Vec3::new(radius, radius, high));
            Solid::cube(&min, &max)
        };
        let ball = Solid::sphere(&Vec3::zeros(), 20.0, 64);
        let body = ball.union(&pipe(0.0, 25.0, 1.2)).difference(&pipe(5.0, 26.0, 0.9));
        let surface = body.to_surface();
        let faces = Faces::of(&surface);
        let end = |plane: &&(Vec3, f64)| (plane.0 - Vec3::z()).norm() < 1e-9 && plane.1 == 25.0;
        assert_eq!(faces.planes.iter().filter(end).count(), 1);
        // The ball bends everywhere.
        let of_ball = Faces::of(&Solid::sphere(&Vec3::zeros(), 20.0, 64).to_surface());
        assert!(of_ball.planes.is_empty(), "{}", of_ball.planes.len());
    }

    #[test]
    fn vertices_out_of_reach_stay() {
        let (mut mesh, surface) = cube();
        mesh.vertices[0] += Vec3::new(0.03, 0.03, 0.03);
        let displaced = mesh.clone();
        assert_eq!(flatten(&mut mesh, &surface, 0.02).moved, 0);
        assert_eq!(mesh, displaced);
    }
}
