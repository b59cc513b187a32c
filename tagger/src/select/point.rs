//! Facets around a point that was picked, as far as the surface has no sharp edge.

use anyhow::Result;
use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::topology::{directed_edges, edge_facets};
use program::table;
use program::table::Range;

use super::{Selector, Sources, extent};
use crate::facets::Facets;

table! {
    /// A point near the surface, and how far around it is selected.
    #[derive(Clone, Debug)]
    pub struct Point {
        /// Near the surface [m].
        at: [f64; 3], Range::FINITE;
        /// Between neighbours beyond which an edge is sharp [deg]; 180 for the whole shell. Sharp edges of CAD are mostly of
        /// 90 degrees; facets of a curved face differ by less than 20.
        angle: f64 = 40.0, Range::between(0.0, 180.0).unit("°");
    }
}

impl Selector for Point {
    fn select(&self, facets: &Facets, _: &Sources) -> Result<Vec<bool>> {
        let surface = &facets.surface;
        let start = SurfaceBvh::new(surface).closest(&Vec3::from(self.at)).triangle;
        let edges = edge_facets(&surface.triangles);
        let flattest = self.angle.to_radians().cos() - 1e-12;
        let mut selected = vec![false; facets.len()];
        selected[start] = true;
        let mut front = vec![start];
        while let Some(f) = front.pop() {
            for [u, v] in directed_edges(surface.triangles[f]) {
                for &other in &edges[&[u.min(v), u.max(v)]] {
                    let smooth = surface.normal(f).dot(&surface.normal(other)) >= flattest;
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
