//! Facets inside a closed selection volume: |winding number of the centroid| > ½.
//!
//! The volume is what a CAD program or `cad2fem offset` makes from an open
//! patch. Its orientation plays no part.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::{Vec3, io, topology};

use super::{Selector, Sources, extent, place};
use crate::facets::Facets;

/// A closed surface.
pub struct Volume {
    path: PathBuf,
    winding: WindingNumber,
    bvh: SurfaceBvh,
}

impl Volume {
    /// Reads it.
    pub fn new(path: &Path) -> Result<Self> {
        let surface = io::read_surface_in_metres(path)?;
        let open = topology::boundary_edges(&surface.triangles);
        if let Some([a, b]) = open.first() {
            let name = path.display();
            bail!(
                "{name}: not closed: {} boundary edges, first {a}–{b} at {} m\n  \
                 a selection volume must enclose a volume; make one with: \
                 cad2fem offset {name} -o {}, or select by `patch`",
                open.len(),
                place(&surface.vertices[*a]),
                path.with_extension("obj").display(),
            );
        }
        let (winding, bvh) = (WindingNumber::new(&surface), SurfaceBvh::new(&surface));
        Ok(Self { path: path.to_path_buf(), winding, bvh })
    }
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
