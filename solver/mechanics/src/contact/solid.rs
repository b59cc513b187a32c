//! Pairs of features of one body between which there is its solid. They are no contact:
//! both skins of a wall cannot meet, however thin it is or becomes.
//!
//! The segment between the closest points of a pair at rest, of length D, runs through the
//! solid if
//!
//! - it crosses no facet on its way,
//! - its middle is on the surface, as between neighbours on a skin, or inside by the winding
//!   number, and
//! - D < r, or D < 2 r and N·N′ ≤ −½ for facets of both ends, or D < 10 r and n·N ≤ −½ at
//!   both ends for a facet there
//!
//! r   range of the barrier [m]
//! n   direction of the segment, seen from that end;   N   outward normal of a facet
//!
//! A wall that is stretched to three times its length in two directions has a ninth of its
//! thickness: all walls that come within range at such stretches are left out, and points
//! beside each other on both skins of a thin one, which is compressed to a half. Longer
//! segments are not, so that a bar can be bent until its ends meet. Nor are those that run
//! close under one skin, which meets itself where it is folded.
//!
//! All of this is decided by the rest shape alone. So nothing changes while a state is
//! searched for, and the energy has no jumps; a design changes a pair where its shapes do.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::{SurfaceMesh, Vec3};

use super::pairs::{Facets, Pair};
use super::surface::Surface;
use crate::parallel::map_merge;

/// D/r from which on pairs repel each other, whatever is between them.
const REACH: f64 = 10.0;

/// D/r from which on skins are not enough that face away from each other.
const BESIDE: f64 = 2.0;

/// −n·N of a segment that does not run along its skin, and −N·N′ of opposite skins.
const STEEP: f64 = 0.5;

/// |n·N| of a facet that is crossed; below, the segment runs along it, up to the rounding of
/// files. So does one whose middle is so near the surface, in D.
const ALONG: f64 = 1e-3;

/// Pairs that are remembered, at most: 80 MB.
const MOST_KNOWN: usize = 1_500_000;

/// Shares of a segment near its ends where nothing is crossed: rounding of closest points.
const ENDS: f64 = 1e-6;

/// The solid of the bodies at rest.
pub struct Solid {
    surface: Arc<Surface>,
    rest: Vec<Vec3>,
    range: f64,
    /// Facets of the bodies.
    facets: Facets,
    search: OnceLock<(SurfaceBvh, WindingNumber)>,
    /// Pairs that were asked for before, as the same come with every step of a search.
    known: Mutex<HashMap<Pair, bool>>,
}

impl Solid {
    /// The solid of a surface at rest positions of its vertices [m], for a barrier of this
    /// range [m].
    pub fn new(surface: &Arc<Surface>, rest: &[Vec3], range: f64) -> Self {
        let triangles = surface.features().triangles.iter().copied();
        let facets = triangles.filter(|t| !surface.is_obstacle(t[0])).collect();
        let facets = Facets::new(facets, rest.len());
        let (surface, rest, search) = (Arc::clone(surface), rest.to_vec(), OnceLock::new());
        Self { surface, rest, range, facets, search, known: Mutex::default() }
    }

    /// The pairs that are not through the solid, and those that are, both in their order.
    pub fn partition(&self, pairs: Vec<Pair>) -> [Vec<Pair>; 2] {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let new: Vec<Pair> =
            pairs.iter().filter(|pair| !known.contains_key(pair)).copied().collect();
        if known.len() + new.len() > MOST_KNOWN {
            known.clear();
        }
        let asked = if known.is_empty() { &pairs } else { &new };
        let part = |range: Range<usize>| -> Vec<bool> {
            asked[range].iter().map(|pair| self.is_between(pair)).collect()
        };
        map_merge(asked.len(), part, |range, through| {
            known.extend(asked[range].iter().copied().zip(through));
        });
        let (through, others) = pairs.into_iter().partition(|pair| known[pair]);
        [others, through]
    }

    /// Whether there is the solid of their body between the features of a pair.
    pub fn is_between(&self, pair: &Pair) -> bool {
        if !self.surface.within_one_body(pair) {
            return false;
        }
        let (x, first) = (pair.gather(&self.rest), pair.corners_of_first());
        let closest = pair.closest(&x);
        let distance = closest.d2.sqrt();
        if distance >= REACH * self.range {
            return false;
        }
        let ends = self.facets.ends(pair, &closest);
        let n = -closest.offset / distance;
        if distance >= self.range && !self.is_wall(&ends, n, distance) {
            return false;
        }
        let start: Vec3 = (0..first).map(|i| closest.coefficients[i] * x[i]).sum();
        let (facets, winding) = self.search();
        let crosses = |&(share, facet): &(f64, usize)| {
            (ENDS..1.0 - ENDS).contains(&share)
                && !ends.iter().flatten().any(|&f| f == facet)
                && n.dot(&self.normal(facet)).abs() > ALONG
        };
        let middle = start - 0.5 * closest.offset;
        !facets.ray(&start, &-closest.offset).iter().any(crosses)
            && (facets.closest(&middle).distance < ALONG * distance || winding.contains(&middle))
    }

    /// Whether facets at both ends of a segment, which leaves the first along n, are skins of
    /// one wall.
    fn is_wall(&self, [first, second]: &[Vec<usize>; 2], n: Vec3, length: f64) -> bool {
        let away =
            |n: Vec3, facets: &[usize]| facets.iter().any(|&f| n.dot(&self.normal(f)) <= -STEEP);
        let steep = away(n, first) && away(-n, second);
        let beside = length < BESIDE * self.range;
        steep || (beside && first.iter().any(|&f| away(self.normal(f), second)))
    }

    fn normal(&self, facet: usize) -> Vec3 {
        self.facets.normal(facet, &self.rest)
    }

    fn search(&self) -> &(SurfaceBvh, WindingNumber) {
        self.search.get_or_init(|| {
            let vertices = self.rest.clone();
            let surface = SurfaceMesh { vertices, triangles: self.facets.all().to_vec() };
            (SurfaceBvh::new(&surface), WindingNumber::new(&surface))
        })
    }
}
