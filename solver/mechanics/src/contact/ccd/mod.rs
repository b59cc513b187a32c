//! Continuous collision detection (CCD): how far features may move on straight lines
//! before they touch.
//!
//! Two convex features A and B are at least as far apart as they are along any
//! direction n, |n| = 1,
//!
//! d(t) ≥ g(t; n) = min_{i ∈ A, j ∈ B} n·(xᵢ(t) − xⱼ(t)),   x(t) = x⁰ + t (x¹ − x⁰)
//!
//! with equality where n joins their closest points, and g is known for all t at
//! once. So t advances to where g(t; n) would fall to the part of the first gap that
//! must be kept, n is renewed there, and this is repeated until the gap is used
//! up, as in additive continuous collision detection (Li et al. 2021,
//! "Codimensional incremental potential contact", doi:10.1145/3450626.3459767).
//! The bound on speed there, |Δxᵢ − Δxⱼ|, counts motion along the features, too;
//! with it they stop only after many steps, or short of contact. Here features
//! that slide along each other or do not move are free in one step.
//!
//! Only differences of positions enter and all thresholds are relative, so that
//! neither place nor scale matters. Directions may be inaccurate: that makes the
//! step shorter, never too long.

use std::sync::atomic::{AtomicU64, Ordering};

use mesh::Vec3;
use rayon::prelude::*;

use super::pairs::Pair;

/// Share of the gap d − thickness that is left where a step is shortened.
///
/// Li et al. keep 0.1, so that Newton's method gets close to contact fast; the
/// barrier needs it to be more than rounding.
pub const KEPT: f64 = 0.1;

/// The search ends when the gap is this close to what shall be kept.
const NEAR: f64 = 1.0 + 1e-2;

/// Share of the distance by which a direction has to separate not to be doubted.
const ACCURATE: f64 = 1.0 - 1e-6;

/// Renewals of the direction; more are needed only where rounding decides. What
/// is free so far is returned then.
const RENEWALS: usize = 100;

/// The least time of impact of all pairs when vertices move from `x0` to `x1` [m], the same for any number of threads: a
/// time in [0, 1] until which the features of a pair keep more than `thickness` and about [`KEPT`] of their gap beyond it,
/// 1 if they do all along, 0 if they are no further apart than that from the start, or numbers are not finite.
pub fn max_step(pairs: &[Pair], x0: &[Vec3], x1: &[Vec3], thickness: f64) -> f64 {
    // numbers ≥ 0 are ordered as their bits
    let least = AtomicU64::new(1.0_f64.to_bits());
    pairs.par_iter().for_each(|pair| {
        let limit = f64::from_bits(least.load(Ordering::Relaxed));
        let t = time_within(limit, *pair, &pair.gather(x0), &pair.gather(x1), thickness);
        least.fetch_min(t.to_bits(), Ordering::Relaxed);
    });
    f64::from_bits(least.into_inner())
}

/// The lesser of `limit` and the time of impact, bit for bit: the way there does not depend on `limit`, which
/// other pairs have found, in an order of their own.
fn time_within(limit: f64, pair: Pair, start: &[Vec3; 4], end: &[Vec3; 4], thickness: f64) -> f64 {
    // as seen from the first corner
    let moved = |i: usize| end[i] - start[i];
    let motion: [Vec3; 4] = std::array::from_fn(|i| moved(i) - moved(0));
    let start = start.map(|x| x - start[0]);
    let mut apart = Separation::new(pair, &start);
    let kept = thickness + KEPT * (apart.gap - thickness);
    let finite = motion.iter().all(|m| m.iter().all(|c| c.is_finite()));
    if !(finite && kept > thickness) {
        return 0.0;
    }
    let at = |t: f64| std::array::from_fn(|i| start[i] + t * motion[i]);
    let (mut t, mut x, mut stride) = (0.0, start, 0.0);
    for _ in 0..RENEWALS {
        let straight = apart.time_to(kept, pair, &x, &motion);
        if t + straight >= limit {
            return limit;
        }
        if stride > straight {
            let next_t = (t + stride).min(1.0);
            let next_x = at(next_t);
            let next = Separation::new(pair, &next_x);
            if apart.gap_while_turning(&next, pair, &x, &next_x) >= kept {
                if next_t >= limit {
                    return limit;
                }
                (stride, t, x, apart) = (2.0 * stride, next_t, next_x, next);
                continue;
            }
            stride *= 0.25;
        }
        t += straight;
        x = at(t);
        apart = Separation::new(pair, &x);
        if apart.gap - thickness <= NEAR * (kept - thickness) {
            break;
        }
        stride = stride.max(2.0 * straight);
    }
    t
}

