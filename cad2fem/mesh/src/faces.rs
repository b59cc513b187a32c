//! Faces of a body by what they measure, and which faces of a changed body they are.

use std::collections::{BTreeMap, BTreeSet};

use crate::topology::directed_edges;
use crate::{SurfaceMesh, Vec3, place_key};

/// Differences of middle [√area of the body], area [1] and normal [1] up to which two faces are the same: other facets of a
/// curved face cause such differences.
const SAME: [f64; 3] = [1e-3, 0.01, 0.02];

/// Differences beyond which a face is another one: a quarter of the body, twice the area, 29°.
const FARTHEST: [f64; 3] = [0.25, std::f64::consts::LN_2, 0.5];

/// Weight of other neighbours, beside the differences of middle, area and normal [1].
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
    pub fn of(surface: &SurfaceMesh, triangles: impl Iterator<Item = usize>) -> Self {
        let mut face = Self::default();
        for t in triangles {
            let part = surface.area(t);
            face.area += part;
            face.middle += part * surface.centroid(t);
            face.normal += part * surface.normal(t);
        }
        face.middle /= face.area;
        face.normal /= face.area;
        face
    }

    /// The faces of one body, each a patch; they meet where they have edges with the same bits.
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
    pub fn differs(&self, other: &Self) -> [f64; 3] {
        let area = (other.area / self.area).ln().abs();
        [(other.middle - self.middle).norm(), area, (other.normal - self.normal).norm()]
    }
}

/// A face of a changed body that stands for an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Again {
    /// The number of the later face.
    pub face: usize,
    /// Whether both faces measure the same, apart from how they are cut into facets.
    pub same: bool,
    /// How many neighbours of the earlier face are neighbours of the later one.
    pub beside: usize,
}

/// Two faces that may be the same, by what they measure.
struct Pair {
    before: usize,
    now: usize,
    /// Sum of what differs [1].
    difference: f64,
    differs: bool,
}

/// For each earlier face the one that it is now, if any is like it; none stands for two.
///
/// Faces that measure the same are found first. The others follow by what differs least: their middles, areas, normals and
/// the neighbours that are found already. In each round those pairs are taken of which neither face has a better one.
pub fn found_again(before: &[Face], now: &[Face]) -> Vec<Option<Again>> {
    let mut pairs = pairs(before, now);
    let mut found: Vec<Option<Again>> = vec![None; before.len()];
    while !pairs.is_empty() {
        let cost = |pair: &Pair| {
            let [common, known] = common(&before[pair.before], &now[pair.now], &found);
            let strange = if known == 0 { 0.0 } else { 1.0 - common as f64 / known as f64 };
            (pair.differs, pair.difference + NEIGHBOURS * strange)
        };
        let costs: Vec<(bool, f64)> = pairs.iter().map(cost).collect();
        let less = |i: usize, j: usize| {
            costs[i].0.cmp(&costs[j].0).then(costs[i].1.total_cmp(&costs[j].1)).is_lt()
        };
        let mut best = [vec![None; before.len()], vec![None; now.len()]];
        for (i, pair) in pairs.iter().enumerate() {
            for (best, face) in best.iter_mut().zip([pair.before, pair.now]) {
                best[face] = best[face].filter(|&other| !less(i, other)).or(Some(i));
            }
        }
        let mut taken = vec![false; now.len()];
        for (i, &Pair { before: b, now: face, differs, .. }) in pairs.iter().enumerate() {
            if best[0][b] == Some(i) && best[1][face] == Some(i) {
                found[b] = Some(Again { face, same: !differs, beside: 0 });
                taken[face] = true;
            }
        }
        pairs.retain(|pair| found[pair.before].is_none() && !taken[pair.now]);
    }
    let beside = |b: usize| {
        let again = found[b]?;
        Some(Again { beside: common(&before[b], &now[again.face], &found)[0], ..again })
    };
    (0..before.len()).map(beside).collect()
}

/// All pairs of faces that are not too far to be the same.
fn pairs(before: &[Face], now: &[Face]) -> Vec<Pair> {
    let size = before.iter().map(|face| face.area).sum::<f64>().sqrt();
    let within = |found: [f64; 3], most: [f64; 3]| (0..3).all(|i| found[i] <= most[i]);
    let mut pairs = Vec::new();
    for (b, earlier) in before.iter().enumerate() {
        for (n, later) in now.iter().enumerate() {
            let [middle, area, normal] = earlier.differs(later);
            let found = [middle / size, area, normal];
            if within(found, FARTHEST) {
                let (difference, differs) = (found.iter().sum(), !within(found, SAME));
                pairs.push(Pair { before: b, now: n, difference, differs });
            }
        }
    }
    pairs
}

/// How many neighbours of a face are also neighbours of another one, and of how many it is known which they are now.
fn common(before: &Face, now: &Face, found: &[Option<Again>]) -> [usize; 2] {
    let known = before.beside.iter().filter_map(|&b| found[b]);
    known.fold([0, 0], |[common, known], again| {
        [common + usize::from(now.beside.binary_search(&again.face).is_ok()), known + 1]
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
            let normal = surface.normal(t).map(|x| x.round() as i64);
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
