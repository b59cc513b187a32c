//! Small sound files to begin with.

use std::path::Path;

use mesh::io::threemf::{self, Place, Shape};
use mesh::io::vtu::{CellType, Field, Grid, write_vtu};
use mesh::io::{npy, write_surface, write_tets};
use mesh::{SurfaceMesh, Vec3};

use tests::workdir::{Workdir, repository};
use tests::{block, tag};

/// What `write` leaves in a file of this name.
fn written(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = Workdir::new();
    let path = folder.path(name);
    write(&path);
    std::fs::read(path).expect("it was written")
}

fn tetrahedron() -> SurfaceMesh {
    let vertices = vec![Vec3::zeros(), Vec3::x() * 0.01, Vec3::y() * 0.02, Vec3::z() * 0.03];
    SurfaceMesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] }
}

pub fn surface(file: &str) -> Vec<Vec<u8>> {
    let write = |path: &Path| write_surface(path, &tetrahedron()).expect("a sound surface");
    let mut all = vec![written(file, write)];
    let ascii: &[u8] = match file {
        "a.stl" => b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
        "a.ply" => b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        _ => b"# square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4/1 2//1 3/1/1 4\n",
    };
    all.push(ascii.to_vec());
    all
}

pub fn msh(file: &str) -> Vec<Vec<u8>> {
    let body = tag(block([1, 1, 1], 0.01, |_| false, |p| p), &[("all", &|_| true)]);
    let ours = written(file, |path| write_tets(path, &body.mesh, &body.tags).expect("sound"));
    let v4 = b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 1\n1 0 0 0 1 1 1 1 7 0\n1 0 0 0 1 1 1 0 1 1\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 3 2\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";
    vec![ours, v4.to_vec()]
}

pub fn vtu(file: &str) -> Vec<Vec<u8>> {
    let body = block([1, 1, 1], 0.01, |_| false, |p| p);
    let field = |name: &str, count: usize, components: usize| Field {
        name: name.into(),
        unit: "m".into(),
        components,
        values: vec![0.5; count * components],
    };
    let grid = Grid {
        point_fields: vec![field("displacement", body.vertices.len(), 3)],
        cell_fields: vec![field("quality", body.tets.len(), 1)],
        cells: body.tets.iter().flatten().copied().collect(),
        cell_type: CellType::Tet4,
        points: body.vertices,
    };
    vec![written(file, |path| write_vtu(path, &grid).expect("a sound grid"))]
}

pub fn npy(file: &str) -> Vec<Vec<u8>> {
    let write = |path: &Path| npy::write_f64(path, &[0.0, 1.5, -2.0, 3.0], &[2, 2]).expect("fits");
    vec![written(file, write)]
}

pub fn checkpoint(file: &str) -> Vec<Vec<u8>> {
    let write = |path: &Path| {
        program::write_checkpoint(path, "fuzz 1", &vec![0.1, -2.0, 1e-300]).expect("writable");
    };
    vec![written(file, write)]
}

pub fn threemf(file: &str) -> Vec<Vec<u8>> {
    let shape = |name: &str| Shape {
        name: name.into(),
        surface: tetrahedron(),
        place: Place::at(Vec3::zeros()),
    };
    let write =
        |path: &Path| threemf::write(path, "fab", "two", &[shape("a"), shape("b")]).expect("sound");
    vec![written(file, write)]
}

/// The files of this name of all pipelines.
pub fn pipelines(name: &str) -> Vec<Vec<u8>> {
    let folders = std::fs::read_dir(repository().join("pipelines")).expect("the pipelines");
    let mut files: Vec<_> = folders.flatten().map(|entry| entry.path().join(name)).collect();
    files.sort();
    let found: Vec<Vec<u8>> = files.iter().filter_map(|path| std::fs::read(path).ok()).collect();
    assert!(!found.is_empty(), "no pipeline has a {name}");
    found
}

pub fn polyfem(_: &str) -> Vec<Vec<u8>> {
    vec![
        br#"{"geometry": [{"mesh": "a.msh", "volume_selection": 1, "transformation": {"scale": [1, 1, 1]}, "surface_selection": [{"id": 2, "box": [[0, 0, 0], [1, 1, 1]], "relative": true}]}], "space": {"discr_order": 2}, "time": {"tend": 1, "time_steps": 10, "integrator": "BDF2"}, "materials": {"type": "NeoHookean", "E": 1e5, "nu": 0.4, "rho": 1000}, "boundary_conditions": {"rhs": [0, 9.81, 0], "dirichlet_boundary": [{"id": 2, "value": ["0", "sin(t)*0.1", 0]}], "pressure_boundary": [{"id": 3, "value": 1000}]}, "contact": {"enabled": true, "dhat": 1e-3}}"#.to_vec(),
    ]
}
