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
pub(super) mod elements;
mod mean;

use std::ops::Range;
use std::sync::Arc;

use mesh::Vec3;

use super::{Energy, Hessian, Iterate};
use crate::element::{FunctionSpace, add_at, at};
use crate::material::{Kinematics, Material, Split};
use crate::math::lanes::widest;
use crate::math::pool::Pool;
use crate::math::sparse::{BlockMatrix, pair_count};
use crate::math::tensor::{Mat3, cofactor_change, vec9};
use crate::parallel::{fill, map_merge, map_merge_waves};
use batch::{Gradients, Hessians, Values};

pub use mean::ElementLaw;

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

/// Geometry of one straight-sided element.
pub(super) struct Element<'a> {
    pub(super) nodes: &'a [usize],
    /// G⁻ᵀ: maps reference gradients to rest gradients [1/m].
    pub(super) to_rest: Mat3,
    /// Rest volume [m³].
    pub(super) volume: f64,
}

impl<'a> Element<'a> {
    #[inline(always)]
    pub(super) fn new(space: &'a FunctionSpace, rest: &[Vec3], e: usize) -> Self {
        let [a, b, c, d] = space.tets()[e].map(|v| rest[v]);
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let det = g.determinant();
        // cof G / det G = G⁻ᵀ; a flat element gives infinities, which the
        // caller sees as an infinite energy
        let to_rest = crate::math::tensor::cofactor(&g) / det;
        let n = space.nodes_per_element();
        let nodes = &space.element_nodes()[e * n..(e + 1) * n];
        Self { nodes, to_rest, volume: det / 6.0 }
    }

    /// Rest gradients ∇φ_a of all nodes at quadrature point q.
    #[inline(always)]
    fn gradients<const N: usize>(&self, space: &FunctionSpace, q: usize) -> [Vec3; N] {
        let table = &space.volume_table().gradients[q];
        std::array::from_fn(|a| self.to_rest * Vec3::from(table[a]))
    }
}

/// ∇w = Σ w_a ⊗ ∇φ_a for a nodal field.
#[inline(always)]
fn field_gradient<const N: usize>(values: &[Vec3; N], gradients: &[Vec3; N]) -> Mat3 {
    let mut result = Mat3::zeros();
    for (w, g) in values.iter().zip(gradients) {
        result += w * g.transpose();
    }
    result
}

impl Elastic {
    /// All elements have one law.
    #[must_use]
    pub fn whole(material: Box<dyn Material>) -> Self {
        Self { material: material.into(), elements: None, mean: None }
    }

    /// The law of consecutive elements.
    #[must_use]
    pub fn part(material: Box<dyn Material>, elements: Range<usize>) -> Self {
        Self { material: material.into(), elements: Some(elements), mean: None }
    }

    /// The elements that have this law.
    #[must_use]
    pub fn elements(&self, space: &FunctionSpace) -> Range<usize> {
        self.elements.clone().unwrap_or(0..space.tets().len())
    }

    /// This energy with mean dilatation; none where the law has no term of the change of volume
    /// alone.
    #[must_use]
    pub fn with_mean_dilatation(self) -> Option<Self> {
        let split = self.material.split()?;
        Some(Self { mean: Some(split), ..self })
    }

    /// The law at the points of an element in a state.
    #[must_use]
    pub fn law_in(&self, at: &Iterate, element: usize) -> ElementLaw<'_> {
        let (law, split) = self.parts(at.space);
        ElementLaw::new(law, split, at, element)
    }

    /// What is evaluated at each point; and both parts of the law where what is evaluated of each
    /// element matters, which it does not where strain is constant in elements.
    fn parts(&self, space: &FunctionSpace) -> (&dyn Material, Option<&Split>) {
        let split = self.mean.as_ref().filter(|_| space.degree() > 1);
        (split.map_or(&*self.material, |split| &*split.pointwise), split)
    }

    fn element_mixed<const N: usize>(
        &self,
        iterate: &Iterate,
        lambda: &[f64],
        elements: Range<usize>,
    ) -> Vec<[Vec3; 4]> {
        let one = |e| {
            let element = Element::new(iterate.space, iterate.rest, e);
            let u: [Vec3; N] = std::array::from_fn(|a| at(iterate.u, element.nodes[a]));
            let l: [Vec3; N] = std::array::from_fn(|a| at(lambda, element.nodes[a]));
            let corner = corner_gradients(&element);
            let ElementLaw { law, dilatation } = self.law_in(iterate, e);
            // of the mean dilatation: by λ, and by ∇V
            let (mut along, mut by_rest) = (0.0, Mat3::zeros());
            let mut local = [Vec3::zeros(); 4];
            for (q, weight) in iterate.space.volume_table().weights.iter().enumerate() {
                let g: [Vec3; N] = element.gradients(iterate.space, q);
                let (grad_u, grad_l) = (field_gradient(&u, &g), field_gradient(&l, &g));
                let k = Kinematics::new(&grad_u);
                let mut stress = law.first_piola(&k);
                let pushed = law.tangent(&k) * vec9(&grad_l);
                let mut pushed = Mat3::from_column_slice(pushed.as_slice());
                if let Some(mean) = &dilatation {
                    stress += mean.pressure() * k.cofactor;
                    pushed += mean.pressure() * cofactor_change(&k.f, &grad_l);
                    along += weight * k.cofactor.dot(&grad_l);
                    by_rest -= *weight * grad_u.transpose() * k.cofactor;
                }
                // V = ψ_j e_k has ∇V = e_k ⊗ ∇ψ_j, so M : ∇V = (M ∇ψ_j)_k
                let m = Mat3::identity() * stress.dot(&grad_l)
                    - grad_u.transpose() * pushed
                    - grad_l.transpose() * stress;
                for (o, c) in local.iter_mut().zip(&corner) {
                    *o += (weight * element.volume) * (m * c);
                }
            }
            if let Some(mean) = &dilatation {
                let by = mean.stiffness() * along * element.volume;
                local.iter_mut().zip(&corner).for_each(|(o, c)| *o += by * (by_rest * c));
            }
            local
        };
        elements.map(one).collect()
    }

    fn element_parameters<const N: usize>(
        &self,
        iterate: &Iterate,
        lambda: &[f64],
        elements: Range<usize>,
    ) -> Vec<f64> {
        let mut sum = vec![0.0; self.material.parameter_count()];
        for e in elements {
            let element = Element::new(iterate.space, iterate.rest, e);
            let u: [Vec3; N] = std::array::from_fn(|a| at(iterate.u, element.nodes[a]));
            let l: [Vec3; N] = std::array::from_fn(|a| at(lambda, element.nodes[a]));
            let ElementLaw { law, dilatation } = self.law_in(iterate, e);
            let mut along = 0.0;
            for (q, weight) in iterate.space.volume_table().weights.iter().enumerate() {
                let g: [Vec3; N] = element.gradients(iterate.space, q);
                let bar = field_gradient(&l, &g) * (weight * element.volume);
                let k = Kinematics::new(&field_gradient(&u, &g));
                law.add_parameter_vjp(&k, &bar, &mut sum);
                along += k.cofactor.dot(&bar);
            }
            if let Some(mean) = dilatation {
                mean.add_parameter_vjp(along, &mut sum);
            }
        }
        sum
    }
}

