//! Small surfaces, and gradient checks, for unit tests.

use mesh::topology::TET_FACETS;
use mesh::{SurfaceMesh, TetMesh, Vec3, facet_key};

use crate::element::FunctionSpace;
use crate::energy::{Chamber, Elastic, Energies, Isobaric, Wall};
use crate::forward::Problem;
use crate::material::{Lame, NeoHookean};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::taylor::taylor;
use crate::schedule::Schedule;
use crate::symmetry::Plane;

/// The square [0, 1]² in the plane z = 0, n cells per side; interior vertices
/// are moved by up to `jitter` of a cell.
pub fn square(n: usize, jitter: f64) -> SurfaceMesh {
    let mut random = Random::new(11);
    let h = 1.0 / n as f64;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let move_by = jitter * h * random.vector();
            let inside = |k: usize| f64::from(u8::from(k > 0 && k < n));
            let (dx, dy) = (inside(i) * move_by.x, inside(j) * move_by.y);
            vertices.push(Vec3::new(i as f64 * h + dx, j as f64 * h + dy, 0.0));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let v = j * (n + 1) + i;
            triangles.push([v, v + 1, v + n + 2]);
            triangles.push([v, v + n + 2, v + n + 1]);
        }
    }
    SurfaceMesh { vertices, triangles }
}

/// The unit sphere: an octahedron refined `levels` times.
pub fn sphere(levels: usize) -> SurfaceMesh {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let vertices = axes.iter().flat_map(|a| [*a, -a]).collect();
    let triangles =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut surface = SurfaceMesh { vertices, triangles: triangles.to_vec() };
    for _ in 0..levels {
        surface = refine(&surface);
        surface.vertices = surface.vertices.iter().map(|v| v.normalize()).collect();
    }
    surface
}

/// The part z > −0.3 of the unit sphere, whose rim is ragged.
pub fn cap(levels: usize) -> SurfaceMesh {
    let sphere = sphere(levels);
    let high = |t: &&[usize; 3]| t.iter().all(|&v| sphere.vertices[v].z > -0.3);
    let facets: Vec<_> = sphere.triangles.iter().filter(high).copied().collect();
    mesh::topology::submesh(&sphere.vertices, &facets).0
}

/// Splits every triangle into four at the middles of its edges.
fn refine(surface: &SurfaceMesh) -> SurfaceMesh {
    let mut vertices = surface.vertices.clone();
    let mut middle = std::collections::BTreeMap::new();
    let mut between = |a: usize, b: usize| {
        *middle.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            vertices.push((vertices[a] + vertices[b]) / 2.0);
            vertices.len() - 1
        })
    };
    let mut triangles = Vec::new();
    for &[a, b, c] in &surface.triangles {
        let (p, q, r) = (between(a, b), between(b, c), between(c, a));
        triangles.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
    }
    SurfaceMesh { vertices, triangles }
}

/// Asserts Taylor slopes of 2 ± 0.1 along the gradient and two random
/// directions, each of length `size` in the maximum norm.
#[track_caller]
pub fn check_gradient(x: &[f64], gradient: &[f64], size: f64, value: impl Fn(&[f64]) -> f64) {
    let mut random = Random::new(13);
    let mut directions = vec![gradient.to_vec()];
    directions.extend((0..2).map(|_| random.numbers(x.len())));
    for mut q in directions {
        let largest = q.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(largest > 0.0, "the gradient vanishes");
        q.iter_mut().for_each(|v| *v *= size / largest);
        let along = |e: f64| -> Result<f64, std::convert::Infallible> {
            Ok(value(&x.iter().zip(&q).map(|(a, b)| a + e * b).collect::<Vec<_>>()))
        };
        let Ok(result) = taylor(1.0, 7, dot(gradient, &q), along);
        assert!((result.slope - 2.0).abs() < 0.1, "{result:?}");
    }
}

/// Components of points, one after the other.
pub fn flat(points: &[Vec3]) -> Vec<f64> {
    points.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
}

/// Points from their components.
pub fn points(flat: &[f64]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(Vec3::from_column_slice).collect()
}

/// The cube [0, 1]³ in n³ cells of six tetrahedra; interior vertices are moved
/// by up to `jitter` of a cell.
pub fn cube(n: usize, jitter: f64) -> TetMesh {
    let mut random = Random::new(12);
    let h = 1.0 / n as f64;
    let mut mesh = block([n; 3]);
    for v in 0..(n + 1).pow(3) {
        let grid = [v % (n + 1), v / (n + 1) % (n + 1), v / (n + 1).pow(2)];
        let moved = jitter * h * random.vector();
        let inside = grid.iter().all(|&i| i > 0 && i < n);
        let at = Vec3::from(grid.map(|i| i as f64 * h));
        mesh.vertices[v] = if inside { at + moved } else { at };
    }
    mesh
}

