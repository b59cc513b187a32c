//! A designed shape on another mesh of the same body.
//!
//! d(x) = Σ_a N_a(p) (X'_a − X_a)        p   the point nearest to x on the facets of the same tag
//!
//! X, X'   vertices of the body as modelled and as designed [m]; N_a hat functions of a facet
//!
//! moves each boundary vertex x of the other mesh; of several tags the one whose facets are nearest
//! counts. The interior follows by an [`Extension`], in steps: the whole motion may turn elements
//! over that each step bears.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, bail, ensure};
use mechanics::body::Body;
use mesh::bvh::SurfaceBvh;
use mesh::measure::{mean_edge, triangle_area};
use mesh::topology::boundary;
use mesh::{SurfaceMesh, TetMesh, Vec3, facet_key};

use mechanics::extension::Extension;

/// Steps of the motion, at most.
const STEPS: usize = 64;
/// Largest distance of both surfaces as modelled, in mean edges of the one that was designed.
const APART: f64 = 1.0;

/// A mesh with the shape of a design.
#[derive(Debug)]
pub struct Carried {
    /// The rest vertices [m].
    pub vertices: Vec<Vec3>,
    /// Largest motion of a vertex [m].
    pub motion: f64,
    /// Largest distance of a vertex that moves from the surface it was carried from, as modelled [m].
    pub apart: f64,
}

/// Facets with one tag, and the motion of their corners.
struct Wall {
    bvh: SurfaceBvh,
    surface: SurfaceMesh,
    motion: Vec<Vec3>,
}

impl Wall {
    fn new(modelled: &Body, designed: &TetMesh, tag: &str) -> Result<Self> {
        let vertices = modelled.mesh.vertices.clone();
        // the numbers of boundary vertices are those of both meshes
        let motion = designed.vertices.iter().zip(&vertices).map(|(b, a)| b - a).collect();
        let surface = SurfaceMesh { vertices, triangles: modelled.facets(tag)? };
        Ok(Self { bvh: SurfaceBvh::new(&surface), surface, motion })
    }

    /// How far the nearest point is, and its motion.
    fn at(&self, x: &Vec3) -> (f64, Vec3) {
        let near = self.bvh.closest(x);
        let corners = self.surface.triangles[near.triangle];
        let [a, b, c] = corners.map(|v| self.surface.vertices[v]);
        let area = triangle_area(a, b, c);
        let parts = [(b, c), (c, a), (a, b)].map(|(p, q)| triangle_area(near.point, p, q) / area);
        let motion = corners.iter().zip(parts).map(|(&v, part)| part * self.motion[v]).sum();
        (near.distance, motion)
    }
}

/// The shape `designed`, which has the boundary facets of the body `modelled`, on another mesh of that
/// body. Their interiors may differ: a re-meshed interior leaves boundary vertices their numbers.
pub fn carry(modelled: &Body, designed: &TetMesh, other: &Body) -> Result<Carried> {
    let [before, after] = [&modelled.mesh, designed].map(facets);
    ensure!(
        before == after,
        "the designed mesh has {} facets on its boundary and not the same as the modelled one with {}: \
         its surface was re-meshed or is of another body; expected the mesh that the design began with, \
         or that of the level it ends with (level-N.msh)",
        after.len(),
        before.len()
    );
    let mut d: BTreeMap<usize, (f64, Vec3)> = BTreeMap::new();
    let tags: Vec<&String> = modelled.used_tags().collect();
    for tag in tags {
        let facets = same_facets(other, tag)?;
        let wall = Wall::new(modelled, designed, tag)?;
        for &v in facets.iter().flatten() {
            let found = wall.at(&other.mesh.vertices[v]);
            let own = d.entry(v).or_insert(found);
            if found.0 < own.0 {
                *own = found;
            }
        }
    }
    let moving = || d.values().filter(|(_, motion)| motion.norm() > 0.0);
    let motion = moving().map(|(_, motion)| motion.norm()).fold(0.0, f64::max);
    let apart = moving().map(|(apart, _)| *apart).fold(0.0, f64::max);
    ensure_near(modelled, apart)?;
    let moves: Vec<(usize, Vec3)> = d.into_iter().map(|(v, (_, motion))| (v, motion)).collect();
    Ok(Carried { vertices: moved(other, &moves)?, motion, apart })
}

/// Checks that shapes which move facets with the tags of a body can be carried onto another mesh of it.
pub fn check_same_body(modelled: &Body, other: &Body, moving: &[String]) -> Result<()> {
    modelled.used_tags().try_for_each(|tag| same_facets(other, tag).map(drop))?;
    for tag in moving {
        let wall = Wall::new(modelled, &modelled.mesh, tag)?;
        let vertices = same_facets(other, tag)?.into_iter().flatten();
        let apart = vertices.map(|v| wall.at(&other.mesh.vertices[v]).0).fold(0.0, f64::max);
        ensure_near(modelled, apart)?;
    }
    Ok(())
}

/// The boundary, whatever the order of its facets and their vertices.
fn facets(mesh: &TetMesh) -> BTreeSet<[usize; 3]> {
    boundary(mesh).facets.into_iter().map(facet_key).collect()
}

fn same_facets(other: &Body, tag: &str) -> Result<Vec<[usize; 3]>> {
    other.facets(tag).or_else(|_| {
        let known: Vec<_> = other.used_tags().map(String::as_str).collect();
        bail!("the other mesh has no tag \"{tag}\"; it has: {}", known.join(", "))
    })
}

