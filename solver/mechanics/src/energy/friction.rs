//! Lagged friction: of the contacts that were there at the start of a time step.
//!
//! E(u) = h Σ_k μ N_k f₀(|τ_k|)      τ_k = 𝒯ᵀ Σᵢ cᵢ vᵢ,   v = W (u − history) / h
//! ∂E/∂u = Σ_k μ N_k (f₀′/y) Γᵀ 𝒯 τ
//! ∂²E/∂u² = (1/h) Σ_k μ N_k Γᵀ 𝒯 [(f₀′/y) I + ((f₀″ − f₀′/y)/y²) τ τᵀ] 𝒯ᵀ Γ
//!
//! N, 𝒯 and c (as Γ) are those of [`LaggedContact`] and do not change with u, so that
//! friction has a potential. Vertices of obstacles have the mean velocity of their
//! last h. Without a step in time there is no friction.
//!
//! u and X enter at fixed lagged contacts through v alone, and v does not depend on the
//! rest shape: the mixed derivative vanishes. The normal forces, closest points and
//! weights at the start of the step change with the rest shape and with the last
//! state: `add_past_vjp` says how the forces follow them, and the contact that
//! made them ([`Contact::add_lagged_contacts_vjp`](super::Contact::add_lagged_contacts_vjp)) how they follow its state.
//!
//! Its one parameter is μ.
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, section 5.

use std::sync::Arc;

use mesh::Vec3;

use super::{Energy, Hessian, Iterate, Nature, Owner, PastCotangent, TimeStep};
use crate::contact::friction::{LaggedContact, LaggedContactCotangent, dissipation};
use crate::contact::surface::{BodyForce, Surface};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat12, Vec12};
use crate::parallel::map_each;

/// Friction on a collision surface.
#[derive(Clone)]
pub struct Friction {
    surface: Arc<Surface>,
    coefficient: f64,
    full_speed: f64,
}

type Mat2 = nalgebra::Matrix2<f64>;
type Vec2 = nalgebra::Vector2<f64>;

impl Friction {
    /// Who owns the coefficient of friction.
    pub const OWNER: Owner = Owner::new("friction", 0);

    /// Friction with a coefficient μ that is full from a sliding speed [m/s] on.
    pub fn new(surface: Arc<Surface>, coefficient: f64, full_speed: f64) -> Self {
        Self { surface, coefficient, full_speed }
    }

    /// This friction with another coefficient.
    pub fn with_coefficient(self, coefficient: f64) -> Self {
        Self { coefficient, ..self }
    }

    /// Force on each collision vertex [N].
    pub fn forces(&self, at: &Iterate) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); self.surface.vertex_count()];
        for (corners, force) in self.corner_forces(at) {
            corners.iter().zip(force).for_each(|(&v, f)| forces[v] += f);
        }
        forces
    }

    /// Force between each two bodies with friction.
    pub fn body_forces(&self, at: &Iterate) -> Vec<BodyForce> {
        self.surface.body_forces(&self.corner_forces(at))
    }

    /// Velocities of the collision vertices [m/s].
    fn velocities(&self, at: &Iterate, step: &TimeStep) -> Vec<Vec3> {
        let h = step.h;
        let moved: Vec<f64> = at.u.iter().zip(&step.history).map(|(u, old)| u - old).collect();
        let mut v = self.surface.motion(at.time - h, at.time);
        v.iter_mut().zip(self.surface.trace(&moved)).for_each(|(v, own)| *v = (*v + own) / h);
        v
    }

    fn corner_forces(&self, at: &Iterate) -> Vec<([usize; 4], [Vec3; 4])> {
        let Some(step) = at.step else { return Vec::new() };
        let v = self.velocities(at, step);
        let force = |contact: &LaggedContact| {
            let [a, b] = contact.velocity(&v);
            let by = dissipation(a.hypot(b), self.full_speed)[1];
            let pull = (contact.tangents[0] * a + contact.tangents[1] * b)
                * (self.coefficient * contact.force * by);
            (contact.corners, contact.coefficients.map(|c| -c * pull))
        };
        step.lagged_contacts.iter().map(force).collect()
    }

    fn hessian(&self, contact: &LaggedContact, v: &[Vec3], h: f64, kind: Hessian) -> Mat12 {
        let velocity = Vec2::from(contact.velocity(v));
        let [_, by, twice] = dissipation(velocity.norm(), self.full_speed);
        let mut inner = Mat2::identity() * by + velocity * (velocity * twice).transpose();
        inner *= self.coefficient * contact.force / h;
        if kind == Hessian::Projected {
            inner = crate::math::tensor::project_positive(&inner);
        }
        let [s, t] =
            contact.tangents.map(|t| Vec12::from_fn(|i, _| contact.coefficients[i / 3] * t[i % 3]));
        let by_s = s * inner[(0, 0)] + t * inner[(1, 0)];
        let by_t = s * inner[(0, 1)] + t * inner[(1, 1)];
        by_s * s.transpose() + by_t * t.transpose()
    }
}