fn shifted(range: &Range<usize>, by: usize) -> Range<usize> {
    range.start + by..range.end + by
}

/// Rest gradients of the four barycentric coordinates.
pub(super) fn corner_gradients(element: &Element) -> [Vec3; 4] {
    let c = |k: usize| element.to_rest.column(k).into_owned();
    [-(c(0) + c(1) + c(2)), c(0), c(1), c(2)]
}

impl Elastic {
    fn total<const N: usize>(&self, iterate: &Iterate) -> f64 {
        let mut sum = 0.0;
        let own = self.elements(iterate.space);
        map_merge(
            own.len(),
            |r| {
                let elements = shifted(&r, own.start);
                widest(Values::<N> { elastic: self, iterate, elements })
            },
            |_, part| sum += part,
        );
        sum
    }

    fn merge_gradients<const N: usize>(&self, iterate: &Iterate, out: &mut [f64]) {
        let own = self.elements(iterate.space);
        let forces = fill(own.len(), N, Vec3::zeros(), |r, out| {
            let elements = shifted(&r, own.start);
            widest(Gradients::<N> { elastic: self, iterate, elements, out });
        });
        iterate.space.incidence().add(N * own.start..N * own.end, &forces, out);
    }

    fn merge_hessians<const N: usize>(
        &self,
        iterate: &Iterate,
        kind: Hessian,
        out: &mut BlockMatrix,
    ) {
        let own = self.elements(iterate.space);
        let memory = Pool::default();
        map_merge_waves(
            own.len(),
            |r| {
                let elements = shifted(&r, own.start);
                let mut blocks = memory.overwritable(pair_count(N) * elements.len(), [0.0; 9]);
                let out = &mut blocks;
                widest(Hessians::<N> { elastic: self, iterate, kind, elements, blocks: out });
                blocks
            },
            |r, parts| {
                let blocks: Vec<&[[f64; 9]]> = parts.iter().map(|part| &part[..]).collect();
                out.add_elements(shifted(&r, own.start), &blocks);
                parts.into_iter().for_each(|part| memory.give(part));
            },
        );
    }

    fn merge_mixed<const N: usize>(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let own = self.elements(iterate.space);
        map_merge(
            own.len(),
            |r| self.element_mixed::<N>(iterate, lambda, shifted(&r, own.start)),
            |r, parts| {
                for (e, part) in shifted(&r, own.start).zip(parts) {
                    for (v, p) in iterate.space.tets()[e].iter().zip(part) {
                        add_at(out, *v, &p);
                    }
                }
            },
        );
    }
}

impl Elastic {
    fn merge_parameters<const N: usize>(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let own = self.elements(iterate.space);
        let mut sum = vec![0.0; self.material.parameter_count()];
        map_merge(
            own.len(),
            |r| self.element_parameters::<N>(iterate, lambda, shifted(&r, own.start)),
            |_, part| sum.iter_mut().zip(part).for_each(|(s, p)| *s += p),
        );
        sum
    }
}

/// Calls a method with the number of nodes per element as a constant, so that
/// its loops have fixed lengths.
macro_rules! with_nodes {
    ($space:expr, $this:ident.$method:ident($($argument:expr),*)) => {
        match $space.nodes_per_element() {
            4 => $this.$method::<4>($($argument),*),
            10 => $this.$method::<10>($($argument),*),
            _ => $this.$method::<20>($($argument),*),
        }
    };
}
pub(super) use with_nodes;

impl Energy for Elastic {
    fn name(&self) -> &'static str {
        "elastic"
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        with_nodes!(iterate.space, self.total(iterate))
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        with_nodes!(iterate.space, self.merge_gradients(iterate, out));
    }

    fn add_hessian(&self, iterate: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        with_nodes!(iterate.space, self.merge_hessians(iterate, kind, out));
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        with_nodes!(iterate.space, self.merge_mixed(iterate, lambda, out));
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        with_nodes!(iterate.space, self.merge_parameters(iterate, lambda))
    }
}

#[cfg(test)]
mod tests;
