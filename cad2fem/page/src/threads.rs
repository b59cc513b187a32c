//! Threads on and in a body: where their segments lie, and the force along each.
//!
//! `windings.csv` has the facet or the tetrahedron of each segment, and the weights of both of its ends there. The page
//! interpolates the displacement of a facet's nodes, in every state, as the solver does. Facets inside the body are known
//! where the page has its cells. A thread at a depth below its tag has ends inside cells, too: segments that meet there
//! are joined, and what is left of one at an end of the thread goes.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context as _, Result};
use mesh::bvh::SurfaceBvh;
use mesh::io::read_text;
use mesh::{SurfaceMesh, Vec3, facet_key};
use reports::{Segment, WINDINGS};
use serde_json::{Value, json};

use crate::solid::Solid;
use crate::store::Store;

/// A weight of a tetrahedron's vertex that is rounding: the end of a segment is on the facet of the others [1].
const ON: f64 = 1e-9;

/// Ends of segments that are nearer than this are one point [m].
const SAME: f64 = 1e-9;

/// The vertices of a facet, and their weights at a point on it.
type Spot = [(usize, f64); 3];

/// Ends of segments, and what joins two of them.
#[derive(Debug, Default, PartialEq)]
struct Lines {
    /// Ends at rest [m]. Segments that follow each other share one.
    points: Vec<Vec3>,
    /// Where each of them is; none inside a cell.
    spots: Vec<Option<Spot>>,
    /// First and last point of each segment.
    segments: Vec<[usize; 2]>,
    /// Mean force along each [N].
    forces: Vec<f64>,
}

impl Lines {
    fn new(segments: &[Segment]) -> Self {
        let mut lines = Self::default();
        for segment in segments {
            let point = |end: usize| {
                let end = &segment.ends[end];
                (Vec3::from(end.rest), spot(&segment.vertices, &end.weights))
            };
            lines.add(point(0), point(1), segment.force);
        }
        lines
    }

    fn add(&mut self, start: (Vec3, Option<Spot>), end: (Vec3, Option<Spot>), force: f64) {
        let follows = self.points.last().is_some_and(|last| (last - start.0).norm() <= SAME);
        for (point, spot) in Some(start).filter(|_| !follows).into_iter().chain([end]) {
            self.points.push(point);
            self.spots.push(spot);
        }
        self.segments.push([self.points.len() - 2, self.points.len() - 1]);
        self.forces.push(force);
    }

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
        let points = self.points.into_iter().zip(self.spots).zip(numbers);
        (lines.points, lines.spots) =
            points.filter_map(|(point, number)| number.map(|_| point)).unzip();
        lines
    }
}

/// The facet on which a point is that has these weights by the vertices of a tetrahedron, or of a facet.
fn spot(vertices: &[usize; 4], weights: &[f64; 4]) -> Option<Spot> {
    let least = (0..4).rev().min_by(|&a, &b| weights[a].abs().total_cmp(&weights[b].abs()))?;
    let out = if vertices[3] == vertices[2] { 3 } else { least };
    let mut others = (0..4).filter(|k| *k != out).map(|k| (vertices[k], weights[k]));
    let facet = [others.next()?, others.next()?, others.next()?];
    (weights[out].abs() <= ON).then_some(facet)
}

/// Facets by their corners, each with all of its nodes.
fn by_corners(per_facet: usize, nodes: &[usize]) -> HashMap<[usize; 3], &[usize]> {
    let facets = nodes.chunks_exact(per_facet);
    facets.map(|facet| (facet_key([facet[0], facet[1], facet[2]]), facet)).collect()
}

/// The largest depth of points below the boundary [m].
fn depth(solid: &Solid, points: &[Vec3]) -> f64 {
    let (nodes, outer) = solid.boundary();
    let triangles = outer.chunks_exact(nodes).map(|f| [f[0], f[1], f[2]]).collect();
    let tree = SurfaceBvh::new(&SurfaceMesh { vertices: solid.points().to_vec(), triangles });
    points.iter().map(|p| tree.closest(p).distance).fold(0.0, f64::max)
}

