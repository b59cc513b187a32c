//! The discrete problem: for which u are the forces of all energies in balance?
//!
//! ∂E/∂u = 0 on the free degrees of freedom, u prescribed on the others.
//!
//! A [`Problem`] does not change while it is solved. What it is evaluated at is an
//! [`Iterate`]: rest shape, displacement, load, multipliers of prescribed volumes and
//! time step, together. A [`Configuration`] owns the part of it that is sought.

use std::sync::Arc;

use mesh::Vec3;

use super::dirichlet::Dirichlet;
use crate::contact::friction::LaggedContact;
use crate::element::FunctionSpace;
use crate::energy::{
    ChamberId, Constraint, Energies, Iterate, Multiplier, RankOne, Springs, Term, TimeStep,
};
use crate::math::linear::norm;
use crate::rigid::RigidSet;

/// Energies on a function space with Dirichlet conditions. A copy shares what is
/// large.
#[derive(Clone)]
pub struct Problem {
    /// Where displacements live.
    pub space: Arc<FunctionSpace>,
    /// Terms of the potential energy.
    pub energies: Energies,
    /// Degrees of freedom that are fixed.
    pub dirichlet: Arc<Dirichlet>,
    /// Multipliers of the chambers with a prescribed volume, before the first step.
    pub multipliers: Vec<Multiplier>,
    /// Whether an equilibrium may have elements that are turned inside out between their
    /// quadrature points.
    pub tolerates_inversion: bool,
}

impl Problem {
    /// Some degrees of freedom are fixed at zero; `fixed` has one entry for each.
    pub fn new(space: FunctionSpace, energies: Energies, fixed: &[bool]) -> Self {
        let (space, dirichlet) = (Arc::new(space), Arc::new(Dirichlet::new(fixed)));
        let multipliers = Vec::new();
        Self { space, energies, dirichlet, multipliers, tolerates_inversion: false }
    }

    /// Sets the multipliers of prescribed volumes at rest, as the energies number them.
    pub fn with_multipliers(self, multipliers: Vec<Multiplier>) -> Self {
        Self { multipliers, ..self }
    }

    /// Prescribes the displacement of all degrees of freedom at a time [m]; entries
    /// of those that are not fixed are ignored.
    pub fn with_motion(mut self, motion: impl Fn(f64) -> Vec<f64> + Send + Sync + 'static) -> Self {
        self.dirichlet = Arc::new(Dirichlet::clone(&self.dirichlet).with_motion(Arc::new(motion)));
        self
    }

    /// Prescribes the displacement of the fixed degrees of freedom at full load
    /// [m], in proportion to which they move; entries of the others are ignored.
    pub fn with_displacement(self, displacement: &[f64]) -> Self {
        let full = displacement.to_vec();
        self.with_motion(move |time| full.iter().map(|u| time * u).collect())
    }

    /// This problem with other degrees of freedom fixed.
    pub fn with_fixed(&self, fixed: &[bool]) -> Self {
        Self { dirichlet: Arc::new(self.dirichlet.with_fixed(fixed)), ..self.clone() }
    }

    /// This problem with parts that are rigid, which have no node in common and none that is fixed along an
    /// axis along which the part moves. What keeps their masters rigid is an energy.
    pub fn with_rigid(mut self, parts: &[RigidSet]) -> Self {
        self.dirichlet = Arc::new(Dirichlet::clone(&self.dirichlet).with_rigid(parts));
        self
    }

    /// This problem with all loads and supports held as they are at a time, but for the pressures of some chambers,
    /// which are scaled in proportion to the time from there.
    pub fn with_scaled_pressures(&self, time: f64, scaled: &[ChamberId]) -> Self {
        let mut held =
            Self { energies: self.energies.with_scaled_pressures(time, scaled), ..self.clone() };
        if self.dirichlet.moves() {
            let there = self.dirichlet.displacement(time);
            held = held.with_motion(move |_| there.clone());
        }
        held
    }

    /// This problem with springs that pull released supports.
    pub fn with_springs(&self, springs: Springs) -> Self {
        let mut pulled = self.clone();
        pulled.energies.extend([Term::new(springs)]);
        pulled
    }

    /// Number of degrees of freedom, fixed ones included.
    pub fn dofs(&self) -> usize {
        3 * self.space.node_count()
    }

