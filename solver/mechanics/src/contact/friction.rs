//! Lagged friction: a smoothed law of Coulomb between the contacts of the start of a time
//! step, whose normal forces and closest points stay as they were there.
//!
//! f₀(y) = y² (1 − y/(3ε)) / ε + ε/3 for y < ε, else y      [m/s]
//! f₀′(y) = (y/ε)(2 − y/ε) for y < ε, else 1
//!
//! y   sliding speed [m/s];   ε   speed from which on friction is full [m/s]
//!
//! Below full friction contacts creep: a fraction r of it is reached at the speed
//! ε (1 − √(1 − r)).
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 15, integrated.

use mesh::Vec3;

use super::distance::tangents;
use super::potential::{Contacts, add, add_vector};
use super::terms::Term;

/// A contact with friction, as it was at the start of a time step: its normal
/// force, and how velocities of its corners make a sliding velocity
/// 𝒯ᵀ Σᵢ cᵢ vᵢ.
#[derive(Clone, Debug, PartialEq)]
pub struct LaggedContact {
    /// Collision vertices of the two features.
    pub corners: [usize; 4],
    /// Barycentric coefficients cᵢ of the closest points, negative on the second
    /// feature [1].
    pub coefficients: [f64; 4],
    /// Two orthonormal directions 𝒯 in which it slides.
    pub tangents: [Vec3; 2],
    /// Normal force [N]; negative where a contact is taken off that others have
    /// counted twice.
    pub force: f64,
}

impl LaggedContact {
    /// A contact of corners whose closest points are `offset` apart.
    pub fn new(corners: [usize; 4], coefficients: [f64; 4], offset: Vec3, force: f64) -> Self {
        Self { corners, coefficients, tangents: tangents(&offset.normalize()), force }
    }

    /// Sliding velocity 𝒯ᵀ Σᵢ cᵢ vᵢ for velocities of all collision vertices
    /// [m/s].
    pub fn velocity(&self, v: &[Vec3]) -> [f64; 2] {
        let relative: Vec3 =
            self.corners.iter().zip(self.coefficients).map(|(&i, c)| c * v[i]).sum();
        self.tangents.map(|t| t.dot(&relative))
    }
}

/// Cotangents of a [`LaggedContact`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaggedContactCotangent {
    /// Cotangents of the coefficients.
    pub coefficients: [f64; 4],
    /// Cotangent of the normal n, a unit vector with 𝒯 𝒯ᵀ = I − n nᵀ.
    pub normal: Vec3,
    /// Cotangent of the normal force [1/N of the unit of J].
    pub force: f64,
}

impl LaggedContact {
    /// The normal n = 𝒯₁ × 𝒯₂, from the second feature to the first.
    pub fn normal(&self) -> Vec3 {
        self.tangents[0].cross(&self.tangents[1])
    }

    /// Cotangents of the power N k(y) (P w)·(P l) of friction, with P = I − n nᵀ,
    /// k = f₀′/y, y = |P w|, w = Σ cᵢ vᵢ and l = Σ cᵢ λᵢ, for velocities v [m/s] and
    /// any λ of all collision vertices.
    pub fn power_vjp(
        &self,
        v: &[Vec3],
        lambda: &[Vec3],
        full_speed: f64,
    ) -> LaggedContactCotangent {
        let normal = self.normal();
        let sum = |of: &[Vec3]| -> Vec3 {
            self.corners.iter().zip(self.coefficients).map(|(&i, c)| c * of[i]).sum()
        };
        let along = |x: &Vec3| x - normal * normal.dot(x);
        let (w, l) = (sum(v), sum(lambda));
        let (pw, pl) = (along(&w), along(&l));
        let [_, by, twice] = dissipation(pw.norm(), full_speed);
        let power = pw.dot(&pl);
        // ∂power/∂w and ∂power/∂l, both within the tangent plane
        let (by_w, by_l) = (by * pl + twice * power * pw, by * pw);
        let coefficient = |&i: &usize| self.force * (by_w.dot(&v[i]) + by_l.dot(&lambda[i]));
        let (wn, ln) = (w.dot(&normal), l.dot(&normal));
        let by_normal = -by * (ln * w + wn * l) - twice * power * wn * w;
        LaggedContactCotangent {
            coefficients: [0, 1, 2, 3].map(|i| coefficient(&self.corners[i])),
            normal: self.force * by_normal,
            force: by * power,
        }
    }
}

