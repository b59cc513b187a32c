//! Barrier between surfaces that must not touch.
//!
//! E(u; X) = B(x; X)      x = W (ΠX + u)
//!
//! B   [`Potential`] of a log barrier, with the scale κ σ of [`Barrier::scale`] [J]
//! x   positions of the collision vertices [m]
//!
//! What is apart at rest repels each other: neither through the [`solid`](crate::contact::solid)
//! of a body, nor from its [rest distance](crate::contact::rest_offset) on, unless a scene
//! wants all pairs.
//!
//! E is +∞ where a pair is not farther apart than d₀, or where more pairs are in
//! range than memory is meant for. Derivatives by x and X of the collision vertices go
//! through Wᵀ and Πᵀ to nodes and rest vertices.
//!
//! Steps are bounded by continuous collision detection ([`ccd`]), and accepted states
//! can be proved free of intersections ([`certify`]).
//!
//! Sources: Li et al. 2020, doi:10.1145/3386569.3392425; Li et al. 2023,
//! arXiv:2307.15908.

use std::sync::Arc;

use mesh::Vec3;

use super::{Energy, Hessian, Iterate, Nature, Owner};
use crate::contact::barrier::Barrier;
use crate::contact::candidates::coming_within;
use crate::contact::ccd;
use crate::contact::certificate::{Intersection, certify};
use crate::contact::friction::{LaggedContact, LaggedContactCotangent};
use crate::contact::neighbours::{Held, NeighbourList};
use crate::contact::pairs::Pair;
use crate::contact::potential::{Contacts, Partners, Potential};
use crate::contact::rest_offset::Close;
use crate::contact::surface::{BodyForce, Surface};
use crate::math::sparse::BlockMatrix;

/// Share of a step below which it is given up.
const SHORTEST: f64 = 1e-10;

/// The barrier between all parts of a collision surface.
pub struct Contact {
    barrier: Barrier,
    potential: Potential,
    neighbours: NeighbourList,
    /// Whether to prove of accepted states that they have no intersection.
    certify: bool,
}

/// How close the surfaces are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSummary {
    /// Number of pairs that repel each other.
    pub pairs: usize,
    /// Smallest (d − d₀) / d̂ of these; infinite without any.
    pub smallest: f64,
}

impl Contact {
    /// Who owns the stiffness of the barrier, in its own forces and in those of friction.
    pub const OWNER: Owner = Owner::new("contact", 0);

    /// The barrier between features of a surface.
    pub fn new(surface: Arc<Surface>, partners: Partners, barrier: Barrier) -> Self {
        // each copy of a part has the same share of the energy of the whole
        let (repulsion, scale) = (barrier.repulsion(), barrier.scale() * surface.share());
        let potential = Potential::new(surface, partners, barrier.form, repulsion, scale);
        Self { barrier, potential, neighbours: NeighbourList::default(), certify: false }
    }

    /// This barrier; of accepted states it is also proved that they have no
    /// intersection.
    pub fn certified(self) -> Self {
        Self { certify: true, ..self }
    }