/// The cube [0, 1]³ in so many cells along each axis, of six tetrahedra each.
pub fn block(cells: [usize; 3]) -> TetMesh {
    let [nx, ny, nz] = cells;
    let id = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
    let mut vertices = Vec::new();
    for v in 0..(nx + 1) * (ny + 1) * (nz + 1) {
        let grid = [v % (nx + 1), v / (nx + 1) % (ny + 1), v / ((nx + 1) * (ny + 1))];
        let place = |k: usize| grid[k] as f64 / cells[k] as f64;
        vertices.push(Vec3::new(place(0), place(1), place(2)));
    }
    // the six orders of steps along the axes from one corner to the opposite
    // one; odd orders are mirrored
    let paths = [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([2, 1, 0], false),
        ([1, 0, 2], false),
    ];
    let mut tets = Vec::new();
    for cell in 0..nx * ny * nz {
        for (path, even) in paths {
            let mut at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let mut tet = [id(at[0], at[1], at[2]); 4];
            for (step, axis) in path.into_iter().enumerate() {
                at[axis] += 1;
                tet[step + 1] = id(at[0], at[1], at[2]);
            }
            if !even {
                tet.swap(1, 2);
            }
            tets.push(tet);
        }
    }
    TetMesh { vertices, tets }
}

/// Facets of a mesh, on its boundary and inside, whose vertices are all where a condition holds, ascending.
pub fn facets_where(mesh: &TetMesh, test: impl Fn(Vec3) -> bool) -> Vec<[usize; 3]> {
    let of_tet = |t: &[usize; 4]| TET_FACETS.map(|corners| facet_key(corners.map(|c| t[c])));
    let here = |f: &[usize; 3]| f.iter().all(|&v| test(mesh.vertices[v]));
    let mut all: Vec<_> = mesh.tets.iter().flat_map(of_tet).filter(here).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// An eighth of a shell with the radii `inner` and 1, in the octant of positive coordinates: an octahedron
/// refined `levels` times, in layers of equal thickness.
pub fn eighth_shell(levels: usize, layers: usize, inner: f64) -> TetMesh {
    let whole = sphere(levels);
    let octant = |t: &&[usize; 3]| t.iter().all(|&v| whole.vertices[v].min() > -1e-12);
    let facets: Vec<[usize; 3]> = whole.triangles.iter().filter(octant).copied().collect();
    let (facets, _) = mesh::topology::submesh(&whole.vertices, &facets);
    let radius = |layer: usize| inner + (1.0 - inner) * layer as f64 / layers as f64;
    prisms(&facets, (0..=layers).map(radius))
}

/// Layers of prisms, of three tetrahedra each, between copies of a surface that are larger by ascending factors.
pub fn prisms(facets: &SurfaceMesh, factors: impl IntoIterator<Item = f64>) -> TetMesh {
    let count = facets.vertices.len();
    let copies =
        factors.into_iter().flat_map(|factor| facets.vertices.iter().map(move |v| factor * v));
    let vertices: Vec<Vec3> = copies.collect();
    let mut tets = Vec::new();
    for layer in 0..vertices.len() / count - 1 {
        for triangle in &facets.triangles {
            let mut below = triangle.map(|v| layer * count + v);
            below.sort_unstable();
            let above = below.map(|v| v + count);
            // a prism between ascending corners: neighbours cut their common side alike
            for corner in 0..3 {
                let mut tet: Vec<usize> = below[corner..].to_vec();
                tet.extend(&above[..=corner]);
                let mut tet = [tet[0], tet[1], tet[2], tet[3]];
                let [a, b, c, d] = tet.map(|v| vertices[v]);
                if mesh::measure::tet_volume(a, b, c, d) < 0.0 {
                    tet.swap(0, 1);
                }
                tets.push(tet);
            }
        }
    }
    TetMesh { vertices, tets }
}

/// A thick neo-Hookean sphere with its pressure at t = 1 over the shear modulus, of which an eighth is meshed, and its
/// vertices.
///
/// # Panics
/// Where the mesh is no eighth.
pub fn balloon(levels: usize, layers: usize, pressure: f64) -> (Problem, Vec<Vec3>) {
    let mesh = eighth_shell(levels, layers, BALLOON);
    // bulk modulus 2000 times the shear modulus 1
    let material = NeoHookean(Lame::new(BALLOON_MODULUS, 0.49975));
    let elastic = Elastic::whole(Box::new(material)).with_mean_dilatation();
    let body = elastic.expect("a term of the volume");
    let gas = Box::new(Isobaric { pressure: Schedule::from(pressure) });
    let problem = shell_problem(&mesh, |space| {
        let wall = shell_wall(&mesh, space, BALLOON);
        let chamber = Chamber::new(wall, gas);
        Energies::bodies([body]).with_chamber("wall", chamber)
    });
    (problem, mesh.vertices)
}

/// An [`eighth_shell`] with quadratic displacements that slides along the planes of symmetry.
pub fn shell_problem(mesh: &TetMesh, energies: impl FnOnce(&FunctionSpace) -> Energies) -> Problem {
    let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets.clone());
    let nodes = space.node_positions(&mesh.vertices);
    let fixed: Vec<bool> =
        nodes.iter().flat_map(|x| [x.x < 1e-12, x.y < 1e-12, x.z < 1e-12]).collect();
    let energies = energies(&space);
    Problem::new(space, energies, &fixed)
}

