//! Threads on and in a body: where their segments lie, and the force along each.
//!
//! `windings.csv` has both ends of each segment at rest. Each is found on a facet of the mesh, at the weights b and c of
//! its second and third corner. The page interpolates the displacement of the facet's nodes there, in every state, as
//! the solver does. Facets inside the body are known where the page has its cells. A thread at a depth below its tag has
//! ends inside cells, too: segments that meet there are joined, and what is left of one at an end of the thread goes.

use std::path::Path;

use anyhow::{Context as _, Result};
use mesh::bvh::{Closest, SurfaceBvh};
use mesh::io::read_text;
use mesh::{SurfaceMesh, Vec3};
use serde_json::{Value, json};

use crate::solid::Solid;
use crate::store::Store;

/// The file beside a state.
const FILE: &str = "windings.csv";
/// Columns of `windings.csv` behind the name: where the ends are at rest, and the force.
const NUMBERS: usize = 13;
/// Farthest that an end may lie from a facet, as a part of the size of the body [1].
const ON: f64 = 1e-6;

/// Ends of segments that are nearer than this are one point [m].
const SAME: f64 = 1e-9;

/// Ends of segments, and what joins two of them.
#[derive(Debug, Default, PartialEq)]
struct Lines {
    /// Ends at rest [m]. Segments that follow each other share one.
    points: Vec<Vec3>,
    /// First and last point of each segment.
    segments: Vec<[usize; 2]>,
    /// Mean force along each [N].
    forces: Vec<f64>,
}

impl Lines {
    fn read(path: &Path) -> Result<Self> {
        let mut lines = Self::default();
        for (i, row) in read_text(path)?.lines().enumerate().skip(1) {
            let row = numbers(row).with_context(|| {
                format!(
                    "{}: line {} does not end with {NUMBERS} finite numbers; expected the file that `solver \
                     simulate` writes",
                    path.display(),
                    i + 1
                )
            })?;
            let end = |first: usize| Vec3::from_column_slice(&row[first..first + 3]);
            lines.add(end(0), end(6), row[NUMBERS - 1]);
        }
        Ok(lines)
    }

    fn add(&mut self, start: Vec3, end: Vec3, force: f64) {
        if self.points.last().is_none_or(|last| (last - start).norm() > SAME) {
            self.points.push(start);
        }
        self.points.push(end);
        self.segments.push([self.points.len() - 2, self.points.len() - 1]);
        self.forces.push(force);
    }
}

impl Lines {
    /// The lines without some points: segments that meet in one of them are joined, with their mean force.
    fn without(self, is_gone: impl Fn(usize) -> bool) -> Self {
        let numbers: Vec<Option<usize>> = (0..self.points.len())
            .scan(0, |kept, point| {
                let number = (!is_gone(point)).then_some(*kept);
                *kept += usize::from(number.is_some());
                Some(number)
            })
            .collect();
        let mut lines = Self::default();
        // where the segment that is being joined began, its length and that times its force
        let (mut start, mut length, mut pulled) = (None, 0.0, 0.0);
        let mut reached = None;
        for (&[a, b], force) in self.segments.iter().zip(&self.forces) {
            if numbers[a].is_some() || reached != Some(a) {
                (start, length, pulled) = (numbers[a], 0.0, 0.0);
            }
            reached = Some(b);
            let own = (self.points[b] - self.points[a]).norm();
            (length, pulled) = (length + own, pulled + own * force);
            if let (Some(from), Some(to)) = (start, numbers[b]) {
                lines.segments.push([from, to]);
                lines.forces.push(pulled / length);
            }
        }
        let points = self.points.into_iter().zip(numbers);
        lines.points = points.filter_map(|(point, number)| number.map(|_| point)).collect();
        lines
    }
}

/// The last numbers of a row, whose name may have commas.
fn numbers(row: &str) -> Option<[f64; NUMBERS]> {
    let mut found = [0.0; NUMBERS];
    let mut cells = row.rsplit(',');
    for number in found.iter_mut().rev() {
        *number = cells.next()?.trim().parse().ok().filter(|x: &f64| x.is_finite())?;
    }
    Some(found)
}

/// Facets of a mesh, to find points on.
struct Facets {
    /// Nodes per facet.
    nodes: usize,
    /// Nodes of all facets, corners first.
    all: Vec<usize>,
    surface: SurfaceMesh,
    tree: SurfaceBvh,
}

