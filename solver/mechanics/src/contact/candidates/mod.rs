//! Broad phase: candidate pairs of features, which may come close while their corners
//! move on straight lines. Features at rest are the case without motion.
//!
//! A pair is a candidate if the boxes around what its features sweep come closer
//! than the radius, and
//!
//! d(x⁰) ≤ radius + ℓ,   ℓ = max |Δxᵢ − Δxⱼ| over corners i of one and j of the
//! other feature
//!
//! d   distance at the start [m]
//! ℓ   how far two of their points move towards each other, at most [m]
//!
//! So features that move together are no candidates. Without motion the
//! candidates are the pairs that are closer than the radius, up to rounding;
//! [`close_within`] and [`close_between`] are exactly those.
//!
//! Overlapping boxes are found with a [`BoxTree`].

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use mesh::bvh::SurfaceBvh;
use mesh::{Vec3, topology};
use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree, Near};
use super::distance::Closest;
use super::pairs::{Features, Pair};
use crate::parallel::map_merge;

/// Pairs of overlapping boxes that are tested before a search is given up.
///
/// Steps of half the length of an edge need some 7 per vertex and edge. A pair
/// takes 8 B while searching and 40 B in the end, so memory is about 0.2 GB and
/// 1 kB per vertex or edge at most.
pub fn budget(features: &Features) -> usize {
    4_000_000 + 20 * (features.vertices.len() + features.edges.len())
}

/// Queries next to each other on the curve whose surroundings are looked up at once.
const PACKET: usize = 16;

/// Rounding of positions, in units of the largest coordinate.
const POSITION_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// There are more pairs than memory is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "more than {budget} pairs of surface features come close within one step; a shorter step is needed"
)]
pub struct TooMany {
    /// Pairs that would have been tested.
    pub budget: usize,
}

/// All pairs of two of `features` that come closer than `radius` [m] while
/// vertices move from `x0` to `x1` [m], and some that do not: sorted, each once,
/// without those that share a vertex and those whose corners `skip` is true for.
pub fn between(
    features: &Features,
    x0: &[Vec3],
    x1: &[Vec3],
    radius: f64,
    skip: &(dyn Fn([usize; 4]) -> bool + Sync),
) -> Result<Vec<Pair>, TooMany> {
    between_within(budget(features), features, x0, x1, radius, skip)
}

/// As [`between`], with a budget of one's own.
pub fn between_within(
    budget: usize,
    features: &Features,
    x0: &[Vec3],
    x1: &[Vec3],
    radius: f64,
    skip: &(dyn Fn([usize; 4]) -> bool + Sync),
) -> Result<Vec<Pair>, TooMany> {
    let Features { vertices, edges, triangles } = features;
    let search = Search { x0, x1, radius: radius + rounding(x0, x1), budget, seen: 0.into() };
    let admit = |pair: &Pair| !skip(pair.corners());
    let point_triangle = |p: &_, t: &_| point_triangle(p, t).filter(admit);
    let edge_edge = |a: &_, b: &_| edge_edge(a, b).filter(admit);
    let mut pairs = search.run(vertices, triangles, false, point_triangle)?;
    pairs.append(&mut search.run(edges, edges, true, edge_edge)?);
    Ok(pairs)
}

/// Keeps the pairs that may come closer than `radius` [m] while vertices move from `x0` to `x1` [m], by the test of
/// [`between`]. Their order stays.
pub fn coming_within(pairs: &[Pair], x0: &[Vec3], x1: &[Vec3], radius: f64) -> Vec<Pair> {
    let radius = radius + rounding(x0, x1);
    let search = Search { x0, x1, radius, budget: usize::MAX, seen: 0.into() };
    let comes = |pair: &&Pair| search.boxes_meet(pair) && search.reachable(pair);
    pairs.par_iter().filter(comes).copied().collect()
}

/// All pairs of two of `features` closer than `radius` [m] at positions `x` [m]:
/// sorted, each once, without those that share a vertex.
pub fn close_within(features: &Features, x: &[Vec3], radius: f64) -> Vec<Pair> {
    let Features { vertices, edges, triangles } = features;
    let search = Search::at_rest(x, radius);
    let mut pairs = search.close(vertices, triangles, false, radius, point_triangle);
    pairs.append(&mut search.close(edges, edges, true, radius, edge_edge));
    pairs
}

/// All pairs of a feature of `a` and one of `b` closer than `radius` [m] at positions
/// `x` [m]: vertices of `a` with triangles of `b`, vertices of `b` with triangles of
/// `a`, and edges, each sorted, without those that share a vertex.
pub fn close_between(a: &Features, b: &Features, x: &[Vec3], radius: f64) -> Vec<Pair> {
    let search = Search::at_rest(x, radius);
    let mut pairs = search.close(&a.vertices, &b.triangles, false, radius, point_triangle);
    pairs.append(&mut search.close(&b.vertices, &a.triangles, false, radius, point_triangle));
    pairs.append(&mut search.close(&a.edges, &b.edges, false, radius, edge_edge));
    pairs
}

