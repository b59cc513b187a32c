//! Where a body or a gap in it is thinner than the finest cell.
//!
//! Measured on the functions, not on triangles: from every triangle of the surface straight along the
//! normal, inward through the body and outward through what is beside it, to the next zero. Sheets that
//! no edge of the lattice tells apart are not on the surface; [`super::refine`] finds them.

use mesh::Vec3;
use rayon::prelude::*;

use super::refine::FINEST;
use super::sides::Sides;
use super::skin::{Kind, Skin, Thin};

/// Places nearer than this to a thinner one are left out [grid].
const APART: f64 = 3.0;

/// Most places that are told.
const MOST: usize = 50;

/// Places on the way to the end of what is measured.
const STEPS: [f64; 2] = [0.4, 1.0];

/// Cosine of the angle between two surfaces up to which they count as parallel (60°), as in
/// [`mesh::walls`].
const PARALLEL: f64 = 0.5;

/// Ways shorter than this end where they begin [finest cell].
const NOTHING: f64 = 0.02;

/// The thin places of a body, the thinnest first, one of each neighbourhood.
pub fn places(skin: &Skin, hidden: Vec<Thin>, sides: &Sides) -> Vec<Thin> {
    let seen: Vec<Thin> = (0..skin.surface.triangles.len())
        .into_par_iter()
        .flat_map_iter(|t| measured(skin, sides, t))
        .collect();
    let mut all: Vec<Thin> = hidden.into_iter().chain(seen).collect();
    all.sort_by(|a, b| a.resolved.cmp(&b.resolved).then(a.thickness.total_cmp(&b.thickness)));
    let mut kept: Vec<Thin> = Vec::new();
    let apart = APART * sides.grid * sides.metres;
    for place in all {
        let near = |k: &Thin| {
            k.kind == place.kind && (Vec3::from(k.at) - Vec3::from(place.at)).norm() < apart
        };
        if kept.len() < MOST && !kept.iter().any(near) {
            kept.push(place);
        }
    }
    kept
}

/// The thicknesses at a triangle, of the body and of the gap beside it, that are less than the finest
/// cell.
fn measured(skin: &Skin, sides: &Sides, t: usize) -> impl Iterator<Item = Thin> {
    let (normal, start) = (skin.surface.normal(t), skin.surface.centroid(t) / sides.metres);
    // On the surface itself, to first order.
    let from = start - normal * sides.depth(&start);
    [Kind::Wall, Kind::Gap].into_iter().filter_map(move |kind| across(sides, from, normal, kind))
}

/// The way from the surface to the next one, through the body or beside it.
fn across(sides: &Sides, from: Vec3, normal: Vec3, kind: Kind) -> Option<Thin> {
    let limit = FINEST * sides.grid;
    let way = if kind == Kind::Wall { -normal } else { normal };
    // Negative on the way.
    let f = |s: f64| {
        let depth = sides.depth(&(from + way * s));
        if kind == Kind::Wall { depth } else { -depth }
    };
    let end = STEPS.map(|part| part * limit).into_iter().find(|&s| f(s) > 0.0)?;
    let (mut low, mut high) = (0.0, end);
    for _ in 0..20 {
        let middle = (low + high) / 2.0;
        if f(middle) > 0.0 { high = middle } else { low = middle }
    }
    let beyond = sides.outward(&(from + way * high)) * if kind == Kind::Wall { 1.0 } else { -1.0 };
    // The beginning itself is found where the surface is a little beside the triangle.
    (high > NOTHING * limit && beyond.dot(&way) >= PARALLEL).then(|| Thin {
        kind,
        resolved: true,
        thickness: high * sides.metres,
        at: ((from + way * high / 2.0) * sides.metres).into(),
    })
}

/// Says where a body is thin, in words.
pub fn remark(places: &[Thin], unit: &str, metres: f64) {
    let Some(first) = places.first() else { return };
    let what = |place: &Thin| {
        let name = match (place.kind, place.resolved) {
            (Kind::Wall, true) => "a wall",
            (Kind::Wall, false) => "a wall, left out,",
            (Kind::Gap, true) => "a gap",
            (Kind::Gap, false) => "a gap, closed,",
        };
        let [x, y, z] = place.at.map(|x| x / metres);
        format!("{name} of {:.4} at ({x:.4}, {y:.4}, {z:.4})", place.thickness / metres)
    };
    let more = if places.len() > 3 { ", …" } else { "" };
    let list: Vec<String> = places.iter().take(3).map(what).collect();
    let text = format!(
        "{} place(s) thinner than the finest cell [{unit}]: {}{more}; all are in model.json",
        places.len(),
        list.join(", ")
    );
    if first.resolved { log::info!("{text}") } else { log::warn!("{text}") }
}
