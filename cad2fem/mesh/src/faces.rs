//! Faces of a body by what they measure, and which faces of a changed body they are.

use std::collections::{BTreeMap, BTreeSet};

use crate::measure::{triangle_area, triangle_normal};
use crate::topology::directed_edges;
use crate::{SurfaceMesh, Vec3, place_key};

/// What is the same to a middle [√area of the body], an area [1] and a normal [1], as facets of a curved face differ.
const SAME: [f64; 3] = [1e-3, 0.01, 0.02];

/// What is too far for a face to be the same: a quarter of the body, twice the area, 29°.
const FARTHEST: [f64; 3] = [0.25, std::f64::consts::LN_2, 0.5];

/// What neighbours that are others weigh beside differences of middle, area and normal.
const NEIGHBOURS: f64 = 0.5;

/// What a face measures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Face {
    /// [m²]
    pub area: f64,
    /// Middle of its area [m].
    pub middle: Vec3,
    /// Mean of its unit normals: 1 long where it is flat, 0 where it goes around.
    pub normal: Vec3,
    /// Numbers of the faces that have an edge in common with it, ascending.
    pub beside: Vec<usize>,
}

impl Face {
    /// A face of some triangles of a surface, without neighbours.
    #[must_use]
    pub fn of(surface: &SurfaceMesh, triangles: impl Iterator<Item = usize>) -> Self {
        let mut face = Self::default();
        for t in triangles {
            let [a, b, c] = surface.corners(t);
            let part = triangle_area(a, b, c);
            face.area += part;
            face.middle += part * surface.centroid(t);
            face.normal += part * triangle_normal(a, b, c);
        }
        face.middle /= face.area;
        face.normal /= face.area;
        face
    }

    /// The faces of one body, each a patch; they meet where they have edges with the same bits.
    #[must_use]
    pub fn of_patches(patches: &[SurfaceMesh]) -> Vec<Self> {
        let mut at_edge: BTreeMap<[[u64; 3]; 2], BTreeSet<usize>> = BTreeMap::new();
        for (face, patch) in patches.iter().enumerate() {
            for side in patch.triangles.iter().flat_map(|&triangle| directed_edges(triangle)) {
                let mut edge = side.map(|v| place_key(&patch.vertices[v]));
                edge.sort_unstable();
                at_edge.entry(edge).or_default().insert(face);
            }
        }
        let mut beside = vec![BTreeSet::new(); patches.len()];
        for faces in at_edge.values().filter(|faces| faces.len() > 1) {
            faces.iter().for_each(|&face| beside[face].extend(faces));
        }
        let face = |(i, patch): (usize, &SurfaceMesh)| {
            beside[i].remove(&i);
            let beside = beside[i].iter().copied().collect();
            Self { beside, ..Self::of(patch, 0..patch.triangles.len()) }
        };
        patches.iter().enumerate().map(face).collect()
    }

    /// By how much another face differs: its middle [m], the logarithm of its area [1], its normal [1].
    #[must_use]
    pub fn differs(&self, other: &Self) -> [f64; 3] {
        let area = (other.area / self.area).ln().abs();
        [(other.middle - self.middle).norm(), area, (other.normal - self.normal).norm()]
    }
}

/// A face of a changed body that stands for an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Again {
    /// Its number.
    pub face: usize,
    /// Whether it measures the same, but for facets.
    pub same: bool,
    /// How many of the neighbours of the earlier face stand beside it.
    pub beside: usize,
}

/// For each earlier face the one that it is now, if any is like it; none stands for two.
///
/// Faces that measure the same are found first. The others follow by what differs least: their middles, areas, normals and
/// the neighbours that are found already.
#[must_use]
pub fn found_again(before: &[Face], now: &[Face]) -> Vec<Option<Again>> {
    let size = before.iter().map(|face| face.area).sum::<f64>().sqrt();
    let scaled = |b: usize, n: usize| {
        let [middle, area, normal] = before[b].differs(&now[n]);
        [middle / size, area, normal]
    };
    let within = |found: [f64; 3], most: [f64; 3]| (0..3).all(|i| found[i] <= most[i]);
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for b in 0..before.len() {
        let near = (0..now.len()).map(|n| (n, scaled(b, n)));
        let near = near.filter(|(_, difference)| within(*difference, FARTHEST));
        pairs.extend(near.map(|(n, difference)| (b, n, difference.iter().sum())));
    }
    let mut found: Vec<Option<usize>> = vec![None; before.len()];
    let mut is_same = vec![false; before.len()];
    loop {
        let cost = |&(b, n, difference): &(usize, usize, f64)| {
            let same = within(scaled(b, n), SAME);
            let [common, known] = common(&before[b], &now[n], &found);
            let strange = if known == 0 { 0.0 } else { 1.0 - common as f64 / known as f64 };
            (!same, difference + NEIGHBOURS * strange)
        };
        let least = pairs.iter().map(|pair| (cost(pair), *pair));
        let Some(((differs, _), (b, n, _))) =
            least.min_by(|(x, _), (y, _)| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)))
        else {
            break;
        };
        (found[b], is_same[b]) = (Some(n), !differs);
        pairs.retain(|&(other, taken, _)| other != b && taken != n);
    }
    let again = |b: usize| {
        let face = found[b]?;
        Some(Again { face, same: is_same[b], beside: common(&before[b], &now[face], &found)[0] })
    };
    (0..before.len()).map(again).collect()
}