/// The threads of a run in `folder` on its solid; null where it has none, or where they are on none of its facets.
/// `largest` is the largest force in the report [N].
pub fn packed(
    folder: &Path,
    solid: &Solid,
    largest: Option<f64>,
    store: &mut Store,
) -> Result<Value> {
    let path = folder.join(WINDINGS);
    if !path.exists() {
        return Ok(Value::Null);
    }
    let segments = Segment::all(&read_text(&path)?).map_err(anyhow::Error::msg);
    let lines = Lines::new(&segments.with_context(|| path.display().to_string())?);
    if lines.segments.is_empty() {
        return Ok(Value::Null);
    }
    let deepest = depth(solid, &lines.points);
    let (nodes, outer) = solid.boundary();
    let sides = solid.sides_of_cells().unwrap_or_default();
    let facets = [by_corners(nodes, outer), by_corners(nodes, &sides)];
    let facet = |spot: &Option<Spot>| {
        let key = facet_key((*spot)?.map(|(vertex, _)| vertex));
        facets.iter().find_map(|facets| facets.get(&key)).copied()
    };
    let is_known: Vec<bool> = lines.spots.iter().map(|spot| facet(spot).is_some()).collect();
    let lines = lines.without(|point| !is_known[point]);
    if lines.segments.is_empty() {
        let why = "its threads are not on facets of the body that the page has";
        log::warn!("{}: {why}, so that they are left out", path.display());
        return Ok(Value::Null);
    }
    let (mut known, mut used) = (HashMap::new(), Vec::new());
    let (mut facet_of_point, mut places) = (Vec::new(), Vec::new());
    for spot in lines.spots.iter().flatten() {
        let Some(found) = facet(&Some(*spot)) else { continue };
        let next = known.len();
        let number = *known.entry(found).or_insert_with(|| {
            used.extend(found);
            next
        });
        facet_of_point.push(number);
        let weight = |corner: usize| spot.iter().find(|(v, _)| *v == found[corner]).map(|s| s.1);
        places.extend([1, 2].map(|corner| weight(corner).unwrap_or_default()));
    }
    let most = lines.forces.iter().copied().fold(0.0, f64::max);
    Ok(json!({
        "facets": store.indices(&solid.numbers_of(&used), nodes),
        "facetOfPoint": store.indices(&facet_of_point, 1),
        "places": store.numbers(&places, 2),
        "segments": store.indices(&lines.segments.concat(), 2),
        "forces": store.numbers(&lines.forces, 1),
        "largest": largest.unwrap_or(most),
        "depth": deepest,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The facet of a tetrahedron that a point is on, and none of one inside.
    #[test]
    fn points_are_on_facets() {
        let corners = |spot: Option<Spot>| spot.map(|spot| spot.map(|(vertex, _)| vertex));
        assert_eq!(corners(spot(&[7, 8, 9, 9], &[0.2, 0.3, 0.5, 0.0])), Some([7, 8, 9]));
        assert_eq!(corners(spot(&[7, 8, 9, 9], &[0.0, 0.3, 0.7, 0.0])), Some([7, 8, 9]));
        assert_eq!(corners(spot(&[6, 7, 8, 9], &[0.2, 1e-17, 0.3, 0.5])), Some([6, 8, 9]));
        assert_eq!(spot(&[6, 7, 8, 9], &[0.25; 4]), None);
    }

    #[test]
    fn segments_are_joined_where_points_go() {
        let x = |k: usize| Vec3::new(k as f64, 0.0, 0.0);
        let mut lines = Lines::default();
        for (a, b, force) in
            [(0, 1, 1.0), (1, 3, 4.0), (3, 4, 2.0), (4, 5, 9.0), (7, 8, 9.0), (8, 9, 5.0)]
        {
            lines.add((x(a), None), (x(b), None), force);
        }
        let left = lines.without(|point| [1, 4, 5].contains(&point));
        assert_eq!(left.points, [0, 3, 4, 8, 9].map(x));
        assert_eq!(left.segments, [[0, 1], [1, 2], [3, 4]]);
        assert_eq!(left.forces, [3.0, 2.0, 5.0]);
    }
}