/// The wall of an [`eighth_shell`] at a radius, as the planes of symmetry complete it.
pub fn shell_wall(mesh: &TetMesh, space: &FunctionSpace, radius: f64) -> Wall {
    symmetric_wall(mesh, space, |x| (x.norm() - radius).abs() < 1e-9)
}

/// The wall of the boundary facets where a condition holds, of a body that may be cut at x = 0, y = 0 and z = 0.
///
/// # Panics
/// Where facets in such a plane are no cut.
pub fn symmetric_wall(
    mesh: &TetMesh,
    space: &FunctionSpace,
    inside: impl Fn(Vec3) -> bool,
) -> Wall {
    let boundary = mesh::topology::boundary(mesh).facets;
    let own_where = |test: &dyn Fn(Vec3) -> bool| -> Vec<[usize; 3]> {
        let facets = boundary.iter().filter(|f| f.iter().all(|&v| test(mesh.vertices[v])));
        facets.copied().collect()
    };
    let cuts = (0..3).map(|axis| own_where(&|x: Vec3| x[axis].abs() < 1e-11));
    let planes = cuts.filter(|cut| !cut.is_empty()).map(|cut| {
        Plane::find(mesh, &boundary, &["cut".to_owned()], &cut).expect("all of a plane")
    });
    let planes: Vec<Plane> = planes.collect();
    Wall::cut_by(&planes, space, &own_where(&inside))
}

/// Inner radius of [`balloon`], whose outer one is 1.
pub const BALLOON: f64 = 0.6;
/// Young's modulus of [`balloon`], whose shear modulus is 1.
pub const BALLOON_MODULUS: f64 = 2.9995;

/// Pressure over the shear modulus at a stretch of the inner wall of [`balloon`]: with W' = 2 (λ − λ⁻⁵) of the incompressible law,
/// ∫ W'/(λ³ − 1) dλ between the stretches of both walls.
pub fn balloon_pressure(inside: f64) -> f64 {
    let outside = (1.0 + (inside.powi(3) - 1.0) * BALLOON.powi(3)).cbrt();
    let part = |l: f64| 1.0 / l + 0.25 / l.powi(4);
    2.0 * (part(outside) - part(inside))
}

/// The largest pressure of [`balloon_pressure`], beyond which there is no equilibrium.
pub fn balloon_limit() -> f64 {
    (1000..4000).map(|i| balloon_pressure(0.001 * f64::from(i))).fold(0.0, f64::max)
}

/// A block that is cut at x = 0 and one beside it, near the plane: each comes close to the
/// other, and the second to its image.
pub fn half() -> (TetMesh, Plane) {
    let mut part = cube(2, 0.1);
    let turn = nalgebra::Rotation3::from_euler_angles(0.02, -0.015, 0.01);
    let count = part.vertices.len();
    let other = part.vertices.iter().map(|v| turn * *v + Vec3::new(0.06, 1.07, 0.05));
    let other: Vec<Vec3> = other.collect();
    part.vertices.extend(other);
    part.tets.extend(part.tets.clone().into_iter().map(|t| t.map(|v| v + count)));
    let boundary = mesh::topology::boundary(&part).facets;
    let in_plane = |f: &&[usize; 3]| f.iter().all(|&v| part.vertices[v].x == 0.0);
    let cut: Vec<[usize; 3]> = boundary.iter().filter(in_plane).copied().collect();
    let plane = Plane::find(&part, &boundary, &["cut".to_owned()], &cut).expect("a plane");
    (part, plane)
}

/// A mesh with its mirror image in x = 0, where vertices are shared.
pub fn whole(part: &TetMesh) -> TetMesh {
    let mut vertices = part.vertices.clone();
    let image = part.vertices.iter().enumerate().map(|(i, v)| {
        if v.x == 0.0 {
            return i;
        }
        vertices.push(Vec3::new(-v.x, v.y, v.z));
        vertices.len() - 1
    });
    let image: Vec<usize> = image.collect();
    let mut tets = part.tets.clone();
    tets.extend(part.tets.iter().map(|&[a, b, c, d]| [b, a, c, d].map(|v| image[v])));
    TetMesh { vertices, tets }
}
