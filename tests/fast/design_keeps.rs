//! What a design keeps of a shape: `[[shape.symmetric]]`, tags of a whole body that move alike, and `keep` in `[shape]`, flat
//! faces that stay in their planes.

use mesh::bvh::SurfaceBvh;
use mesh::io::read_tets;
use mesh::{Vec3, topology};
use tests::chamber::{chamber, refined};
use tests::workdir::Workdir;

use crate::samples::{OWN, alike, kept, two_chambers};

/// Vertices before and after an optimisation.
fn designed(dir: &Workdir) -> [Vec<Vec3>; 2] {
    dir.solver("optimize design.toml -o out").assert_good();
    ["body.msh", "out/design.msh"].map(|file| read_tets(&dir.path(file)).unwrap().mesh.vertices)
}

/// How far the chamber is from its mirror image, and how far it has moved [m].
fn off([before, after]: &[Vec<Vec3>; 2]) -> (f64, f64) {
    let (surface, ids) = topology::submesh(after, &refined(2).facets("cavity").unwrap());
    let tree = SurfaceBvh::new(&surface);
    let mirrored = surface.vertices.iter().map(|x| Vec3::new(x.x, 0.04 - x.y, x.z));
    let off = mirrored.map(|x| tree.closest(&x).distance).fold(0.0, f64::max);
    (off, ids.iter().map(|&v| (after[v] - before[v]).norm()).fold(0.0, f64::max))
}

/// Triangles of the chamber are mirror images of each other, so that the shape is its own image to rounding.
#[test]
fn a_symmetric_body_stays_symmetric_with_an_unsymmetric_target() {
    let run = |symmetric: &str| {
        let dir = alike(symmetric);
        dir.put("body.msh", &refined(2));
        off(&designed(&dir))
    };
    let ((with, moved), (without, all)) = (run(OWN), run(""));
    eprintln!("off by {with:e} of {moved:e} m; without the table {without:e} of {all:e} m");
    assert!(moved > 1e-3 && with < 1e-9 * moved, "{with} {moved}");
    assert!(without > 0.3 * all, "{without} {all}");
}

#[test]
fn two_chambers_move_alike() {
    let [before, after] = designed(&two_chambers());
    let way = |x: Vec3| {
        let v = (0..before.len()).find(|&v| (before[v] - x).norm() < 1e-9).unwrap();
        after[v] - before[v]
    };
    // the middle of the end of each chamber
    let (a, b) = (way(Vec3::new(0.04, 0.02, 0.02)), way(Vec3::new(0.05, 0.02, 0.02)));
    eprintln!("{a:?} {b:?}");
    assert!(a.norm() > 1e-4 && (a.x + b.x).hypot((a - b).yz().norm()) < 0.1 * a.norm(), "{a} {b}");
}

#[test]
fn a_flat_floor_stays_flat_and_moves_along_its_plane() {
    for level in ["handles = 3", "vertices = true"] {
        let dir = kept();
        dir.write("design.toml", &dir.text("design.toml").replace("handles = 3", level));
        let [before, after] = designed(&dir);
        let mut floor: Vec<usize> = chamber().facets("cavity").unwrap().concat();
        floor.retain(|&v| (before[v].z - 0.01).abs() < 1e-9);
        assert!(floor.iter().all(|&v| after[v].z.to_bits() == before[v].z.to_bits()), "{level}");
        let way = |v: usize| -> Vec3 { after[v] - before[v] };
        let along = floor.iter().map(|&v| way(v).xy().norm()).fold(0.0, f64::max);
        let all = (0..before.len()).map(|v| way(v).z.abs()).fold(0.0, f64::max);
        assert!(along > 1e-5 && all > 1e-4, "{level}: floor {along} m, others {all} m");
    }
}
