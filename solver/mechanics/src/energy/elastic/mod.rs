//! Elastic energy of the body.
//!
//! E(u; X) = ∫ ψ(F) dX        F = I + ∇u
//! ∂E/∂u_a = ∫ P ∇φ_a dX      ∂²E/∂u_a∂u_b = ∫ ∇φ_a · A · ∇φ_b dX
//!
//! Shape derivative along a velocity field V with nodal u fixed:
//! δ(λ·∂E/∂u) = ∫ −[A : (∇u ∇V)] : ∇λ − P : (∇λ ∇V) + (div V) P : ∇λ dX
//!
//! Its parameters are those of the law. Where the volume of an element shall change as a whole: [`mean`].
//!
//! Source: Bonet and Wood, "Nonlinear Continuum Mechanics for Finite Element
//! Analysis"; shape derivative: Haug, Choi and Komkov, "Design Sensitivity
//! Analysis of Structural Systems".

mod batch;
mod mean;
mod moments;

use std::ops::Range;
use std::sync::Arc;

use mesh::Vec3;

use super::quadrature_points::points;
use super::{Iterate, Owner};
use crate::element::FunctionSpace;
use crate::material::{Material, Split};
use crate::math::tensor::{Mat3, cofactor_change, vec9};

pub use mean::ElementLaw;
use mean::MEANS;

/// Elastic energy of elements with one law.
#[derive(Clone)]
pub struct Elastic {
    /// The law.
    pub material: Arc<dyn Material>,
    /// The elements; none means all.
    elements: Option<Range<usize>>,
    /// The law in two parts, where the volume of an element changes as a whole.
    mean: Option<Split>,
}

impl Elastic {
    /// Who owns the parameters of the law of a body, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("material", place)
    }

    /// All elements have one law.
    pub fn whole(material: Box<dyn Material>) -> Self {
        Self { material: material.into(), elements: None, mean: None }
    }

    /// The law of consecutive elements.
    pub fn part(material: Box<dyn Material>, elements: Range<usize>) -> Self {
        Self { material: material.into(), elements: Some(elements), mean: None }
    }

    /// The elements that have this law.
    pub fn elements(&self, space: &FunctionSpace) -> Range<usize> {
        self.elements.clone().unwrap_or(0..space.tets().len())
    }

    /// This energy with mean dilatation; none where the law has no term of the change of volume
    /// alone.
    pub fn with_mean_dilatation(self) -> Option<Self> {
        let split = self.material.split()?;
        Some(Self { mean: Some(split), ..self })
    }

    /// The law at the points of an element in a state.
    pub fn law_in<'a>(&'a self, at: &Iterate<'a>, element: usize) -> ElementLaw<'a> {
        let (law, split) = self.parts(at.space);
        ElementLaw::new(law, split, at, element)
    }

    /// What is evaluated at each point; and both parts of the law where what is evaluated of each
    /// element matters, which it does not where strain is constant in elements.
    fn parts(&self, space: &FunctionSpace) -> (&dyn Material, Option<&Split>) {
        let split = self.mean.as_ref().filter(|_| space.degree() > 1);
        (split.map_or(&*self.material, |split| &*split.pointwise), split)
    }

    fn element_mixed(&self, iterate: &Iterate, lambda: &[f64], e: usize) -> [Vec3; 4] {
        let (element, own) = points(iterate, e, false);
        let corner = element.corner_gradients();
        let ElementLaw { law, dilatation } = self.law_in(iterate, e);
        // of the mean dilatations: by λ, and by ∇V
        let (mut along, mut by_rest) = ([0.0; MEANS], [Mat3::zeros(); MEANS]);
        let mut local = [Vec3::zeros(); 4];
        for point in own {
            let (q, k, grad_l) = (point.place, &point.k, point.gradient(&element, lambda));
            let mut stress = law.first_piola(k);
            let pushed = law.tangent(k) * vec9(&grad_l);
            let mut pushed = Mat3::from_column_slice(pushed.as_slice());
            if let Some(mean) = &dilatation {
                stress += mean.pressure(q) * k.cofactor;
                pushed += mean.pressure(q) * cofactor_change(&k.f, &grad_l);
                for c in 0..mean.count() {
                    let weight = point.share * mean.weight(c, q);
                    along[c] += weight * k.cofactor.dot(&grad_l);
                    by_rest[c] -= weight * k.grad_u.transpose() * k.cofactor;
                }
            }
            // V = ψ_j e_k has ∇V = e_k ⊗ ∇ψ_j, so M : ∇V = (M ∇ψ_j)_k
            let m = point.by_rest(&stress, &pushed, &grad_l);
            local.iter_mut().zip(&corner).for_each(|(o, c)| *o += point.weight * (m * c));
        }
        if let Some(mean) = &dilatation {
            for c in 0..mean.count() {
                let by = mean.stiffness(c) * along[c] * element.volume;
                local.iter_mut().zip(&corner).for_each(|(o, g)| *o += by * (by_rest[c] * g));
            }
        }
        local
    }

    fn element_parameters(
        &self,
        iterate: &Iterate,
        lambda: &[f64],
        elements: Range<usize>,
    ) -> Vec<f64> {
        let mut sum = vec![0.0; self.material.parameter_count()];
        for e in elements {
            let (element, own) = points(iterate, e, false);
            let ElementLaw { law, dilatation } = self.law_in(iterate, e);
            let mut along = [0.0; MEANS];
            for point in own {
                let bar = point.gradient(&element, lambda) * point.weight;
                law.add_parameter_vjp(&point.k, &bar, &mut sum);
                if let Some(mean) = &dilatation {
                    let by = point.k.cofactor.dot(&bar);
                    (0..mean.count()).for_each(|c| along[c] += mean.weight(c, point.place) * by);
                }
            }
            if let Some(mean) = dilatation {
                mean.add_parameter_vjp(&along, &mut sum);
            }
        }
        sum
    }
}

#[cfg(test)]
pub(super) mod tests;
