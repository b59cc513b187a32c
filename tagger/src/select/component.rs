//! One connected component of the boundary, such as the wall of a closed cavity.
//!
//! Components are numbered from 0 by the volume that they enclose, largest
//! first: 0 is the outer skin.

use anyhow::{Result, ensure};
use mesh::{measure, topology};
use schemars::JsonSchema;

use super::{Entry, Selector, Sources, extent, parse};
use crate::facets::Facets;

/// Row of [`super::SELECTORS`].
pub const ENTRY: Entry = Entry {
    key: "component",
    meaning: "a number: 0 for the outer skin, 1, 2, ... for closed cavities, largest first",
    build,
    schema: usize::json_schema,
};

struct Component(usize);

fn build(value: &toml::Value, _: &mut Sources) -> Result<Box<dyn Selector>> {
    Ok(Box::new(Component(parse(value, &ENTRY)?)))
}

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
    let volume = |component: &Vec<usize>| {
        let triangles: Vec<_> = component.iter().map(|&f| facets.triangles[f]).collect();
        let (surface, _) = topology::submesh(&facets.vertices, &triangles);
        measure::enclosed_volume(&surface).abs()
    };
    let mut components = topology::components(&facets.triangles);
    components.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    components
}
