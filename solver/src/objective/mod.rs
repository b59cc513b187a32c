//! What to minimise, each term at one equilibrium.

mod clearance;
mod distance_field;
mod integral;
mod smoothness;
mod target;
mod wall_thickness;

use mesh::Vec3;

use crate::element::FunctionSpace;

pub use clearance::Clearance;
pub use distance_field::{DistanceField, DistanceKind};
pub use integral::TimeIntegral;
pub use smoothness::Smoothness;
pub use target::Target;
pub use wall_thickness::{SidesTouch, WallThickness};

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
}

/// One term J(u, X, f) of the objective, with its partial derivatives.
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
    /// Adds `weight` ∂J/∂u at fixed f, three components per node.
    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]);
    /// Whether it looks at the forces of contact.
    fn uses_contact(&self) -> bool {
        false
    }
    /// Adds `weight` ∂J/∂f by the forces f of contact, three components per node.
    fn add_dcontact(&self, _: &Equilibrium, _weight: f64, _out: &mut [f64]) {}
    /// Adds `weight` ∂J/∂X at fixed u and f, three components per vertex.
    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]);
}