    /// A displacement [m] at a time, without a time step and with the multipliers of
    /// the rest shape.
    pub fn iterate<'a>(&'a self, rest: &'a [Vec3], u: &'a [f64], time: f64) -> Iterate<'a> {
        let multipliers = &self.multipliers;
        Iterate { multipliers, ..Iterate::new(&self.space, rest, u, time) }
    }

    /// Total potential energy [J].
    pub fn value(&self, at: &Iterate) -> f64 {
        self.value_by(|term| term.energy.value(at))
    }

    /// Total potential energy [J], with the value of each term by `value`.
    pub(super) fn value_by(&self, value: impl FnMut(&Term) -> f64) -> f64 {
        self.energies.terms().map(value).sum()
    }

    /// Gradient over all degrees of freedom [N], reactions included, and the
    /// scale of the forces that have to balance: the largest norm of one term's
    /// free part, or of the reactions where supports move.
    pub fn gradient(&self, at: &Iterate) -> (Vec<f64>, f64) {
        self.gradient_by(|term, out| term.energy.add_gradient(at, out))
    }

    /// Results of [`Self::gradient`], with the gradient of each term added by `add`.
    pub(super) fn gradient_by(&self, mut add: impl FnMut(&Term, &mut [f64])) -> (Vec<f64>, f64) {
        let mut total = vec![0.0; self.dofs()];
        let mut scale = 0.0_f64;
        let mut part = vec![0.0; self.dofs()];
        for term in self.energies.terms() {
            part.fill(0.0);
            add(term, &mut part);
            scale = scale.max(norm(&self.restrict(&part)));
            total.iter_mut().zip(&part).for_each(|(t, p)| *t += p);
        }
        if self.dirichlet.moves() {
            let reactions: Vec<f64> =
                self.dirichlet.supports().iter().map(|&dof| total[dof]).collect();
            scale = scale.max(norm(&reactions));
        }
        (total, scale)
    }

    /// What the Hessian adds to its sparse part.
    pub fn rank_ones(&self, at: &Iterate) -> Vec<RankOne> {
        self.energies.iter().filter_map(|energy| energy.rank_one(at)).collect()
    }

    /// The prescribed volumes.
    pub fn constraints(&self, at: &Iterate) -> Vec<Constraint> {
        self.energies.iter().filter_map(|energy| energy.constraint(at)).collect()
    }

    /// The contacts at a state whose friction acts in the next step.
    pub fn lagged_contacts(&self, at: &Iterate) -> Vec<LaggedContact> {
        self.energies.contact().map_or_else(Vec::new, |contact| contact.lagged_contacts(at))
    }

    /// Largest step length in [0, 1] from one iterate to another, straight in u and the
    /// load, on which surfaces stay apart.
    pub fn max_step(&self, from: &Iterate, to: &Iterate) -> f64 {
        self.energies.contact().map_or(1.0, |contact| contact.max_step(from, to))
    }

    /// Why a state must not be accepted, if so.
    pub fn objection(&self, at: &Iterate) -> Option<String> {
        self.energies.contact()?.objection(at)
    }

    /// Forces on the unknowns from those on all degrees of freedom.
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        self.dirichlet.restrict(full)
    }

    /// Motion of all degrees of freedom from that of the unknowns.
    pub fn prolong(&self, free: &[f64]) -> Vec<f64> {
        self.dirichlet.prolong(free)
    }
}

/// A state of a problem: the unknowns, with their rest shape, load and time step.
#[derive(Clone, Debug)]
pub struct Configuration<'a> {
    /// Rest vertex positions X [m].
    pub rest: &'a [Vec3],
    /// Time t [s]; in a static scene the fraction of the full load.
    pub time: f64,
    /// The step in time that leads here, if there is one.
    pub step: Option<&'a Arc<TimeStep>>,
    /// Displacement u [m], three components per node.
    pub u: Vec<f64>,
    /// Multipliers of the chambers with a prescribed volume.
    pub multipliers: Vec<Multiplier>,
    /// The time at which the forces of this displacement balance [s], if that is known: the tangent there is
    /// the first that Newton's method uses.
    pub balanced_at: Option<f64>,
}

impl<'a> Configuration<'a> {
    /// A displacement [m] at a time, without a time step and with the multipliers of
    /// the rest shape.
    pub fn new(problem: &Problem, rest: &'a [Vec3], u: Vec<f64>, time: f64) -> Self {
        let multipliers = problem.multipliers.clone();
        Self { rest, time, step: None, u, multipliers, balanced_at: None }
    }

    /// What energies depend on.
    pub fn iterate<'b>(&'b self, problem: &'b Problem) -> Iterate<'b> {
        let Self { rest, time, step, u, multipliers, .. } = self;
        Iterate {
            space: &problem.space,
            rest,
            u,
            time: *time,
            multipliers,
            step: step.map(|step| &**step),
            before: None,
        }
    }
}
