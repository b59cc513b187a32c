//! One connected component of the boundary, such as the wall of a closed cavity.
//!
//! Components are numbered from 0 by the volume that they enclose, largest
//! first: 0 is the outer skin.

use anyhow::{Result, ensure};
use mesh::{measure, topology};

use super::{Selector, Sources, extent};
use crate::facets::Facets;

/// The component with this number.
pub struct Component(pub usize);

impl Selector for Component {
    fn select(&self, facets: &Facets, _: &Sources) -> Result<Vec<bool>> {
        let components = by_volume(facets);
        ensure!(
            self.0 < components.len(),
            "component {} was asked for, but the boundary has {}, numbered from 0",
            self.0,
            components.len()
        );
        let mut selected = vec![false; facets.len()];
        for &f in &components[self.0] {
            selected[f] = true;
        }
        Ok(selected)
    }

    fn advice(&self, facets: &Facets, _: &Sources) -> String {
        extent(facets)
    }
}

/// Connected components, by enclosed volume, largest first.
fn by_volume(facets: &Facets) -> Vec<Vec<usize>> {
    let volume =
        |component: &Vec<usize>| measure::enclosed_volume(&facets.surface.part(component)).abs();
    let mut components = topology::components(&facets.surface.triangles);
    components.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    components
}
