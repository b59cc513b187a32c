//! The objective function: what to minimise, each term at one equilibrium.
//!
//! One kind of term per file, with its keys in `[[objective]]`; one row per kind in
//! [`KINDS`].

#[cfg(test)]
pub(crate) mod tests;
mod clearance;
mod config;
mod contact_force;
mod contact_proxy;
mod context;
mod distance_field;
mod draft;
mod integral;
mod kind;
mod motion;
mod probe;
mod rest_term;
mod smoothness;
mod solid_integral;
mod strain_limit;
mod stress;
pub mod surface_integral;
mod target;
mod volume;
mod wall_thickness;

use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use mechanics::contact::density::{Density, Repulsion};
use mechanics::element::{FunctionSpace, at};

pub use clearance::Clearance;
pub use config::{ObjectiveConfig, Weight, check_shares};
pub use contact_force::{ContactForce, Resultant};
pub use contact_proxy::{ContactProxy, PartsTouch};
pub use context::{Context, Law};
pub use distance_field::{DistanceField, DistanceKind};
pub use draft::Draft;
pub use integral::TimeIntegral;
pub use kind::{Builder, COMMON_KEYS, Kind, Specification, from_keys, refuse_unknown};
pub use motion::{Motion, Quantity};
pub use rest_term::RestTerm;
pub use smoothness::{Smoothness, SmoothnessForm};
pub use strain_limit::StrainLimit;
pub use stress::Stress;
pub use surface_integral::Patch;
pub use target::Target;
pub use volume::Volume;
pub use wall_thickness::{SidesTouch, WallThickness};

/// All kinds, in the order in which they are listed.
pub const KINDS: &[Kind] = &[
    target::KIND,
    motion::DISPLACEMENT,
    motion::POSITION,
    contact_force::KIND,
    contact_proxy::KIND,
    wall_thickness::KIND,
    smoothness::KIND,
    clearance::KIND,
    volume::KIND,
    stress::KIND,
    strain_limit::KIND,
    probe::KIND,
    draft::KIND,
];

/// Which shape areas, volumes and distances are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// That at rest.
    #[default]
    Rest,
    /// The deformed one.
    Deformed,
}

/// Everything an objective may look at: a rest shape and its equilibrium.
pub struct Equilibrium<'a> {
    /// Topology and basis; never changes with the design.
    pub space: &'a FunctionSpace,
    /// Rest vertex positions X [m].
    pub rest: &'a [Vec3],
    /// Nodal displacement [m], three components per node.
    pub u: &'a [f64],
    /// The time t [s]; in a static scene 1.
    pub load: f64,
    /// Force of contact and friction on each node [N], three components per node;
    /// empty where no term needs it.
    pub contact: &'a [f64],
    /// Force of the supports on each node [N], in the components that they fix, three
    /// components per node; empty where no term needs it.
    pub reaction: &'a [f64],
}

impl Equilibrium<'_> {
    /// Positions of the nodes [m].
    #[must_use]
    pub fn nodes(&self, measure: Measure) -> Vec<Vec3> {
        let mut nodes = self.space.node_positions(self.rest);
        if measure == Measure::Deformed {
            nodes.iter_mut().enumerate().for_each(|(n, x)| *x += at(self.u, n));
        }
        nodes
    }
}

/// One term J(u, X, f, r) of the objective, with its partial derivatives.
pub trait Objective: Send + Sync {
    /// The user's name for this term.
    fn name(&self) -> &str;
    /// Whether the rest shape alone is admissible.
    ///
    /// # Errors
    /// Why it is not, with numbers.
    fn admit(&self, _rest: &[Vec3]) -> Result<(), String> {
        Ok(())
    }
    /// J. Infinite where the rest shape is not admissible.
    fn value(&self, at: &Equilibrium) -> f64;
    /// Adds `weight` ∂J/∂u at fixed f and r, three components per node.
    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]);
    /// Whether it looks at the forces of contact.
    fn uses_contact(&self) -> bool {
        false
    }
    /// Whether it looks at the forces of supports.
    fn uses_reaction(&self) -> bool {
        false
    }
    /// Adds `weight` ∂J/∂f by the forces f of contact, three components per node.
    fn add_dcontact(&self, _: &Equilibrium, _weight: f64, _out: &mut [f64]) {}
    /// Adds `weight` ∂J/∂r by the forces r of supports, on the degrees of freedom that they
    /// fix.
    fn add_dreaction(&self, _: &Equilibrium, _weight: f64, _out: &mut [f64]) {}
    /// Adds `weight` ∂J/∂X at fixed u, f and r, three components per vertex.
    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]);
}
