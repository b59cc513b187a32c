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
use std::path::Path;

use anyhow::{Result, ensure};
use mechanics::math::tensor::Mat3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{BODY, Builder, Kind, Specification, form};
use super::{Equilibrium, Objective, solid_integral};

pub(super) const KIND: Kind = Kind {
    key: "strain-limit",
    formula: "∫ Σ (λ_i − largest)₊² + (smallest − λ_i)₊² dX of the principal stretches",
    unit: "m³",
    keys: &[BODY, ("largest", "[1]"), ("smallest", "[1] (0)")],
    may_be_maximised: false,
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: Option<String>,
    largest: f64,
    #[serde(default)]
    smallest: f64,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        let Self { largest, smallest, .. } = self;
        ensure!(
            (0.0..1.0).contains(smallest) && largest.is_finite() && *largest > 1.0,
            "largest = {largest}, smallest = {smallest}: stretches, the largest must be above 1 \
             and the smallest from 0 to 1"
        );
        Ok(())
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let Self { on, largest, smallest } = self.clone();
        Ok(Box::new(move |name, bodies| {
            let parts = bodies.parts(on.as_deref())?.into_iter();
            let elements = parts.map(|(_, elements)| elements).collect();
            Ok(Box::new(StrainLimit::new(name, elements, [smallest, largest])))
        }))
    }
}

/// Penalty on large and small stretches.
pub struct StrainLimit {
    name: String,
    elements: Vec<Range<usize>>,
    smallest: f64,
    largest: f64,
}

impl StrainLimit {
    /// The penalty in some elements, beyond a `smallest` and a `largest` stretch.
    #[must_use]
    pub fn new(name: &str, elements: Vec<Range<usize>>, [smallest, largest]: [f64; 2]) -> Self {
        Self { name: name.to_owned(), elements, smallest, largest }
    }

    fn density(&self, grad_u: &Mat3) -> (f64, Mat3) {
        let f = Mat3::identity() + grad_u;
        let eigen = (f.transpose() * f).symmetric_eigen();
        let (mut value, mut by_f) = (0.0, Mat3::zeros());
        for i in 0..3 {
            let stretch = eigen.eigenvalues[i].max(0.0).sqrt();
            let beyond = (stretch - self.largest).max(0.0) - (self.smallest - stretch).max(0.0);
            if beyond != 0.0 {
                let direction = eigen.eigenvectors.column(i);
                let slope = 2.0 * beyond / stretch.max(f64::MIN_POSITIVE);
                value += beyond * beyond;
                by_f += slope * (f * direction) * direction.transpose();
            }
        }
        (value, by_f)
    }
}

impl Objective for StrainLimit {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        let one = |elements| solid_integral::value(at, elements, &|h| self.density(h));
        self.elements.iter().map(one).sum()
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        for elements in &self.elements {
            solid_integral::add_du(at, elements, &|h| self.density(h), weight, out);
        }
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        for elements in &self.elements {
            solid_integral::add_drest(at, elements, &|h| self.density(h), weight, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use mesh::Vec3;

    use super::*;
    use crate::objective::tests::Case;

    #[test]
    fn derivatives_belong_to_the_value() {
        for (degree, scale) in [(1, 1.0), (2, 1e-3), (3, 1.0)] {
            let case = Case::cube(degree, scale);
            for limits in [[0.9, 1.1], [0.0, 1.02], [0.98, 1e3]] {
                let term = StrainLimit::new("s", vec![0..20, 20..48], limits);
                // where a stretch passes its limit, curvature jumps
                case.check_near(&term, 1e-5);
            }
        }
    }

    /// Whatever the rotation, and where two stretches are the same.
    #[test]
    fn stretches_count_from_their_limits_on() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let term = StrainLimit::new("s", vec![], [0.8, 2.0]);
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
