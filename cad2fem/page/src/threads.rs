//! Threads on a body: where their segments lie, and the force along each.
//!
//! `windings.csv` has the facet of each segment, and the weights of both of its ends there. The page interpolates the
//! displacement of a facet's nodes, in every state, as the solver does. Facets inside the body are known where the page
//! has its cells; segments on others are left out.

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

/// Points that are nearer than this are one [m].
const SAME: f64 = 1e-9;

/// Ends of segments on facets of a solid, and what joins two of them.
#[derive(Default)]
struct Lines {
    /// Ends at rest [m]. Segments that follow each other share one.
    points: Vec<Vec3>,
    /// The facet that each of them is on.
    facets: Vec<usize>,
    /// Weights of its second and third corner.
    places: Vec<f64>,
    /// First and last point of each segment.
    segments: Vec<[usize; 2]>,
    /// Mean force along each [N].
    forces: Vec<f64>,
}

impl Lines {
    /// Adds a segment on a facet whose corners are these.
    fn add(&mut self, segment: &Segment, facet: usize, corners: [usize; 3]) {
        let start = Vec3::from(segment.ends[0].rest);
        let follows = self.points.last().is_some_and(|last| (last - start).norm() <= SAME);
        for end in &segment.ends[usize::from(follows)..] {
            let weight = |corner: usize| {
                let place = segment.vertices.iter().position(|v| *v == corners[corner]);
                place.map_or(0.0, |place| end.weights[place])
            };
            self.points.push(end.rest.into());
            self.facets.push(facet);
            self.places.extend([1, 2].map(weight));
        }
        self.segments.push([self.points.len() - 2, self.points.len() - 1]);
        self.forces.push(segment.force);
    }
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
    let segments = segments.with_context(|| path.display().to_string())?;
    let (nodes, outer) = solid.boundary();
    let sides = solid.sides_of_cells().unwrap_or_default();
    let facets = [by_corners(nodes, outer), by_corners(nodes, &sides)];
    let (mut lines, mut known, mut used) = (Lines::default(), HashMap::new(), Vec::new());
    for segment in &segments {
        let key = facet_key(segment.vertices);
        let Some(facet) = facets.iter().find_map(|facets| facets.get(&key)) else { continue };
        let next = known.len();
        let number = *known.entry(*facet).or_insert_with(|| {
            used.extend(*facet);
            next
        });
        lines.add(segment, number, [facet[0], facet[1], facet[2]]);
    }
    if lines.segments.is_empty() {
        if !segments.is_empty() {
            let why = "its threads are not on facets of the body that the page has";
            log::warn!("{}: {why}, so that they are left out", path.display());
        }
        return Ok(Value::Null);
    }
    let deepest = depth(solid, &lines.points);
    let most = lines.forces.iter().copied().fold(0.0, f64::max);
    Ok(json!({
        "facets": store.indices(&solid.numbers_of(&used), nodes),
        "facetOfPoint": store.indices(&lines.facets, 1),
        "places": store.numbers(&lines.places, 2),
        "segments": store.indices(&lines.segments.concat(), 2),
        "forces": store.numbers(&lines.forces, 1),
        "largest": largest.unwrap_or(most),
        "depth": deepest,
    }))
}

#[cfg(test)]
mod tests {
    use reports::SegmentEnd;

    use super::*;

    /// Segments that follow each other share a point, and weights are those of the facet's own order of corners.
    #[test]
    fn segments_share_their_points() {
        let end = |x: f64, weights| SegmentEnd { rest: [x, 0.0, 0.0], now: [x, 0.0, 0.0], weights };
        let segment = |ends| Segment { winding: "u".into(), ends, force: 2.0, vertices: [7, 8, 9] };
        let [a, b, c] = [[0.2, 0.3, 0.5], [0.0, 0.4, 0.6], [1.0, 0.0, 0.0]];
        let mut lines = Lines::default();
        lines.add(&segment([end(0.0, a), end(1.0, b)]), 0, [9, 7, 8]);
        lines.add(&segment([end(1.0, b), end(2.0, c)]), 1, [9, 7, 8]);
        assert_eq!(lines.segments, [[0, 1], [1, 2]]);
        assert_eq!((lines.points.len(), lines.facets), (3, vec![0, 0, 1]));
        assert_eq!(lines.places, [0.2, 0.3, 0.0, 0.4, 1.0, 0.0]);
    }
}