impl Facets {
    fn new(points: &[Vec3], nodes: usize, all: Vec<usize>) -> Self {
        let triangles = all.chunks_exact(nodes).map(|f| [f[0], f[1], f[2]]).collect();
        let surface = SurfaceMesh { vertices: points.to_vec(), triangles };
        let tree = SurfaceBvh::new(&surface);
        Self { nodes, all, surface, tree }
    }

    /// The nodes of the facet on which a point was found, and the weights of its second and third corner there.
    fn spot(&self, found: &Closest) -> (Vec<usize>, [f64; 2]) {
        let first = self.nodes * found.triangle;
        let corners = self.surface.corners(found.triangle);
        (self.all[first..first + self.nodes].to_vec(), weights(&found.point, &corners))
    }
}

/// Weights of the second and third corner of a triangle at a point in its plane.
fn weights(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> [f64; 2] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(&ac);
    let area = normal.norm_squared();
    [ap.cross(&ac).dot(&normal) / area, ab.cross(&ap).dot(&normal) / area]
}

/// Where points lie: the facet of each among those that are used, its weights there, and the largest depth below the
/// boundary [m].
struct Spots {
    facets: Vec<usize>,
    facet_of_point: Vec<usize>,
    places: Vec<f64>,
    depth: f64,
}

/// Finds the points of lines on the facets of a solid, and lets lines without those that are on none; none where no
/// segment is left.
fn spots(solid: &Solid, lines: Lines) -> Option<(Lines, Spots)> {
    let size = extent(solid.points());
    let (nodes, outer) = solid.boundary();
    let outer = Facets::new(solid.points(), nodes, outer.to_vec());
    let near: Vec<Closest> = lines.points.iter().map(|p| outer.tree.closest(p)).collect();
    let depth = near.iter().map(|found| found.distance).fold(0.0, f64::max);
    let is_on = |found: &Closest| found.distance <= ON * size;
    let inner = if near.iter().all(is_on) {
        None
    } else {
        Some(Facets::new(solid.points(), nodes, solid.sides_of_cells()?))
    };
    let place = |(p, found): (&Vec3, &Closest)| match &inner {
        Some(inner) if !is_on(found) => {
            let found = inner.tree.closest(p);
            is_on(&found).then(|| inner.spot(&found))
        }
        _ => Some(outer.spot(found)),
    };
    let places: Vec<_> = lines.points.iter().zip(&near).map(place).collect();
    let lines = lines.without(|point| places[point].is_none());
    if lines.segments.is_empty() {
        return None;
    }
    let mut spots = Spots { facets: vec![], facet_of_point: vec![], places: vec![], depth };
    let mut known = std::collections::HashMap::new();
    for (facet, place) in places.into_iter().flatten() {
        let next = known.len();
        let number = *known.entry(facet).or_insert_with_key(|facet| {
            spots.facets.extend(facet);
            next
        });
        spots.facet_of_point.push(number);
        spots.places.extend(place);
    }
    Some((lines, spots))
}

/// Length of the diagonal of the box around points.
fn extent(points: &[Vec3]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(a, b), p| (a.inf(p), b.sup(p)));
    (high - low).norm()
}