fn ensure_near(modelled: &Body, apart: f64) -> Result<()> {
    let limit = APART * mean_edge(&modelled.mesh.vertices, modelled.boundary());
    ensure!(
        apart <= limit,
        "a vertex of the other mesh that would move is {:.3} mm from the modelled surface; expected a \
         mesh of the same body, at most {:.3} mm away (a mean edge)",
        1e3 * apart,
        1e3 * limit
    );
    Ok(())
}

/// The vertices of a body whose boundary moves, in as few steps as elements bear.
fn moved(body: &Body, moves: &[(usize, Vec3)]) -> Result<Vec<Vec3>> {
    let mut steps = 1;
    loop {
        match in_steps(body, moves, steps)? {
            Ok(vertices) => return Ok(vertices),
            Err(_) if steps < STEPS => steps *= 2,
            Err(finding) => bail!(
                "elements of the other mesh turn over, in {STEPS} steps, too: {finding}\n  improve it at an \
                 earlier shape with cad2fem remesh, or take a finer one"
            ),
        }
    }
}

fn in_steps(
    body: &Body,
    moves: &[(usize, Vec3)],
    steps: usize,
) -> Result<Result<Vec<Vec3>, String>> {
    let mut body = body.clone();
    for _ in 0..steps {
        let Ok(extension) = Extension::new(&body) else {
            return Ok(Err("an element is flat".to_owned()));
        };
        let mut d = vec![Vec3::zeros(); body.mesh.vertices.len()];
        moves.iter().for_each(|(v, motion)| d[*v] = motion / steps as f64);
        extension.apply(&mut d);
        body.mesh.vertices.iter_mut().zip(&d).for_each(|(x, d)| *x += d);
        if let Some(finding) = mesh::check::check_tets(&body.mesh).first() {
            return Ok(Err(finding.message.clone()));
        }
    }
    Ok(Ok(body.mesh.vertices))
}

#[cfg(test)]
mod tests {
    use mechanics::testing::cube;
    use mesh::Tags;

    use super::*;

    /// The unit cube with n cells per side, its floor tagged, and a smooth motion of its other faces.
    fn body(n: usize) -> Body {
        let mesh = cube(n, 0.1);
        let mut tags = Tags::new(vec!["floor".to_owned(), "wall".to_owned()]);
        let facets = boundary(&mesh).facets;
        let low = |f: &[usize; 3]| f.iter().all(|&v| mesh.vertices[v].z == 0.0);
        let (floor, rest): (Vec<[usize; 3]>, Vec<_>) = facets.iter().copied().partition(low);
        for (name, own) in [("floor", floor), ("wall", rest)] {
            let id = tags.id(name).expect("named above");
            own.into_iter().for_each(|f| tags.set(f, id));
        }
        Body::new(mesh, tags)
    }

    fn designed(body: &Body) -> TetMesh {
        let bend = |x: &Vec3| x + x.z * Vec3::new(0.3 * x.z, 0.1 * x.y, 0.2);
        let mut mesh = body.mesh.clone();
        mesh.vertices.iter_mut().for_each(|x| *x = bend(x));
        mesh
    }

    #[test]
    fn a_mesh_carried_to_itself_has_the_boundary_of_the_design() {
        let own = body(4);
        let shape = designed(&own);
        let found = carry(&own, &shape, &own).expect("the same body");
        for &v in own.boundary().iter().flatten() {
            assert!((found.vertices[v] - shape.vertices[v]).norm() < 1e-12);
        }
        assert!(found.apart < 1e-12 && (found.motion / 0.4 - 1.0).abs() < 0.2, "{found:?}");
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let own = body(3);
        let message = |result: Result<Carried>| format!("{:#}", result.expect_err("refused"));
        let other = carry(&own, &body(4).mesh, &own);
        assert!(message(other).contains("re-meshed or is of another body"));
        let bare = Body::new(own.mesh.clone(), Tags::default());
        assert!(message(carry(&own, &designed(&own), &bare)).contains("no tag \"floor\""));
        let mut far = own.clone();
        far.mesh.vertices.iter_mut().for_each(|x| *x += Vec3::repeat(2.0));
        assert!(message(carry(&own, &designed(&own), &far)).contains("same body"));
    }

    /// Where elements were poor, the interior has other tetrahedra than at the start.
    #[test]
    fn an_interior_that_was_re_meshed_does_not_matter() {
        let own = body(3);
        let same = carry(&own, &designed(&own), &own).expect("the same body");
        let mut other = designed(&own);
        let whole = other.tets[0];
        other.vertices.push(whole.iter().map(|&v| other.vertices[v]).sum::<Vec3>() / 4.0);
        let middle = other.vertices.len() - 1;
        other.tets[0][0] = middle;
        for corner in 1..4 {
            let mut part = whole;
            part[corner] = middle;
            other.tets.push(part);
        }
        let found = carry(&own, &other, &own).expect("the same boundary");
        assert_eq!(found.vertices, same.vertices);
    }

    /// A motion of second order is interpolated with an error of h².
    #[test]
    fn a_finer_mesh_gets_the_shape_to_second_order() {
        let fine = body(12);
        let exact = designed(&fine);
        let error = |n: usize| {
            let own = body(n);
            let found = carry(&own, &designed(&own), &fine).expect("the same body");
            let on = fine.boundary().iter().flatten();
            on.map(|&v| (found.vertices[v] - exact.vertices[v]).norm()).fold(0.0, f64::max)
        };
        let [coarse, finer] = [3, 6].map(error);
        assert!(finer < 0.4 * coarse && finer < 0.01, "{coarse:e} {finer:e}");
    }
}
