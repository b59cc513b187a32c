//! Is a trial rest shape one that can be simulated and cast?
//!
//! Every tetrahedron must have a positive volume that is not negligible beside
//! the mean, and the moving part of the boundary must not run through itself or
//! through the rest of the boundary, which is decided exactly.

use std::collections::BTreeSet;

use anyhow::{Result, bail, ensure};
use mechanics::body::Body;
use mesh::crossings::self_intersecting_pairs;
use mesh::measure::tet_volume;
use mesh::{SurfaceMesh, Vec3, facet_key};

/// Smallest volume of a tetrahedron that can be simulated in units of the mean volume [1].
const SMALLEST: f64 = 1e-7;
/// That of a shape that a design moves to, where its start has no smaller one.
const SMALLEST_OF_TRIALS: f64 = 1e-5;

fn point(p: &Vec3) -> String {
    format!("({:.5}, {:.5}, {:.5}) m", p.x, p.y, p.z)
}

/// Checks vertex positions `rest` of a body, of whose boundary facets `moving` are those
/// that the design moves.
pub fn check(rest: &[Vec3], body: &Body, moving: &[[usize; 3]]) -> Result<()> {
    check_volumes(rest, &body.mesh.tets, SMALLEST)?;
    check_sides(rest, body)?;
    check_intersections(rest, body.boundary(), moving)
}

/// What crosses a plane of symmetry runs through its mirror image.
fn check_sides(rest: &[Vec3], body: &Body) -> Result<()> {
    for plane in &body.planes {
        let surface: BTreeSet<usize> = body.boundary().iter().flatten().copied().collect();
        let depths = surface.iter().map(|&v| -plane.height(&rest[v]));
        let crossing: Vec<f64> = depths.filter(|&depth| depth > plane.tolerance).collect();
        let depth = crossing.iter().copied().fold(0.0, f64::max);
        ensure!(
            crossing.is_empty(),
            "{} vertices cross the plane of symmetry {}, the deepest by {depth:.2e} m",
            crossing.len(),
            plane.equation()
        );
    }
    Ok(())
}

/// Volumes of tetrahedra in units of their mean.
fn volumes(rest: &[Vec3], tets: &[[usize; 4]]) -> Vec<f64> {
    let volume = |tet: &[usize; 4]| {
        let [a, b, c, d] = tet.map(|v| rest[v]);
        tet_volume(a, b, c, d)
    };
    let volumes: Vec<f64> = tets.iter().map(volume).collect();
    let mean = volumes.iter().map(|v| v.abs()).sum::<f64>() / volumes.len() as f64;
    volumes.iter().map(|volume| volume / mean).collect()
}

/// The smallest volume over the mean of shapes that a design moves to from a start: re-meshing may leave smaller ones there.
pub fn smallest_of_trials(start: &[Vec3], tets: &[[usize; 4]]) -> f64 {
    let smallest = volumes(start, tets).into_iter().fold(f64::INFINITY, f64::min);
    (0.5 * smallest).clamp(SMALLEST, SMALLEST_OF_TRIALS)
}

/// Checks that no tetrahedron is flat, with less than `least` of the mean volume, or inverted.
pub(super) fn check_volumes(rest: &[Vec3], tets: &[[usize; 4]], least: f64) -> Result<()> {
    let volumes = volumes(rest, tets);
    let is_bad = |&t: &usize| volumes[t].is_nan() || volumes[t] <= least;
    let bad: Vec<usize> = (0..tets.len()).filter(is_bad).collect();
    let worst = bad.iter().min_by(|&&a, &&b| volumes[a].total_cmp(&volumes[b]));
    let Some(&tet) = worst else { return Ok(()) };
    bail!(
        "{} elements are flat or inverted, the worst is {tet} at {} with a volume of {:.1e} of the mean; expected at \
         least {least:.0e}",
        bad.len(),
        point(&(tets[tet].iter().map(|&v| rest[v]).sum::<Vec3>() / 4.0)),
        volumes[tet]
    )
}

fn check_intersections(
    rest: &[Vec3],
    boundary: &[[usize; 3]],
    moving: &[[usize; 3]],
) -> Result<()> {
    let moving: BTreeSet<[usize; 3]> = moving.iter().map(|&f| facet_key(f)).collect();
    let moves = |facet: usize| moving.contains(&facet_key(boundary[facet]));
    let surface = SurfaceMesh { vertices: rest.to_vec(), triangles: boundary.to_vec() };
    let mut pairs = self_intersecting_pairs(&surface);
    pairs.retain(|&(a, b)| moves(a) || moves(b));
    let Some(&(a, _)) = pairs.first() else { return Ok(()) };
    bail!("{} pairs of facets intersect, the first at {}", pairs.len(), point(&surface.centroid(a)))
}

#[cfg(test)]
mod tests {
    use mechanics::testing::cube;
    use mesh::{Tags, TetMesh, topology};

    use super::*;

    /// What is wrong with a mesh; nothing with a valid one.
    fn said(mesh: &TetMesh, moving: &[[usize; 3]]) -> String {
        let checked = check(&mesh.vertices, &Body::new(mesh.clone(), Tags::default()), moving);
        checked.err().map_or_else(String::new, |why| why.to_string())
    }

    #[test]
    fn an_inverted_element_is_named() {
        let mut mesh = cube(3, 0.0);
        let facets = topology::boundary(&mesh).facets;
        assert_eq!(said(&mesh, &facets), "");
        let inner = 21;
        mesh.vertices[inner] += Vec3::new(0.5, 0.0, 0.0);
        let found = said(&mesh, &facets);
        assert!(found.contains("inverted") && found.contains("volume of -"), "{found}");
        mesh.vertices[inner].x = f64::NAN;
        assert!(said(&mesh, &facets).contains("inverted"));
    }

    /// Two cubes, one pushed into the other: no element is inverted.
    #[test]
    fn a_moving_facet_that_runs_into_another_is_found_and_resting_ones_are_not() {
        let one = cube(2, 0.0);
        let n = one.vertices.len();
        let mut two = one.clone();
        two.vertices.extend(one.vertices.iter().map(|v| 0.7 * v + Vec3::new(1.1, 0.1, 0.2)));
        two.tets.extend(one.tets.iter().map(|t| t.map(|v| v + n)));
        let facets = topology::boundary(&two).facets;
        let (resting, moving): (Vec<_>, Vec<_>) = facets.iter().partition(|f| f[0] < n);
        assert_eq!(said(&two, &moving), "");
        two.vertices[n..].iter_mut().for_each(|v| v.x -= 0.2);
        for facets in [&moving, &resting] {
            assert!(said(&two, facets).contains("pairs of facets intersect"));
        }
        assert_eq!(said(&two, &[]), "");
    }
}
