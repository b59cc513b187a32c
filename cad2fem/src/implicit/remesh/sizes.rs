//! How long edges should be: by the curvature of the functions and the thickness of what is beside them.

use mesh::topology::edge_facets;
use mesh::walls;
use mesh::{SurfaceMesh, Vec3};
use rayon::prelude::*;

use super::super::sides::Sides;
use super::super::skin::Skin;

/// The shortest and the longest edges [grid].
const SHORTEST: f64 = 0.4;
const LONGEST: f64 = 3.0;

/// The middle of an equilateral triangle is h²/6r from the sphere of radius r that its corners lie on, for edges h. Edges
/// are up to a third longer than their size, where they bend less than that: h² = 4.5 r e for a distance e, as
/// for CAD.
const SQUARED: f64 = 4.5;

/// Edges over the thickness of the wall or the gap beside them [1].
const THICK: f64 = 2.0;

/// How fast edges grow from shorter ones [1].
const GROWTH: f64 = 0.5;

/// The way over which normals are compared [grid]. What bends more within it is as small as the shortest edges.
const WAY: f64 = 0.2;

/// Step of the differences that give normals [grid].
const STEP: f64 = 1e-4;

/// The length of edges that is wanted at each vertex [m], so that triangles are `tolerance` [m] from the functions.
pub fn wanted(skin: &Skin, tolerance: f64, sides: &Sides) -> Vec<f64> {
    let grid = sides.grid * sides.metres;
    let mut on = vec![0_u64; skin.surface.vertices.len()];
    for (triangle, part) in skin.surface.triangles.iter().zip(&skin.part) {
        triangle.iter().for_each(|&v| on[v] |= 1 << sides.index(*part));
    }
    let by_curvature = |(p, on): (&Vec3, &u64)| {
        let of_side = |k: usize| if on >> k & 1 == 1 { curvature(sides, k, p) } else { 0.0 };
        let most = (0..sides.list.len()).map(of_side).fold(0.0, f64::max);
        (SQUARED * tolerance / most).sqrt().clamp(SHORTEST * grid, LONGEST * grid)
    };
    let mut size: Vec<f64> = skin.surface.vertices.par_iter().zip(&on).map(by_curvature).collect();
    // The walls of a body are the gaps of what is beside it.
    let turned = skin.surface.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let beside = SurfaceMesh { vertices: skin.surface.vertices.clone(), triangles: turned };
    for (width, [t, _]) in walls::gaps(&beside).into_iter().chain(walls::gaps(&skin.surface)) {
        for &v in &skin.surface.triangles[t] {
            size[v] = size[v].min((THICK * width).max(SHORTEST * grid));
        }
    }
    grade(&mut size, skin);
    size
}

/// Largest normal curvature of side `k` near a point [m] of it, by differences of normals [1/m].
fn curvature(sides: &Sides, k: usize, p: &Vec3) -> f64 {
    let (way, step) = (WAY * sides.grid, STEP * sides.grid);
    let p = p / sides.metres;
    let normal = |p: &Vec3| sides.list[k].gradient(p, step).try_normalize(0.0).unwrap_or_default();
    let n = normal(&p);
    let along = Vec3::ith(n.iamin(), 1.0).cross(&n).try_normalize(0.0).unwrap_or_default();
    let axes = [along, n.cross(&along)];
    // Two columns of the shape operator, in the tangent plane.
    let columns =
        axes.map(|axis| (normal(&(p + axis * way)) - normal(&(p - axis * way))) / (2.0 * way));
    let [[a, b], [c, d]] = columns.map(|column| axes.map(|axis| column.dot(&axis)));
    // Its larger eigenvalue, of the symmetric part.
    let (mean, off) = ((a + d) / 2.0, (b + c) / 2.0);
    (mean.abs() + ((a - d) / 2.0).hypot(off)) / sides.metres
}

/// Lets sizes grow by no more than [`GROWTH`] along edges.
fn grade(size: &mut [f64], skin: &Skin) {
    let edges: Vec<[usize; 2]> = edge_facets(&skin.surface.triangles).into_keys().collect();
    loop {
        let mut changed = false;
        for &[a, b] in edges.iter().chain(edges.iter().rev()) {
            let room = GROWTH * (skin.surface.vertices[a] - skin.surface.vertices[b]).norm();
            for [v, w] in [[a, b], [b, a]] {
                if size[v] > size[w] + room {
                    size[v] = size[w] + room;
                    changed = true;
                }
            }
        }
        if !changed {
            return;
        }
    }
}
