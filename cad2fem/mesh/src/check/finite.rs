//! There are triangles, their indices exist and coordinates are finite.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::measure::diagonal;

pub const NAME: &str = "finite";

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let n = surface.vertices.len();
    let mut findings = Vec::new();
    let mut add = |count, message| findings.push(Finding { rule: NAME, message, count });
    if surface.triangles.is_empty() {
        add(1, format!("the surface is empty: {n} vertices, no triangles"));
    }
    let bad = |v: &usize| surface.vertices[*v].iter().any(|x| !x.is_finite());
    let infinite: Vec<usize> = (0..n).filter(bad).collect();
    if let Some(&v) = infinite.first() {
        let place = at(&surface.vertices[v]);
        let count = infinite.len();
        add(count, format!("{count} vertices are not finite, first vertex {v} at {place}"));
    }
    let size = diagonal(&surface.vertices);
    if infinite.is_empty() && !size.powi(3).is_finite() {
        add(1, format!("the surface is {size:.1e} m across: its volume has no number"));
    }
    let lost = |t: &usize| surface.triangles[*t].iter().any(|&v| v >= n);
    let lost: Vec<usize> = (0..surface.triangles.len()).filter(lost).collect();
    if let Some(&t) = lost.first() {
        let (count, corners) = (lost.len(), surface.triangles[t]);
        let message = format!(
            "{count} triangles have vertices that do not exist, first triangle {t} with \
             {corners:?} of {n} vertices"
        );
        add(count, message);
    }
    findings
}