/// How many neighbours of a face are also neighbours of another one, and of how many it is known which they are now.
fn common(before: &Face, now: &Face, found: &[Option<usize>]) -> [usize; 2] {
    let known = before.beside.iter().filter_map(|&b| found[b]);
    known.fold([0, 0], |[common, known], n| {
        [common + usize::from(now.beside.binary_search(&n).is_ok()), known + 1]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Solid;
    use crate::topology::submesh;

    /// The faces of a box with a box of air in it, by their normals, those of the air last.
    fn hollow(length: f64, air: [f64; 2]) -> Vec<Face> {
        let outer = Solid::cube(&Vec3::zeros(), &Vec3::new(length, 20.0, 10.0));
        let inner = Solid::cube(&Vec3::new(air[0], 5.0, 3.0), &Vec3::new(air[1], 15.0, 7.0));
        let surface = outer.difference(&inner).to_surface();
        let mut parts: BTreeMap<(bool, [i64; 3]), Vec<[usize; 3]>> = BTreeMap::new();
        for (t, &triangle) in surface.triangles.iter().enumerate() {
            let [a, b, c] = surface.corners(t);
            let normal = triangle_normal(a, b, c).map(|x| x.round() as i64);
            let inside =
                [a, b, c].iter().all(|p| (5.0..=15.0).contains(&p.y) && (3.0..=7.0).contains(&p.z));
            parts.entry((inside, normal.into())).or_default().push(triangle);
        }
        let patches: Vec<_> =
            parts.values().map(|part| submesh(&surface.vertices, part).0).collect();
        Face::of_patches(&patches)
    }

    /// Which face each is now, whether it measures the same, and how many of its neighbours are beside it.
    fn told(before: &[Face], now: &[Face]) -> Vec<Option<(usize, bool, usize)>> {
        let again = found_again(before, now);
        again.into_iter().map(|a| a.map(|a| (a.face, a.same, a.beside))).collect()
    }

    #[test]
    fn faces_know_their_neighbours() {
        let faces = hollow(40.0, [5.0, 25.0]);
        assert_eq!(faces.len(), 12);
        assert!(faces.iter().all(|face| face.beside.len() == 4));
        assert!(
            (faces[0].area - 200.0).abs() < 1e-9 && (faces[0].normal + Vec3::x()).norm() < 1e-12
        );
        assert!((faces[0].middle - Vec3::new(0.0, 10.0, 5.0)).norm() < 1e-12);
    }

    #[test]
    fn other_numbers_are_no_other_faces() {
        let before = hollow(40.0, [5.0, 25.0]);
        let mut now = before.clone();
        now.reverse();
        let last = now.len() - 1;
        for face in &mut now {
            face.beside.iter_mut().for_each(|n| *n = last - *n);
            face.beside.sort_unstable();
        }
        let expected: Vec<_> = (0..12).map(|i| Some((last - i, true, 4))).collect();
        assert_eq!(told(&before, &now), expected);
    }

    #[test]
    fn a_longer_body_keeps_its_faces_by_their_neighbours() {
        let (before, now) = (hollow(40.0, [5.0, 25.0]), hollow(50.0, [5.0, 33.0]));
        let found = told(&before, &now);
        let numbers: Vec<_> =
            found.iter().map(|found| found.map(|(face, _, beside)| (face, beside))).collect();
        assert_eq!(numbers, (0..12).map(|i| Some((i, 4))).collect::<Vec<_>>());
        let same = found.iter().filter(|found| found.is_some_and(|(_, same, _)| same)).count();
        assert_eq!(same, 2, "the end and the wall of the air that have not moved: {found:?}");
    }

    #[test]
    fn a_face_that_is_gone_is_no_other_one() {
        let before = hollow(40.0, [5.0, 25.0]);
        // without the end at x = 40, which is no other face, though it is as large as that at x = 0
        let end = before.iter().position(|face| face.middle.x > 39.0).expect("it has an end");
        let mut now = before.clone();
        now.remove(end);
        for face in &mut now {
            face.beside.retain(|&n| n != end);
            face.beside.iter_mut().filter(|n| **n > end).for_each(|n| *n -= 1);
        }
        let found = told(&before, &now);
        assert_eq!(found[end], None);
        assert_eq!(found.iter().flatten().count(), 11);
    }
}
