//! Every shell comes off.
//!
//! The shells are taken away in the reverse order of the report, each along its direction.
//! It must meet none of the shells that are still there, which is decided for the whole
//! way by what lies before its facets, and for four places of it by the volume that the two
//! share. What it presses into the silicone is reported: silicone gives way and can be
//! peeled out, so that an undercut is a warning.

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, measure};
use rayon::prelude::*;

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};

/// Distances by which a shell is moved: from what play lets it, to beyond keys and undercuts;
/// what lies further is found by `path` [mm].
const PULLS: [f64; 4] = [0.25, 1.0, 4.0, 16.0];

/// Undercuts above this part of the silicone are pointed out: a judgement, not a
/// measurement.
const UNDERCUT: f64 = 0.01;

/// Facets whose normal is nearer than this to being across the pull slide along it: the
/// sine of half a degree.
const SLIDING: f64 = 9e-3;

/// Area that may seem blocked, from rays along common edges, as a part of that which looks
/// along the pull.
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
    let surfaces: Vec<SurfaceMesh> = left.iter().map(|body| body.solid.to_surface()).collect();
    let others: Vec<SurfaceBvh> = surfaces.iter().map(SurfaceBvh::new).collect();
    let seen = |t: usize| {
        let [a, b, c] = surface.corners(t);
        let toward = measure::triangle_normal(a, b, c).dot(&shell.demolding);
        if toward < SLIDING {
            return [0.0; 2];
        }
        let area = measure::triangle_area(a, b, c) * toward;
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
    let mut line = Line::at_most(name, 100.0 * part, 100.0 * UNDERCUT, "% of the part");
    if line.status == Status::Fail {
        line.status = Status::Warn;
    }
    line
}
