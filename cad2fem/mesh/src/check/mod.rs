//! Validity rules for meshes, one per file.
//!
//! A rule reports what is wrong with numbers and with the place of the first
//! offender, so that it can be looked up in a viewer.

mod closed;
mod coincident;
mod degenerate;
mod finite;
mod intersecting;
mod manifold;
mod nesting;
mod oriented;
mod tets;

pub use coincident::coincident;
pub use intersecting::self_intersections;
pub use nesting::orient_by_nesting;
pub use tets::check_tets;

use crate::{SurfaceMesh, Vec3};

/// A broken rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Name of the rule.
    pub rule: &'static str,
    /// What is wrong, with numbers, the first offender and its place [m].
    pub message: String,
    /// Number of offenders.
    pub count: usize,
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
        name: finite::NAME,
        demands: "triangles, finite coordinates and indices in range",
        find: finite::find,
    },
    Check { name: degenerate::NAME, demands: "every triangle has area", find: degenerate::find },
    Check { name: closed::NAME, demands: "no edge with a single triangle", find: closed::find },
    Check {
        name: manifold::NAME,
        demands: "at most two triangles at an edge, one fan at a vertex",
        find: manifold::find,
    },
    Check {
        name: oriented::NAME,
        demands: "neighbours wind alike, and closed surfaces enclose positive volume",
        find: oriented::find,
    },
    Check {
        name: intersecting::NAME,
        demands: "triangles meet in shared vertices and edges only",
        find: intersecting::find,
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
    let unusable = finite::find(surface);
    if !unusable.is_empty() {
        return unusable;
    }
    let chosen = CHECKS.iter().filter(|check| rules.contains(&check.name));
    chosen.flat_map(|check| (check.find)(surface)).collect()
}

/// A place as rules print it.
fn at(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests;
