//! The silicone gets everywhere, and the air out.
//!
//! The space that silicone fills is cut into upright columns, each a row of intervals
//! of height. Air at a height in an interval rises, and moves sideways where the next
//! column is open at its height or above, so that E(i), the greatest height in interval i
//! from which air still escapes, is
//!
//! E(i) = max over neighbours j of min(top of the opening between i and j, E(j)),
//!
//! where the term counts if it lies in the opening, and E is the top of the interval
//! where that is open to the sky. It is found from the sky down, greatest first (a widest
//! path). What is above E(i) in an interval is a pocket that stays full of air when the
//! mold is filled slowly and not tilted.

use std::collections::BinaryHeap;

use geometry::columns::{Grid, Layer, layers};
use mesh::solid::Solid;

use super::closed_mold::ClosedMold;
use super::{Line, Status};
use crate::mold::Purpose;

/// Distance between columns, at least: four of them find every channel, as a vent is
/// 1.6 mm wide [mm].
const STEP: f64 = 0.4;

/// Columns, at most: at the least distance they cover 250 × 250 mm, the bed of a printer.
const MOST: f64 = 4e5;

/// An interval that ends this near to the outside is open: far above the rounding of files,
/// 10⁻⁵ mm, and far below any film that is printed [mm].
const REACHED: f64 = 1e-4;

/// Shallower pockets hold no bubble that matters: `vents.persistence` by default, so that
/// what gets no vent is no fault [mm].
const SHALLOW: f64 = 1.0;

/// Air left in the mold, as a part of the body, that is pointed out, and that is too much:
/// judgements, not measurements. Degassing and tilting help against the first.
const SOME: f64 = 1e-3;
const MUCH: f64 = 2e-2;

/// All checks of filling.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let columns = Columns::new(&poured(mold), &mold.outside.solid);
    let (mut unreached, mut trapped, mut deepest) = (0.0, 0.0, 0.0_f64);
    for ([bottom, top], level) in columns.escape() {
        match level.map(|level| top - level) {
            None => unreached += top - bottom,
            Some(height) => {
                trapped += if height > SHALLOW { height } else { 0.0 };
                deepest = deepest.max(height);
            }
        }
    }
    let percent = 100.0 * columns.grid.step * columns.grid.step / mold.cast.volume;
    let unit = "% of the body";
    // A column on the rim of the body may miss the opening to its neighbours.
    let reached = Line::at_most("filling: not reached", percent * unreached, 100.0 * SOME, unit);
    let mut air = Line::at_most("filling: trapped air", percent * trapped, 100.0 * MUCH, unit);
    air.found += &format!(", {deepest:.1} mm deep");
    if air.status == Status::Ok && percent * trapped > 100.0 * SOME {
        air.status = Status::Warn;
    }
    vec![reached, air]
}

/// What silicone fills: the body, sprue and vents, without what the parts put there.
fn poured(mold: &ClosedMold) -> Solid {
    let channels = mold.report.features.iter();
    let channels = channels.filter(|f| matches!(f.purpose, Purpose::Sprue | Purpose::Vent));
    let whole = channels.fold(mold.cast.solid.clone(), |all, f| all.union(&f.exact()));
    let inside = whole.intersection(&mold.outside.solid);
    mold.parts().fold(inside, |rest, part| rest.difference(&part.solid))
}

/// A solid as upright columns.
struct Columns {
    grid: Grid,
    /// Height above which each column is open to the sky.
    sky: Vec<f64>,
    /// The intervals of each.
    columns: Vec<Vec<Layer>>,
}

impl Columns {
    /// Columns of `solid`, open to the sky where they reach the surface of `outside`.
    fn new(solid: &Solid, outside: &Solid) -> Self {
        let (low, high) = solid.bounds();
        let size = high - low;
        let step = STEP.max((size.x * size.y / MOST).sqrt());
        let count = [size.x, size.y].map(|s| (s / step).ceil().max(1.0) as usize);
        let grid = Grid { origin: [low.x, low.y].map(|x| x + 0.5 * step), step, count };
        let top = |column: &Vec<Layer>| column.last().map_or(f64::INFINITY, |[_, top]| *top);
        let cover = layers(&outside.to_surface(), &grid);
        let sky = cover.iter().map(|column| top(column) - REACHED).collect();
        Self { sky, columns: layers(&solid.to_surface(), &grid), grid }
    }

