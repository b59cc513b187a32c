//! Barrier between surfaces that must not touch.
//!
//! E(u; X) = B(x; X)      x = W (ΠX + u)
//!
//! B   [`Potential`] of a log barrier, with the scale κ σ of [`Barrier::scale`] [J]
//! x   positions of the collision vertices [m]
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

use super::{Energy, Hessian, Iterate};
use crate::contact::barrier::Barrier;
use crate::contact::ccd;
use crate::contact::certificate::{Intersection, certify};
use crate::contact::distance::Closest;
use crate::contact::friction::{LaggedContact, LaggedContactCotangent};
use crate::contact::neighbours::NeighbourList;
use crate::contact::pairs::Pair;
use crate::contact::potential::{Contacts, Partners, Potential};
use crate::contact::surface::{BodyForce, Surface};
use crate::math::sparse::BlockMatrix;

/// Share of a step below which it is given up.
const SHORTEST: f64 = 1e-10;

/// The barrier between all parts of a collision surface.
pub struct Contact {
    potential: Potential,
    neighbours: NeighbourList,
    /// Whether to prove of accepted states that they have no intersection.
    certify: bool,
}

/// How close the surfaces are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSummary {
    /// Number of pairs within the barrier's range.
    pub pairs: usize,
    /// Smallest (d − d₀) / d̂; infinite without pairs.
    pub smallest: f64,
}

impl Contact {
    /// The barrier between all features of a surface.
    #[must_use]
    pub fn new(surface: Arc<Surface>, barrier: Barrier) -> Self {
        // each copy of a part has the same share of the energy of the whole
        let (repulsion, scale) = (barrier.repulsion(), barrier.scale() * surface.share());
        let potential = Potential::new(surface, Partners::All, barrier.form, repulsion, scale);
        Self { potential, neighbours: NeighbourList::default(), certify: false }
    }

    /// The same, and of accepted states it is proved that they have no
    /// intersection.
    #[must_use]
    pub fn certified(self) -> Self {
        Self { certify: true, ..self }
    }

    /// What intersects at positions of the collision vertices [m], if anything.
    #[must_use]
    pub fn intersection(&self, x: &[Vec3]) -> Option<Intersection> {
        let movable = |vertex: usize| !self.surface().immovable(&[vertex]);
        certify(&self.surface().features().triangles, x, movable).err()
    }

    /// The collision surface.
    #[must_use]
    pub fn surface(&self) -> &Arc<Surface> {
        self.potential.surface()
    }

    /// Force on each collision vertex [N].
    #[must_use]
    pub fn forces(&self, at: &Iterate) -> Vec<Vec3> {
        let mut forces = self.contacts(at).gradient();
        // zero has no sign
        forces.iter_mut().for_each(|f| *f = Vec3::zeros() - *f);
        forces
    }

    /// Force between each two bodies that touch.
    #[must_use]
    pub fn body_forces(&self, at: &Iterate) -> Vec<BodyForce> {
        let mut forces = Vec::new();
        self.contacts(at).for_each_gradient(|corners, gradient| {
            forces.push((corners, gradient.map(|g| -g)));
        });
        self.surface().body_forces(&forces)
    }

    /// How close the surfaces are.
    #[must_use]
    pub fn gaps(&self, at: &Iterate) -> GapSummary {
        let close = self.close_pairs(&self.positions(at)).unwrap_or_default();
        let repulsion = self.potential.repulsion();
        let gap = |d2: f64| (d2.sqrt() - repulsion.minimum) / repulsion.activation;
        let gaps = close.iter().map(|(_, closest)| gap(closest.d2));
        GapSummary { pairs: close.len(), smallest: gaps.fold(f64::INFINITY, f64::min) }
    }

    /// The closest of the pairs within range at positions of the collision
    /// vertices, and its distance [m].
    #[must_use]
    pub fn closest(&self, x: &[Vec3]) -> Option<(Pair, f64)> {
        let close = self.close_pairs(x)?.into_iter();
        let closest = close.min_by(|a, b| a.1.d2.total_cmp(&b.1.d2))?;
        Some((closest.0, closest.1.d2.sqrt()))
    }

    fn positions(&self, at: &Iterate) -> Vec<Vec3> {
        self.surface().positions(at.space, at.rest, at.u, at.load)
    }

    /// All pairs within range, in a fixed order; none if there are more than
    /// memory is meant for.
    fn close_pairs(&self, x: &[Vec3]) -> Option<Vec<(Pair, Closest)>> {
        let neighbours = self.neighbours.at(&self.potential, x)?;
        Some(self.potential.close_pairs(&neighbours.pairs, x))
    }

    /// What interacts at an iterate.
    fn contacts(&self, at: &Iterate) -> Contacts<'_> {
        let x = self.positions(at);
        self.contacts_of(&self.close_pairs(&x).unwrap_or_default(), x, at)
    }

    fn contacts_of(&self, close: &[(Pair, Closest)], x: Vec<Vec3>, at: &Iterate) -> Contacts<'_> {
        self.potential.contacts(close, x, self.surface().rest(at.space, at.rest))
    }
}

impl Energy for Contact {
    fn name(&self) -> &'static str {
        "contact"
    }

    fn value(&self, at: &Iterate) -> f64 {
        let x = self.positions(at);
        let Some(close) = self.close_pairs(&x) else { return f64::INFINITY };
        let repulsion = self.potential.repulsion();
        if close.iter().any(|(_, closest)| repulsion.is_violated(closest.d2)) {
            return f64::INFINITY;
        }
        self.contacts_of(&close, x, at).value()
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
        let x = self.positions(at);
        let pairs: Vec<Pair> = if reach <= 1.0 {
            self.close_pairs(&x).unwrap_or_default().into_iter().map(|(pair, _)| pair).collect()
        } else {
            let radius = reach * self.potential.repulsion().range();
            self.potential.candidates(&x, &x, radius).unwrap_or_default()
        };
        let corners: Vec<_> = pairs.iter().map(Pair::corners).collect();
        self.surface().couplings(&corners)
    }

    fn max_step(&self, from: &Iterate, to: &Iterate) -> f64 {
        let (start, whole) = (self.positions(from), self.positions(to));
        let minimum = self.potential.repulsion().minimum;
        if let Some(list) = self.neighbours.last_at(&[&start, &whole]) {
            return ccd::max_step(&list.pairs, &start, &whole, minimum);
        }
        let mut share = 1.0;
        // a step that sweeps through too much is searched in part
        while share > SHORTEST {
            let along = |(a, b): (&Vec3, &Vec3)| a + share * (b - a);
            let end: Vec<Vec3> = start.iter().zip(&whole).map(along).collect();
            if let Ok(pairs) = self.potential.candidates(&start, &end, minimum) {
                return share * ccd::max_step(&pairs, &start, &end, minimum);
            }
            share *= 0.5;
        }
        0.0
    }

    fn objection(&self, at: &Iterate) -> Option<String> {
        let found = self.certify.then(|| self.intersection(&self.positions(at))).flatten();
        found.map(|intersection| intersection.to_string())
    }

    fn lagged_contacts(&self, at: &Iterate) -> Vec<LaggedContact> {
        self.contacts(at).lagged()
    }

    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let by_rest = self.contacts(at).shape_vjp(&self.surface().trace(lambda));
        self.surface().add_to_rest(at.space, &by_rest, out);
    }

    fn add_lagged_contacts_vjp(
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

#[cfg(test)]
mod tests;