    /// Takes rest shapes that hardly differ from the last one for it ([`NeighbourList::hold`]).
    pub fn hold(&self) -> Held<'_> {
        self.neighbours.hold()
    }

    /// The barrier.
    pub fn barrier(&self) -> &Barrier {
        &self.barrier
    }

    /// This contact with another stiffness of the barrier [Pa]; in the plain form [J/m⁴].
    pub fn with_stiffness(&self, stiffness: f64) -> Self {
        let barrier = Barrier { stiffness, ..self.barrier };
        let own = Self::new(Arc::clone(self.surface()), self.potential.partners(), barrier);
        Self { certify: self.certify, ..own }
    }

    /// What intersects at positions of the collision vertices [m], if anything.
    pub fn intersection(&self, x: &[Vec3]) -> Option<Intersection> {
        let movable = |vertex: usize| !self.surface().immovable(&[vertex]);
        certify(&self.surface().features().triangles, x, movable).err()
    }

    /// The collision surface.
    pub fn surface(&self) -> &Arc<Surface> {
        self.potential.surface()
    }

    /// Force on each collision vertex [N].
    pub fn forces(&self, at: &Iterate) -> Vec<Vec3> {
        let mut forces = self.contacts(at).gradient();
        // zero has no sign
        forces.iter_mut().for_each(|f| *f = Vec3::zeros() - *f);
        forces
    }

    /// Force between each two bodies that touch.
    pub fn body_forces(&self, at: &Iterate) -> Vec<BodyForce> {
        let mut forces = Vec::new();
        self.contacts(at).for_each_gradient(|corners, gradient| {
            forces.push((corners, gradient.map(|g| -g)));
        });
        self.surface().body_forces(&forces)
    }

    /// How close the surfaces are.
    pub fn gaps(&self, at: &Iterate) -> GapSummary {
        let repulsion = self.potential.repulsion();
        let close = self.close_pairs(&self.positions(at), &self.rest(at)).unwrap_or_default();
        let gap = |d2: f64| (d2.sqrt() - repulsion.minimum) / repulsion.activation;
        let mut summary = GapSummary { pairs: 0, smallest: f64::INFINITY };
        for pair in close.iter().filter(|pair| pair.acts(repulsion)) {
            summary.pairs += 1;
            summary.smallest = summary.smallest.min(gap(pair.closest.d2));
        }
        summary
    }

    /// The pairs within range at rest positions of the collision vertices, in a fixed order;
    /// none if there are more than memory is meant for.
    pub fn close_at_rest(&self, rest: &[Vec3]) -> Option<Vec<Close>> {
        self.close_pairs(rest, rest)
    }

    fn positions(&self, at: &Iterate) -> Vec<Vec3> {
        self.surface().positions(at.space, at.rest, at.u, at.time)
    }

    fn rest(&self, at: &Iterate) -> Vec<Vec3> {
        self.surface().rest(at.space, at.rest)
    }

    /// The pairs within range, in a fixed order; none if there are more than memory is
    /// meant for.
    fn close_pairs(&self, x: &[Vec3], rest: &[Vec3]) -> Option<Vec<Close>> {
        let neighbours = self.neighbours.at(&self.potential, x, rest)?;
        Some(self.potential.close_pairs(&neighbours.pairs, x, rest))
    }

    /// What interacts at an iterate.
    fn contacts(&self, at: &Iterate) -> Contacts<'_> {
        let (x, rest) = (self.positions(at), self.rest(at));
        let close = self.close_pairs(&x, &rest).unwrap_or_default();
        self.potential.contacts(&close, x, rest)
    }

    /// How much of the way from `start` to `end` these pairs may go; those through solid keep
    /// no thickness.
    fn free_share(&self, pairs: [&[Pair]; 2], start: &[Vec3], end: &[Vec3]) -> f64 {
        let minimum = self.potential.repulsion().minimum;
        let [air, solid] = pairs;
        ccd::max_step(air, start, end, minimum).min(ccd::max_step(solid, start, end, 0.0))
    }

    /// Largest step length α in [0, 1] for which nothing on the straight path, in u and the time, from
    /// one iterate to another of the same rest shape comes closer than d₀ before α.
    pub fn max_step(&self, from: &Iterate, to: &Iterate) -> f64 {
        let (start, whole, rest) = (self.positions(from), self.positions(to), self.rest(from));
        if let Some(list) = self.neighbours.last_at(&rest, &[&start, &whole]) {
            return self.free_share([&list.pairs, &list.through_solid], &start, &whole);
        }
        let minimum = self.potential.repulsion().minimum;
        if let Some(swept) = self.neighbours.sweep(&self.potential, [&start, &whole], &rest) {
            let [air, solid] = [&swept.pairs, &swept.through_solid]
                .map(|pairs| coming_within(pairs, &start, &whole, minimum));
            return self.free_share([&air, &solid], &start, &whole);
        }
        let mut share = 1.0;
        // a step that sweeps through too much is searched in part
        while share > SHORTEST {
            let along = |(a, b): (&Vec3, &Vec3)| a + share * (b - a);
            let end: Vec<Vec3> = start.iter().zip(&whole).map(along).collect();
            if let Ok(pairs) = self.potential.candidates(&start, &end, minimum) {
                // without a thickness it makes no difference what is between them
                let [air, solid] = match minimum {
                    0.0 => [pairs, Vec::new()],
                    _ => self.neighbours.partition(&self.potential, &rest, pairs),
                };
                return share * self.free_share([&air, &solid], &start, &end);
            }
            share *= 0.5;
        }
        0.0
    }

    /// What intersects, if it is to be proved that nothing does.
    pub fn objection(&self, at: &Iterate) -> Option<String> {
        let found = self.certify.then(|| self.intersection(&self.positions(at))).flatten();
        found.map(|intersection| intersection.to_string())
    }

    /// The contacts whose friction acts in the next step (lagged friction).
    pub fn lagged_contacts(&self, at: &Iterate) -> Vec<LaggedContact> {
        self.contacts(at).lagged()
    }

    /// What cotangents of [`Self::lagged_contacts`] make of the stiffness, to which their forces are proportional.
    pub fn lagged_stiffness_vjp(
        &self,
        contacts: &[LaggedContact],
        cotangents: &[LaggedContactCotangent],
    ) -> f64 {
        let each = contacts.iter().zip(cotangents);
        each.map(|(contact, by)| contact.force * by.force).sum::<f64>() / self.barrier.stiffness
    }

    /// Adds to `by_u` and `by_rest` what cotangents of [`Self::lagged_contacts`] make of this state.
    pub fn add_lagged_contacts_vjp(
        &self,
        at: &Iterate,
        cotangents: &[LaggedContactCotangent],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) {
        let state = self.contacts(at).lagged_vjp(cotangents);
        self.surface().add_to_nodes(&state.positions, by_u);
        self.surface().add_to_rest(at.space, &state.rest, by_rest);
    }
}

