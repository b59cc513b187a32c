//! Contact of a body with its mirror image, and of a part with obstacles, against the whole.

use mesh::io::{write_surface, write_tets};
use mesh::{SurfaceMesh, Vec3};
use tests::symmetric::{difference, nodes};
use tests::workdir::Workdir;
use tests::{block, tag};

/// Largest difference of displacements, relative to the largest, set before it was measured.
const SAME: f64 = 1e-9;

const MATERIAL: &str = r#"
[solver]
relative_tolerance = 1e-12

"#;

/// Where the plane across x is [m].
const LEVEL: f64 = 0.004;

/// Half of a U of 40 × 10 × 30 mm, cut at x = 4 mm. The upper end of its arm is 0.6 mm from
/// the plane. Tags: `cut`, `seat` at the bottom, `outside` of the arm, `skin`.
fn half_of_a_u(dir: &Workdir) {
    let lean = |p: Vec3| {
        let rise = (p.z - 0.01).max(0.0);
        Vec3::new(p.x * (1.0 + 3.0 * p.y) - 0.47 * rise * (p.x / 0.01).min(1.0) + LEVEL, p.y, p.z)
    };
    let mesh = block([4, 2, 6], 0.005, |c| c[0] < 2 && c[2] > 1, lean);
    let body = tag(
        mesh,
        &[
            ("cut", &|p| p.x < LEVEL + 1e-9),
            ("seat", &|p| p.z < 1e-9),
            ("outside", &|p| {
                p.z > 0.01
                    && p.z < 0.03 - 1e-9
                    && p.x > LEVEL + 0.0115
                    && p.y > 1e-9
                    && p.y < 0.01 - 1e-9
            }),
            ("skin", &|_| true),
        ],
    );
    write_tets(&dir.path("half.msh"), &body.mesh, &body.tags).unwrap();
    dir.solver("mirror half.msh --on cut -o whole.msh").assert_good();
}

/// The arms of a U are pressed together: each touches its image, with friction from the
/// second step on.
#[test]
fn an_arm_touches_its_mirror_image() {
    for degree in [1, 2] {
        let dir = Workdir::new();
        half_of_a_u(&dir);
        let scene = |part: &str, symmetry: &str| {
            format!(
                "mesh = \"{part}.msh\"\ndegree = {degree}\n{MATERIAL}\n\
                 [material]\nkind = \"neo-hookean\"\nyoung = 1e5\npoisson = 0.4\n\
                 [[fixed]]\non = \"seat\"\n{symmetry}\
                 [[traction]]\non = \"outside\"\n\
                 traction = [\"if(x - {LEVEL}, -1, 1)*6e3*t\", 0, \"2e3*t\"]\n\
                 [contact]\nactivation = 4e-4\nstiffness = 1e5\nfriction = 0.3\n\
                 [time]\nend = 1\nsteps = 4\nmethod = \"quasistatic\"\n"
            )
        };
        dir.write("whole.toml", &scene("whole", ""));
        dir.write("half.toml", &scene("half", "[[symmetry]]\non = \"cut\"\n"));
        for part in ["whole", "half"] {
            dir.solver(&format!("simulate {part}.toml -o {part}")).assert_good();
        }
        let off = difference(&nodes(&dir, "half"), &nodes(&dir, "whole"));
        let [half, whole] = ["half", "whole"].map(|part| dir.json(&format!("{part}/report.json")));
        let last = |report: &serde_json::Value| report["steps"][3]["collisions"].clone();
        println!("degree {degree}: {off:.1e}, {}, {}", last(&half), last(&whole));
        assert!(last(&whole)["smallest_gap"].as_f64().unwrap() < 0.9);
        assert_eq!(last(&half)["pairs"], last(&whole)["pairs"]);
        assert!(off < SAME, "{degree} {off}");
    }
}

