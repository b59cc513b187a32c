//! The outside of the closed mold: planes around the part, and flanges.
//!
//! The hull is the intersection of half-spaces n·x ≤ max over the part of n·x + wall
//! for the 26 directions n with components −1, 0, 1: nowhere closer to the part than
//! `wall`, and without an overhang below 45° however it is printed. The rims of channels
//! count as points of the part.

use mesh::Vec3;
use mesh::solid::Solid;

use super::block::Block;
use crate::config::{Config, OutsideShape};

/// The hull of `points` within `block`; `below` replaces the wall under the part [m].
pub fn hull(points: &[Vec3], block: &Block, below: f64, config: &Config) -> Solid {
    if config.outside == OutsideShape::Box {
        return block.solid();
    }
    let mut hull = block.solid();
    for n in directions() {
        let reach = points.iter().map(|p| p.dot(&n)).fold(f64::NEG_INFINITY, f64::max);
        let wall = if n.z < 0.0 { below.max(config.wall) } else { config.wall };
        let limit = reach + wall;
        if block.reach(&n) > limit {
            hull = hull.trim_by_plane(&-n, -limit);
        }
    }
    hull
}

/// The unit vectors with components in the proportions −1, 0, 1.
fn directions() -> impl Iterator<Item = Vec3> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(move |x| {
        steps.into_iter().flat_map(move |y| steps.into_iter().map(move |z| Vec3::new(x, y, z)))
    });
    all.filter(|d| d.norm() > 0.5).map(|d| d.normalize())
}

/// The box [min, max] within a block.
pub fn slab(block: &Block, min: Vec3, max: Vec3) -> Solid {
    Solid::cube(&min.sup(&block.min), &max.inf(&block.max))
}
