//! `solver carry`: a shape on another mesh of the same body, and what is refused.

use mesh::Vec3;
use mesh::io::read_tets;
use tests::workdir::Workdir;
use tests::{block, tag};

/// A block of 40 × 20 × 20 mm in cells, as modelled and bent, with its ends tagged.
fn write(dir: &Workdir, cells: usize, names: [&str; 2]) {
    let size = 0.02 / cells as f64;
    let mesh = block([2 * cells, cells, cells], size, |_| false, |p| p);
    let mut body = tag(mesh, &[("end", &|p| p.x < 1e-9), ("skin", &|_| true)]);
    dir.put(names[0], &body);
    body.mesh.vertices.iter_mut().for_each(|x| *x = bent(x));
    dir.put(names[1], &body);
}

fn bent(x: &Vec3) -> Vec3 {
    x + Vec3::new(0.0, 0.0, 4.0 * x.x * x.x)
}

/// A motion of second order on edges of h = 5 mm is off by 4 h²/4 at most: 0.025 mm of 6.4.
#[test]
fn a_finer_mesh_takes_the_shape() {
    let dir = Workdir::new();
    write(&dir, 4, ["coarse.msh", "design.msh"]);
    write(&dir, 7, ["fine.msh", "exact.msh"]);
    dir.solver("carry design.msh --from coarse.msh --onto fine.msh -o out.msh")
        .assert_says(&["moved by up to 6.4"]);
    let [fine, exact, out] =
        ["fine.msh", "exact.msh", "out.msh"].map(|name| read_tets(&dir.path(name)).unwrap());
    assert_eq!(out.mesh.tets, fine.mesh.tets);
    assert_eq!(out.tags.names, fine.tags.names);
    for &v in mesh::topology::boundary(&out.mesh).facets.iter().flatten() {
        let off = (out.mesh.vertices[v] - exact.mesh.vertices[v]).norm();
        assert!(off < 2.6e-5, "vertex {v} is {off:.1e} m off");
    }
}
