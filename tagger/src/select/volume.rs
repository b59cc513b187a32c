//! Facets inside a closed selection volume: |winding number of the centroid| > ½.
//!
//! The volume is what a CAD program or `cad2fem offset` makes from an open
//! patch. Its orientation plays no part.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::{Vec3, io, topology};
use schemars::JsonSchema;

use super::{Entry, Selector, Sources, extent, path_of, point};
use crate::facets::Facets;

/// Row of [`super::SELECTORS`].
pub const ENTRY: Entry = Entry {
    key: "volume",
    meaning: "the file of a closed surface (stl, obj, ply), for facets inside it",
    build,
    schema: PathBuf::json_schema,
};

struct Volume {
    path: PathBuf,
    winding: WindingNumber,
    bvh: SurfaceBvh,
}

fn build(value: &toml::Value, sources: &mut Sources) -> Result<Box<dyn Selector>> {
    let path = path_of(value, &ENTRY, sources)?;
    let surface = io::read_surface_in_metres(&path)?;
    let open = topology::boundary_edges(&surface.triangles);
    if let Some([a, b]) = open.first() {
        let name = path.display();
        ensure!(
            open.is_empty(),
            "{name}: not closed: {} boundary edges, first {a}–{b} at {} m\n  \
             a selection volume must enclose a volume; make one with: \
             cad2fem offset {name} -o {}, or select by `patch`",
            open.len(),
            point(&surface.vertices[*a]),
            path.with_extension("obj").display(),
        );
    }
    let (winding, bvh) = (WindingNumber::new(&surface), SurfaceBvh::new(&surface));
    Ok(Box::new(Volume { path, winding, bvh }))
}

impl Selector for Volume {
    fn select(&self, facets: &Facets, _: &Sources) -> Result<Vec<bool>> {
        Ok(facets.centroids.iter().map(|c| self.winding.at(c).abs() > 0.5).collect())
    }

    fn signed_distance(&self, p: &Vec3) -> Option<f64> {
        let sign = if self.winding.at(p).abs() > 0.5 { -1.0 } else { 1.0 };
        Some(sign * self.bvh.closest(p).distance)
    }

    fn advice(&self, facets: &Facets, _: &Sources) -> String {
        format!("no centroid lies inside {}; {}", self.path.display(), extent(facets))
    }
}
