//! Facets that lie on an open surface patch.
//!
//! A facet belongs to a patch if, among the triangles of *all* patches (and of
//! the model surface, if given) that face the same way (dot product > 0) and
//! are within ε of its centroid, the nearest is one of the patch. The mesher
//! moves the boundary by less than ε, facing the same way keeps walls thinner
//! than 2ε apart, and competing with the other patches keeps a selection from
//! bleeding past its rim. Ties (a shared rim) go to the patch declared first.
//!
//! A facet less than ε high may be turned any way by vertices that moved by ε. If
//! nothing that faces the same way is near such a sliver, it belongs to the nearest
//! patch whichever way that faces.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use mesh::bvh::{SurfaceBvh, closest_on_triangle};
use mesh::{SurfaceMesh, Vec3, io, measure};

use super::{Selector, Sources, extent};
use crate::facets::Facets;

/// Distances that differ by less than this part of ε are a tie.
const TIE: f64 = 1e-6;

/// The facets on some of the patches.
pub struct Patch {
    /// Indices into [`Sources::patches`].
    range: Range<usize>,
}

impl Patch {
    /// Reads the files with these names into the patches of all selectors.
    pub fn new(names: &[String], sources: &mut Sources) -> Result<Self> {
        let begin = sources.patches.len();
        for name in names {
            for path in files(name, sources)? {
                let surface = io::read_surface_in_metres(&path)?;
                sources.patches.push((path, surface));
            }
        }
        ensure!(sources.patches.len() > begin, "`patch`: an empty list selects nothing");
        Ok(Self { range: begin..sources.patches.len() })
    }
}

/// The files that a name means, in the order of their names.
fn files(name: &str, sources: &Sources) -> Result<Vec<PathBuf>> {
    let path = sources.file(name)?;
    let pattern = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if path.is_file() {
        return Ok(vec![path]);
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let within = parent.unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(within).with_context(|| within.display().to_string())?;
    let mut known: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    known.sort();
    let name_of = |p: &PathBuf| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let found: Vec<PathBuf> =
        known.iter().filter(|p| program::fits(&name_of(p), &pattern)).cloned().collect();
    ensure!(
        !found.is_empty(),
        "no file in {} is called {pattern}; there are {}",
        within.display(),
        known.iter().map(name_of).collect::<Vec<_>>().join(", ")
    );
    Ok(found)
}

impl Selector for Patch {
    fn select(&self, _: &Facets, sources: &Sources) -> Result<Vec<bool>> {
        let own = |owner: &Option<usize>| owner.is_some_and(|owner| self.range.contains(&owner));
        Ok(sources.nearest.iter().map(own).collect())
    }

    fn expected_area(&self, sources: &Sources) -> Option<f64> {
        Some(sources.patches[self.range.clone()].iter().map(|(_, p)| measure::area(p)).sum())
    }

    fn advice(&self, facets: &Facets, sources: &Sources) -> String {
        let (path, surface) = &sources.patches[self.range.start];
        let bvh = SurfaceBvh::new(surface);
        let distances: Vec<f64> =
            facets.centroids.iter().map(|c| bvh.closest(c).distance).collect();
        let near = distances.iter().filter(|&&d| d <= sources.epsilon).count();
        let path = path.display();
        if near > 0 {
            return format!(
                "{near} facets lie within epsilon = {:.3e} m of {path}, but they face the other way \
                 or belong to a nearer or earlier patch; turn the patch or change the order",
                sources.epsilon
            );
        }
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        format!(
            "the nearest facet is {nearest:.3e} m from {path}, epsilon is {:.3e} m; {}",
            sources.epsilon,
            extent(facets)
        )
    }
}

/// All input triangles in one tree, each with the patch that owns it.
struct Inputs {
    surface: SurfaceMesh,
    /// Index of the patch; the number of patches for the model surface.
    owners: Vec<usize>,
    bvh: SurfaceBvh,
}

impl Inputs {
    fn new(sources: &Sources) -> Self {
        let mut surface = SurfaceMesh::default();
        let mut owners = Vec::new();
        let patches = sources.patches.iter().map(|(_, patch)| patch);
        for (owner, patch) in patches.chain(&sources.surface).enumerate() {
            surface.append(patch);
            owners.resize(surface.triangles.len(), owner);
        }
        Self { bvh: SurfaceBvh::new(&surface), surface, owners }
    }

    /// The owner of the nearest triangle within `epsilon` whose normal is `fit`.
    fn owner(&self, centroid: &Vec3, epsilon: f64, fit: impl Fn(&Vec3) -> bool) -> Option<usize> {
        let reach = Vec3::repeat(epsilon);
        let distance =
            |t: usize| (closest_on_triangle(centroid, &self.surface.corners(t)) - centroid).norm();
        let mut near: Vec<(f64, usize)> = self
            .bvh
            .overlaps(&(centroid - reach), &(centroid + reach))
            .into_iter()
            .filter(|&t| fit(&self.surface.normal(t)))
            .map(|t| (distance(t), self.owners[t]))
            .filter(|&(d, _)| d <= epsilon)
            .collect();
        let best = near.iter().map(|&(d, _)| d).fold(f64::INFINITY, f64::min);
        near.retain(|&(d, _)| d <= best + TIE * epsilon);
        near.into_iter().map(|(_, owner)| owner).min()
    }
}

/// The patch that each facet belongs to, if any.
pub fn nearest_patches(facets: &Facets, sources: &Sources) -> Vec<Option<usize>> {
    if sources.patches.is_empty() {
        return vec![None; facets.len()];
    }
    let inputs = Inputs::new(sources);
    let owner = |f: usize| {
        let (centroid, normal, epsilon) =
            (&facets.centroids[f], facets.surface.normal(f), sources.epsilon);
        let facing = inputs.owner(centroid, epsilon, |n| n.dot(&normal) > 0.0);
        let sliver = facing.is_none() && facets.height(f) < epsilon;
        if sliver { inputs.owner(centroid, epsilon, |_| true) } else { facing }
    };
    (0..facets.len()).map(|f| owner(f).filter(|&o| o < sources.patches.len())).collect()
}
