//! CalculiX, where it is installed.

use std::path::Path;
use std::process::Command;

/// The program.
const CCX: &str = "ccx";

/// Whether CalculiX is on this machine.
#[must_use]
pub fn is_installed() -> bool {
    Command::new(CCX).arg("-v").output().is_ok()
}

/// Runs `DIR/NAME.inp`; the result is the displacement of all nodes at the end [m].
///
/// # Panics
/// When it cannot be run, or does not reach the end of its step.
#[must_use]
pub fn displacement(folder: &Path, name: &str) -> Vec<[f64; 3]> {
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

/// The largest difference of displacements, over the largest of the second ones.
///
/// # Panics
/// When they are not of the same nodes.
#[must_use]
pub fn apart(ours: &[[f64; 3]], theirs: &[[f64; 3]]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let norm = |u: [f64; 3]| u.iter().map(|u| u * u).sum::<f64>().sqrt();
    let largest = theirs.iter().map(|u| norm(*u)).fold(0.0, f64::max);
    let both = ours.iter().zip(theirs);
    both.map(|(a, b)| norm(std::array::from_fn(|k| a[k] - b[k]))).fold(0.0, f64::max) / largest
}
