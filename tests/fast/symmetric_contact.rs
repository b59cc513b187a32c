//! Contact of parts by the program: with an obstacle that crosses the plane against the whole,
//! and with the mirror image. That energies and forces are those of the whole is tested with
//! the energy.

use mesh::io::write_surface;
use mesh::{SurfaceMesh, Vec3};
use serde_json::Value;
use tests::symmetric::{difference, nodes};
use tests::workdir::Workdir;
use tests::{block, plate, tag};

/// Largest difference of displacements, relative to the largest, set before it was measured.
const SAME: f64 = 1e-9;

const CUTS: [&str; 2] =
    ["[[symmetry]]\non = \"foot.cut x\"\n", "[[symmetry]]\non = \"foot.cut y\"\n"];

/// A block of 20 × 20 × 20 mm with a rounded foot above the plane z = 0, as `quarter.msh`,
/// `half.msh`, which is cut across x, and `whole.msh`.
fn workdir() -> Workdir {
    let foot = |p: Vec3| {
        let rise = 20.0 * (p.x * p.x + 0.7 * p.y * p.y) * (1.0 - p.z / 0.02);
        Vec3::new(p.x * (1.0 + 5.0 * p.z), p.y, p.z + rise + 5e-4)
    };
    let mesh = block([2, 2, 4], 0.005, |_| false, foot);
    let body =
        tag(mesh, &[("cut x", &|p| p.x < 1e-9), ("cut y", &|p| p.y < 1e-9), ("skin", &|_| true)]);
    let dir = Workdir::new();
    dir.put("quarter.msh", &body);
    for (whole, cuts) in [("half", &["cut y"][..]), ("whole", &["cut x", "cut y"])] {
        let mut mirror = dir.command(&format!("mirror quarter.msh -o {whole}.msh"));
        cuts.iter().for_each(|cut| {
            mirror.args(["--on", *cut]);
        });
        assert!(mirror.status().unwrap().success());
    }
    let triangle = |low: f64| SurfaceMesh {
        vertices: [[low, -0.2], [0.3, -0.2], [0.0, 0.4]]
            .map(|[x, y]| Vec3::new(x, y, 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let square = |low: f64| plate([low, 0.1], [-0.1, 0.1], 0.0);
    for (name, floor) in [
        // its mesh, too, is its own mirror image across x
        ("triangle", triangle(-0.3)),
        ("half", triangle(0.0)),
        ("square", square(-0.1)),
        ("odd", square(-0.05)),
    ] {
        write_surface(&dir.path(&format!("{name}.stl")), &floor).unwrap();
    }
    dir
}

/// The block falls on a floor, with inertia and friction.
fn scene(part: &str, floor: &str, symmetry: &str) -> String {
    format!(
        "degree = 1\ngravity = [0, 0, -9.81]\n\n[[body]]\nname = \"foot\"\n\
         mesh = \"{part}.msh\"\nvelocity = [0, 0, -0.6]\n\
         material = {{ kind = \"neo-hookean\", young = 1e5, poisson = 0.4, density = 1000 }}\n\
         [[obstacle]]\nname = \"floor\"\nsurface = \"{floor}.stl\"\n{symmetry}\
         [contact]\nactivation = 4e-4\nstiffness = 1e5\nfriction = 0.5\n\
         [time]\nend = 8e-3\nsteps = 8\n"
    )
}

fn simulate(dir: &Workdir, name: &str, scene: &str) -> Value {
    dir.write(&format!("{name}.toml"), scene);
    dir.solver(&format!("simulate {name}.toml -o {name}")).assert_good();
    let report = dir.json(&format!("{name}/report.json"));
    report["steps"].as_array().unwrap().last().unwrap()["collisions"].clone()
}

/// Upward force between the first two surfaces that touch [N].
fn force(collisions: &Value) -> f64 {
    collisions["contact"][0]["force"][2].as_f64().unwrap()
}

#[test]
fn parts_fall_as_the_whole() {
    let dir = workdir();
    let whole = simulate(&dir, "whole", &scene("whole", "triangle", ""));
    assert!(force(&whole) > 0.01);
    let half = simulate(&dir, "half", &scene("half", "triangle", CUTS[0]));
    let off = difference(&nodes(&dir, "half"), &nodes(&dir, "whole"));
    assert!(off < SAME, "{off}");
    assert!((2.0 * force(&half) / force(&whole) - 1.0).abs() < 1e-8);
    // of the floor on one side the other side is its image; the edge in the plane is one more feature of the floor
    let part = simulate(&dir, "part", &scene("half", "half", CUTS[0]));
    assert!((2.0 * force(&part) / force(&whole) - 1.0).abs() < 0.3);
}

#[test]
fn obstacles_that_are_not_symmetric_are_refused() {
    let dir = workdir();
    let refuse = |scene: &str, words: &[&str]| {
        dir.write("sim.toml", scene);
        dir.solver("simulate sim.toml -o out").assert_refused(2, words);
    };
    let cuts = CUTS.concat();
    let words = ["[[obstacle]] \"floor\"", "both sides", "x = 0.000000 m", "5.000e-2 m off"];
    refuse(&scene("quarter", "odd", &cuts), &words);
    let moving = format!("displacement = [0, \"1e-3*t\", 0]\n{}", CUTS[1]);
    refuse(&scene("quarter", "square", &moving), &["moves by 8.000e-6 m along y", "t = 0.008"]);
    let thrown = scene("quarter", "square", &cuts).replace("[0, 0, -0.6]", "[0.1, 0, -0.6]");
    refuse(&thrown, &["velocity of \"foot\" is 0.1 m/s along x", "x = 0.000000 m"]);
}
