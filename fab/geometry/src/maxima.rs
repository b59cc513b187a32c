//! Local maxima of a height on a mesh graph, with their persistence.
//!
//! Sweeping the vertices from the highest down, a component of the visited graph
//! is born at each local maximum and dies where it meets one born higher. The
//! persistence of a maximum is the height between the two: how far air caught
//! there would have to be pushed down to escape to a higher place.
//!
//! Source: Edelsbrunner, Letscher, Zomorodian 2002, "Topological persistence and
//! simplification", doi:10.1007/s00454-002-2885-2, in dimension 0.

use mesh::topology::DisjointSets;

/// A local maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The highest vertex.
    pub vertex: usize,
    /// Height above the pass to a higher maximum; infinite for the highest of a component [m].
    pub persistence: f64,
}

/// The maxima of `heights` with at least the given persistence, highest first.
///
/// `neighbours` lists the adjacent vertices of each vertex; vertices without any
/// are ignored. Equal heights are ordered by index.
pub fn peaks(heights: &[f64], neighbours: &[Vec<usize>], persistence: f64) -> Vec<Peak> {
    let mut order: Vec<usize> = (0..heights.len()).filter(|&v| !neighbours[v].is_empty()).collect();
    order.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]).then(a.cmp(&b)));
    // Components by the ranks of vertices: the first of each is its maximum, which was born first.
    let mut rank = vec![usize::MAX; heights.len()];
    let mut components = DisjointSets::new(order.len());
    let mut died = vec![f64::NEG_INFINITY; order.len()];
    for (i, &v) in order.iter().enumerate() {
        rank[v] = i;
        for &n in neighbours[v].iter().filter(|&&n| rank[n] < i) {
            let (a, b) = (components.representative(i), components.representative(rank[n]));
            if a != b {
                died[a.max(b)] = heights[v];
                components.join(a, b);
            }
        }
    }
    let peaks = order.into_iter().zip(died);
    peaks
        .map(|(vertex, died)| Peak { vertex, persistence: heights[vertex] - died })
        .filter(|peak| peak.persistence >= persistence)
        .collect()
}

/// The vertex in the middle of the flat top around a peak: the one nearest to the
/// mean of `positions` among the vertices connected to it that lie less than
/// `depth` below.
pub fn middle_of_top(
    peak: usize,
    positions: &[mesh::Vec3],
    neighbours: &[Vec<usize>],
    depth: f64,
) -> usize {
    let lowest = positions[peak].z - depth;
    let mut seen = std::collections::BTreeSet::from([peak]);
    let mut stack = vec![peak];
    while let Some(v) = stack.pop() {
        for &n in &neighbours[v] {
            if positions[n].z >= lowest && seen.insert(n) {
                stack.push(n);
            }
        }
    }
    let mean = seen.iter().map(|&v| positions[v]).sum::<mesh::Vec3>() / seen.len() as f64;
    let distance = |v: usize| (positions[v] - mean).norm_squared();
    seen.iter().copied().fold(peak, |best, v| if distance(v) < distance(best) { v } else { best })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;

    /// The graph of a polyline.
    fn path(n: usize) -> Vec<Vec<usize>> {
        (0..n)
            .map(|i| [i.wrapping_sub(1), i + 1].into_iter().filter(|&j| j < n).collect())
            .collect()
    }

    #[test]
    fn persistence_is_the_descent_to_the_pass() {
        let heights = [0.0, 3.0, 1.0, 5.0, 4.5, 4.75, 0.0];
        let found = peaks(&heights, &path(7), 0.5);
        assert_eq!(found[0].vertex, 3);
        assert!(found[0].persistence.is_infinite());
        assert_eq!(found[1], Peak { vertex: 1, persistence: 2.0 });
        assert_eq!(found.len(), 2);
        assert_eq!(peaks(&heights, &path(7), 0.25).len(), 3);
    }

    #[test]
    fn a_plateau_is_one_maximum_and_its_middle_is_found() {
        let heights = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
        let found = peaks(&heights, &path(7), 1e-9);
        assert_eq!(found.len(), 1);
        let positions: Vec<Vec3> =
            heights.iter().enumerate().map(|(i, &z)| Vec3::new(i as f64, 0.0, z)).collect();
        assert_eq!(middle_of_top(found[0].vertex, &positions, &path(7), 0.1), 3);
    }
}
