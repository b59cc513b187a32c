//! The largest step of a rest shape before its boundary intersects itself.
//!
//! Handles turn, so that vertices go along curves. The path is cut into pieces whose
//! middle is near their chord, and each chord is followed by continuous collision
//! detection. What is left between chord and curve is small beside an edge, and the
//! end of a trial is checked exactly by [`validity`](super::validity).

use measure::constraint::{Inequality, distances};
use mechanics::contact::candidates;
use mechanics::contact::ccd;
use mechanics::contact::pairs::Features;
use mesh::Vec3;

/// Distance of a middle from its chord, in mean edges, up to which a piece counts as
/// straight [1].
const STRAIGHT: f64 = 0.02;
/// Longest piece: a path that comes back must not look straight [1].
const LONGEST: f64 = 0.25;
/// Pieces are not cut further than to this part of the path.
const SHORTEST: f64 = 1.0 / 64.0;

/// The boundary of a body, part of which a design moves.
pub struct RestPath {
    features: Features,
    moves: Vec<bool>,
    mean_edge: f64,
}

impl RestPath {
    /// A boundary of which the vertices of `moving` facets move.
    pub fn new(vertices: usize, boundary: &[[usize; 3]], moving: &[[usize; 3]], edge: f64) -> Self {
        let mut moves = vec![false; vertices];
        moving.iter().flatten().for_each(|&v| moves[v] = true);
        Self { features: Features::new(boundary), moves, mean_edge: edge }
    }

    /// The fraction of the path `at`(t), t from 0 to 1, that is free: vertex positions
    /// of the whole mesh [m].
    pub fn free(&self, at: impl Fn(f64) -> Vec<Vec3>) -> f64 {
        let (mut begin, mut from) = (0.0, at(0.0));
        let mut length = LONGEST;
        while begin < 1.0 {
            let end = f64::min(begin + length, 1.0);
            let to = at(end);
            let middle = at(0.5 * (begin + end));
            let short = length <= SHORTEST;
            let found = (short || self.is_straight(&from, &middle, &to))
                .then(|| self.chord(&from, &to))
                .flatten();
            match found {
                Some(free) if free < 1.0 => return begin + free * (end - begin),
                Some(_) => (begin, from) = (end, to),
                None if short => return begin,
                None => length *= 0.5,
            }
        }
        1.0
    }

    /// Distances between parts of the surface without a common vertex, where a motion of at most `motion` [m] may close
    /// them and they are within half an edge.
    pub fn gaps(&self, x: &[Vec3], motion: f64) -> Vec<Inequality> {
        let mut pairs =
            candidates::close_within(&self.features, x, (2.0 * motion).min(0.5 * self.mean_edge));
        pairs.retain(|pair| pair.corners().iter().any(|&v| self.moves[v]));
        distances(pairs, x)
    }

    fn is_straight(&self, from: &[Vec3], middle: &[Vec3], to: &[Vec3]) -> bool {
        let off = |v: usize| (middle[v] - 0.5 * (from[v] + to[v])).norm();
        (0..from.len()).all(|v| !self.moves[v] || off(v) <= STRAIGHT * self.mean_edge)
    }

    /// Free fraction of a chord; none where it sweeps through too much at once.
    fn chord(&self, from: &[Vec3], to: &[Vec3]) -> Option<f64> {
        let rests = |corners: [usize; 4]| !corners.iter().any(|&v| self.moves[v]);
        let pairs = candidates::between(&self.features, from, to, 0.0, &rests).ok()?;
        Some(ccd::max_step(&pairs, from, to, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::square;

    use super::*;

    /// A plate that swings through another, and back to where it was: only the path
    /// shows it.
    #[test]
    fn a_plate_that_swings_through_another_is_stopped() {
        let mut surface = square(2, 0.0);
        let other = square(2, 0.0);
        let n = surface.vertices.len();
        surface.vertices.extend(other.vertices.iter().map(|v| v + Vec3::new(0.0, 0.0, 0.5)));
        surface.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
        let moving = surface.triangles[other.triangles.len()..].to_vec();
        let path = RestPath::new(2 * n, &surface.triangles, &moving, 0.5);
        let swing = |by: f64| {
            let rest = surface.vertices.clone();
            move |t: f64| -> Vec<Vec3> {
                let moved = |(v, x): (usize, &Vec3)| {
                    let down = Vec3::new(0.3 * t, 0.0, -(std::f64::consts::TAU * t).sin() * by);
                    if v < n { *x } else { x + down }
                };
                rest.iter().enumerate().map(moved).collect()
            }
        };
        assert!((path.free(swing(0.4)) - 1.0).abs() < 1e-12);
        // down by one half at sin = 1/1.2
        let expected = (0.5_f64 / 0.6).asin() / std::f64::consts::TAU;
        let found = path.free(swing(0.6));
        assert!(found < expected * 1.02 && found > 0.8 * expected, "{found} {expected}");
    }
}
