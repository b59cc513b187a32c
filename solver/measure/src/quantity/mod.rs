//! Quantities: numbers q(u, X, t, f, r) of a state, with their partial derivatives.
//!
//! A probe is a quantity that is measured at every reported step. An objective is a quantity that is
//! minimised: it has a weight, and a sum over time.

mod close_pairs;
mod distance_field;
mod kind;
mod means;
mod normal;
mod site;
pub mod solid_integral;
pub mod surface_integral;
#[cfg(test)]
pub(crate) mod tests;

use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{Energies, Iterate, Owner};
use mechanics::forward::Problem;

pub use close_pairs::{ClosePairs, PartsTouch};
pub use distance_field::{DistanceField, DistanceKind, Targets};
pub use kind::{Kind, List, Read, Specification};
pub use means::{Means, of_means};
pub use normal::Normal;
pub use site::{Law, Site};
pub use surface_integral::Patch;

/// A direction as it is written: of any length but 0 [1].
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "[f64; 3]")]
pub struct Axis([f64; 3]);

impl TryFrom<[f64; 3]> for Axis {
    type Error = String;

    fn try_from(axis: [f64; 3]) -> Result<Self, String> {
        match axis.iter().all(|x| x.is_finite()) && axis.iter().any(|x| *x != 0.0) {
            true => Ok(Self(axis)),
            false => Err(format!("{axis:?}: must be a direction, finite and not zero")),
        }
    }
}

impl Axis {
    /// The unit vector along it.
    pub fn unit(&self) -> Vec3 {
        Vec3::from(self.0).normalize()
    }
}

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

/// Everything a quantity may look at: a rest shape and its equilibrium.
pub struct Equilibrium<'a> {
    /// Topology and basis; never changes with the design.
    pub space: &'a FunctionSpace,
    /// Rest vertex positions X [m].
    pub rest: &'a [Vec3],
    /// Nodal displacement [m], three components per node.
    pub u: &'a [f64],
    /// The time t [s]; in a static scene 1.
    pub time: f64,
    /// Force of contact and friction on each node [N], three components per node;
    /// empty where no quantity needs it.
    pub contact: &'a [f64],
    /// Force of the supports on each node [N], in the components that they fix, three
    /// components per node; empty where no quantity needs it.
    pub reaction: &'a [f64],
    /// The terms of the energy, of which threads have forces.
    pub energies: &'a Energies,
}

/// Forces on the nodes at a state [N], three components per node; empty where no quantity needs them.
#[derive(Default)]
pub struct Forces {
    /// Forces of contact and friction.
    pub contact: Vec<f64>,
    /// Forces of supports, in the components that they fix.
    pub reaction: Vec<f64>,
}

impl<'a> Equilibrium<'a> {
    /// A state of a problem, with the forces there.
    pub fn new(problem: &'a Problem, at: &Iterate<'a>, forces: &'a Forces) -> Self {
        let &Iterate { space, rest, u, time, .. } = at;
        let Forces { contact, reaction } = forces;
        Self { space, rest, u, time, contact, reaction, energies: &problem.energies }
    }

    /// Positions of the vertices in one of the shapes [m].
    pub fn vertices(&self, measure: Measure) -> Vec<Vec3> {
        let mut vertices = self.rest.to_vec();
        if measure == Measure::Deformed {
            vertices.iter_mut().enumerate().for_each(|(v, x)| *x += at(self.u, v));
        }
        vertices
    }

    /// Positions of the nodes [m].
    pub fn nodes(&self, measure: Measure) -> Vec<Vec3> {
        let mut nodes = self.space.node_positions(self.rest);
        if measure == Measure::Deformed {
            nodes.iter_mut().enumerate().for_each(|(n, x)| *x += at(self.u, n));
        }
        nodes
    }
}

/// Where the partial derivatives of quantities are added up.
pub struct Partials<'a> {
    /// ∂q/∂u at fixed f and r, three components per node.
    pub u: &'a mut [f64],
    /// ∂q/∂X at fixed u, f and r, three components per vertex.
    pub rest: &'a mut [f64],
    /// ∂q/∂f by the forces f of contact, three components per node.
    pub contact: &'a mut [f64],
    /// ∂q/∂r by the forces r of supports, on the degrees of freedom that they fix.
    pub reaction: &'a mut [f64],
}

impl Partials<'_> {
    /// Adds derivatives by the positions of the nodes in one of the shapes, which `add` adds to a
    /// list with three components per node.
    pub fn add_by_nodes(&mut self, at: &Equilibrium, measure: Measure, add: impl Fn(&mut [f64])) {
        if measure == Measure::Deformed {
            add(self.u);
        }
        let mut nodal = vec![0.0; 3 * at.space.node_count()];
        add(&mut nodal);
        at.space.add_to_vertices(&nodal, self.rest);
    }
}

/// One number q(u, X, t, f, r) of a state, with its partial derivatives.
pub trait Quantity: Send + Sync {
    /// Whether the rest shape alone is admissible.
    fn admit(&self, _rest: &[Vec3]) -> Result<(), String> {
        Ok(())
    }
    /// Computes q. Infinite where the rest shape is not admissible.
    fn value(&self, at: &Equilibrium) -> f64;
    /// Adds `weight` times the partial derivatives of q, which must be finite.
    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials);
    /// `weight` times the partial derivatives of q by the parameters of terms of the energy that it is made with.
    fn by_parameters(&self, _at: &Equilibrium, _weight: f64) -> Vec<(Owner, Vec<f64>)> {
        Vec::new()
    }
    /// Whether it looks at the forces of contact.
    fn uses_contact(&self) -> bool {
        false
    }
    /// Whether it looks at the forces of supports.
    fn uses_reaction(&self) -> bool {
        false
    }
}
