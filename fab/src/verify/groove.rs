//! The thread fits into its groove, and the ridge leaves it.
//!
//! The written casting is probed by rays where the report says that the thread runs: across the groove at four fifths
//! of its depth, and from its middle to its bottom and on through the wall. The ridge of a shell is what it has
//! within the groove; moved along its demolding direction, it must not share a volume with the casting.

use geometry::MM;
use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::solid::Solid;
use rayon::prelude::*;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::body::groove::{Groove, Station};
use crate::files::report::MoldReport;
use crate::mold::Purpose;

/// Distances by which a ridge is moved, over the depth of the groove: until it has left it along the surface, too [1].
const PULLS: [f64; 6] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0];

/// Where the width is measured, in parts of the depth.
const WIDTH_AT: f64 = 0.8;

/// Least part of the depth that a groove must have: facets are flat, and the casting is round [1].
const DEEP: f64 = 0.9;

/// All checks of a groove.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let Some(groove) = &mold.report.groove else { return Vec::new() };
    let cast = SurfaceBvh::new(&mold.cast.solid.to_surface());
    let places: Vec<Station> = groove.courses.iter().flat_map(|c| middles(c)).collect();
    let probes: Vec<Probe> = places.par_iter().map(|at| Probe::new(groove, at, &cast)).collect();
    let at_least = |name: &str, of: fn(&Probe) -> f64, needed: f64| {
        let narrowest = probes.iter().min_by(|a, b| of(a).total_cmp(&of(b)));
        narrowest.map(|probe| Line::at_least(name, of(probe), needed, "mm").placed(&probe.at))
    };
    let wall = mold.report.casting.least_wall * MM - 2.0 * mold.rounding;
    let width = groove.thread - 2.0 * mold.rounding;
    let mut lines: Vec<Line> = [
        at_least("groove: width", |probe| probe.width, width),
        at_least("groove: depth", |probe| probe.depth, DEEP * groove.depth),
        at_least("groove: silicone below", |probe| probe.below, wall),
    ]
    .into_iter()
    .flatten()
    .collect();
    let solid = groove.solid();
    for shell in &mold.shells {
        let ridge = shell.solid.intersection(&solid);
        let limit = mold.volume_rounding(ridge.area());
        let pressed = PULLS.into_iter().map(|part| {
            let moved = ridge.translate(&(shell.demolding * (part * groove.depth)));
            moved.intersection(&mold.cast.solid).volume()
        });
        let name = format!("groove: ridge leaves {}", shell.name);
        lines.push(Line::at_most(name, pressed.fold(0.0, f64::max), limit, "mm³"));
    }
    lines.push(pins(mold, &solid));
    lines.push(guides(groove));
    lines.extend(printed(&mold.report, groove));
    lines
}

/// Half-way between stations where the groove has its whole depth.
fn middles(course: &[Station]) -> Vec<Station> {
    let whole = |pair: &&[Station]| pair[0].depth == pair[1].depth;
    let middle = |pair: &[Station]| {
        let mean = |a: &[f64; 3], b: &[f64; 3]| (Vec3::from(*a) + Vec3::from(*b)) / 2.0;
        let [a, b] = [&pair[0], &pair[1]];
        let along = mean(&a.along, &b.along).normalize();
        let normal = mean(&a.normal, &b.normal);
        let normal = (normal - along * normal.dot(&along)).normalize().into();
        Station { at: mean(&a.at, &b.at).into(), normal, along: along.into(), ..a.clone() }
    };
    course.windows(2).filter(whole).map(middle).collect()
}

/// What rays find at a place of a groove [mm].
struct Probe {
    at: Vec3,
    width: f64,
    depth: f64,
    /// Silicone below its bottom.
    below: f64,
}

impl Probe {
    fn new(groove: &Groove, at: &Station, cast: &SurfaceBvh) -> Self {
        let low = at.place(-WIDTH_AT * at.depth, 0.0);
        let beside = |way: Vec3| cast.ray(&low, &way).first().map_or(f64::INFINITY, |hit| hit.0);
        let from = at.place(-at.depth / 2.0, 0.0);
        let down: Vec<f64> =
            cast.ray(&from, &-Vec3::from(at.normal)).into_iter().map(|hit| hit.0).collect();
        let bottom = down.first().copied().unwrap_or(f64::INFINITY);
        // A ray through an edge meets both of its facets.
        let through = down.iter().find(|&&hit| hit > bottom + groove.depth / 100.0);
        Self {
            at: low,
            width: beside(at.across()) + beside(-at.across()),
            depth: at.depth / 2.0 + bottom,
            below: through.map_or(f64::INFINITY, |hit| hit - bottom),
        }
    }
}

/// Pins stand beside the groove, as the thread goes around their holes.
fn pins(mold: &ClosedMold, groove: &Solid) -> Line {
    let pins = mold.report.outlines(Purpose::Pin);
    let cut = pins.filter(|pin| !pin.exact().intersection(groove).is_empty()).count();
    let found = format!("{cut} pins in it");
    Line::new(
        "groove: pins",
        cut == 0,
        found,
        "none: core.pins gives them places, and the groove leaves them free",
    )
}

/// How much of the thread lies in the groove.
fn guides(groove: &Groove) -> Line {
    let Groove { length, wound, widened, locked, .. } = groove;
    let left_out = match locked {
        Some(by) => format!(", elsewhere it had to be {by:.2} mm wider"),
        None => String::new(),
    };
    let found = format!(
        "{:.0} % of the thread, up to {widened:.2} mm wider{left_out}",
        100.0 * length / wound
    );
    let whole = *length >= 0.999 * wound;
    Line::new("groove: guides", whole, found, "all of the thread on its tags").or_warning()
}

/// Whether the printer draws a line as narrow as the ridge.
fn printed(report: &MoldReport, groove: &Groove) -> Option<Line> {
    let nozzle = report.casting.printer()?.nozzle;
    let found = format!("{:.2} mm wide at its top", groove.width);
    let holds = groove.width >= nozzle;
    let needed = format!("at least a line of {nozzle:.2} mm");
    let mut line = Line::new("groove: ridge is printed", holds, found, &needed).or_warning();
    if !holds {
        line.needed += ", or a printer with a finer nozzle or of resin";
    }
    Some(line)
}
