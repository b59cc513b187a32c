//! Distances between parts of a surface, where planes of symmetry cut it those of the whole.

use std::collections::BTreeSet;

use mechanics::contact::candidates::{close_between, close_within, closest_between};
use mechanics::contact::images::Mirrored;
use mechanics::contact::pairs::{Facets, Features, Pair};
use mechanics::symmetry::Plane;
use mesh::Vec3;

/// Two parts have vertices in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the two sides of the wall share {count} vertices, the first is {first}: no thickness is \
     defined there; leave the surface that joins them (the seat) out of both sides"
)]
pub struct SidesTouch {
    /// Number of shared vertices.
    pub count: usize,
    /// The smallest shared vertex id.
    pub first: usize,
}

/// Walls between each two of several parts of a surface.
pub struct Walls {
    /// The whole of what planes of symmetry cut.
    pub whole: Mirrored,
    /// Parts, each with what it is compared with.
    sides: Vec<[Features; 2]>,
}

impl Walls {
    /// The walls between each two of several sets of facets.
    pub fn new(planes: &[Plane], parts: &[Vec<[usize; 3]>]) -> Result<Self, SidesTouch> {
        let (whole, mirrored) = Mirrored::new(planes, parts);
        let mut sides = Vec::new();
        for i in 1..parts.len() {
            check_apart(&parts[i - 1], &parts[i..].concat())?;
            sides.push([mirrored[i - 1].as_slice(), &mirrored[i..].concat()].map(Features::new));
        }
        Ok(Self { whole, sides })
    }

    /// Pairs closer than `radius` [m] at positions of the whole.
    pub fn pairs(&self, x: &[Vec3], radius: f64) -> Vec<Pair> {
        self.sides.iter().flat_map(|[a, b]| close_between(a, b, x, radius)).collect()
    }

    /// Smallest distance between two parts [m]; infinite if there are none.
    pub fn min_distance(&self, x: &[Vec3]) -> f64 {
        let x = self.whole.positions(x);
        let least = |sides| closest_between(sides, &x).map_or(f64::INFINITY, |c| c.1.d2.sqrt());
        self.sides.iter().map(least).fold(f64::INFINITY, f64::min)
    }
}

/// Cosine of the greatest angle between the straight line through the air and the normals of both sides: 30°.
const FACING: f64 = 0.866;

/// Air between parts of one surface that face each other: what a core is there.
pub struct Cores {
    /// The whole of what planes of symmetry cut.
    pub whole: Mirrored,
    features: Features,
    facets: Facets,
}

impl Cores {
    /// The air beside a set of facets.
    pub fn new(planes: &[Plane], facets: &[[usize; 3]]) -> Self {
        let (whole, mirrored) = Mirrored::new(planes, &[facets.to_vec()]);
        let facets = mirrored.concat();
        let count = facets.as_flattened().iter().max().map_or(0, |last| last + 1);
        Self { whole, features: Features::new(&facets), facets: Facets::new(facets, count) }
    }

    /// Pairs closer than `radius` [m] at positions of the whole, from each of which the straight line to the other leaves the
    /// solid, within 30° of the normal of a facet there: neighbours along the surface are none.
    pub fn pairs(&self, x: &[Vec3], radius: f64) -> Vec<Pair> {
        let mut pairs = close_within(&self.features, x, radius);
        pairs.retain(|pair| self.face_each_other(pair, x));
        pairs
    }

    fn face_each_other(&self, pair: &Pair, x: &[Vec3]) -> bool {
        let closest = pair.closest(&pair.gather(x));
        let way = -closest.offset / closest.d2.sqrt();
        let [first, second] = self.facets.ends(pair, &closest);
        let leaves = |facets: Vec<usize>, way: Vec3| {
            facets.iter().any(|&f| self.facets.normal(f, x).dot(&way) >= FACING)
        };
        leaves(first, way) && leaves(second, -way)
    }
}

/// Refuses two sets of facets with a common vertex.
fn check_apart(inner: &[[usize; 3]], outer: &[[usize; 3]]) -> Result<(), SidesTouch> {
    let [inner, outer] = [inner, outer].map(|s| s.iter().flatten().collect::<BTreeSet<_>>());
    let mut shared = inner.intersection(&outer);
    let count = shared.clone().count();
    shared.next().map_or(Ok(()), |&&first| Err(SidesTouch { count, first }))
}
