//! Facets on or beyond a plane: n · (c − p) ≥ −ε.

use anyhow::Result;
use mesh::Vec3;
use program::{KeyPath, Misfit, table};

use super::{Selector, Sources, extent};
use crate::facets::Facets;

table! {
    /// A plane and the side of it that is selected.
    #[derive(Clone, Debug)]
    pub struct Plane {
        /// A point of the plane [m].
        point: [f64; 3];
        /// Direction of the selected side, of any length.
        normal: [f64; 3], direction;
    }
}

fn direction(at: &KeyPath, normal: &[f64; 3]) -> Result<(), Misfit> {
    table::direction(at, &Some(*normal))
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