/// The closest pair of a feature of each of two surfaces without a common vertex, at
/// positions `x` [m]; none where one of them has no triangles.
pub fn closest_between([a, b]: &[Features; 2], x: &[Vec3]) -> Option<(Pair, Closest)> {
    if b.triangles.is_empty() {
        return None;
    }
    let surface = SurfaceBvh::new(&topology::submesh(x, &b.triangles).0);
    let nearest = a.vertices.iter().map(|&v| surface.closest(&x[v]).distance);
    let bound = nearest.fold(f64::INFINITY, f64::min);
    // no pair but the closest ones is nearer than any vertex is
    let radius = bound * (1.0 + POSITION_ROUNDING) + rounding(x, x);
    let pairs = close_between(a, b, x, radius).into_iter();
    let closest = pairs.map(|pair| (pair, pair.closest(&pair.gather(x))));
    closest.min_by(|(_, one), (_, other)| one.d2.total_cmp(&other.d2))
}

/// The pair of a vertex and a triangle that does not contain it.
fn point_triangle(&p: &usize, &[a, b, c]: &[usize; 3]) -> Option<Pair> {
    (p != a && p != b && p != c).then_some(Pair::PointTriangle([p, a, b, c]))
}

/// The pair of two edges without a common end.
fn edge_edge(&[p, q]: &[usize; 2], &[r, s]: &[usize; 2]) -> Option<Pair> {
    (p != r && p != s && q != r && q != s).then_some(Pair::EdgeEdge([p, q, r, s]))
}

/// How far positions may be off in the comparisons below [m].
fn rounding(x0: &[Vec3], x1: &[Vec3]) -> f64 {
    let largest = |x: &[Vec3]| x.par_iter().map(Vec3::amax).reduce(|| 0.0, f64::max);
    POSITION_ROUNDING * largest(x0).max(largest(x1))
}

/// A search for candidates.
struct Search<'a> {
    x0: &'a [Vec3],
    x1: &'a [Vec3],
    radius: f64,
    budget: usize,
    /// Pairs tested so far.
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

impl<'a> Search<'a> {
    /// A search in what does not move, without a budget: nothing is listed but close pairs.
    fn at_rest(x: &'a [Vec3], radius: f64) -> Self {
        let (radius, budget) = (radius + rounding(x, x), usize::MAX);
        Self { x0: x, x1: x, radius, budget, seen: 0.into() }
    }

    /// The candidates of [`Self::run`] that are closer than `radius` at the start.
    fn close<A: Corners, B: Corners>(
        &self,
        a: &[A],
        b: &[B],
        same: bool,
        radius: f64,
        pair: impl Fn(&A, &B) -> Option<Pair> + Sync,
    ) -> Vec<Pair> {
        let mut pairs = self.run(a, b, same, pair).unwrap_or_default();
        pairs.retain(|p| p.closest(&p.gather(self.x0)).d2 < radius * radius);
        pairs
    }

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
            let (mut keys, mut near) = (Vec::new(), Near::default());
            for start in places.clone().step_by(PACKET) {
                let before = self.seen.load(Ordering::Relaxed);
                if before > self.budget {
                    break;
                }
                let left = self.budget - before;
                let packet: Vec<(usize, Bounds)> = (start..places.end.min(start + PACKET))
                    .map(|place| queries.at(place))
                    .map(|(i, query)| (i, query.grown(self.radius)))
                    .collect();
                let all = packet.iter().fold(packet[0].1, |all, (_, query)| all.and(query));
                tree.look_up(&all, if same { start + 1 } else { 0 }, &mut near);
                let mut seen = 0;
                for (offset, (i, query)) in packet.iter().enumerate() {
                    near.meeting(query, |place| {
                        if same && place <= start + offset {
                            return true;
                        }
                        let j = tree.at(place).0;
                        let (i, j) = if same { (*i.min(&j), *i.max(&j)) } else { (*i, j) };
                        let Some(pair) = pair(&a[i], &b[j]) else { return true };
                        if self.reachable(&pair) {
                            keys.push((i as u64) << 32 | j as u64);
                        }
                        seen += 1;
                        seen <= left
                    });
                }
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
        features.par_iter().map(|feature| self.swept(feature.corners())).collect()
    }

    /// The box around what a feature sweeps.
    fn swept(&self, corners: &[usize]) -> Bounds {
        Bounds::around(corners.iter().flat_map(|&v| [self.x0[v], self.x1[v]]))
    }

    /// Whether the boxes around what the features of a pair sweep come closer than the radius.
    fn boxes_meet(&self, pair: &Pair) -> bool {
        let corners = pair.corners();
        let (first, second) = corners.split_at(pair.corners_of_first());
        self.swept(first).grown(self.radius).meets(&self.swept(second))
    }

    /// Whether a pair is near enough at the start for how far it moves.
    fn reachable(&self, pair: &Pair) -> bool {
        let (start, end) = (pair.gather(self.x0), pair.gather(self.x1));
        let first = pair.corners_of_first();
        let moved: [Vec3; 4] = std::array::from_fn(|i| end[i] - start[i]);
        let mut closing2 = 0.0_f64;
        for i in 0..first {
            for j in first..4 {
                closing2 = closing2.max((moved[i] - moved[j]).norm_squared());
            }
        }
        let reach = self.radius + closing2.sqrt();
        pair.closest(&start).d2 <= reach * reach
    }
}

#[cfg(test)]
mod tests;
