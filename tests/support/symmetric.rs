//! A body with two planes of symmetry, as its quarter, its half and the whole.

use mesh::Vec3;
use mesh::io::npy;

use crate::workdir::{Run, Workdir};
use crate::{block, tag};

/// Where the planes are: y and z [m].
pub const LEVELS: [f64; 2] = [0.003, -0.007];

/// The loads of most tests; the mesh, the degree and `[[symmetry]]` come before.
pub const LOADS: &str = r#"
[material]
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6
density = 1070

[[fixed]]
on = "seat"

[[traction]]
on = "top"
traction = [80, 0, 0]

[[body_force]]
force = [2000, 0, 0]

[solver]
relative_tolerance = 1e-12
"#;

/// Parts of the body: mesh, `[[symmetry]]` tables, and how many of it make the whole.
pub const PARTS: [(&str, &str, f64); 3] = [
    ("whole", "", 1.0),
    ("half", "[[symmetry]]\non = \"cut z\"\n", 2.0),
    ("quarter", "[[symmetry]]\non = \"cut y\"\n[[symmetry]]\non = \"cut z\"\n", 4.0),
];

/// A folder with `quarter.msh`, `half.msh` and `whole.msh`, made from the quarter by
/// `solver mirror`. The whole is about 50 × 40 × 40 mm. Tags: `seat` at x = 0, `cavity`, the
/// wall of a chamber that the planes cut, which opens to the seat if `open`, `top` on the
/// sides across z, `skin`, and the cuts.
pub fn workdir(open: bool) -> Workdir {
    let from = usize::from(!open);
    let hollow = |c: [usize; 3]| (from..4).contains(&c[0]) && c[1] == 0 && c[2] == 0;
    // not regular, and not the same along y and z
    let distort = |p: Vec3| {
        let y = p.y * (1.0 + 6.0 * p.x + 4.0 * p.z);
        let z = p.z * (1.1 - 5.0 * p.x + 3.0 * p.y);
        Vec3::new(p.x * (1.0 + 2.0 * p.z * p.x / 0.05), y + LEVELS[0], z + LEVELS[1])
    };
    let mesh = block([5, 2, 2], 0.01, hollow, distort);
    let inner = |p: Vec3| p.y < LEVELS[0] + 0.015 && p.z < LEVELS[1] + 0.012;
    let body = tag(
        mesh,
        &[
            ("cut y", &|p| p.y < LEVELS[0] + 1e-9),
            ("cut z", &|p| p.z < LEVELS[1] + 1e-9),
            ("seat", &|p| p.x < 1e-9),
            ("cavity", &|p| p.x < 0.0425 && inner(p)),
            ("top", &|p| p.z > LEVELS[1] + 0.016 && p.x < 0.049),
            ("skin", &|_| true),
        ],
    );
    let dir = Workdir::new();
    dir.put("quarter.msh", &body);
    for (part, whole, plane) in [("quarter", "half", "cut y"), ("half", "whole", "cut z")] {
        let mut command = dir.command(&format!("mirror {part}.msh -o {whole}.msh --on"));
        Run::from(command.arg(plane).output().expect("the program starts")).assert_good();
    }
    dir
}

/// Rest positions and displacements of the nodes in a folder of results [m].
pub fn nodes(dir: &Workdir, folder: &str) -> Vec<(Vec3, Vec3)> {
    let read = |name: &str| {
        let (values, _) = npy::read_f64(&dir.path(&format!("{folder}/{name}"))).expect("results");
        values.chunks_exact(3).map(Vec3::from_column_slice).collect::<Vec<_>>()
    };
    read("nodes.npy").into_iter().zip(read("displacement.npy")).collect()
}

/// For each point of a list the index of the same point in another.
pub fn find(points: &[Vec3], among: &[Vec3]) -> Vec<usize> {
    let one = |p: &Vec3| {
        let found = among.iter().position(|q| (p - q).norm() < 1e-9);
        found.unwrap_or_else(|| panic!("{p} is not there"))
    };
    points.iter().map(one).collect()
}

/// Largest difference of two displacement fields where both are known, relative to the
/// largest displacement.
pub fn difference(some: &[(Vec3, Vec3)], all: &[(Vec3, Vec3)]) -> f64 {
    let points = |nodes: &[(Vec3, Vec3)]| nodes.iter().map(|n| n.0).collect::<Vec<_>>();
    let same = find(&points(some), &points(all));
    let pairs = some.iter().zip(same).map(|((_, u), i)| (u - all[i].1).norm());
    let largest = all.iter().map(|n| n.1.norm()).fold(0.0, f64::max);
    pairs.fold(0.0, f64::max) / largest
}
