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
        let lies_within = |p: &Vec3| p.dot(&n) <= limit;
        if !block.corners().iter().all(lies_within) {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::bvh::SurfaceBvh;

    #[test]
    fn the_hull_keeps_the_wall_everywhere_and_saves_the_corners() {
        let config = Config::default();
        let ball = Solid::sphere(&Vec3::new(0.0, 0.0, 0.02), 0.02, 64).to_surface();
        let reach = Vec3::repeat(0.02 + config.wall);
        let centre = Vec3::new(0.0, 0.0, 0.02);
        let block = Block { min: centre - reach, max: centre + reach };
        let hull = hull(&ball.vertices, &block, config.wall, &config);
        let outside = SurfaceBvh::new(&hull.to_surface());
        let nearest = ball.vertices.iter().map(|p| outside.closest(p).distance);
        let least = nearest.fold(f64::INFINITY, f64::min);
        assert!((least - config.wall).abs() < 1e-9, "{least}");
        // A ball that touches all sides has π/6 of the box, planes in 26 directions more.
        let share = hull.volume() / block.solid().volume();
        assert!((std::f64::consts::FRAC_PI_6..0.65).contains(&share), "{share}");
    }
}
