//! What is timed: a bar of ours at a series of sizes, and published bodies.

use anyhow::{Result, bail};
use mesh::io::write_tets;
use solver::body::Body;
use solver::scene::Scene;
use tests::published::{WORM_CHAMBERS, gripper, worm};
use tests::workdir::Workdir;
use tests::{block, tag};

/// Cells through the wall of the bars, from 18 000 to 470 000 degrees of freedom.
pub const BARS: [usize; 5] = [2, 3, 4, 5, 6];

/// The silicone of the authors' frog, finger and gripper.
const SILICONE: &str = "kind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6";
/// That of their worm.
const WORM_SILICONE: &str = "kind = \"mooney-rivlin\"\nc1 = 50e3\nc2 = 8e3\nc3 = 1e3\nd1 = 1320132";

/// A body and a scene on it, named `<body>-p<degree>`, where the body is
/// `bar<cells in the wall>`, `gripper` or `worm`. None, with a printed reason,
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
            let Some(cells) = which.strip_prefix("bar") else { bail!("no body {which:?}") };
            let text = settings(degree, SILICONE, "end", &["cavity".into()], 10e3);
            (Some(bar(cells.parse()?)), text)
        }
    };
    let Some(body) = body else { return Ok(None) };
    // the way of the programs, so that what is timed is what they run
    let folder = Workdir::new();
    write_tets(&folder.path("body.msh"), &body.mesh, &body.tags)?;
    folder.write("sim.toml", &text);
    Scene::read(&folder.path("sim.toml"), None).map(Some)
}

/// A scene file that reaches its full load in one step if it can, as the
/// independent solver does.
fn settings(degree: &str, law: &str, fixed: &str, chambers: &[String], pressure: f64) -> String {
    let mut text = format!(
        "mesh = \"body.msh\"\ndegree = {degree}\n[solver]\nfirst_load_step = 1.0\n\
         [material]\n{law}\n[[fixed]]\non = \"{fixed}\"\n"
    );
    for chamber in chambers {
        text += &format!("[[pressure]]\non = \"{chamber}\"\npressure = {pressure}\n");
    }
    text
}

/// 70 × 40 × 40 mm with a closed cavity of 50 × 20 × 20 mm: walls of 10 mm with
/// `cells` cells through them, of six tetrahedra each.
fn bar(cells: usize) -> Body {
    let hole = |i: usize, last: usize| i >= cells && i < last * cells;
    let mesh = block(
        [7 * cells, 4 * cells, 4 * cells],
        0.01 / cells as f64,
        |c| hole(c[0], 6) && hole(c[1], 3) && hole(c[2], 3),
        |p| p,
    );
    let inside = |x: f64, last: f64| x > 0.009 && x < last;
    tag(
        mesh,
        &[
            ("end", &|p| p.x < 1e-6),
            ("cavity", &|p| inside(p.x, 0.061) && inside(p.y, 0.031) && inside(p.z, 0.031)),
        ],
    )
}
