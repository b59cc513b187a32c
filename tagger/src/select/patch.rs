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
use mesh::bvh::SurfaceBvh;
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
    normals: Vec<Vec3>,
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
            let offset = surface.vertices.len();
            surface.vertices.extend(&patch.vertices);
            surface.triangles.extend(patch.triangles.iter().map(|t| t.map(|v| v + offset)));
            owners.resize(surface.triangles.len(), owner);
        }
        let normals = (0..surface.triangles.len())
            .map(|t| surface.corners(t))
            .map(|[a, b, c]| measure::triangle_normal(a, b, c))
            .collect();
        Self { bvh: SurfaceBvh::new(&surface), surface, normals, owners }
    }

    /// The owner of the nearest triangle within `epsilon` whose normal is `fit`.
    fn owner(&self, centroid: &Vec3, epsilon: f64, fit: impl Fn(&Vec3) -> bool) -> Option<usize> {
        let reach = Vec3::repeat(epsilon);
        let mut near: Vec<(f64, usize)> = self
            .bvh
            .overlaps(&(centroid - reach), &(centroid + reach))
            .into_iter()
            .filter(|&t| fit(&self.normals[t]))
            .map(|t| (distance(centroid, self.surface.corners(t)), self.owners[t]))
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
            (&facets.centroids[f], &facets.normals[f], sources.epsilon);
        let facing = inputs.owner(centroid, epsilon, |n| n.dot(normal) > 0.0);
        let sliver = facing.is_none() && facets.height(f) < epsilon;
        if sliver { inputs.owner(centroid, epsilon, |_| true) } else { facing }
    };
    (0..facets.len()).map(|f| owner(f).filter(|&o| o < sources.patches.len())).collect()
}

/// Distance from a point to a triangle [m], by the Voronoi region of the point
/// (Ericson, Real-Time Collision Detection, 5.1.5).
fn distance(p: &Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(p - a)), ac.dot(&(p - a)));
    let (d3, d4) = (ab.dot(&(p - b)), ac.dot(&(p - b)));
    let (d5, d6) = (ab.dot(&(p - c)), ac.dot(&(p - c)));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let closest = if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + (ab * vb + ac * vc) / (va + vb + vc)
    };
    (p - closest).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_in_every_voronoi_region() {
        let triangle = [Vec3::zeros(), Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        let cases = [
            (Vec3::new(1.0, 1.0, 2.0), 2.0),
            (Vec3::new(-3.0, -4.0, 0.0), 5.0),
            (Vec3::new(7.0, 0.0, 4.0), 5.0),
            (Vec3::new(0.0, 9.0, 12.0), 13.0),
            (Vec3::new(2.0, -3.0, 4.0), 5.0),
            (Vec3::new(-3.0, 2.0, 4.0), 5.0),
            (Vec3::new(3.0, 3.0, 0.0), 2.0_f64.sqrt()),
        ];
        for (p, expected) in cases {
            // a handful of products of small integers: a few units in the last place
            assert!((distance(&p, triangle) - expected).abs() < 1e-14, "{p}");
        }
    }
}
