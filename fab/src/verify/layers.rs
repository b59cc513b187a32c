//! Sheets that are laid in lie in the silicone.

use mesh::solid::Solid;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::body::layer::LaidIn;

/// Silicone on both sides of a sheet [mm]: a judgement, from what a film that holds a sheet needs.
const COVER: f64 = 0.3;

/// Part of that silicone which may be missing, at rims that lie in the outside of the body.
const BARE: f64 = 0.02;

/// The checks of all sheets of a mold.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    mold.report.layers.iter().map(|layer| of(mold, layer)).collect()
}

fn of(mold: &ClosedMold, LaidIn { tag, height, outlines, .. }: &LaidIn) -> Line {
    let level = mold.cast.solid.bounds().0.z + height;
    let cover = Solid::extrude(&counter_clockwise(outlines), level - COVER, level + COVER);
    let whole = cover.volume();
    let bare = if whole > 0.0 { cover.difference(&mold.cast.solid).volume() / whole } else { 1.0 };
    let unit = format!("% of {COVER} mm on both sides missing");
    Line::at_most(format!("{tag}: in silicone"), 100.0 * bare, 100.0 * BARE, &unit)
}

/// Outlines with the same area on their left side, seen from above: facets may look down.
fn counter_clockwise(outlines: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    let twice = |outline: &Vec<[f64; 2]>| -> f64 {
        let next = outline.iter().cycle().skip(1);
        outline.iter().zip(next).map(|(p, q)| p[0] * q[1] - q[0] * p[1]).sum()
    };
    let mut all = outlines.to_vec();
    if all.iter().map(twice).sum::<f64>() < 0.0 {
        all.iter_mut().for_each(|outline| outline.reverse());
    }
    all
}
