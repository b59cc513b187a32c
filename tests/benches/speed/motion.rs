//! Runs of several steps, by the programs as users run them: first steps of published
//! scenes, and a finger of ours.

use std::time::Duration;

use criterion::Throughput;
use tests::published::FOLDER;
use tests::shared;
use tests::workdir::Workdir;

use crate::{Bench, finger};

struct Case {
    body: &'static str,
    steps: usize,
    /// Writes `scene/sim.toml` into a folder; false where a published scene is not at hand.
    write: fn(&Workdir) -> bool,
}

const CASES: [Case; 3] = [
    Case {
        body: "gripper",
        steps: 3,
        write: |dir| import(dir, "gripper_bellows/state_gripper_bellows.json"),
    },
    Case { body: "worm", steps: 5, write: |dir| import(dir, "worm/state_worm.json") },
    Case { body: "finger", steps: finger::STEPS, write: finger::write },
];

/// All that is asked for, without the time to read and write files.
pub fn time(bench: &mut Bench) {
    for Case { body, steps, write } in &CASES {
        let dir = Workdir::new();
        if !bench.wants("motion", body) || !write(&dir) {
            continue;
        }
        let run = format!("simulate scene/sim.toml -o out --final-only --steps {steps}");
        let seconds = || dir.report(&run)["equilibrium_s"].as_f64().expect("a time");
        bench.group(["motion", body], Throughput::Elements(*steps as u64), |group| {
            group.bench_function(*body, |b| {
                b.iter_custom(|times| Duration::from_secs_f64((0..times).map(|_| seconds()).sum()));
            });
        });
    }
}

/// A published scene, to the tolerance of PolyFEM's runs.
fn import(dir: &Workdir, scene: &str) -> bool {
    let Some(path) = shared(&format!("{FOLDER}/{scene}")) else { return false };
    dir.solver(&format!("import {} -o scene", path.display())).assert_good();
    dir.write("scene/sim.toml", &(dir.text("scene/sim.toml") + TOLERANCE));
    true
}

const TOLERANCE: &str = "\n[solver]\nrelative_tolerance = 1e-7\n";
