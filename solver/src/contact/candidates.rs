//! Pairs of features that may come close while their corners move on straight
//! lines.
//!
//! A pair is a candidate if the boxes around what its features sweep come closer
//! than the radius, and
//!
//! d(x⁰) ≤ radius + ℓ,   ℓ = max |Δxᵢ − Δxⱼ| over corners i of one and j of the
//! other feature
//!
//! d   distance at the start [m]
//! ℓ   the way that two of their points move towards each other, at most [m]
//!
//! So whatever moves along with what is near it is none. Without motion the
//! candidates are the pairs that are closer than the radius.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use mesh::Vec3;
use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree};
use super::pairs::{Features, Pair};
use crate::parallel::map_merge;

/// Pairs of overlapping boxes that are looked at before a search is given up.
///
/// Steps of half the length of an edge need some 7 per vertex and edge. A pair
/// takes 8 B while searching and 40 B in the end, so memory is about 0.2 GB and
/// 1 kB per vertex or edge at most.
#[must_use]
pub fn budget(features: &Features) -> usize {
    4_000_000 + 20 * (features.vertices.len() + features.edges.len())
}

/// Rounding of positions, in units of the largest coordinate.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// There are more pairs than memory is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "more than {budget} pairs of surface features come close within one step; a shorter step is needed"
)]
pub struct TooMany {
    /// Pairs that would have been looked at.
    pub budget: usize,
}

/// All pairs of two of `features` that come closer than `radius` [m] while
/// vertices move from `x0` to `x1` [m], and some that do not: sorted, each once,
/// without those that share a vertex and those whose corners `skip` is true for.
///
/// # Errors
/// [`TooMany`] where more than [`budget`] pairs of boxes overlap, so that memory is
/// bounded however long the step is.
pub fn between(
    features: &Features,
    x0: &[Vec3],
    x1: &[Vec3],
    radius: f64,
    skip: impl Fn([usize; 4]) -> bool + Sync,
) -> Result<Vec<Pair>, TooMany> {
    between_within(budget(features), features, x0, x1, radius, skip)
}

/// As [`between`], with a budget of one's own.
///
/// # Errors
/// As [`between`].
pub fn between_within(
    budget: usize,
    features: &Features,
    x0: &[Vec3],
    x1: &[Vec3],
    radius: f64,
    skip: impl Fn([usize; 4]) -> bool + Sync,
) -> Result<Vec<Pair>, TooMany> {
    let Features { vertices, edges, triangles } = features;
    let search = Search { x0, x1, radius: radius + rounding(x0, x1), budget, seen: 0.into() };
    let admit = |pair: Pair| (!skip(pair.corners())).then_some(pair);
    let mut pairs = search.run(vertices, triangles, false, |&p, &[a, b, c]| {
        (p != a && p != b && p != c).then_some(Pair::PointTriangle([p, a, b, c])).and_then(admit)
    })?;
    pairs.append(&mut search.run(edges, edges, true, |&[p, q], &[r, s]| {
        let apart = p != r && p != s && q != r && q != s;
        apart.then_some(Pair::EdgeEdge([p, q, r, s])).and_then(admit)
    })?);
    Ok(pairs)
}

/// How far positions may be off in the comparisons below [m].
fn rounding(x0: &[Vec3], x1: &[Vec3]) -> f64 {
    let largest = |x: &[Vec3]| x.par_iter().map(Vec3::amax).reduce(|| 0.0, f64::max);
    ROUNDING * largest(x0).max(largest(x1))
}

/// A search under way.
struct Search<'a> {
    x0: &'a [Vec3],
    x1: &'a [Vec3],
    radius: f64,
    budget: usize,
    /// Pairs looked at so far.
    seen: AtomicUsize,
}

/// A feature by its corners.
trait Corners: Copy + Sync {
    fn corners(&self) -> &[usize];
}

impl Corners for usize {
    fn corners(&self) -> &[usize] {
        std::slice::from_ref(self)
    }
}

