//! Penalty on principal stretches beyond the limits of a material.
//!
//! J(u, X) = ∫ Σ_i (λ_i − λ⁺)₊² + (λ⁻ − λ_i)₊² dX
//!
//! λ_i   principal stretches, the singular values of F = I + ∇u [1]
//! λ⁺    largest, λ⁻ smallest stretch that costs nothing [1]
//!
//! J is in m³: the volume that is strained too much, each point by the square of
//! how much. It is zero within the limits and once continuously differentiable,
//! also where stretches coincide, as the sum over all three is symmetric in them:
//! ∂J/∂F = Σ_i g′(λ_i) n_i N_iᵀ with F N_i = λ_i n_i.

use std::ops::Range;

use mechanics::math::tensor::Mat3;

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "strain-limit",
    unit: "m³",
    example: "largest = 1.05\nsmallest = 0.95",
    ..Kind::of::<Keys>(&[List::Objective, List::Probe])
};

program::table! {
    /// ∫ Σ (λ_i − largest)₊² + (smallest − λ_i)₊² dX of the principal stretches
    #[derive(Debug)]
    struct Keys {
        /// body; all if not given
        on: Option<String> = None;
        /// largest principal stretch that costs nothing [1]
        largest: f64, program::table::Range::above(1.0);
        /// smallest principal stretch that costs nothing [1]
        smallest: f64 = 0.0, program::table::Range::at_least(0.0).below(1.0);
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let (elements, Self { smallest, largest, .. }) = (site.elements(self.on.as_deref())?, self);
        Ok(Arc::new(StrainLimit { elements, smallest: *smallest, largest: *largest }))
    }
}

/// Penalty on large and small stretches.
struct StrainLimit {
    elements: Vec<Range<usize>>,
    smallest: f64,
    largest: f64,
}

impl StrainLimit {
    fn density(&self, grad_u: &Mat3) -> (f64, Mat3) {
        over_stretches(grad_u, |stretch| {
            let beyond = (stretch - self.largest).max(0.0) - (self.smallest - stretch).max(0.0);
            (beyond * beyond, 2.0 * beyond)
        })
    }
}

/// Σ g(λ_i) over the principal stretches, with its derivative by F; `of` gives g and g′.
pub(super) fn over_stretches(grad_u: &Mat3, of: impl Fn(f64) -> (f64, f64)) -> (f64, Mat3) {
    let f = Mat3::identity() + grad_u;
    let eigen = (f.transpose() * f).symmetric_eigen();
    let (mut sum, mut by_f) = (0.0, Mat3::zeros());
    for i in 0..3 {
        let stretch = eigen.eigenvalues[i].max(0.0).sqrt();
        let (value, slope) = of(stretch);
        if slope != 0.0 {
            let direction = eigen.eigenvectors.column(i);
            sum += value;
            by_f +=
                slope / stretch.max(f64::MIN_POSITIVE) * (f * direction) * direction.transpose();
        }
    }
    (sum, by_f)
}

impl Quantity for StrainLimit {
    fn value(&self, at: &Equilibrium) -> f64 {
        let one = |elements| solid_integral::value(at, elements, &|h| self.density(h));
        self.elements.iter().map(one).sum()
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        for elements in &self.elements {
            solid_integral::add_partials(at, elements, &|h| self.density(h), weight, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use mesh::Vec3;

    use super::*;

    /// Whatever the rotation, and where two stretches are the same.
    #[test]
    fn stretches_count_from_their_limits_on() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let term = StrainLimit { elements: vec![], smallest: 0.8, largest: 2.0 };
        let value = |stretches: [f64; 3]| {
            let f = q * Mat3::from_diagonal(&Vec3::from(stretches)) * q * q;
            term.density(&(f - Mat3::identity())).0
        };
        assert!(value([1.9, 0.9, 0.81]) == 0.0);
        assert!((value([2.5, 2.5, 0.5]) - (0.25 + 0.25 + 0.09)).abs() < 1e-12);
        let f = Mat3::from_diagonal_element(2.5) * q;
        let slope = term.density(&(f - Mat3::identity())).1;
        assert!((slope - 2.0 * 0.5 * q).norm() < 1e-12);
    }
}