/// A quarter of a block with a rounded foot falls on a floor, with inertia and friction.
#[test]
fn a_quarter_falls_as_the_whole() {
    let dir = Workdir::new();
    let foot = |p: Vec3| {
        let rise = 20.0 * (p.x * p.x + 0.7 * p.y * p.y) * (1.0 - p.z / 0.02);
        Vec3::new(p.x * (1.0 + 5.0 * p.z), p.y, p.z + rise + 5e-4)
    };
    let mesh = block([2, 2, 4], 0.005, |_| false, foot);
    let body =
        tag(mesh, &[("cut x", &|p| p.x < 1e-9), ("cut y", &|p| p.y < 1e-9), ("skin", &|_| true)]);
    write_tets(&dir.path("quarter.msh"), &body.mesh, &body.tags).unwrap();
    let mut mirror = dir.command("mirror quarter.msh -o whole.msh");
    mirror.args(["--on", "cut x", "--on", "cut y"]);
    assert!(mirror.status().unwrap().success());
    let floor = |x: [f64; 2], y: [f64; 2]| SurfaceMesh {
        vertices: [[0, 0], [1, 0], [1, 1], [0, 1]]
            .map(|[i, j]| Vec3::new(x[i], y[j], 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let (all, right) = ([-0.1, 0.1], [0.0, 0.1]);
    write_surface(&dir.path("floor.stl"), &floor(all, all)).unwrap();
    write_surface(&dir.path("half-floor.stl"), &floor(right, all)).unwrap();
    write_surface(&dir.path("odd-floor.stl"), &floor([-0.05, 0.1], all)).unwrap();
    let scene = |part: &str, floor: &str, symmetry: &str| {
        format!(
            "gravity = [0, 0, -9.81]\n{MATERIAL}\n[[body]]\nname = \"foot\"\n\
             mesh = \"{part}.msh\"\nvelocity = [0, 0, -0.6]\n\
             material = {{ kind = \"neo-hookean\", young = 1e5, poisson = 0.4, density = 1000 }}\n\
             [[obstacle]]\nname = \"floor\"\nsurface = \"{floor}.stl\"\n{symmetry}\
             [contact]\nactivation = 4e-4\nstiffness = 1e5\nfriction = 0.5\n\
             [time]\nend = 8e-3\nsteps = 8\n"
        )
        .replacen("gravity", "degree = 1\ngravity", 1)
    };
    let cuts = "[[symmetry]]\non = \"foot.cut x\"\n[[symmetry]]\non = \"foot.cut y\"\n";
    dir.write("whole.toml", &scene("whole", "floor", ""));
    dir.write("quarter.toml", &scene("quarter", "floor", cuts));
    dir.write("one-sided.toml", &scene("quarter", "half-floor", cuts));
    for part in ["whole", "quarter", "one-sided"] {
        dir.solver(&format!("simulate {part}.toml -o {part}")).assert_good();
    }
    let whole = nodes(&dir, "whole");
    let report = dir.json("whole/report.json");
    let force = |report: &serde_json::Value| {
        let contact = &report["steps"][7]["collisions"]["contact"];
        let floor = contact.as_array().unwrap().iter().find(|f| f["bodies"][1] == "floor").unwrap();
        floor["force"][2].as_f64().unwrap()
    };
    for part in ["quarter", "one-sided"] {
        let off = difference(&nodes(&dir, part), &whole);
        let own = dir.json(&format!("{part}/report.json"));
        println!("{part}: {off:.1e}, force {} of {}", force(&own), force(&report));
        assert!(force(&report) > 0.01);
        assert!((4.0 * force(&own) / force(&report) - 1.0).abs() < 1e-6);
        // the seam of the completed half floor is a rim, which contact weights differently
        assert!(off < SAME, "{part} {off}");
    }
    dir.write("odd.toml", &scene("quarter", "odd-floor", cuts));
    let run = dir.solver("simulate odd.toml -o odd");
    run.assert_refused(
        2,
        &["[[obstacle]] \"floor\"", "both sides", "x = 0.000000 m", "5.000e-2 m off"],
    );
    let moving = scene("quarter", "floor", cuts).replace(
        "[[symmetry]]\non = \"foot.cut y\"",
        "displacement = [0, \"1e-3*t\", 0]\n[[symmetry]]\non = \"foot.cut y\"",
    );
    let moving = moving.replacen("[[symmetry]]\non = \"foot.cut x\"\n", "", 1);
    dir.write("moving.toml", &moving);
    dir.solver("simulate moving.toml -o moving").assert_refused(2, &["moves by", "along y"]);
    let thrown = scene("quarter", "floor", cuts).replace("[0, 0, -0.6]", "[0.1, 0, -0.6]");
    dir.write("thrown.toml", &thrown);
    dir.solver("simulate thrown.toml -o out").assert_refused(2, &["velocity", "0.1 m/s along x"]);
}
