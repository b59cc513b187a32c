//! Facets on or beyond a plane: n · (c − p) ≥ −ε.

use anyhow::{Result, ensure};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::{Entry, Selector, Sources, extent, parse};
use crate::facets::Facets;

/// Row of [`super::SELECTORS`].
pub const ENTRY: Entry = Entry {
    key: "plane",
    meaning: "{ point = [x, y, z], normal = [x, y, z] }, in metres, for facets on or beyond it",
    build,
    schema: Plane::json_schema,
};

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Plane {
    /// A point of the plane [m].
    point: [f64; 3],
    /// Direction of the selected side, of any length.
    normal: [f64; 3],
}

fn build(value: &toml::Value, _: &mut Sources) -> Result<Box<dyn Selector>> {
    let plane: Plane = parse(value, &ENTRY)?;
    let length = Vec3::from(plane.normal).norm();
    ensure!(length.is_finite() && length > 0.0, "`plane`: the normal has length {length}");
    Ok(Box::new(plane))
}

impl Selector for Plane {
    fn select(&self, facets: &Facets, sources: &Sources) -> Result<Vec<bool>> {
        let normal = Vec3::from(self.normal).normalize();
        let beyond = |c: &Vec3| normal.dot(&(c - Vec3::from(self.point))) >= -sources.epsilon;
        Ok(facets.centroids.iter().map(beyond).collect())
    }

    fn signed_distance(&self, p: &Vec3) -> Option<f64> {
        Some(Vec3::from(self.normal).normalize().dot(&(Vec3::from(self.point) - p)))
    }

    fn advice(&self, facets: &Facets, _: &Sources) -> String {
        format!("no centroid lies on or beyond the plane; {}", extent(facets))
    }
}
