//! Terms of the potential energy [J]: elasticity, sheets, fibres, threads, inertia as an incremental potential, dead
//! loads, follower loads (gas in chambers), the contact barrier and lagged friction; and the
//! overstress of viscoelastic bodies and the softening after a first stretch as such.

mod body_force;
mod chamber;
mod contact;
mod elastic;
mod elements;
mod energies;
mod fibres;
mod friction;
pub mod gas_law;
mod inertia;
mod membrane;
mod mullins;
mod owner;
mod profile;
mod quadrature_points;
mod rigid;
mod rim;
mod springs;
#[cfg(test)]
mod tests;
mod traction;
mod viscous;
mod wall;
mod winding;

pub use body_force::BodyForce;
pub use chamber::Chamber;
pub use contact::{Contact, GapSummary};
pub use elastic::{Elastic, ElementLaw};
pub use energies::{ChamberId, Energies, Term};
pub use fibres::{Axis, Direction, Directions, FibreMean, FibreSummary, Fibres};
pub use friction::Friction;
pub use gas_law::{GasLaw, IdealGas, Isobaric, Moment, Potential, PrescribedVolume};
pub use inertia::Inertia;
pub use membrane::{Membrane, MembraneSummary};
pub use mullins::{Mullins, MullinsMean, MullinsSummary};
pub use owner::{Owner, ParameterGradients, Slot};
pub use profile::{Basis, Profile};
pub use rigid::{MassPoint, NoLever, Rigid, RigidLoad, RigidMass, RigidMoment};
pub use rim::Rim;
pub use springs::{Spring, Springs};
pub use traction::Traction;
pub use viscous::{Branch, Viscous};
pub use wall::Wall;
pub use winding::{
    Along, Helix, LayError, Lead, Piece, Strand, Winding, WindingSummary, helix, polyline,
};

use std::any::Any;
use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use crate::contact::friction::{LaggedContact, LaggedContactCotangent};
use crate::element::FunctionSpace;
use crate::math::sparse::BlockMatrix;

/// What a term depends on: one displacement of one rest shape.
#[derive(Clone, Copy)]
pub struct Iterate<'a> {
    /// Topology and basis; never changes with the design.
    pub space: &'a FunctionSpace,
    /// Rest vertex positions X [m].
    pub rest: &'a [Vec3],
    /// Nodal displacement u [m], three components per node.
    pub u: &'a [f64],
    /// Time t [s]; in a static scene the fraction of the
    /// full load.
    pub time: f64,
    /// Multipliers of the chambers with a prescribed volume.
    pub multipliers: &'a [Multiplier],
    /// The step in time that leads here; without it velocities are displacements.
    pub step: Option<&'a TimeStep>,
    /// The displacement that a step of Newton's method began at [m], where one leads here. Hessians of elastic bodies have
    /// the pressures that were foreseen there in place of those here.
    pub before: Option<&'a [f64]>,
}

impl<'a> Iterate<'a> {
    /// At a time, without multipliers and not at the end of a time step.
    pub fn new(space: &'a FunctionSpace, rest: &'a [Vec3], u: &'a [f64], time: f64) -> Self {
        Self { space, rest, u, time, multipliers: &[], step: None, before: None }
    }

    /// The state that a step of Newton's method began at.
    pub(crate) fn foreseen_from(&self) -> Option<Self> {
        self.before.map(|u| Self { u, before: None, ..*self })
    }
}

/// A step in time: where it leads by what velocity and acceleration.
#[derive(Clone, Debug, Default)]
pub struct TimeStep {
    /// h of the velocity v = (u − history) / h at the end [s].
    pub h: f64,
    /// Where a body would be that stops, from the last states [m].
    pub history: Vec<f64>,
    /// Where bodies would go without forces; none where inertia is neglected.
    pub free_flight: Option<FreeFlight>,
    /// Contacts with friction, lagged: as they were at the start of the step.
    pub lagged_contacts: Vec<LaggedContact>,
    /// h of the rates (Z − Z°) / h of internal variables at the end [s].
    pub internal_h: f64,
    /// Z° of the internal variables of all terms, from the last states; empty where all are zero.
    pub internal: Vec<f64>,
}

