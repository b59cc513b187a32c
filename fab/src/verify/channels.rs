//! Channels are open, cores are held, keys engage, bolts join.

use std::f64::consts::PI;

use mesh::Vec3;
use mesh::solid::Solid;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::files::report::Outline;
use crate::mold::Purpose;

/// Least part of a key's or stub's seat that must be filled: a key of 3 mm with 0.2 mm around
/// it fills 0.8; with half of it missing two pieces no longer find each other.
const FILLED: f64 = 0.5;

/// The ring around a bolt in which its pieces are looked for, in radii of its hole.
const BESIDE: f64 = 1.5;

/// Least length over which a joined piece fills that ring: two threads of an M3 nut's four; a
/// judgement [mm].
const HELD: f64 = 2.0;

/// Least depth of a channel's mouth in the body, in the mean over its section: half of what
/// channels are cut into a flat top; thinner than that a printed mold closes it [mm].
const MOUTH: f64 = 0.1;

/// All checks of features.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let mut lines = Vec::new();
    let report = &mold.report;
    for (purpose, kind) in [
        (Purpose::Sprue, "sprue"),
        (Purpose::Vent, "vent"),
        (Purpose::Key, "key"),
        (Purpose::Socket, "socket"),
        (Purpose::Bolt, "bolt"),
    ] {
        for (i, outline) in report.outlines(purpose).enumerate() {
            let name = format!("{kind} {}", i + 1);
            match purpose {
                Purpose::Key => lines.push(engaged(mold, &name, outline)),
                Purpose::Socket => lines.extend(seated(mold, &name, outline)),
                Purpose::Bolt => lines.push(joins(mold, &name, outline)),
                _ => lines.extend(open(mold, &name, outline)),
            }
        }
        if purpose == Purpose::Sprue && lines.is_empty() && !report.open {
            lines.push(Line::new("sprue", false, "0 sprues".into(), "1 sprue"));
        }
    }
    lines
}

/// A bolt passes through at least two pieces, and nothing is in its hole.
fn joins(mold: &ClosedMold, name: &str, outline: &Outline) -> Line {
    let hole = outline.exact();
    let around = Outline {
        base_radius: BESIDE * outline.base_radius,
        top_radius: BESIDE * outline.top_radius,
        ..outline.clone()
    }
    .exact();
    let shared = |solid: &Solid, with: &Solid| solid.intersection(with).volume();
    let blocked: f64 = mold.parts().map(|part| shared(&part.solid, &hole)).sum();
    let ring = PI * (BESIDE * BESIDE - 1.0) * outline.base_radius.powi(2);
    let held = |solid: &Solid| shared(solid, &around) >= HELD * ring;
    let joined: Vec<&str> =
        mold.shells.iter().filter(|s| held(&s.solid)).map(|s| s.name.as_str()).collect();
    Line::new(
        format!("{name}: joins"),
        joined.len() >= 2 && blocked <= mold.volume_rounding(hole.area()),
        format!("{}, {blocked:.1e} mm³ in the way", joined.join(" and ")),
        "two pieces, nothing in the way",
    )
}

/// A channel leads from above the mold into the body, nothing is in it, and nothing runs
/// over its rim before the body is full.
fn open(mold: &ClosedMold, name: &str, outline: &Outline) -> Vec<Line> {
    let channel = outline.exact();
    let blocked: f64 = mold.shells.iter().map(|s| s.solid.intersection(&channel).volume()).sum();
    let top = mold.bounds.1.z;
    let reaches_top = |piece: &Solid| piece.bounds().1.z >= top - mold.rounding;
    let free = mold.parts().fold(channel.clone(), |rest, part| rest.difference(&part.solid));
    let through = free.decompose().into_iter().find(reaches_top);
    let full = mold.cast.solid.bounds().1.z;
    let rim = channel.difference(&mold.outside.solid).bounds().0.z - full;
    let inside = through.map_or(0.0, |piece| piece.intersection(&mold.cast.solid).volume());
    vec![
        Line::at_most(
            format!("{name}: blocked"),
            blocked,
            mold.volume_rounding(channel.area()),
            "mm³",
        ),
        Line::at_least(
            format!("{name}: reaches the cavity"),
            inside / (PI * outline.base_radius.powi(2)),
            MOUTH,
            "mm within",
        ),
        Line::new(
            format!("{name}: rim"),
            rim >= -mold.rounding,
            format!("{rim:.1} mm above the body"),
            "not below its top, or silicone runs over",
        ),
    ]
}

/// A cone fills most of its seat, and leaves a gap.
fn engaged(mold: &ClosedMold, name: &str, outline: &Outline) -> Line {
    let seat = outline.exact();
    let filled: f64 = mold.shells.iter().map(|s| s.solid.intersection(&seat).volume()).sum();
    let part = filled / seat.volume();
    let found = format!("{:.1} % filled", 100.0 * part);
    let needed = "at least 50 % and less than all";
    Line::new(format!("{name}: engaged"), (FILLED..1.0 - 1e-6).contains(&part), found, needed)
}

/// The core's stub reaches down into its socket and fills most of it.
fn seated(mold: &ClosedMold, name: &str, outline: &Outline) -> Vec<Line> {
    let socket = outline.exact();
    let depth = mold.cast.solid.bounds().0.z - mold.bounds.0.z;
    let below = Vec3::new(mold.bounds.1.x, mold.bounds.1.y, mold.bounds.0.z + depth);
    let hole = socket.intersection(&Solid::cube(&mold.bounds.0, &below));
    // As it is cut: with the flats of its stub.
    let hole = mold.shells.iter().fold(hole, |hole, shell| hole.difference(&shell.solid));
    let stubs = mold.cores.iter().map(|core| core.solid.intersection(&hole));
    let stub = stubs.max_by(|a, b| a.volume().total_cmp(&b.volume()));
    let (length, part) = stub.filter(|s| !s.is_empty()).map_or((0.0, 0.0), |stub| {
        let (low, high) = stub.bounds();
        (high.z - low.z, stub.volume() / hole.volume())
    });
    vec![
        Line::at_least(format!("{name}: stub length"), length, FILLED * depth, "mm"),
        Line::at_least(format!("{name}: stub fills"), 100.0 * part, 100.0 * FILLED, "%"),
    ]
}