    /// All intervals with their E; none where no air escapes at all.
    fn escape(&self) -> impl Iterator<Item = (Layer, Option<f64>)> {
        let mut levels: Vec<Vec<Option<f64>>> =
            self.columns.iter().map(|column| vec![None; column.len()]).collect();
        let mut heap = BinaryHeap::new();
        for (c, column) in self.columns.iter().enumerate() {
            for (i, &[_, top]) in column.iter().enumerate().filter(|(_, l)| l[1] >= self.sky[c]) {
                heap.push(Reached { level: top, interval: (c, i) });
            }
        }
        while let Some(Reached { level: from, interval: (c, i) }) = heap.pop() {
            if levels[c][i].is_some() {
                continue;
            }
            levels[c][i] = Some(from);
            let own = self.columns[c][i];
            for d in self.grid.neighbours(c) {
                for (j, other) in self.columns[d].iter().enumerate() {
                    // The opening between the two.
                    let (bottom, top) = (own[0].max(other[0]), own[1].min(other[1]));
                    let height = top.min(from);
                    if levels[d][j].is_none() && bottom < top && height >= bottom {
                        heap.push(Reached { level: height, interval: (d, j) });
                    }
                }
            }
        }
        self.columns.iter().flatten().copied().zip(levels.into_iter().flatten())
    }
}

/// An interval from which air escapes up to a level; ordered by it.
#[derive(PartialEq)]
struct Reached {
    level: f64,
    /// The index of its column, and its own index among the intervals of that column.
    interval: (usize, usize),
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.level.total_cmp(&other.level).then(other.interval.cmp(&self.interval))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::Vec3;

    fn cube(low: [f64; 3], high: [f64; 3]) -> Solid {
        Solid::cube(&Vec3::from(low), &Vec3::from(high))
    }

    /// Volume above E in mm³, and that of what nothing escapes from.
    fn air(solid: &Solid, sky: f64) -> (f64, f64) {
        let outside = cube([-9.0; 3], [29.0, 29.0, sky]);
        let columns = Columns::new(solid, &outside);
        let area = columns.grid.step * columns.grid.step;
        let (mut trapped, mut closed) = (0.0, 0.0);
        for ([bottom, top], level) in columns.escape() {
            match level {
                Some(level) => trapped += area * (top - level),
                None => closed += area * (top - bottom),
            }
        }
        (trapped, closed)
    }

    #[test]
    fn air_is_trapped_above_the_saddle_to_the_vent() {
        // A trough with two towers, one open to the sky; the other is lower.
        let trough = cube([0.0, 0.0, 0.0], [20.0, 4.0, 5.0]);
        let tower = cube([0.0, 0.0, 0.0], [4.0, 4.0, 12.0]);
        let open = cube([16.0, 0.0, 0.0], [20.0, 4.0, 20.0]);
        let (trapped, closed) = air(&trough.union(&tower).union(&open), 20.0);
        assert!((trapped - 16.0 * 7.0).abs() < 1e-9, "{trapped}");
        assert_eq!(closed, 0.0);
        // With a vent on the other tower, none.
        let vent = cube([1.0, 1.0, 10.0], [3.0, 3.0, 20.0]);
        let (trapped, _) = air(&trough.union(&tower).union(&open).union(&vent), 20.0);
        assert!(trapped < 1e-9, "{trapped}");
        // A roof that rises towards the vent traps none although no column is flat.
        let wedge = cube([0.0; 3], [20.0, 4.0, 10.0])
            .trim_by_plane(&Vec3::new(1.0, 0.0, -2.0).normalize(), 0.0);
        let (trapped, _) = air(&wedge.union(&open), 20.0);
        assert!(trapped < 1e-9, "{trapped}");
    }

    #[test]
    fn what_is_not_connected_is_not_reached() {
        let open = cube([0.0; 3], [4.0, 4.0, 20.0]);
        let lonely = cube([8.0, 0.0, 0.0], [12.0, 4.0, 5.0]);
        let (_, closed) = air(&open.union(&lonely), 20.0);
        assert!((closed - 80.0).abs() < 1e-9, "{closed}");
    }
}
