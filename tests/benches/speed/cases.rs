//! What is timed: a bar of ours at a series of sizes, and published bodies.

use anyhow::{Result, bail};
use mechanics::body::Body;
use mesh::Vec3;
use scene::Scene;
use tests::published::{WORM_CHAMBERS, gripper, worm};
use tests::workdir::Workdir;
use tests::{block, tag};

/// Bars by their names: cells through the wall, across the chamber, and along the
/// bar, so that cells are nearly cubes.
const BARS: [(&str, [usize; 3]); 4] = [
    ("bar20k", [1, 4, 24]),
    ("bar60k", [2, 5, 36]),
    ("bar100k", [2, 7, 48]),
    ("bar250k", [2, 10, 80]),
];

/// Edges of the bars [m].
const SIZE: [f64; 3] = [0.12, 0.028, 0.028];

/// The silicone of the authors' frog, finger and gripper.
const SILICONE: &str = "kind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6";
/// That of their worm.
const WORM_SILICONE: &str = "kind = \"mooney-rivlin\"\nc1 = 50e3\nc2 = 8e3\nc3 = 1e3\nd1 = 1320132";

/// A body and a scene on it, named `<body>-p<degree>`, where the body is
/// one of [`BARS`], `gripper` or `worm`. None, with a printed reason,
/// where a published body is not at hand.
pub fn scene(name: &str) -> Result<Option<Scene>> {
    let Some((which, degree)) = name.split_once("-p") else { bail!("no degree in {name:?}") };
    let (body, text) = match which {
        "gripper" => (gripper(), settings(degree, SILICONE, "fixed", &["cavity".into()], 5e3)),
        "worm" => {
            let chambers = WORM_CHAMBERS.map(|id| format!("chamber {id}"));
            (worm(), settings(degree, WORM_SILICONE, "end", &chambers, 5e3))
        }
        _ => {
            let Some((_, cells)) = BARS.into_iter().find(|b| b.0 == which) else {
                bail!("no body {which:?}")
            };
            let text = settings(degree, SILICONE, "end", &["cavity".into()], 10e3);
            (Some(bar(cells)), text)
        }
    };
    let Some(body) = body else { return Ok(None) };
    // the way of the programs, so that what is timed is what they run
    let folder = Workdir::with(&body);
    folder.write("sim.toml", &text);
    Scene::read(&folder.path("sim.toml")).map(Some)
}

/// A scene file that reaches its full load in one step if it can, as the
/// independent solver does.
fn settings(degree: &str, law: &str, fixed: &str, chambers: &[String], pressure: f64) -> String {
    let mut text = format!(
        "mesh = \"body.msh\"\ndegree = {degree}\n[solver]\nfirst_load_step = 1.0\n\
         [material]\n{law}\n[[fixed]]\non = \"{fixed}\"\n"
    );
    for chamber in chambers {
        text += &format!("[[chamber]]\non = \"{chamber}\"\npressure = {pressure}\n");
    }
    text
}

/// 120 × 28 × 28 mm with walls of 5 mm around a closed chamber, in cubes of six
/// tetrahedra.
fn bar([wall, core, length]: [usize; 3]) -> Body {
    const THICKNESS: f64 = 5e-3;
    let side = 2 * wall + core;
    let hole = |i: usize, n: usize| i >= wall && i < n - wall;
    let cells = [length, side, side];
    // cells of the walls and of what is between them differ in size
    let along = |i: f64, n: usize, size: f64| {
        let (w, n) = (wall as f64, n as f64);
        let between = (size - 2.0 * THICKNESS) / (n - 2.0 * w);
        let in_walls = i.min(w) + (i - (n - w)).max(0.0);
        in_walls * THICKNESS / w + (i - in_walls) * between
    };
    let mesh = block(
        cells,
        1.0,
        |c| (0..3).all(|k| hole(c[k], cells[k])),
        |p| Vec3::from_fn(|k, _| along(p[k], cells[k], SIZE[k])),
    );
    let inside = |p: Vec3, k: usize| p[k] > THICKNESS - 1e-6 && p[k] < SIZE[k] - THICKNESS + 1e-6;
    tag(mesh, &[("end", &|p| p.x < 1e-6), ("cavity", &|p| (0..3).all(|k| inside(p, k)))])
}