/// A direction along which two features are apart.
struct Separation {
    /// n, towards the first feature.
    direction: Vec3,
    /// g(n) [m]; not positive if no direction was found.
    gap: f64,
}

impl Separation {
    /// Along the line that joins the closest points or, where rounding shows in
    /// that, along it without its parts along edges or along the common normal.
    fn new(pair: Pair, x: &[Vec3; 4]) -> Self {
        let closest = pair.closest(x);
        let found = Self::along(&closest.offset, pair, x);
        if found.gap > ACCURATE * closest.d2.sqrt() {
            return found;
        }
        let edge = |[i, j]: [usize; 2]| x[j] - x[i];
        let (edges, normal): (&[[usize; 2]], _) = match pair {
            Pair::PointTriangle(_) => {
                (&[[1, 2], [2, 3], [3, 1]], edge([1, 2]).cross(&edge([1, 3])))
            }
            Pair::EdgeEdge(_) => (&[[0, 1], [2, 3]], edge([0, 1]).cross(&edge([2, 3]))),
        };
        let inside =
            |[i, j]: [usize; 2]| closest.coefficients[i] != 0.0 && closest.coefficients[j] != 0.0;
        let across = edges.iter().filter(|e| inside(**e)).fold(closest.offset, |r, e| {
            let e = edge(*e);
            r - e * (e.dot(&r) / e.norm_squared().max(f64::MIN_POSITIVE))
        });
        let others = [across, normal, -normal];
        others.iter().map(|n| Self::along(n, pair, x)).fold(found, Self::wider)
    }

    fn along(direction: &Vec3, pair: Pair, x: &[Vec3; 4]) -> Self {
        let Some(direction) = direction.try_normalize(0.0) else {
            return Self { direction: *direction, gap: 0.0 };
        };
        let s = x.map(|p| direction.dot(&p));
        let gap = across(pair).map(|(i, j)| s[i] - s[j]).fold(f64::INFINITY, f64::min);
        Self { direction, gap }
    }

    /// The least gap along a direction that turns evenly from this one, where the
    /// corners are at `x`, to `end`, where they are at `y`.
    ///
    /// It is at least the least coefficient in the Bernstein form of
    /// ((1−τ) m + τ n)·((1−τ) (xᵢ − xⱼ) + τ (yᵢ − yⱼ)), as |(1−τ) m + τ n| ≤ 1.
    fn gap_while_turning(&self, end: &Self, pair: Pair, x: &[Vec3; 4], y: &[Vec3; 4]) -> f64 {
        let (m, n) = (self.direction, end.direction);
        let s: [f64; 4] = std::array::from_fn(|i| 0.5 * (m.dot(&y[i]) + n.dot(&x[i])));
        let ends = self.gap.min(end.gap);
        across(pair).map(|(i, j)| s[i] - s[j]).fold(ends, f64::min)
    }

    fn wider(self, other: Self) -> Self {
        if other.gap > self.gap { other } else { self }
    }

    /// Until when the gap along this direction is at least `kept`.
    fn time_to(&self, kept: f64, pair: Pair, x: &[Vec3; 4], motion: &[Vec3; 4]) -> f64 {
        let s = x.map(|p| self.direction.dot(&p));
        let v = motion.map(|m| self.direction.dot(&m));
        let until = |(i, j): (usize, usize)| {
            let closing = v[j] - v[i];
            if closing > 0.0 { (s[i] - s[j] - kept) / closing } else { f64::INFINITY }
        };
        across(pair).map(until).fold(f64::INFINITY, f64::min).max(0.0)
    }
}

/// Every corner of the first feature with every one of the second.
fn across(pair: Pair) -> impl Iterator<Item = (usize, usize)> {
    let first = pair.corners_of_first();
    (0..first).flat_map(move |i| (first..4).map(move |j| (i, j)))
}

#[cfg(test)]
mod tests;
