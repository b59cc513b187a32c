//! Every shell can be demolded.
//!
//! The shells are taken off in the reverse order of the report, each along its demolding
//! direction. A shell must not meet the shells that are still there. This is checked in two
//! ways: by rays from its facets along the whole path, and by the volume that it shares with
//! the others at four places of the path. The volume that it presses into the silicone is an
//! undercut; it is a warning only, because silicone gives way and can be peeled out.

use mesh::bvh::SurfaceBvh;
use rayon::prelude::*;

use super::Line;
use super::closed_mold::{Body, ClosedMold};

/// Distances by which a shell is moved: from about the play of the keys to beyond keys and undercuts;
/// what lies further is found by `path` [mm].
const PULLS: [f64; 4] = [0.25, 1.0, 4.0, 16.0];

/// Undercuts above this part of the silicone are a warning: a judgement, not a
/// measurement.
const UNDERCUT: f64 = 0.01;

/// Facets whose normal is nearer than this to being across the pull slide along it: the
/// sine of half a degree.
const SLIDING: f64 = 9e-3;

/// Area that may seem blocked, from rays along common edges, as a part of the area that faces
/// the demolding direction.
const BLOCKED: f64 = 1e-4;

/// All checks of demolding.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let mut lines = Vec::new();
    for (i, shell) in mold.shells.iter().enumerate().rev() {
        lines.push(comes_off(mold, shell, &mold.shells[..i]));
        lines.push(path(mold, shell, &mold.shells[..i]));
        lines.push(undercut(mold, shell));
    }
    lines
}

/// Largest volume that a moving shell shares with others [mm³].
fn pressed(shell: &Body, others: &[&Body]) -> f64 {
    let shared = |distance: f64| {
        let moved = shell.solid.translate(&(shell.demolding * distance));
        others.iter().map(|other| moved.intersection(&other.solid).volume()).sum::<f64>()
    };
    PULLS.iter().map(|&d| shared(d)).fold(0.0, f64::max)
}

fn comes_off(mold: &ClosedMold, shell: &Body, left: &[Body]) -> Line {
    let left: Vec<&Body> = left.iter().collect();
    let area = shell.area + left.iter().map(|body| body.area).sum::<f64>();
    let name = format!("{}: comes off", shell.name);
    Line::at_most(name, pressed(shell, &left), mold.volume_rounding(area), "mm³")
}

/// Nothing lies in the path of the shell, however far.
fn path(mold: &ClosedMold, shell: &Body, left: &[Body]) -> Line {
    let surface = shell.solid.to_surface();
    let others: Vec<SurfaceBvh> =
        left.iter().map(|body| SurfaceBvh::new(&body.solid.to_surface())).collect();
    let seen = |t: usize| {
        let toward = surface.normal(t).dot(&shell.demolding);
        if toward < SLIDING {
            return [0.0; 2];
        }
        let area = surface.area(t) * toward;
        let from = surface.centroid(t);
        // What is left behind at once only touches.
        let meets = |other: &SurfaceBvh| {
            other.ray(&from, &shell.demolding).iter().any(|hit| hit.0 > 2.0 * mold.rounding)
        };
        [area, if others.iter().any(meets) { area } else { 0.0 }]
    };
    let areas = (0..surface.triangles.len()).into_par_iter().map(seen).collect::<Vec<_>>();
    let [all, blocked] = areas.iter().fold([0.0; 2], |sum, a| [sum[0] + a[0], sum[1] + a[1]]);
    let name = format!("{}: path", shell.name);
    Line::at_most(name, blocked, BLOCKED * all, "mm² blocked")
}

fn undercut(mold: &ClosedMold, shell: &Body) -> Line {
    let silicone: Vec<&Body> = mold.cores.iter().chain([&mold.cast]).collect();
    let volume: f64 = silicone.iter().map(|body| body.volume).sum();
    let part = pressed(shell, &silicone) / volume;
    let name = format!("{}: undercut", shell.name);
    Line::at_most(name, 100.0 * part, 100.0 * UNDERCUT, "% of the part").or_warning()
}
