//! Validity rules for meshes.
//!
//! A rule reports what is wrong with numbers and with the place of the first
//! offender, so that it can be looked up in a viewer.

mod coincident;
mod nesting;
mod surface;
mod tets;

pub use coincident::coincident;
pub use nesting::orient_by_nesting;
pub use tets::check_tets;

use serde::Serialize;

use crate::measure::diagonal;
use crate::{SurfaceMesh, Vec3};

/// A broken rule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Name of the rule.
    pub rule: &'static str,
    /// Number of offenders.
    pub count: usize,
    /// What is wrong, with numbers, the first offender and its place [m].
    pub message: String,
}

impl Finding {
    fn new(rule: &'static str, count: usize, message: String) -> Self {
        Self { rule, message, count }
    }
}

/// What was found, one indented line each.
pub fn findings(found: &[Finding]) -> String {
    found.iter().map(|f| format!("\n  {}: {}", f.rule, f.message)).collect()
}

/// A rule for surfaces.
pub struct Check {
    /// Name of the rule.
    pub name: &'static str,
    /// What the rule demands.
    pub demands: &'static str,
    find: fn(&SurfaceMesh) -> Vec<Finding>,
}

/// The rules for surfaces, in the order in which they run.
pub const CHECKS: &[Check] = &[
    Check {
        name: "finite",
        demands: "triangles, finite coordinates and indices in range",
        find: surface::finite,
    },
    Check { name: "degenerate", demands: "every triangle has area", find: surface::degenerate },
    Check { name: "closed", demands: "no edge with a single triangle", find: surface::closed },
    Check {
        name: "manifold",
        demands: "at most two triangles at an edge, one fan at a vertex",
        find: surface::manifold,
    },
    Check {
        name: "oriented",
        demands: "neighbours wind alike, and closed surfaces enclose positive volume",
        find: surface::oriented,
    },
    Check {
        name: "intersecting",
        demands: "triangles meet in shared vertices and edges only",
        find: surface::intersecting,
    },
];

/// What all rules find.
pub fn check_surface(surface: &SurfaceMesh) -> Vec<Finding> {
    let all: Vec<&str> = CHECKS.iter().map(|check| check.name).collect();
    run(surface, &all)
}

/// What the named rules find, in the order of [`CHECKS`]. The rule `finite`
/// always runs first; if it is broken the others cannot be applied.
///
/// # Panics
/// If a name is not in [`CHECKS`].
pub fn run(surface: &SurfaceMesh, rules: &[&str]) -> Vec<Finding> {
    for rule in rules {
        assert!(CHECKS.iter().any(|check| check.name == *rule), "unknown rule {rule:?}");
    }
    let unusable = surface::finite(surface);
    if !unusable.is_empty() {
        return unusable;
    }
    let chosen = CHECKS.iter().filter(|check| rules.contains(&check.name));
    chosen.flat_map(|check| (check.find)(surface)).collect()
}

/// What is wrong with coordinates: they are not finite, or so far apart that what they bound, a `surface` or a
/// `mesh`, has no volume that is a number.
fn not_finite(vertices: &[Vec3], what: &str) -> Option<Finding> {
    let bad = |v: &usize| vertices[*v].iter().any(|x| !x.is_finite());
    let bad: Vec<usize> = (0..vertices.len()).filter(bad).collect();
    if let Some(&v) = bad.first() {
        let (count, place) = (bad.len(), at(&vertices[v]));
        let message = format!("{count} vertices are not finite, first vertex {v} at {place}");
        return Some(Finding::new("finite", count, message));
    }
    let size = diagonal(vertices);
    let message = || format!("the {what} is {size:.1e} m across: its volume has no number");
    (!size.powi(3).is_finite()).then(|| Finding::new("finite", 1, message()))
}

/// Cells, `names` are those of several and of one, with vertices beyond the `n` that there are.
fn lost<const N: usize>(
    rule: &'static str,
    cells: &[[usize; N]],
    n: usize,
    [cells_are, cell_is]: [&str; 2],
) -> Option<Finding> {
    let bad = |t: &usize| cells[*t].iter().any(|&v| v >= n);
    let bad: Vec<usize> = (0..cells.len()).filter(bad).collect();
    let (&t, count) = (bad.first()?, bad.len());
    let message = format!(
        "{count} {cells_are} have vertices that do not exist, first {cell_is} {t} with {:?} of {n} vertices",
        cells[t]
    );
    Some(Finding::new(rule, count, message))
}

/// A place as rules print it.
fn at(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests;
