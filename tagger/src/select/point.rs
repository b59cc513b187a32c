//! Facets around a point that was picked, as far as the surface has no sharp edge.

use anyhow::{Result, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::topology::edge_facets;
use mesh::{SurfaceMesh, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{Entry, Selector, Sources, extent, parse};
use crate::facets::Facets;

/// Row of [`super::SELECTORS`].
pub const ENTRY: Entry = Entry {
    key: "point",
    meaning: "{ at = [x, y, z], angle = 40 }, in metres and degrees, for the facet nearest to it and \
              those around it up to edges that are sharper than the angle; angle = 180: the whole shell",
    build,
    schema: Point::json_schema,
};

/// Sharp edges of CAD are mostly of 90 degrees; facets of a curved face differ by less than 20.
const ANGLE: f64 = 40.0;

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Point {
    /// Near the surface [m].
    at: [f64; 3],
    /// Between neighbours beyond which an edge is sharp [deg].
    #[serde(default = "default_angle")]
    angle: f64,
}

fn default_angle() -> f64 {
    ANGLE
}

fn build(value: &toml::Value, _: &mut Sources) -> Result<Box<dyn Selector>> {
    let point: Point = parse(value, &ENTRY)?;
    ensure!(point.at.iter().all(|x| x.is_finite()), "`point`: at = {:?} is no place", point.at);
    ensure!(
        (0.0..=180.0).contains(&point.angle),
        "`point`: angle = {} must be from 0 to 180 degrees",
        point.angle
    );
    Ok(Box::new(point))
}

impl Selector for Point {
    fn select(&self, facets: &Facets, _: &Sources) -> Result<Vec<bool>> {
        let surface =
            SurfaceMesh { vertices: facets.vertices.clone(), triangles: facets.triangles.clone() };
        let start = SurfaceBvh::new(&surface).closest(&Vec3::from(self.at)).triangle;
        let edges = edge_facets(&facets.triangles);
        let flattest = self.angle.to_radians().cos() - 1e-12;
        let mut selected = vec![false; facets.len()];
        selected[start] = true;
        let mut front = vec![start];
        while let Some(f) = front.pop() {
            let [a, b, c] = facets.triangles[f];
            for [u, v] in [[a, b], [b, c], [c, a]] {
                for &other in &edges[&[u.min(v), u.max(v)]] {
                    let smooth = facets.normals[f].dot(&facets.normals[other]) >= flattest;
                    if smooth && !selected[other] {
                        selected[other] = true;
                        front.push(other);
                    }
                }
            }
        }
        Ok(selected)
    }

    fn advice(&self, facets: &Facets, _: &Sources) -> String {
        extent(facets)
    }
}
