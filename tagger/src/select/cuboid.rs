//! Facets inside an axis-aligned box.

use anyhow::Result;
use mesh::Vec3;
use program::{KeyPath, Misfit, table};

use super::{Selector, Sources, extent};
use crate::facets::Facets;

table! {
    /// A box along the axes.
    #[derive(Clone, Debug)]
    pub struct Cuboid {
        /// Lower corner [m].
        min: [f64; 3];
        /// Upper corner [m].
        max: [f64; 3];
    }
}

/// The rule of a box, if there is one.
pub fn ordered(at: &KeyPath, cuboid: &Option<Cuboid>) -> Result<(), Misfit> {
    match cuboid {
        Some(Cuboid { min, max }) if !(0..3).all(|i| min[i] < max[i]) => {
            Err(at.clone().says(format!(": min {min:?} is not below max {max:?}")))
        }
        _ => Ok(()),
    }
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