impl Energy for Friction {
    fn kind(&self) -> (&'static str, Nature) {
        ("friction", Nature::Friction)
    }

    fn value(&self, at: &Iterate) -> f64 {
        let Some(step) = at.step else { return 0.0 };
        let v = self.velocities(at, step);
        let work = |contact: &LaggedContact| {
            let [a, b] = contact.velocity(&v);
            contact.force * dissipation(a.hypot(b), self.full_speed)[0]
        };
        step.h * self.coefficient * step.lagged_contacts.iter().map(work).sum::<f64>()
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let pull: Vec<Vec3> = self.forces(at).iter().map(|f| -f).collect();
        self.surface.add_to_nodes(&pull, out);
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let Some(step) = at.step else { return };
        let (v, h) = (self.velocities(at, step), step.h);
        map_each(
            &step.lagged_contacts,
            |contact| self.hessian(contact, &v, h, kind),
            |contact, block| self.surface.add_block(&contact.corners, &block, out),
        );
    }

    fn couplings(&self, at: &Iterate, _reach: f64) -> Vec<[usize; 2]> {
        let lagged_contacts = at.step.map_or(&[][..], |step| &step.lagged_contacts);
        let corners: Vec<_> = lagged_contacts.iter().map(|contact| contact.corners).collect();
        self.surface.couplings(&corners)
    }

    fn add_mixed_vjp(&self, _: &Iterate, _lambda: &[f64], _out: &mut [f64]) {}

    fn add_past_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some(step) = at.step else { return };
        let (v, lambda) = (self.velocities(at, step), self.surface.trace(lambda));
        let mut pull = vec![Vec3::zeros(); v.len()];
        out.lagged_contacts.resize(step.lagged_contacts.len(), LaggedContactCotangent::default());
        for (contact, out) in step.lagged_contacts.iter().zip(&mut out.lagged_contacts) {
            // v = (u − history) / h
            let l = crate::contact::distance::corners(contact.corners.map(|i| lambda[i]));
            let by_velocity = self.hessian(contact, &v, step.h, Hessian::Exact) * l;
            for (i, &corner) in contact.corners.iter().enumerate() {
                pull[corner] -= by_velocity.fixed_rows::<3>(3 * i);
            }
            let own = contact.power_vjp(&v, &lambda, self.full_speed);
            for (o, c) in out.coefficients.iter_mut().zip(own.coefficients) {
                *o += self.coefficient * c;
            }
            out.normal += self.coefficient * own.normal;
            out.force += self.coefficient * own.force;
        }
        self.surface.add_to_nodes(&pull, &mut out.history);
    }

    fn parameter_vjp(&self, at: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let lambda = self.surface.trace(lambda);
        let work: f64 = self.forces(at).iter().zip(&lambda).map(|(f, l)| -f.dot(l)).sum();
        vec![work / self.coefficient]
    }
}
