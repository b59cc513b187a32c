//! Structured meshes of bodies whose equilibrium is known.

use mesh::{TetMesh, Vec3};

/// Points and triangles of a parameter plane.
pub struct Plane {
    /// Parameters of each point.
    pub points: Vec<[f64; 2]>,
    /// Triangles as point ids.
    pub triangles: Vec<[usize; 3]>,
}

/// The triangle (0, 0), (1, 0), (0, 1) with `n` segments per side.
pub fn triangle(n: usize) -> Plane {
    let id = |i: usize, j: usize| j * (n + 1) - j * j.saturating_sub(1) / 2 + i;
    let mut plane = Plane { points: Vec::new(), triangles: Vec::new() };
    for j in 0..=n {
        for i in 0..=n - j {
            plane.points.push([i as f64 / n as f64, j as f64 / n as f64]);
            if i + j < n {
                plane.triangles.push([id(i, j), id(i + 1, j), id(i, j + 1)]);
            }
            if i + j + 1 < n {
                plane.triangles.push([id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
    }
    plane
}

/// The unit square with n[0] by n[1] cells of two triangles.
pub fn square(n: [usize; 2]) -> Plane {
    let id = |i: usize, j: usize| j * (n[0] + 1) + i;
    let mut plane = Plane { points: Vec::new(), triangles: Vec::new() };
    for j in 0..=n[1] {
        for i in 0..=n[0] {
            plane.points.push([i as f64 / n[0] as f64, j as f64 / n[1] as f64]);
            if i < n[0] && j < n[1] {
                plane.triangles.push([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
                plane.triangles.push([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
    }
    plane
}

/// Prisms over a plane in `layers` layers, three tetrahedra each, at the places
/// that `place` gives to parameters and height in [0, 1].
pub fn extrude(plane: &Plane, layers: usize, place: impl Fn([f64; 2], f64) -> Vec3) -> TetMesh {
    let count = plane.points.len();
    let mut vertices = Vec::new();
    for k in 0..=layers {
        vertices.extend(plane.points.iter().map(|&p| place(p, k as f64 / layers as f64)));
    }
    prisms(&plane.triangles, vertices, count)
}

/// Prisms between triangles and the same a layer of `count` vertices above, three tetrahedra each, for
/// every layer of the vertices but the last. Diagonals go up from the lower vertex, so that neighbours agree.
pub fn prisms(triangles: &[[usize; 3]], vertices: Vec<Vec3>, count: usize) -> TetMesh {
    let mut tets = Vec::new();
    for k in 0..vertices.len() / count - 1 {
        for &triangle in triangles {
            let mut t = triangle;
            t.sort_unstable();
            let [a, b, c] = t.map(|i| i + k * count);
            let [x, y, z] = t.map(|i| i + (k + 1) * count);
            tets.extend([[a, b, c, z], [a, b, y, z], [a, x, y, z]]);
        }
    }
    for tet in &mut tets {
        let [a, b, c, d] = tet.map(|v| vertices[v]);
        if mesh::measure::tet_volume(a, b, c, d) < 0.0 {
            tet.swap(0, 1);
        }
    }
    TetMesh { vertices, tets }
}

/// The octant x, y, z ≥ 0 of a spherical shell: `n` segments along each arc,
/// `layers` through the wall.
pub fn shell_octant(inner: f64, outer: f64, n: usize, layers: usize) -> TetMesh {
    extrude(&triangle(n), layers, |[s, t], h| {
        // equal angles along the sides instead of equal chords
        let [a, b, c] = [1.0 - s - t, s, t].map(|l| (l * std::f64::consts::FRAC_PI_2).sin());
        (inner + h * (outer - inner)) * Vec3::new(a, b, c).normalize()
    })
}

/// The quarter x, y ≥ 0 of a ring of rectangular section and a height, one
/// element high: n[0] segments through the wall, n[1] around.
pub fn ring_quarter(inner: f64, outer: f64, height: f64, n: [usize; 2]) -> TetMesh {
    extrude(&square(n), 1, |[s, t], h| {
        let (radius, angle) = (inner + s * (outer - inner), t * std::f64::consts::FRAC_PI_2);
        Vec3::new(radius * angle.cos(), radius * angle.sin(), h * height)
    })
}

/// The unit ball: an icosahedron whose triangles are split `levels` times, and
/// tetrahedra from each of them to the centre, which is the last vertex.
pub fn ball(levels: usize) -> TetMesh {
    let g = f64::midpoint(1.0, 5.0_f64.sqrt());
    let corner = |k: usize| {
        let (a, b) = (if k & 1 == 0 { 1.0 } else { -1.0 }, if k & 2 == 0 { g } else { -g });
        match k / 4 {
            0 => Vec3::new(0.0, a, b),
            1 => Vec3::new(a, b, 0.0),
            _ => Vec3::new(b, 0.0, a),
        }
    };
    let mut vertices: Vec<Vec3> = (0..12).map(|k| corner(k).normalize()).collect();
    let edge = (corner(0) - corner(1)).norm() / corner(0).norm();
    let near = |a: usize, b: usize| ((vertices[a] - vertices[b]).norm() / edge - 1.0).abs() < 1e-9;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    for _ in 0..levels {
        triangles = split(&mut vertices, &triangles);
    }
    let centre = vertices.len();
    vertices.push(Vec3::zeros());
    let tets = triangles.iter().map(|&[a, b, c]| {
        let outwards =
            (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a])).dot(&vertices[a]);
        if outwards > 0.0 { [centre, a, b, c] } else { [centre, b, a, c] }
    });
    let tets = tets.collect();
    TetMesh { vertices, tets }
}

/// Every triangle into four, new points on the unit sphere.
fn split(vertices: &mut Vec<Vec3>, triangles: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut middles = std::collections::BTreeMap::new();
    let mut middle = |a: usize, b: usize| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            vertices.push((vertices[a] + vertices[b]).normalize());
            vertices.len() - 1
        })
    };
    let mut finer = Vec::new();
    for &[a, b, c] in triangles {
        let (p, q, r) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
    }
    finer
}
