//! The sprue and the vents.

use mesh::bvh::SurfaceBvh;

use super::features::channel;
use super::piece::{Feature, Purpose};
use super::venting::Places;
use crate::config::Config;

/// The sprue and the vents from `places` on the body, whose filled surface is `surface`, up to height `end` [m].
pub fn channels(places: &Places, surface: &SurfaceBvh, end: f64, config: &Config) -> Vec<Feature> {
    let (sprue, vent) = (&config.sprue, config.vents.radius);
    let frustum = channel(surface, &places.sprue, end, sprue.radius, sprue.top_radius);
    let vents = places.vents.iter().map(|top| {
        let frustum = channel(surface, top, end, vent, vent);
        Feature { purpose: Purpose::Vent, frustum }
    });
    [Feature { purpose: Purpose::Sprue, frustum }].into_iter().chain(vents).collect()
}
