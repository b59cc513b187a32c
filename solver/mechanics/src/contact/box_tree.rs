//! Which of many boxes overlap: a tree of bounding boxes over a space-filling
//! curve.
//!
//! Boxes are sorted by the Morton code of their centres (Lauterbach et al. 2009,
//! "Fast BVH construction on GPUs", doi:10.1111/j.1467-8659.2009.01377.x), and
//! `FAN` consecutive ones make one box of the level above, until one is left.
//! The tree has no pointers, so that building it is a sort and a few passes. Queries that follow one another on the
//! curve are close: what is near all of them is looked up once, and compared with each by vectors.

use std::ops::Range;

use mesh::Vec3;
use rayon::prelude::*;

use crate::math::lanes::widest;

/// Children of a node.
const FAN: usize = 4;

/// Bits of a Morton code per direction.
const BITS: u32 = 21;

/// An axis-parallel box, boundary included [m].
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    /// The smallest box around points; of none it meets no other.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        let none = Self { low: Vec3::repeat(f64::MAX), high: Vec3::repeat(f64::MIN) };
        points.into_iter().fold(none, |all, p| all.and(&Self { low: p, high: p }))
    }

    /// Larger by `margin` [m] on all sides.
    pub fn grown(&self, margin: f64) -> Self {
        let margin = Vec3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// The smallest box around this one and another.
    pub fn and(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Whether this one and another have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// Boxes that are ready for queries.
pub struct BoxTree {
    /// Index of the box at each place of the curve.
    order: Vec<u32>,
    /// Boxes along the curve, and those around them level by level.
    levels: Vec<Vec<Bounds>>,
}

impl BoxTree {
    /// A tree of at most 2³² boxes.
    pub fn new(boxes: &[Bounds]) -> Self {
        let order = along_curve(boxes);
        let mut levels = vec![order.par_iter().map(|&i| boxes[i as usize]).collect::<Vec<_>>()];
        while levels[levels.len() - 1].len() > 1 {
            let below = &levels[levels.len() - 1];
            let parent = |children: &[Bounds]| {
                children.iter().skip(1).fold(children[0], |all, child| all.and(child))
            };
            levels.push(below.par_chunks(FAN).map(parent).collect());
        }
        Self { order, levels }
    }

    /// Number of boxes.
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// The box at a place of the curve, and its index.
    pub fn at(&self, place: usize) -> (usize, &Bounds) {
        (self.order[place] as usize, &self.levels[0][place])
    }

    /// Finds the boxes at `first` or a later place of the curve that meet `query`.
    pub fn look_up(&self, query: &Bounds, first: usize, near: &mut Near) {
        near.clear();
        let top = self.levels.len() - 1;
        self.descend(top, 0..self.levels[top].len(), query, first, near);
    }

    fn descend(
        &self,
        level: usize,
        nodes: Range<usize>,
        query: &Bounds,
        first: usize,
        near: &mut Near,
    ) {
        let width = FAN.pow(level as u32);
        for node in nodes {
            let bounds = &self.levels[level][node];
            if (node + 1) * width <= first || !bounds.meets(query) {
                continue;
            }
            if level == 0 {
                near.push(node, bounds);
            } else {
                let children = FAN * node..(FAN * (node + 1)).min(self.levels[level - 1].len());
                self.descend(level - 1, children, query, first, near);
            }
        }
    }
}

/// Boxes that were found, by their places on the curve; coordinates side by side.
#[derive(Default)]
pub struct Near {
    places: Vec<usize>,
    low: [Vec<f64>; 3],
    high: [Vec<f64>; 3],
    gaps: Vec<f64>,
}

impl Near {
    fn clear(&mut self) {
        self.places.clear();
        self.low.iter_mut().chain(&mut self.high).for_each(Vec::clear);
    }

    fn push(&mut self, place: usize, bounds: &Bounds) {
        self.places.push(place);
        for k in 0..3 {
            self.low[k].push(bounds.low[k]);
            self.high[k].push(bounds.high[k]);
        }
    }

    /// Calls `found` with the place of every one that meets `query`, until it returns false.
    pub fn meeting(&mut self, query: &Bounds, mut found: impl FnMut(usize) -> bool) {
        let Self { places, low, high, gaps } = self;
        gaps.resize(places.len(), 0.0);
        widest(|| gaps_to(query, low, high, gaps));
        for (&place, &gap) in places.iter().zip(&*gaps) {
            if gap <= 0.0 && !found(place) {
                return;
            }
        }
    }
}

/// The largest gap between a box and each of others along an axis: negative where they overlap.
#[inline(always)]
fn gaps_to(query: &Bounds, low: &[Vec<f64>; 3], high: &[Vec<f64>; 3], gaps: &mut [f64]) {
    let count = gaps.len();
    let [lx, ly, lz] = [&low[0][..count], &low[1][..count], &low[2][..count]];
    let [hx, hy, hz] = [&high[0][..count], &high[1][..count], &high[2][..count]];
    let (from, to) = (query.low, query.high);
    for k in 0..count {
        let x = larger(lx[k] - to.x, from.x - hx[k]);
        let y = larger(ly[k] - to.y, from.y - hy[k]);
        let z = larger(lz[k] - to.z, from.z - hz[k]);
        gaps[k] = larger(larger(x, y), z);
    }
}

/// The larger of two numbers, as one instruction has it.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Indices of boxes in the order of the Morton codes of their centres.
fn along_curve(boxes: &[Bounds]) -> Vec<u32> {
    let Some(first) = boxes.first() else { return Vec::new() };
    let all = boxes.par_iter().copied().reduce(|| *first, |a, b| a.and(&b));
    let extent = (all.high - all.low).max();
    let cells = f64::from((1_u32 << BITS) - 1);
    let code = |b: &Bounds| {
        let centre = 0.5 * (b.low - all.low) + 0.5 * (b.high - all.low);
        // a cast stays in range whatever the number is
        let cell = centre.map(|c| (c / extent * cells) as u32);
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut keys: Vec<(u64, u32)> =
        boxes.par_iter().enumerate().map(|(i, b)| (code(b), i as u32)).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

/// The lowest [`BITS`] bits, each followed by two zeros.
fn spread(x: u32) -> u64 {
    let x = u64::from(x.min((1 << BITS) - 1));
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
