//! `[[shape.symmetric]]`: tags of a whole body that move alike.

use mesh::bvh::SurfaceBvh;
use mesh::io::{read_tets, write_surface, write_tets};
use mesh::{Vec3, topology};
use tests::chamber::{DESIGN, refined, workdir};
use tests::workdir::Workdir;
use tests::{block, plate, tag};

/// The chamber is its own mirror image.
pub const OWN: &str =
    "[[shape.symmetric]]\nof = \"cavity\"\nmirror = { axis = \"y\", at = 0.02 }\n";

/// A design of the chamber with what [`OWN`] may stand for, on a target that is higher on one side.
pub fn folder(symmetric: &str) -> Workdir {
    let dir = workdir();
    let mut target = plate([-0.02, 0.07], [-0.02, 0.07], 0.0);
    target.vertices.iter_mut().for_each(|x| x.z = 0.0405 + 0.1 * (x.y - 0.02));
    write_surface(&dir.path("target.stl"), &target).unwrap();
    let (first, rest) = DESIGN.split_once("[[shape.level]]").unwrap();
    let (_, terms) = rest.split_once("[[objective]]").unwrap();
    let level = "[[shape.level]]\nhandles = 4\niterations = 4\n";
    let design =
        format!("{first}surface_tolerance = 0\n\n{symmetric}\n{level}\n[[objective]]{terms}");
    dir.write("design.toml", &design.replace("sim.toml", "p1.toml"));
    dir
}

/// How far a chamber is from its mirror image, and how far it has moved [m].
fn off(dir: &Workdir) -> (f64, f64) {
    let before = read_tets(&dir.path("body.msh")).unwrap();
    let after = read_tets(&dir.path("out/design.msh")).unwrap().mesh.vertices;
    let facets = refined(2).facets("cavity").unwrap();
    let (surface, ids) = topology::submesh(&after, &facets);
    let tree = SurfaceBvh::new(&surface);
    let mirrored = surface.vertices.iter().map(|x| Vec3::new(x.x, 0.04 - x.y, x.z));
    let off = mirrored.map(|x| tree.closest(&x).distance).fold(0.0, f64::max);
    let way = |v: &usize| (after[*v] - before.mesh.vertices[*v]).norm();
    (off, ids.iter().map(way).fold(0.0, f64::max))
}

/// Triangles of the chamber are mirror images of each other, so that the shape is its own image to rounding.
#[test]
fn a_symmetric_body_stays_symmetric_with_an_unsymmetric_target() {
    let body = refined(2);
    let run = |symmetric: &str| {
        let dir = folder(symmetric);
        write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
        dir.solver("optimize design.toml -o out").assert_good();
        off(&dir)
    };
    let ((with, moved), (without, all)) = (run(OWN), run(""));
    eprintln!("off by {with:e} of {moved:e} m; without the table {without:e} of {all:e} m");
    assert!(moved > 1e-3 && with < 1e-9 * moved, "{with} {moved}");
    assert!(without > 0.3 * all, "{without} {all}");
}

/// A bar of 90 mm with a chamber in each end, both open to the end, as images of each other.
pub fn two_chambers() -> Workdir {
    let dir = folder(
        "[[shape.symmetric]]\nof = [\"cavity\", \"other\"]\nmirror = { axis = \"x\", at = 0.045 }\n",
    );
    let middle = |i: usize| (1..3).contains(&i);
    let hollow = |c: [usize; 3]| c[0] != 4 && middle(c[1]) && middle(c[2]);
    let mesh = block([9, 4, 4], 0.01, hollow, |p| p);
    let inner = |x: f64| x > 0.009 && x < 0.031;
    let body = tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6 || p.x > 0.09 - 1e-6),
            ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
            ("other", &|p| p.x > 0.049 && inner(p.y) && inner(p.z)),
            ("top", &|p| p.z > 0.04 - 1e-6),
            ("skin", &|_| true),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let design = dir.text("design.toml");
    dir.write(
        "design.toml",
        &design.replacen("on = \"cavity\"", "on = [\"cavity\", \"other\"]", 1),
    );
    dir
}

#[test]
pub fn two_chambers_move_alike() {
    let dir = two_chambers();
    dir.solver("optimize design.toml -o out").assert_good();
    let before = read_tets(&dir.path("body.msh")).unwrap().mesh.vertices;
    let after = read_tets(&dir.path("out/design.msh")).unwrap().mesh.vertices;
    let way = |x: Vec3| {
        let v = (0..before.len()).find(|&v| (before[v] - x).norm() < 1e-9).unwrap();
        after[v] - before[v]
    };
    // the middle of the end of each chamber
    let (a, b) = (way(Vec3::new(0.04, 0.02, 0.02)), way(Vec3::new(0.05, 0.02, 0.02)));
    eprintln!("{a:?} {b:?}");
    assert!(a.norm() > 1e-4 && (a.x + b.x).hypot((a - b).yz().norm()) < 0.1 * a.norm(), "{a} {b}");
}
