//! Integrals over bodies of a function of the displacement gradient.
//!
//! J(u, X) = ∫ j(∇u) dX       S = ∂j/∂∇u
//! ∂J/∂u_a = ∫ S ∇φ_a dX
//! ∂J/∂X_k = ∫ j ∇ψ_k − ∇uᵀ S ∇ψ_k dX      at fixed nodal u
//!
//! φ   basis of the displacement;   ψ   linear basis of the rest shape
//!
//! Source of the derivative by shape: Haug, Choi and Komkov, "Design Sensitivity
//! Analysis of Structural Systems".

use std::ops::Range;

use mechanics::element::{add_at, at};
use mechanics::math::tensor::{Mat3, cofactor};
use mechanics::parallel::map_merge;
use mesh::Vec3;

use super::{Equilibrium, Partials};

/// j and S at ∇u.
pub type Integrand<'a> = &'a (dyn Fn(&Mat3) -> (f64, Mat3) + Sync);

/// J of one element, with its derivatives by its nodes and vertices.
struct Part {
    value: f64,
    by_u: Vec<Vec3>,
    by_rest: [Vec3; 4],
}

/// J over some elements.
pub fn value(equilibrium: &Equilibrium, elements: &Range<usize>, j: Integrand) -> f64 {
    let mut sum = 0.0;
    for_each_part(equilibrium, elements, j, |_, part| sum += part.value);
    sum
}

/// Adds `weight` times the partial derivatives of J.
pub fn add_partials(
    at: &Equilibrium,
    elements: &Range<usize>,
    j: Integrand,
    weight: f64,
    out: &mut Partials,
) {
    let (n, nodes) = (at.space.nodes_per_element(), at.space.element_nodes());
    for_each_part(at, elements, j, |e, part| {
        let (own, corners) = (&nodes[n * e..n * (e + 1)], at.space.tets()[e]);
        own.iter().zip(&part.by_u).for_each(|(&node, g)| add_at(out.u, node, &(weight * g)));
        let by_rest = corners.iter().zip(&part.by_rest);
        by_rest.for_each(|(&v, g)| add_at(out.rest, v, &(weight * g)));
    });
}

/// Evaluates elements in parallel and passes them to `f` in order.
fn for_each_part(
    equilibrium: &Equilibrium,
    elements: &Range<usize>,
    j: Integrand,
    mut f: impl FnMut(usize, &Part),
) {
    let first = elements.start;
    let part = |range: Range<usize>| -> Vec<Part> {
        range.map(|i| element(equilibrium, first + i, j)).collect()
    };
    map_merge(elements.len(), part, |range, parts| {
        range.zip(&parts).for_each(|(i, part)| f(first + i, part));
    });
}

fn element(equilibrium: &Equilibrium, e: usize, j: Integrand) -> Part {
    let space = equilibrium.space;
    let [a, b, c, d] = space.tets()[e].map(|v| equilibrium.rest[v]);
    let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
    let det = edges.determinant();
    let to_rest = cofactor(&edges) / det;
    // ∇ψ of the vertices: minus the sum of the others for the first
    let mut linear = [Vec3::zeros(); 4];
    for k in 0..3 {
        linear[k + 1] = to_rest.column(k).into_owned();
        linear[0] -= linear[k + 1];
    }
    let n = space.nodes_per_element();
    let nodes = &space.element_nodes()[n * e..n * (e + 1)];
    let table = space.volume_table();
    let mut part = Part { value: 0.0, by_u: vec![Vec3::zeros(); n], by_rest: [Vec3::zeros(); 4] };
    for (weight, gradients) in table.weights.iter().zip(&table.gradients) {
        let gradients: Vec<Vec3> = gradients.iter().map(|g| to_rest * Vec3::from(*g)).collect();
        let terms = nodes.iter().zip(&gradients);
        let grad_u: Mat3 = terms.map(|(&n, g)| at(equilibrium.u, n) * g.transpose()).sum();
        let (value, slope) = j(&grad_u);
        let weight = weight * det / 6.0;
        part.value += weight * value;
        for (by_u, g) in part.by_u.iter_mut().zip(&gradients) {
            *by_u += weight * (slope * g);
        }
        let turned = grad_u.transpose() * slope;
        for (by_rest, g) in part.by_rest.iter_mut().zip(&linear) {
            *by_rest += weight * (value * g - turned * g);
        }
    }
    part
}