/// The threads of a run in `folder` on its solid; null where it has none, or where they cannot be found on the solid.
/// `largest` is the largest force in the report [N].
pub fn packed(
    folder: &Path,
    solid: &Solid,
    largest: Option<f64>,
    store: &mut Store,
) -> Result<Value> {
    let path = folder.join(FILE);
    if !path.exists() {
        return Ok(Value::Null);
    }
    let lines = Lines::read(&path)?;
    if lines.segments.is_empty() {
        return Ok(Value::Null);
    }
    let Some((lines, spots)) = spots(solid, lines) else {
        let why = "its threads are not on facets of the body that the page has";
        log::warn!("{}: {why}, so that they are left out", path.display());
        return Ok(Value::Null);
    };
    let (nodes, _) = solid.boundary();
    let most = lines.forces.iter().copied().fold(0.0, f64::max);
    Ok(json!({
        "facets": store.indices(&solid.numbers_of(&spots.facets), nodes),
        "facetOfPoint": store.indices(&spots.facet_of_point, 1),
        "places": store.numbers(&spots.places, 2),
        "segments": store.indices(&lines.segments.concat(), 2),
        "forces": store.numbers(&lines.forces, 1),
        "largest": largest.unwrap_or(most),
        "depth": spots.depth,
    }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use mesh::io::MshFile;
    use mesh::{Tags, TetMesh};

    use super::*;

    /// Two tetrahedra that share the facet between the unit points.
    fn pair() -> Solid {
        let vertices =
            vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(1.0, 1.0, 1.0)];
        let mesh = TetMesh { vertices, tets: vec![[0, 1, 2, 3], [1, 2, 3, 4]] };
        Solid::of_mesh(&MshFile { mesh, tags: Tags::new(vec![]) })
    }

    /// Where the page will have a point.
    fn interpolated(solid: &Solid, spots: &Spots, point: usize) -> Vec3 {
        let facet = &spots.facets[3 * spots.facet_of_point[point]..][..3];
        let [b, c] = [spots.places[2 * point], spots.places[2 * point + 1]];
        let corner = |i: usize| solid.points()[facet[i]];
        (1.0 - b - c) * corner(0) + b * corner(1) + c * corner(2)
    }

    #[test]
    fn points_are_found_outside_and_inside() {
        let solid = pair();
        let third = 1.0 / 3.0;
        let points = [
            Vec3::new(0.25, 0.5, 0.0),
            Vec3::new(0.0, 0.0, 0.7),
            Vec3::new(third, third, third),
            Vec3::new(0.2, 0.5, 0.3),
        ];
        let along = |points: &[Vec3]| {
            let mut lines = Lines::default();
            points.windows(2).for_each(|ends| lines.add(ends[0], ends[1], 1.0));
            lines
        };
        let (_, found) = spots(&solid, along(&points)).unwrap();
        for (i, point) in points.iter().enumerate() {
            assert!((interpolated(&solid, &found, i) - point).norm() < 1e-12, "{point}");
        }
        // from the middle of the facet between both, the nearest side of the cube's corner is a third away
        assert!((found.depth - third).abs() < 1e-12, "{}", found.depth);
        let inside = Vec3::new(0.1, 0.1, 0.1);
        let (lines, _) = spots(&solid, along(&[points[0], inside, points[1]])).unwrap();
        assert_eq!(lines.segments, [[0, 1]]);
        assert!(spots(&solid, along(&[points[0], inside])).is_none(), "on no facet");
    }

    #[test]
    fn segments_that_follow_each_other_share_a_point() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(FILE);
        let row =
            |name: &str, a: &str, b: &str, f: &str| format!("{name},{a},9,9,9,{b},9,9,9,{f}\n");
        let head = "winding,…\n".to_owned();
        let body = row("t", "0,0,0", "1,0,0", "0.5")
            + &row("t", "1,0,0", "0,1,0", "0")
            + &row("\"u, v\"", "0,0,1", "0,1,0", "2");
        std::fs::write(&path, head.clone() + &body).unwrap();
        let lines = Lines::read(&path).unwrap();
        assert_eq!(lines.segments, [[0, 1], [1, 2], [3, 4]]);
        assert_eq!((lines.points.len(), &lines.forces[..]), (5, &[0.5, 0.0, 2.0][..]));

        let mut store = Store::default();
        let packed = packed(dir.path(), &pair(), None, &mut store).unwrap();
        assert_eq!((&packed["largest"], &packed["depth"]), (&json!(2.0), &json!(0.0)));
        std::fs::write(&path, head + &row("t", "0,0,0", "1,0,x", "0.5")).unwrap();
        let message = Lines::read(&path).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.contains("13 finite numbers"), "{message}");
    }

    /// One point of a line goes, then its end, and the first of another line.
    #[test]
    fn segments_are_joined_where_points_go() {
        let x = |k: usize| Vec3::new(k as f64, 0.0, 0.0);
        let mut lines = Lines::default();
        for (a, b, force) in
            [(0, 1, 1.0), (1, 3, 4.0), (3, 4, 2.0), (4, 5, 9.0), (7, 8, 9.0), (8, 9, 5.0)]
        {
            lines.add(x(a), x(b), force);
        }
        let left = lines.without(|point| [1, 4, 5].contains(&point));
        assert_eq!(left.points, [0, 3, 4, 8, 9].map(x));
        assert_eq!(left.segments, [[0, 1], [1, 2], [3, 4]]);
        assert_eq!(left.forces, [3.0, 2.0, 5.0]);
    }

    #[test]
    fn weights_of_a_point_give_it_back() {
        let corners =
            [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.2, 2.0, 0.4)];
        let p = 0.2 * corners[0] + 0.3 * corners[1] + 0.5 * corners[2];
        let [b, c] = weights(&p, &corners);
        assert!((b - 0.3).abs() < 1e-12 && (c - 0.5).abs() < 1e-12);
    }
}
