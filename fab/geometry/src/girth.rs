//! How far around: the outlines of sections across an axis.

use mesh::{SurfaceMesh, Vec3};

use super::extent;

/// Sections that are measured along a body.
const SECTIONS: usize = 200;

/// The section with the longest outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Girth {
    /// Length of its outline, that of all islands and holes together [m].
    pub length: f64,
    /// The position along the axis [m].
    pub position: f64,
}

/// What has to pass through what, when a rigid body is pulled out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The section that has to stretch most.
    pub neck: Girth,
    /// The longest outline that passes there.
    pub through: Girth,
}

impl Passage {
    /// How far the neck must stretch [1].
    pub fn ratio(&self) -> f64 {
        self.through.length / self.neck.length
    }
}

/// The passage that stretches most when a closed surface is pulled along a unit vector out
/// of what it fills: every section has to pass wherever one is that is further along.
/// The last `rim` of its length is left out, where an uneven end cuts sections short [m].
///
/// Outlines of one height are taken together: a neck beside another branch of the
/// body is found too wide.
pub fn tightest(surface: &SurfaceMesh, out: &Vec3, rim: f64) -> Passage {
    let sections = sections(surface, out);
    let end = sections.iter().map(|s| s.position).fold(f64::NEG_INFINITY, f64::max) - rim;
    let mut passing = sections[0];
    let mut worst = Passage { neck: passing, through: passing };
    for neck in sections.into_iter().filter(|s| s.position <= end && s.length > 0.0) {
        if neck.length > passing.length {
            passing = neck;
        }
        let passage = Passage { neck, through: passing };
        if passage.ratio() > worst.ratio() || worst.neck.length == 0.0 {
            worst = passage;
        }
    }
    worst
}

/// The longest outline of the sections of a closed surface across a unit vector.
pub fn largest(surface: &SurfaceMesh, axis: &Vec3) -> Girth {
    let longest = sections(surface, axis).into_iter().max_by(|a, b| a.length.total_cmp(&b.length));
    longest.expect("there are sections")
}

/// The sections of a closed surface across a unit vector, in its direction.
///
/// A plane meets each triangle in a segment; the outline's length is their sum.
fn sections(surface: &SurfaceMesh, axis: &Vec3) -> Vec<Girth> {
    let [low, high] = extent(&surface.vertices, axis);
    let step = (high - low) / SECTIONS as f64;
    let position = |k: usize| low + (k as f64 + 0.5) * step;
    let mut lengths = vec![0.0; SECTIONS];
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let heights = corners.map(|p| p.dot(axis));
        let first = heights.into_iter().fold(f64::INFINITY, f64::min);
        let last = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let index = |h: f64| ((h - low) / step - 0.5).max(0.0);
        let sections = index(first).ceil() as usize..=index(last).floor() as usize;
        for k in sections.filter(|&k| k < SECTIONS) {
            lengths[k] += chord(&corners, &heights, position(k));
        }
    }
    let girth = |(k, length)| Girth { length, position: position(k) };
    lengths.into_iter().enumerate().map(girth).collect()
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

    #[test]
    fn a_second_chamber_passes_through_the_neck_before_it() {
        // Boxes of 8, 4 and 8 mm around: pulled along z, the lowest passes through the neck.
        let part = |half: f64, low: f64, high: f64| {
            Solid::cube(&Vec3::new(-half, -half, low), &Vec3::new(half, half, high))
        };
        let core = part(1.0, 0.0, 4.0).union(&part(0.5, 4.0, 6.0)).union(&part(1.0, 6.0, 10.0));
        let core = core.to_surface();
        let passage = tightest(&core, &Vec3::z(), 0.0);
        assert!((passage.ratio() - 2.0).abs() < 1e-9, "{passage:?}");
        assert!((4.0..6.0).contains(&passage.neck.position), "{passage:?}");
        assert!(passage.through.position < 4.0, "{passage:?}");
        // A cone that widens towards its end leaves freely, one that narrows does not.
        let cone = Solid::cylinder(&Vec3::zeros(), &Vec3::z(), 0.5, 1.0, 96).to_surface();
        assert!((tightest(&cone, &Vec3::z(), 0.0).ratio() - 1.0).abs() < 1e-9);
        let narrow = tightest(&cone, &-Vec3::z(), 0.0).ratio();
        assert!((narrow - 2.0).abs() < 0.01, "{narrow}");
        // Without the last fifth of it.
        let without = tightest(&cone, &-Vec3::z(), 0.2).ratio();
        assert!((without - 1.0 / 0.6).abs() < 0.01, "{without}");
    }
}
