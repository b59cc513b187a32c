//! Facets inside an axis-aligned box.

use anyhow::{Result, ensure};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::{Entry, Selector, Sources, extent, parse};
use crate::facets::Facets;

/// Row of [`super::SELECTORS`].
pub const ENTRY: Entry = Entry {
    key: "box",
    meaning: "{ min = [x, y, z], max = [x, y, z] }, in metres, for facets inside it",
    build,
    schema: Cuboid::json_schema,
};

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    /// Lower corner [m].
    min: [f64; 3],
    /// Upper corner [m].
    max: [f64; 3],
}

fn build(value: &toml::Value, _: &mut Sources) -> Result<Box<dyn Selector>> {
    let cuboid: Cuboid = parse(value, &ENTRY)?;
    let ordered = (0..3).all(|i| cuboid.min[i] < cuboid.max[i]);
    ensure!(ordered, "`box`: min {:?} is not below max {:?}", cuboid.min, cuboid.max);
    Ok(Box::new(cuboid))
}

impl Selector for Cuboid {
    fn select(&self, facets: &Facets, _: &Sources) -> Result<Vec<bool>> {
        let inside = |c: &Vec3| (0..3).all(|i| (self.min[i]..=self.max[i]).contains(&c[i]));
        Ok(facets.centroids.iter().map(inside).collect())
    }

    fn signed_distance(&self, p: &Vec3) -> Option<f64> {
        let beyond = Vec3::from_fn(|i, _| (self.min[i] - p[i]).max(p[i] - self.max[i]));
        let inside = beyond.max().min(0.0);
        Some(beyond.map(|x| x.max(0.0)).norm() + inside)
    }

    fn advice(&self, facets: &Facets, _: &Sources) -> String {
        format!("no centroid lies inside the box; {}", extent(facets))
    }
}
