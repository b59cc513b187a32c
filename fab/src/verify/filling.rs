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

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::solid::Solid;
use rayon::prelude::*;

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
    let escape = columns.escape();
    let (mut unreached, mut trapped, mut deepest) = (0.0, 0.0, 0.0_f64);
    for (interval, level) in columns.intervals.iter().zip(&escape) {
        let height = interval.top - level.unwrap_or(interval.bottom);
        match level {
            None => unreached += height,
            Some(_) if height > SHALLOW => trapped += height,
            Some(_) => {}
        }
        deepest = deepest.max(if level.is_some() { height } else { 0.0 });
    }
    let percent = 100.0 * columns.step * columns.step / mold.cast.volume;
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

/// A stretch of a column within a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Interval {
    bottom: f64,
    top: f64,
}

/// A solid as upright columns on a square grid.
struct Columns {
    step: f64,
    /// Height above which each column is open to the sky.
    sky: Vec<f64>,
    /// Columns along x.
    width: usize,
    /// The first interval of each column, and one more.
    first: Vec<usize>,
    intervals: Vec<Interval>,
}

impl Columns {
    /// Columns of `solid`, open to the sky where they reach the surface of `outside`.
    fn new(solid: &Solid, outside: &Solid) -> Self {
        let surface = solid.to_surface();
        let (low, high) = solid.bounds();
        let size = high - low;
        let step = STEP.max((size.x * size.y / MOST).sqrt());
        let [width, depth] = [size.x, size.y].map(|s| (s / step).ceil().max(1.0) as usize);
        let bvh = SurfaceBvh::new(&surface);
        let cover = SurfaceBvh::new(&outside.to_surface());
        let up = |t: usize| {
            let [a, b, c] = surface.corners(t);
            (b - a).cross(&(c - a)).z > 0.0
        };
        let column = |i: usize| {
            let x = low.x + (0.5 + (i % width) as f64) * step;
            let y = low.y + (0.5 + (i / width) as f64) * step;
            let from = Vec3::new(x, y, low.z - 1.0);
            let top = cover.ray(&from, &Vec3::z()).last().map_or(f64::INFINITY, |hit| hit.0);
            let hits = bvh.ray(&from, &Vec3::z()).into_iter();
            (from.z + top - REACHED, stretches(hits.map(|(s, t)| (from.z + s, up(t)))))
        };
        let columns = (0..width * depth).into_par_iter().map(column);
        let (sky, columns): (Vec<f64>, Vec<Vec<Interval>>) = columns.unzip();
        let mut first = vec![0];
        first.extend(columns.iter().scan(0, |end, column| {
            *end += column.len();
            Some(*end)
        }));
        Self { step, sky, width, first, intervals: columns.concat() }
    }

    /// The intervals beside an interval of column `c`, with the opening between the two.
    fn beside(&self, c: usize, i: usize) -> impl Iterator<Item = (usize, usize, Interval)> {
        let rows = (self.first.len() - 1) / self.width;
        let (x, y) = (c % self.width, c / self.width);
        let left = (x > 0).then(|| c - 1);
        let right = (x + 1 < self.width).then(|| c + 1);
        let front = (y > 0).then(|| c - self.width);
        let back = (y + 1 < rows).then(|| c + self.width);
        let own = self.intervals[i];
        [left, right, front, back].into_iter().flatten().flat_map(move |d| {
            (self.first[d]..self.first[d + 1]).filter_map(move |j| {
                let other = self.intervals[j];
                let (bottom, top) = (own.bottom.max(other.bottom), own.top.min(other.top));
                (bottom < top).then_some((d, j, Interval { bottom, top }))
            })
        })
    }

    /// E of every interval; none where no air escapes at all.
    fn escape(&self) -> Vec<Option<f64>> {
        let mut level = vec![None; self.intervals.len()];
        let mut heap = BinaryHeap::new();
        for c in 0..self.first.len() - 1 {
            for i in self.first[c]..self.first[c + 1] {
                let top = self.intervals[i].top;
                if top >= self.sky[c] {
                    heap.push(Reached { level: top, column: c, interval: i });
                }
            }
        }
        while let Some(Reached { level: from, column, interval }) = heap.pop() {
            if level[interval].is_some() {
                continue;
            }
            level[interval] = Some(from);
            for (d, j, opening) in self.beside(column, interval) {
                let height = opening.top.min(from);
                if level[j].is_none() && height >= opening.bottom {
                    heap.push(Reached { level: height, column: d, interval: j });
                }
            }
        }
        level
    }
}

/// An interval from which air escapes up to a level; ordered by it.
#[derive(PartialEq)]
struct Reached {
    level: f64,
    column: usize,
    interval: usize,
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

/// Stretches inside, from crossings in ascending order, each with whether the surface
/// faces up there. A crossing in an edge is reported by both of its triangles.
fn stretches(crossings: impl Iterator<Item = (f64, bool)>) -> Vec<Interval> {
    let mut found = Vec::new();
    let mut bottom = None;
    for (z, up) in crossings {
        match (bottom, up) {
            (None, false) => bottom = Some(z),
            (Some(low), true) => {
                found.push(Interval { bottom: low, top: z });
                bottom = None;
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(low: [f64; 3], high: [f64; 3]) -> Solid {
        Solid::cube(&Vec3::from(low), &Vec3::from(high))
    }

    /// Volume above E in mm³, and that of what nothing escapes from.
    fn air(solid: &Solid, sky: f64) -> (f64, f64) {
        let outside = cube([-9.0; 3], [29.0, 29.0, sky]);
        let columns = Columns::new(solid, &outside);
        let area = columns.step * columns.step;
        let escape = columns.escape();
        let levels = columns.intervals.iter().zip(&escape);
        let trapped = levels.clone().map(|(i, e)| e.map_or(0.0, |e| i.top - e)).sum::<f64>();
        let closed = levels.map(|(i, e)| e.map_or(i.top - i.bottom, |_| 0.0)).sum::<f64>();
        (area * trapped, area * closed)
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
