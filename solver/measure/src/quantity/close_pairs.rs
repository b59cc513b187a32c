//! Pairs of features that are close on a surface, where planes of symmetry cut it those of the whole.

use std::collections::BTreeSet;

use mechanics::contact::candidates::{close_between, close_within};
use mechanics::contact::images::Mirrored;
use mechanics::contact::pairs::{Facets, Features, Pair};
use mechanics::symmetry::Plane;
use mesh::Vec3;

/// Two of several parts have vertices in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "parts {} and {} share {count} vertices, the first is {vertex}: no distance is defined there; name \
     parts that are apart, and leave the surface that joins them (the seat) out of both",
    .parts[0],
    .parts[1]
)]
pub struct PartsTouch {
    /// Their numbers, from 1.
    pub parts: [usize; 2],
    /// Number of shared vertices.
    pub count: usize,
    /// The smallest shared vertex id.
    pub vertex: usize,
}

impl PartsTouch {
    /// Refuses sets of facets of which two have a common vertex.
    pub fn check(parts: &[Vec<[usize; 3]>]) -> Result<(), Self> {
        let of = |part: &Vec<[usize; 3]>| part.iter().flatten().copied().collect::<BTreeSet<_>>();
        let vertices: Vec<BTreeSet<usize>> = parts.iter().map(of).collect();
        for (j, other) in vertices.iter().enumerate() {
            for (i, one) in vertices[..j].iter().enumerate() {
                let shared: Vec<usize> = one.intersection(other).copied().collect();
                if let [vertex, ..] = shared[..] {
                    return Err(Self { parts: [i + 1, j + 1], count: shared.len(), vertex });
                }
            }
        }
        Ok(())
    }
}

/// Cosine of the greatest angle between the straight line through the air and the normals of both sides: 30°.
const FACING: f64 = 0.866;

/// Pairs of features of a surface.
pub struct ClosePairs {
    /// The whole of what planes of symmetry cut.
    pub whole: Mirrored,
    which: Which,
}

/// Which pairs count.
enum Which {
    /// Pairs between parts: of each part and of all parts after it.
    Between(Vec<[Features; 2]>),
    /// Pairs of one surface without a common vertex.
    Within(Features),
    /// Pairs of one surface that face each other through air.
    ThroughAir(Features, Facets),
}

impl ClosePairs {
    /// Between each two of several sets of facets: walls.
    pub fn between(planes: &[Plane], parts: &[Vec<[usize; 3]>]) -> Result<Self, PartsTouch> {
        PartsTouch::check(parts)?;
        let (whole, mirrored) = Mirrored::new(planes, parts);
        let sides =
            |i: usize| [mirrored[i - 1].as_slice(), &mirrored[i..].concat()].map(Features::new);
        Ok(Self { whole, which: Which::Between((1..parts.len()).map(sides).collect()) })
    }

    /// Within a set of facets.
    pub fn within(planes: &[Plane], facets: &[[usize; 3]]) -> Self {
        let (whole, mirrored) = Mirrored::new(planes, &[facets.to_vec()]);
        Self { whole, which: Which::Within(Features::new(&mirrored[0])) }
    }

    /// Within a set of facets those from each of which the straight line to the other leaves the solid, within 30° of
    /// the normal of a facet there, so that neighbours along the surface are none: what a core is there.
    pub fn through_air(planes: &[Plane], facets: &[[usize; 3]]) -> Self {
        let (whole, mirrored) = Mirrored::new(planes, &[facets.to_vec()]);
        let facets = mirrored.concat();
        let count = facets.as_flattened().iter().max().map_or(0, |last| last + 1);
        let features = Features::new(&facets);
        Self { whole, which: Which::ThroughAir(features, Facets::new(facets, count)) }
    }

    /// Those closer than `radius` [m] at positions of the body's vertices, with the positions of the whole.
    pub fn at(&self, vertices: &[Vec3], radius: f64) -> (Vec<Pair>, Vec<Vec3>) {
        let x = self.whole.positions(vertices);
        let pairs = match &self.which {
            Which::Between(sides) => {
                sides.iter().flat_map(|[a, b]| close_between(a, b, &x, radius)).collect()
            }
            Which::Within(features) => close_within(features, &x, radius),
            Which::ThroughAir(features, facets) => {
                let mut pairs = close_within(features, &x, radius);
                pairs.retain(|pair| face_each_other(facets, pair, &x));
                pairs
            }
        };
        (pairs, x)
    }

    /// What a distance [m] of one of them is.
    pub fn in_words(&self, distance: f64) -> String {
        match self.which {
            Which::Between(_) => format!("the wall is {distance:.3e} m thin"),
            _ => format!("the surface is {distance:.3e} m from itself"),
        }
    }
}

fn face_each_other(facets: &Facets, pair: &Pair, x: &[Vec3]) -> bool {
    let closest = pair.closest(&pair.gather(x));
    let way = -closest.offset / closest.d2.sqrt();
    let [first, second] = facets.ends(pair, &closest);
    let leaves =
        |ends: Vec<usize>, way: Vec3| ends.iter().any(|&f| facets.normal(f, x).dot(&way) >= FACING);
    leaves(first, way) && leaves(second, -way)
}
