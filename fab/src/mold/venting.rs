//! Where silicone enters and air leaves.
//!
//! Air rises through the silicone along the edges of the volume mesh until it
//! reaches a local maximum of height. Those on the outer boundary get a vent; those
//! on the wall of the chamber, below the core, cannot have one and are reported.

use anyhow::{Context, Result};
use geometry::frame::Frame;
use geometry::maxima::{self, Peak};
use geometry::place;
use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;

use super::features::channel;
use super::piece::{Feature, Purpose};
use crate::body::boundary::{AirPaths, Boundary};
use crate::body::orientation::Portion;
use crate::config::Config;

/// Tops that are flat within this height get their channel in the middle [m].
const TOP_FLATNESS: f64 = 2e-4;

/// A vent must keep this distance from the rim of the sprue's mouth [m].
const APART: f64 = 1e-3;

/// Points on top of the part, in the mold's frame.
pub struct Places {
    /// Where the sprue meets the part [m].
    pub sprue: Vec3,
    /// Where the vents do [m].
    pub vents: Vec<Vec3>,
    /// Air that no vent reaches.
    pub findings: Vec<Finding>,
}

impl Places {
    /// The sprue and the vents from here on the body, whose filled surface is `surface`, up to height `end` [m].
    pub fn channels(&self, surface: &SurfaceBvh, end: f64, config: &Config) -> Vec<Feature> {
        let (sprue, vent) = (&config.sprue, config.vents.radius);
        let frustum = channel(surface, &self.sprue, end, sprue.radius, sprue.top_radius);
        let vents = self.vents.iter().map(|top| {
            let frustum = channel(surface, top, end, vent, vent);
            Feature { purpose: Purpose::Vent, frustum }
        });
        [Feature { purpose: Purpose::Sprue, frustum }].into_iter().chain(vents).collect()
    }
}

/// Finds the places for sprue and vents; `filled` is the boundary in the mold's frame.
pub fn places(
    boundary: &Boundary,
    frame: &Frame,
    portion: Portion,
    filled: &SurfaceBvh,
    config: &Config,
) -> Result<Places> {
    let AirPaths { points, neighbours, outer } = &boundary.air_paths;
    let positions: Vec<Vec3> = points.iter().map(|p| frame.point(p)).collect();
    let heights: Vec<f64> = positions.iter().map(|p| p.z).collect();
    let is_cast = |v: &usize| portion.cut().is_none() || heights[*v] > 0.0;
    let neighbours: Vec<Vec<usize>> = (0..heights.len())
        .map(|v| match is_cast(&v) {
            true => neighbours[v].iter().copied().filter(is_cast).collect(),
            false => Vec::new(),
        })
        .collect();
    let peaks = maxima::peaks(&heights, &neighbours, config.vents.persistence);
    let (open, trapped): (Vec<Peak>, Vec<Peak>) =
        peaks.into_iter().partition(|peak| outer.contains(&peak.vertex));
    let top_of = |peak: &Peak| {
        let middle = maxima::middle_of_top(peak.vertex, &positions, &neighbours, TOP_FLATNESS);
        surface_near(filled, &positions[middle], positions[peak.vertex].z)
    };
    let mut tops: Vec<Vec3> = open.iter().filter_map(top_of).collect();
    // The place asked for is that of the whole body's sprue.
    let asked = config.sprue.at.filter(|_| portion == Portion::Whole);
    let sprue = match asked.map(Vec3::from) {
        Some(at) => {
            let missed = || {
                let [x, y, z] = at.into();
                format!(
                    "the vertical through sprue.at = ({x:.5}, {y:.5}, {z:.5}) m does not meet the part; choose a point above it"
                )
            };
            surface_near(filled, &frame.point(&at), f64::INFINITY).with_context(missed)?
        }
        None => tops.first().copied().unwrap_or_else(|| top(filled, &positions)),
    };
    let reach = config.sprue.radius + config.vents.radius + APART;
    tops.retain(|top| (top - sprue).xy().norm() > reach);
    let findings = trapped_air(&trapped, &positions);
    Ok(Places { sprue, vents: tops, findings })
}

/// Where the vertical through `p` meets the surface nearest to height `z`.
fn surface_near(surface: &SurfaceBvh, p: &Vec3, z: f64) -> Option<Vec3> {
    let above = Vec3::new(p.x, p.y, 1.0 + p.z.abs());
    let heights = surface.ray(&above, &-Vec3::z()).into_iter().map(|hit| above.z - hit.0);
    let z = z.min(above.z);
    let nearest = heights.min_by(|a, b| (a - z).abs().total_cmp(&(b - z).abs()))?;
    Some(Vec3::new(p.x, p.y, nearest))
}

/// The point of the surface at the highest of some points. A mesh is a little off its model, so that the vertical
/// through its top, such as one at the rim of a round end, may miss the part.
fn top(surface: &SurfaceBvh, points: &[Vec3]) -> Vec3 {
    let highest = points.iter().max_by(|a, b| a.z.total_cmp(&b.z)).expect("a body has points");
    surface.closest(highest).point
}

fn trapped_air(peaks: &[Peak], positions: &[Vec3]) -> Vec<Finding> {
    let Some(first) = peaks.first() else { return Vec::new() };
    let deepest = peaks.iter().map(|p| p.persistence).fold(0.0, f64::max) * 1e3;
    let at = place(&positions[first.vertex], 1);
    vec![Finding {
        rule: "trapped air",
        message: format!(
            "air can collect at {} places below the core, up to {deepest:.1} mm deep, the highest at {at}: degas the \
             silicone and tilt the mold while filling",
            peaks.len()
        ),
        count: peaks.len(),
    }]
}

#[cfg(test)]
mod tests {
    use mesh::solid::Solid;

    use super::*;

    #[test]
    fn the_top_of_a_lying_cylinder_is_at_its_rim_although_its_mesh_stands_out() {
        let lying = Solid::cylinder(&Vec3::zeros(), &Vec3::new(50.0, 0.0, 0.0), 10.0, 8.0, 64);
        let surface = SurfaceBvh::new(&lying.to_surface());
        let out = Vec3::new(-0.2, 0.0, 10.1);
        assert!(surface_near(&surface, &out, out.z).is_none());
        let found = top(&surface, &[Vec3::new(25.0, 0.0, 9.0), out]);
        assert!((found - Vec3::new(0.0, 0.0, 10.0)).norm() < 1e-9, "{found}");
    }
}
