//! Every shell comes off.
//!
//! The shells are taken away in the reverse order of the report. Each is moved
//! along its direction; it must not touch the shells that are still there, and
//! what it presses into the silicone is reported: silicone gives way and can be
//! peeled out, so that an undercut is a warning.

use super::set::{Body, Set};
use super::{Line, Status};

/// Distances by which a shell is moved [mm].
const PULLS: [f64; 4] = [0.25, 1.0, 4.0, 16.0];

/// Undercuts above this part of the silicone are pointed out: a judgement, not a
/// measurement.
const UNDERCUT: f64 = 0.01;

/// All checks of demolding.
pub fn checks(set: &Set) -> Vec<Line> {
    let mut lines = Vec::new();
    for (i, shell) in set.shells.iter().enumerate().rev() {
        lines.push(comes_off(set, shell, &set.shells[..i]));
        lines.push(undercut(set, shell));
    }
    lines
}

/// Largest volume that a moving shell shares with others [mm³].
fn pressed(shell: &Body, others: &[&Body]) -> f64 {
    let shared = |distance: f64| {
        let moved = shell.solid.translate(&(shell.leaves * distance));
        others.iter().map(|other| moved.intersection(&other.solid).volume()).sum::<f64>()
    };
    PULLS.iter().map(|&d| shared(d)).fold(0.0, f64::max)
}

fn comes_off(set: &Set, shell: &Body, left: &[Body]) -> Line {
    let left: Vec<&Body> = left.iter().collect();
    let area = shell.area + left.iter().map(|body| body.area).sum::<f64>();
    let name = format!("{}: comes off", shell.name);
    Line::at_most(name, pressed(shell, &left), set.volume_rounding(area), "mm³")
}

fn undercut(set: &Set, shell: &Body) -> Line {
    let silicone: Vec<&Body> = set.cores.iter().chain([&set.cast]).collect();
    let volume: f64 = silicone.iter().map(|body| body.volume).sum();
    let part = pressed(shell, &silicone) / volume;
    let name = format!("{}: undercut", shell.name);
    let mut line = Line::at_most(name, 100.0 * part, 100.0 * UNDERCUT, "% of the part");
    if line.status == Status::Fail {
        line.status = Status::Warn;
    }
    line
}
