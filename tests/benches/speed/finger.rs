//! A finger of ours that bends onto a rod and presses on it, with friction.

use mechanics::body::Body;
use mesh::io::write_surface;
use mesh::{SurfaceMesh, Vec3};
use tests::workdir::Workdir;
use tests::{block, tag};

/// Time steps of 10 ms.
pub const STEPS: usize = 50;

/// Edge of a cube of six tetrahedra [m]; cubes along the finger, across it and in height.
const EDGE: f64 = 1.0 / 300.0;
const CELLS: [usize; 3] = [30, 6, 6];

/// Centre of the rod, in x and z, and its radius [m]; it begins 2 mm below the finger.
const ROD: [f64; 3] = [0.08, -0.010, 0.008];
/// Edges of its circle.
const ROUND: usize = 48;

/// Writes `scene/sim.toml` and its meshes.
pub fn write(dir: &Workdir) -> bool {
    std::fs::create_dir(dir.path("scene")).expect("an empty folder");
    dir.put("scene/finger.msh", &finger());
    write_surface(&dir.path("scene/rod.stl"), &rod()).expect("a sound rod");
    let end = 0.01 * STEPS as f64;
    let text = format!(
        "mesh = \"finger.msh\"\ndegree = 2\n\
         [material]\nkind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6\ndensity = 1000\n\
         [[fixed]]\non = \"seat\"\n\
         [[obstacle]]\nname = \"rod\"\nsurface = \"rod.stl\"\n\
         [contact]\nactivation = 2e-4\nstiffness = 1e5\nfriction = 0.5\n\
         [[chamber]]\non = \"cavity\"\npressure = \"{PRESSURE:e}*t/{end}\"\n\
         [time]\nend = {end}\nsteps = {STEPS}\nmethod = \"implicit-euler\"\n"
    );
    dir.write("scene/sim.toml", &text);
    true
}

/// At the end [Pa].
const PRESSURE: f64 = 40e3;

/// 100 × 20 × 20 mm with a closed chamber near its upper face: it bends down.
fn finger() -> Body {
    let hole = |c: [usize; 3]| {
        (1..CELLS[0] - 1).contains(&c[0]) && (1..5).contains(&c[1]) && (3..5).contains(&c[2])
    };
    let mesh = block(CELLS, EDGE, hole, |p| p);
    let inside = |p: Vec3| (0..3).all(|k| p[k] > 1e-6 && p[k] < EDGE * CELLS[k] as f64 - 1e-6);
    tag(mesh, &[("seat", &|p| p.x < 1e-6), ("cavity", &inside), ("skin", &|_| true)])
}

/// A tube along y, wider than the finger.
fn rod() -> SurfaceMesh {
    let [x, z, radius] = ROD;
    let point = |i: usize| {
        let angle = std::f64::consts::TAU * (i / 2) as f64 / ROUND as f64;
        let y = if i.is_multiple_of(2) { -0.01 } else { 0.03 };
        Vec3::new(x + radius * angle.cos(), y, z + radius * angle.sin())
    };
    let n = 2 * ROUND;
    let square = |i: usize| [[i, (i + 2) % n, i + 1], [(i + 2) % n, (i + 3) % n, i + 1]];
    SurfaceMesh {
        vertices: (0..n).map(point).collect(),
        triangles: (0..n).step_by(2).flat_map(square).collect(),
    }
}
