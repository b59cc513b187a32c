//! Surfaces as files keep them: coordinates in 32-bit floats, still valid.
//!
//! Binary STL keeps 24 bits of a coordinate. Rounding can merge vertices and fold
//! needles over, so the rounded surface is welded and checked again. If it is no longer
//! valid, the needles that cross others are taken out one by one.

use std::collections::BTreeSet;

use crate::check::check_surface;
use crate::needles::take_out;
use crate::{SurfaceMesh, welded};

/// A surface whose coordinates 32-bit floats hold exactly.
pub struct Rounded {
    /// The surface, welded.
    pub surface: SurfaceMesh,
    /// For each triangle that of the input which it comes from.
    pub source: Vec<usize>,
    /// Whether more than rounding and welding was needed. What that left unsound the checks find.
    pub repaired: bool,
}

impl Rounded {
    /// Rounds a surface, and takes out needles no thicker than `thin`, in its unit, if it is not
    /// valid then.
    pub fn new(surface: &SurfaceMesh, thin: f64) -> Self {
        // Adding zero turns -0 into +0.
        let round = |p: &crate::Vec3| p.map(|x| f64::from(x as f32) + 0.0);
        let vertices = surface.vertices.iter().map(round).collect();
        let mut surface = SurfaceMesh { vertices, triangles: surface.triangles.clone() };
        let mut source: Vec<usize> = (0..surface.triangles.len()).collect();
        let (welded, kept) = weld(&surface, &source);
        if check_surface(&welded).is_empty() {
            return Self { surface: welded, source: kept, repaired: false };
        }
        take_out(&mut surface, &mut source, thin);
        (surface, source) = weld(&surface, &source);
        take_out(&mut surface, &mut source, thin);
        // Vertices of edges that were merged are still in the list.
        (surface, source) = weld(&surface, &source);
        Self { surface, source, repaired: true }
    }
}

/// Makes one vertex of those that coincide, as whoever reads the file does, and nothing of
/// two triangles that lie upside down on each other.
fn weld(surface: &SurfaceMesh, source: &[usize]) -> (SurfaceMesh, Vec<usize>) {
    let corners: Vec<_> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
    let SurfaceMesh { vertices, triangles } = welded(&corners);
    let mut welded: Vec<([usize; 3], usize)> = triangles
        .into_iter()
        .zip(source.iter().copied())
        .filter(|([a, b, c], _)| a != b && b != c && c != a)
        .collect();
    let from_least = |mut t: [usize; 3]| {
        let least = (0..3).min_by_key(|&k| t[k]).unwrap_or_default();
        t.rotate_left(least);
        t
    };
    let all: BTreeSet<[usize; 3]> = welded.iter().map(|(t, _)| from_least(*t)).collect();
    welded.retain(|&([a, b, c], _)| !all.contains(&from_least([a, c, b])));
    let (triangles, source) = welded.into_iter().unzip();
    (SurfaceMesh { vertices, triangles }, source)
}
