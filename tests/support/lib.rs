//! Small bodies and helpers that the tests share.

pub mod book;
pub mod chamber;
pub mod chromium;
pub mod equilibrium;
pub mod judges;
pub mod meshes;
pub mod motion;
pub mod published;
pub mod reported;
pub mod skip;
pub mod symmetric;
pub mod workdir;

use std::path::PathBuf;

use mechanics::body::Body;
use mesh::{SurfaceMesh, Tags, TetMesh, Vec3};

/// The six tetrahedra of a cube whose corners are numbered by the bits zyx.
const KUHN: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// A block of `cells` cubes of edge `edge` [m] without the cells for which
/// `empty` holds, its vertices moved by `distort`.
pub fn block(
    cells: [usize; 3],
    edge: f64,
    empty: impl Fn([usize; 3]) -> bool,
    distort: impl Fn(Vec3) -> Vec3,
) -> TetMesh {
    let size = cells.map(|n| n + 1);
    let id = |i: [usize; 3]| (i[2] * size[1] + i[1]) * size[0] + i[0];
    let mut tets = Vec::new();
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                if empty([x, y, z]) {
                    continue;
                }
                let corner =
                    |bits: usize| id([x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2)]);
                tets.extend(KUHN.map(|tet| tet.map(corner)));
            }
        }
    }
    let mut used: Vec<usize> = tets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let position = |v: usize| {
        let [x, y, z] = [v % size[0], v / size[0] % size[1], v / size[0] / size[1]];
        distort(edge * Vec3::new(x as f64, y as f64, z as f64))
    };
    let renumber = |v: usize| used.binary_search(&v).expect("every corner is used");
    TetMesh {
        vertices: used.iter().map(|&v| position(v)).collect(),
        tets: tets.into_iter().map(|t| t.map(renumber)).collect(),
    }
}

/// Where a tag is.
pub type Place<'a> = &'a dyn Fn(Vec3) -> bool;

/// A rectangle of two triangles at a height, which faces up, between two places along x and two along y [m].
pub fn plate(x: [f64; 2], y: [f64; 2], z: f64) -> SurfaceMesh {
    let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    SurfaceMesh {
        vertices: corners.map(|[x, y]| Vec3::new(x, y, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Tags boundary facets by the first rule that holds at their centroid.
pub fn tag(mesh: TetMesh, rules: &[(&str, Place)]) -> Body {
    let mut tags = Tags::new(rules.iter().map(|r| r.0.to_owned()).collect());
    for facet in mesh::topology::boundary(&mesh).facets {
        let centroid = facet.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0;
        if let Some((i, _)) = rules.iter().enumerate().find(|(_, r)| (r.1)(centroid)) {
            tags.set(facet, u32::try_from(i + 1).expect("few rules"));
        }
    }
    Body::new(mesh, tags)
}

/// A file beside the repository that is not part of it; none where it is absent,
/// and the test is counted as skipped.
pub fn shared(path: &str) -> Option<PathBuf> {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(path);
    if file.exists() {
        return Some(file);
    }
    skip::skip(&format!("{path} of the shared files is not on this machine"));
    None
}