/// f₀, f₀′/y and (f₀″ − f₀′/y)/y² at a speed, for a speed ε of full friction.
pub fn dissipation(y: f64, full: f64) -> [f64; 3] {
    if y < full {
        let r = y / full;
        let value = y * r * (1.0 - r / 3.0) + full / 3.0;
        // f₀′/y = (2 − y/ε)/ε, whose derivative by y is −1/ε²
        // and which acts on τ τᵀ, of size y²
        let curvature = if r > 1e-100 { -1.0 / (full * full * y) } else { 0.0 };
        [value, (2.0 - r) / full, curvature]
    } else {
        [y, 1.0 / y, -1.0 / (y * y * y)]
    }
}

/// Cotangents of a state, given those of its lagged contacts.
pub struct LaggedStateCotangent {
    /// Cotangents of positions x of the collision vertices.
    pub positions: Vec<Vec3>,
    /// Cotangents of their rest positions X, for x that moves along with X.
    pub rest: Vec<Vec3>,
}

impl Contacts<'_> {
    /// The contacts with friction in a step that begins here. Mollified pairs, of nearly
    /// parallel edges, have none: their closest points jump.
    pub fn lagged(&self) -> Vec<LaggedContact> {
        let one = |term: &Term| {
            let local = self.local(term);
            let closest = local.closest;
            let force = term.weight * local.normal_force(self.scale())[0];
            let corners = term.stencil.corners;
            LaggedContact::new(corners, closest.coefficients, closest.offset, force)
        };
        self.with_friction().map(one).collect()
    }

    /// How [`Self::lagged`] follows the state.
    pub fn lagged_vjp(&self, cotangents: &[LaggedContactCotangent]) -> LaggedStateCotangent {
        let (mut positions, mut by_area) = (self.zeros(), self.zero_areas());
        let mut by_offset = Vec::new();
        for (term, by) in self.with_friction().zip(cotangents) {
            let local = self.local(term);
            let closest = local.closest;
            let [force, force_slope] = local.normal_force(self.scale());
            let normal = closest.offset.normalize();
            let turned = (by.normal - normal * normal.dot(&by.normal)) / closest.d2.sqrt();
            let by_gap = turned + closest.offset * (2.0 * by.force * term.weight * force_slope);
            let corners = term.stencil.gather(self.positions());
            let by_closest = (&by.coefficients, &by_gap);
            let pull = term.stencil.region.closest_vjp(&corners, &closest, by_closest);
            add(&mut positions, &term.stencil.corners, pull);
            self.add_by_area(term, by.force * force, &mut by_area);
            if let Some((by_activation, own)) = local.normal_force_by_offset(self.scale()) {
                let by_activation = by.force * term.weight * by_activation;
                by_offset.push((own.corners, own.by_rest * by_activation));
            }
        }
        let mut rest = positions.clone();
        by_offset.iter().for_each(|(corners, by)| add_vector(&mut rest, corners, by));
        self.add_area_gradient(&by_area, &mut rest);
        LaggedStateCotangent { positions, rest }
    }

    fn with_friction(&self) -> impl Iterator<Item = &Term> {
        self.terms().iter().filter(|t| !t.stencil.mollified && t.weight != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_has_its_closed_forms_and_is_smooth() {
        let full = 1e-3;
        // at rest f₀ = ε/3 and f₀′/y = 2/ε
        assert_eq!(dissipation(0.0, full), [full / 3.0, 2.0 / full, 0.0]);
        // creep at fractions r of full friction
        for (r, speed) in [(0.5, 0.2929), (0.9, 0.6838)] {
            let y = full * (1.0 - f64::sqrt(1.0 - r));
            assert!((y / full - speed).abs() < 5e-5);
            assert!((y * dissipation(y, full)[1] - r).abs() < 1e-14);
        }
        let [below, above] = [full * (1.0 - 1e-12), full].map(|y| dissipation(y, full));
        assert!((below[0] / above[0] - 1.0).abs() < 1e-11);
        assert!((below[1] / above[1] - 1.0).abs() < 1e-11);
    }

    #[test]
    fn tangents_are_orthonormal() {
        for offset in [Vec3::x(), Vec3::new(-1e-5, 2e-5, 3e-6), Vec3::new(1.0, 1.0, -1.0)] {
            let [a, b] = LaggedContact::new([0; 4], [0.0; 4], offset, 1.0).tangents;
            let parts = [a.norm() - 1.0, b.norm() - 1.0, a.dot(&b)];
            assert!(parts.iter().all(|p| p.abs() < 1e-15));
            assert!(a.dot(&offset).abs() + b.dot(&offset).abs() < 1e-15 * offset.norm() + 1e-20);
        }
    }
}
