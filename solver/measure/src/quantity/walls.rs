//! Distances between parts of a surface, where planes of symmetry cut it those of the whole.

use std::collections::BTreeSet;

use mechanics::contact::candidates::{close_between, closest_between};
use mechanics::contact::images::Mirrored;
use mechanics::contact::pairs::{Features, Pair};
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
    ///
    /// # Errors
    /// [`SidesTouch`] if a vertex belongs to two sets.
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
    #[must_use]
    pub fn pairs(&self, x: &[Vec3], radius: f64) -> Vec<Pair> {
        self.sides.iter().flat_map(|[a, b]| close_between(a, b, x, radius)).collect()
    }

    /// Smallest distance between two parts [m]; infinite if there are none.
    #[must_use]
    pub fn min_distance(&self, x: &[Vec3]) -> f64 {
        let x = self.whole.positions(x);
        let least = |sides| closest_between(sides, &x).map_or(f64::INFINITY, |c| c.1.d2.sqrt());
        self.sides.iter().map(least).fold(f64::INFINITY, f64::min)
    }
}

/// Refuses two sets of facets with a common vertex.
fn check_apart(inner: &[[usize; 3]], outer: &[[usize; 3]]) -> Result<(), SidesTouch> {
    let [inner, outer] = [inner, outer].map(|s| s.iter().flatten().collect::<BTreeSet<_>>());
    let mut shared = inner.intersection(&outer);
    let count = shared.clone().count();
    shared.next().map_or(Ok(()), |&&first| Err(SidesTouch { count, first }))
}