impl<const N: usize> Corners for [usize; N] {
    fn corners(&self) -> &[usize] {
        self
    }
}

impl Search<'_> {
    /// The candidates among `pair` of each of `a` and each of `b`, in that order;
    /// if the two are the same list, each pair once.
    fn run<A: Corners, B: Corners>(
        &self,
        a: &[A],
        b: &[B],
        same: bool,
        pair: impl Fn(&A, &B) -> Option<Pair> + Sync,
    ) -> Result<Vec<Pair>, TooMany> {
        let tree = BoxTree::new(&self.boxes(b));
        let queries = if same { None } else { Some(BoxTree::new(&self.boxes(a))) };
        let queries = queries.as_ref().unwrap_or(&tree);
        let mut keys = Vec::new();
        let search = |places: Range<usize>| {
            let mut keys = Vec::new();
            for place in places {
                let (i, query) = queries.at(place);
                let first = if same { place + 1 } else { 0 };
                let left = self.budget.saturating_sub(self.seen.load(Ordering::Relaxed));
                let mut seen = 0;
                tree.overlaps(&query.grown(self.radius), first, &mut |j| {
                    let (i, j) = if same { (i.min(j), i.max(j)) } else { (i, j) };
                    let Some(pair) = pair(&a[i], &b[j]) else { return true };
                    if self.reachable(&pair) {
                        keys.push((i as u64) << 32 | j as u64);
                    }
                    seen += 1;
                    seen <= left
                });
                self.seen.fetch_add(seen, Ordering::Relaxed);
            }
            keys
        };
        map_merge(queries.count(), search, |_, mut part| keys.append(&mut part));
        if self.seen.load(Ordering::Relaxed) > self.budget {
            return Err(TooMany { budget: self.budget });
        }
        keys.par_sort_unstable();
        let both = |key: &u64| pair(&a[(key >> 32) as usize], &b[(key & 0xffff_ffff) as usize]);
        Ok(keys.par_iter().filter_map(both).collect())
    }

    /// Boxes around what features sweep.
    fn boxes<T: Corners>(&self, features: &[T]) -> Vec<Bounds> {
        let swept = |feature: &T| {
            let corners = feature.corners().iter();
            Bounds::around(corners.flat_map(|&v| [self.x0[v], self.x1[v]]))
        };
        features.par_iter().map(swept).collect()
    }

    /// Whether a pair is near enough at the start for the way it moves.
    fn reachable(&self, pair: &Pair) -> bool {
        let (start, end) = (pair.gather(self.x0), pair.gather(self.x1));
        let first = pair.corners_of_first();
        let moved: [Vec3; 4] = std::array::from_fn(|i| end[i] - start[i]);
        let mut way2 = 0.0_f64;
        for i in 0..first {
            for j in first..4 {
                way2 = way2.max((moved[i] - moved[j]).norm_squared());
            }
        }
        let reach = self.radius + way2.sqrt();
        pair.closest(&start).d2 <= reach * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// Triangles of different sizes, some with common vertices, and a motion.
    fn cloud(seed: u64, way: f64) -> (Features, [Vec<Vec3>; 2]) {
        let mut random = Random::new(seed);
        let facets: Vec<[usize; 3]> = (0..60).map(|t| [2 * t, 2 * t + 1, 2 * t + 2]).collect();
        let x0: Vec<Vec3> =
            (0..121).map(|i| 2.0 * random.vector() * if i % 40 == 7 { 3.0 } else { 1.0 }).collect();
        let drift = random.vector();
        let x1 = x0.iter().map(|x| x + way * (drift + 0.2 * random.vector())).collect();
        (Features::new(&facets), [x0, x1])
    }

    /// Every pair of features without a common vertex.
    fn all_pairs(features: &Features) -> Vec<Pair> {
        let Features { vertices, edges, triangles } = features;
        let corners = |t: &[usize]| -> [usize; 4] { t.try_into().expect("four corners") };
        let point_triangle = vertices.iter().flat_map(|&p| {
            triangles.iter().map(move |t| Pair::PointTriangle(corners(&[&[p], &t[..]].concat())))
        });
        let edge_edge = edges.iter().enumerate().flat_map(|(i, a)| {
            let later = edges.iter().skip(i + 1);
            later.map(move |b| Pair::EdgeEdge(corners(&[&a[..], &b[..]].concat())))
        });
        let apart = |pair: &Pair| {
            let mut corners = pair.corners();
            corners.sort_unstable();
            corners.windows(2).all(|w| w[0] != w[1])
        };
        point_triangle.chain(edge_edge).filter(apart).collect()
    }

    #[test]
    fn without_motion_candidates_are_the_close_pairs() {
        let (features, [x, _]) = cloud(1, 0.0);
        for radius in [0.05, 0.3, 100.0] {
            let close = |p: &Pair| p.closest(&p.gather(&x)).d2 < radius * radius;
            let expected: Vec<Pair> = all_pairs(&features).into_iter().filter(close).collect();
            assert!(expected.len() > 20, "{}", expected.len());
            let found = between(&features, &x, &x, radius, |_| false);
            assert_eq!(found, Ok(expected), "in this order");
        }
    }

    /// Sampling in time finds no pair that is not among the candidates, and the
    /// candidates are not simply all pairs.
    #[test]
    fn nothing_that_comes_close_on_the_way_is_missed() {
        for (seed, way) in [(2, 0.1), (3, 1.0), (4, 30.0)] {
            let (features, [x0, x1]) = cloud(seed, way);
            let radius = 0.05;
            let found = between(&features, &x0, &x1, radius, |_| false).expect("few");
            let mut missed = all_pairs(&features);
            let all = missed.len();
            missed.retain(|p| !found.contains(p));
            assert_eq!(missed.len() + found.len(), all);
            assert!(way > 1.0 || found.len() < all / 2, "{} of {all}", found.len());
            for step in 0..=50 {
                let t = f64::from(step) / 50.0;
                let x: Vec<Vec3> = x0.iter().zip(&x1).map(|(a, b)| a + t * (b - a)).collect();
                for pair in &missed {
                    assert!(pair.closest(&pair.gather(&x)).d2 >= radius * radius, "{pair:?} {t}");
                }
            }
        }
    }

    #[test]
    fn what_moves_together_is_no_candidate() {
        let (features, [x0, _]) = cloud(5, 0.0);
        let x1: Vec<Vec3> = x0.iter().map(|x| x + Vec3::new(20.0, 20.0, 20.0)).collect();
        let still = between(&features, &x0, &x0, 0.1, |_| false);
        let moving = between(&features, &x0, &x1, 0.1, |_| false);
        assert_eq!(still, moving);
    }

    #[test]
    fn skipped_pairs_are_left_out_and_threads_change_nothing() {
        let (features, [x0, x1]) = cloud(6, 0.3);
        let skip = |corners: [usize; 4]| corners.iter().all(|&v| v < 60);
        let run = || between(&features, &x0, &x1, 0.1, skip).expect("few");
        let mut expected = between(&features, &x0, &x1, 0.1, |_| false).expect("few");
        let all = expected.len();
        expected.retain(|p| !skip(p.corners()));
        assert!(expected.len() < all);
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            assert_eq!(pool.expect("a thread pool").install(run), expected);
        }
    }

    #[test]
    fn a_step_that_is_too_long_is_refused() {
        let (features, [x0, x1]) = cloud(7, 100.0);
        let all = all_pairs(&features).len();
        let run = |budget| between_within(budget, &features, &x0, &x1, 1e3, |_| false);
        assert_eq!(run(all).map(|pairs| pairs.len()), Ok(all));
        for budget in [0, 10, all - 1] {
            assert_eq!(run(budget), Err(TooMany { budget }));
        }
    }
}