impl Energy for Contact {
    fn kind(&self) -> (&'static str, Nature) {
        ("contact", Nature::Contact)
    }

    fn value(&self, at: &Iterate) -> f64 {
        let (x, rest) = (self.positions(at), self.rest(at));
        let Some(close) = self.close_pairs(&x, &rest) else { return f64::INFINITY };
        if close.iter().any(|pair| pair.is_violated(self.potential.repulsion())) {
            return f64::INFINITY;
        }
        self.potential.contacts(&close, x, rest).value()
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        self.surface().add_to_nodes(&self.contacts(at).gradient(), out);
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let contacts = self.contacts(at);
        match kind {
            Hessian::Exact => contacts.add_hessian(out),
            Hessian::Projected => contacts.add_projected_hessian(out),
        }
    }

    fn couplings(&self, at: &Iterate, reach: f64) -> Vec<[usize; 2]> {
        let (x, rest) = (self.positions(at), self.rest(at));
        let pairs: Vec<Pair> = if reach <= 1.0 {
            self.close_pairs(&x, &rest).unwrap_or_default().iter().map(|close| close.pair).collect()
        } else {
            let radius = reach * self.potential.repulsion().range();
            let pairs = self.potential.candidates(&x, &x, radius).unwrap_or_default();
            let [pairs, _] = self.neighbours.partition(&self.potential, &rest, pairs);
            pairs
        };
        let corners: Vec<_> = pairs.iter().map(Pair::corners).collect();
        self.surface().couplings(&corners)
    }

    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let by_rest = self.contacts(at).shape_vjp(&self.surface().trace(lambda));
        self.surface().add_to_rest(at.space, &by_rest, out);
    }

    /// By the stiffness, to which all forces are proportional.
    fn parameter_vjp(&self, at: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let pulls = self.contacts(at).gradient();
        let along = pulls.iter().zip(self.surface().trace(lambda)).map(|(g, l)| g.dot(&l));
        vec![along.sum::<f64>() / self.barrier.stiffness]
    }
}

#[cfg(test)]
mod tests;