/// Where the bodies of a step would go without forces, so that a = (u − at) / square.
#[derive(Clone, Debug)]
pub struct FreeFlight {
    /// Displacement [m].
    pub at: Vec<f64>,
    /// Displacement by acceleration at the end of the step [s²].
    pub square: f64,
}

impl FreeFlight {
    /// The acceleration at a displacement [m/s²].
    pub fn acceleration(&self, u: &[f64]) -> Vec<f64> {
        u.iter().zip(&self.at).map(|(u, at)| (u - at) / self.square).collect()
    }
}

/// Cotangents (adjoint variables) of the past in a [`TimeStep`].
#[derive(Clone, Debug, Default)]
pub struct PastCotangent {
    /// Cotangents of the history, three components per node.
    pub history: Vec<f64>,
    /// Cotangents of the free flight, three components per node.
    pub free_flight: Vec<f64>,
    /// Cotangents of the lagged contacts, in their order; empty if nothing depends on them.
    pub lagged_contacts: Vec<LaggedContactCotangent>,
    /// Cotangents of Z°; empty if nothing depends on them.
    pub internal: Vec<f64>,
}

impl PastCotangent {
    /// Zero, for a number of degrees of freedom.
    pub fn zeros(len: usize) -> Self {
        Self { history: vec![0.0; len], free_flight: vec![0.0; len], ..Self::default() }
    }
}

/// The Lagrange multiplier of a prescribed volume, with its penalty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Multiplier {
    /// Gauge pressure at the wanted volume [Pa].
    pub pressure: f64,
    /// What a gap in the volume adds to it [Pa/m³].
    pub penalty: f64,
}

/// A prescribed volume at an iterate.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Index of its multiplier.
    pub multiplier: usize,
    /// Volume [m³].
    pub volume: f64,
    /// Volume that it shall have [m³].
    pub wanted: f64,
    /// ∂V/∂u, three components per node [m²].
    pub gradient: Vec<f64>,
}

/// Which Hessian to assemble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hessian {
    /// The second derivative.
    Exact,
    /// With the elastic tangent of each quadrature point, and the second
    /// derivative of each contact, made positive semidefinite, and without that of the
    /// volume of chambers: positive semidefinite, but for rounding.
    Projected,
}

/// The symmetric matrix s v vᵀ.
#[derive(Clone, Debug)]
pub struct RankOne {
    /// s
    pub scale: f64,
    /// v, three components per node.
    pub vector: Vec<f64>,
}

/// Internal variables Z of a term, such as those of viscosity or damage: at the end of a step functions of u,
/// X, the numbers of the term, and of Z° and h of the step, with which their rates are (Z − Z°) / h. A term
/// knows where its own begin among those of all terms, which follow each other in the order of
/// [`Energies::terms`].
pub trait InternalVariables {
    /// How many there are.
    fn count(&self, space: &FunctionSpace) -> usize;
    /// Z at the end of the step that leads to an iterate.
    fn values(&self, at: &Iterate) -> Vec<f64>;
    /// Adds to `by_u` and `by_rest` what cotangents of Z, of all terms, make of the state.
    fn add_vjp(
        &self,
        at: &Iterate,
        cotangents: &[f64],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) -> InternalCotangent;
}

/// What cotangents of the [`InternalVariables`] of a term make of the rest that they depend on.
pub struct InternalCotangent {
    /// Cotangents of Z° of the term.
    pub past: Vec<f64>,
    /// Cotangents of its numbers, in the order of [`Energy::parameter_vjp`].
    pub parameters: Vec<f64>,
}

