//! CalculiX, where it is installed.

use std::path::Path;
use std::process::Command;

use mesh::Vec3;
use mesh::io::npy;

use crate::workdir::Workdir;

/// The program.
const CCX: &str = "ccx";

/// Whether CalculiX is on this machine.
pub fn is_installed() -> bool {
    Command::new(CCX).arg("-v").output().is_ok()
}

/// Runs `DIR/NAME.inp` to the end of its step, and returns the displacement of all nodes there [m].
fn displacement(folder: &Path, name: &str) -> Vec<[f64; 3]> {
    let run = Command::new(CCX).arg(name).current_dir(folder).output().expect("ccx starts");
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && !said.contains("*ERROR"), "{said}");
    let table = std::fs::read_to_string(folder.join(format!("{name}.dat"))).expect("displacements");
    let (_, last) = table.rsplit_once("displacements").expect("a block of displacements");
    let mut lines = last.lines();
    let time = lines.next().and_then(|line| line.split_whitespace().last()).expect("a time");
    assert!((time.parse::<f64>().expect("a time") - 1.0).abs() < 1e-9, "ended at {time}");
    let row = |line: &str| {
        let mut numbers = line
            .split_whitespace()
            .skip(1)
            .map(|text| 1e-3 * text.parse::<f64>().expect("a number"));
        std::array::from_fn(|_| numbers.next().expect("three numbers"))
    };
    lines.filter(|line| !line.trim().is_empty()).map(row).collect()
}

/// The largest difference of any node between the deck `NAME.inp` in a folder, which is run, and the result of `solver
/// simulate` in `RESULT` there, over the largest displacement.
pub fn apart(dir: &Workdir, name: &str, result: &str) -> f64 {
    let theirs = displacement(&dir.path(""), name);
    let (ours, _) =
        npy::read_f64(&dir.path(&format!("{result}/displacement.npy"))).expect("a result");
    assert_eq!(ours.len(), 3 * theirs.len());
    let ours = ours.chunks_exact(3).map(Vec3::from_column_slice);
    let both = ours.zip(theirs.into_iter().map(Vec3::from));
    let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
    for (ours, theirs) in both {
        apart = apart.max((ours - theirs).norm());
        largest = largest.max(ours.norm());
    }
    apart / largest
}
