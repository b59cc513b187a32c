//! How far around: the outlines of sections across an axis.

use mesh::measure::bounds;
use mesh::{SurfaceMesh, Vec3};

/// Sections that are measured along a body.
const SECTIONS: usize = 200;

/// The section with the longest outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Girth {
    /// Length of its outline, that of all islands and holes together [m].
    pub length: f64,
    /// Its position along the axis [m].
    pub position: f64,
}

/// The longest outline of the sections of a closed surface across a unit vector.
///
/// A plane meets each triangle in a segment; the outline's length is their sum.
#[must_use]
pub fn largest(surface: &SurfaceMesh, axis: &Vec3) -> Girth {
    let along: Vec<Vec3> =
        surface.vertices.iter().map(|p| Vec3::new(p.dot(axis), 0.0, 0.0)).collect();
    let (low, high) = bounds(&along);
    let step = (high.x - low.x) / SECTIONS as f64;
    let position = |k: usize| low.x + (k as f64 + 0.5) * step;
    let mut lengths = vec![0.0; SECTIONS];
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let heights = surface.triangles[t].map(|v| along[v].x);
        let first = heights.into_iter().fold(f64::INFINITY, f64::min);
        let last = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let index = |h: f64| ((h - low.x) / step - 0.5).max(0.0);
        let sections = index(first).ceil() as usize..=index(last).floor() as usize;
        for k in sections.filter(|&k| k < SECTIONS) {
            lengths[k] += chord(&corners, &heights, position(k));
        }
    }
    let longest = (0..SECTIONS).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
    let k = longest.expect("there are sections");
    Girth { length: lengths[k], position: position(k) }
}

/// Length of the segment in which a triangle meets the plane at a height [m].
fn chord(corners: &[Vec3; 3], heights: &[f64; 3], at: f64) -> f64 {
    let mut ends = Vec::with_capacity(3);
    for [i, j] in [[0, 1], [1, 2], [2, 0]] {
        let (a, b) = (heights[i] - at, heights[j] - at);
        if (a < 0.0) != (b < 0.0) {
            ends.push(corners[i] + (corners[j] - corners[i]) * (a / (a - b)));
        }
    }
    match ends[..] {
        [p, q] => (q - p).norm(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;

    #[test]
    fn the_girth_of_balls_and_boxes() {
        let ball = Solid::sphere(&Vec3::new(3.0, 0.0, 0.0), 1.0, 400).to_surface();
        for axis in [Vec3::x(), Vec3::new(1.0, 1.0, 1.0).normalize()] {
            let girth = largest(&ball, &axis);
            assert!((girth.length - std::f64::consts::TAU).abs() < 2e-3, "{girth:?}");
        }
        assert!((largest(&ball, &Vec3::x()).position - 3.0).abs() < 0.02);
        let bar = Solid::cube(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 10.0)).to_surface();
        assert!((largest(&bar, &Vec3::z()).length - 6.0).abs() < 1e-12);
        assert!((largest(&bar, &Vec3::x()).length - 24.0).abs() < 1e-12);
    }
}