/// What a term is to balances of forces and energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// Its forces depend on differences of the displacement and have no resultant.
    Elastic,
    /// The same, of which nothing is stored, such as an overstress.
    Dissipative,
    /// The same of what keeps a part rigid, whose strain is none to speak of.
    Rigid,
    /// Its forces are given and do not depend on the displacement.
    DeadLoad,
    /// Its forces are given, and turn or give way with the displacement.
    Load,
    /// The gas in a chamber.
    Gas,
    /// What inertia adds to the potential of a time step.
    Inertia,
    /// A barrier between surfaces.
    Contact,
    /// What friction adds to the potential of a time step.
    Friction,
    /// None of these: a term that no scene has, such as manufactured forces.
    Other,
}

impl Nature {
    /// Whether its forces count as those of contact.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Contact | Self::Friction)
    }

    /// Whether its forces are internal ones.
    pub fn is_elastic(self) -> bool {
        matches!(self, Self::Elastic | Self::Dissipative | Self::Rigid)
    }

    /// Whether energy is stored in it. Elastic energy and softening together are the work done on a body, of which the
    /// part that is lost cannot be had back.
    pub fn is_stored(self) -> bool {
        !matches!(self, Self::Dissipative | Self::Inertia | Self::Friction)
    }
}

/// One term E(u; X) of the potential energy with all its derivatives.
pub trait Energy: Any + Send + Sync {
    /// What reports call it, and what it is to balances of forces and energy.
    fn kind(&self) -> (&'static str, Nature);
    /// What reports call it.
    fn name(&self) -> &'static str {
        self.kind().0
    }
    /// What it is to balances of forces and energy.
    fn nature(&self) -> Nature {
        self.kind().1
    }
    /// Whether it is stiff along lines in a soft body: where a step of Newton's method has turned these, forces are off that
    /// Hessians do not foresee, and the energy must not increase.
    fn is_reinforcement(&self) -> bool {
        false
    }
    /// This term with its load as it is at a time, for all times, where it has one that changes, but for pressures.
    fn held(&self, _time: f64) -> Option<Arc<dyn Energy>> {
        None
    }
    /// E [J]; infinite where the state is not admissible.
    fn value(&self, at: &Iterate) -> f64;
    /// Adds ∂E/∂u [N].
    fn add_gradient(&self, at: &Iterate, out: &mut [f64]);
    /// Adds the sparse part of ∂²E/∂u² [N/m].
    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix);
    /// The rest of ∂²E/∂u², where every node is coupled with every other [N/m].
    fn rank_one(&self, _: &Iterate) -> Option<RankOne> {
        None
    }
    /// Entries of the sparsity pattern beside those of the elements: pairs of nodes
    /// (row > column) that the Hessian may couple although they share no element, those of
    /// features closer than `reach` ≥ 1 times the distance at which they begin to interact.
    fn couplings(&self, _: &Iterate, _reach: f64) -> Vec<[usize; 2]> {
        Vec::new()
    }
    /// What the term remembers from step to step, if anything.
    fn internal_variables(&self) -> Option<&dyn InternalVariables> {
        None
    }
    /// The volume that the term prescribes, if any.
    fn constraint(&self, _: &Iterate) -> Option<Constraint> {
        None
    }
    /// Adds μ_i ∂(V − V*)/∂X of the volume i that the term prescribes, three components per vertex; the result is
    /// μ_i ∂(V − V*)/∂p for the number p that prescribes it.
    fn constraint_vjp(&self, _: &Iterate, _mu: &[f64], _out: &mut [f64]) -> Option<f64> {
        None
    }
    /// Adds λᵀ ∂²E/∂u∂X, three components per vertex.
    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]);
    /// Adds λᵀ ∂²E/∂u∂(history, free flight, lagged contacts, Z°).
    fn add_past_vjp(&self, _at: &Iterate, _lambda: &[f64], _out: &mut PastCotangent) {}
    /// The numbers of its last owner, by which [`Self::parameter_vjp`] ends; none where these are those of a law.
    fn slots(&self) -> Vec<Slot> {
        Vec::new()
    }
    /// λᵀ ∂²E/∂u∂p for the numbers p that the term was made with, in the order that
    /// its type documents.
    fn parameter_vjp(&self, _at: &Iterate, _lambda: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
