//! Force per rest area on a part of the boundary: a traction (Neumann condition) that is
//! a dead load.
//!
//! E(u; X) = −∫_Γ t · u dA        ∂E/∂u_a = −∫_Γ φ_a t dA      ∂²E/∂u² = 0
//! δ(λ·∂E/∂u) = −∫_Γ λ · ∇t V dA − Σ (mean of t · λ over a facet) δA
//! ∂A/∂X_i = ½ n × (X_{i+2} − X_{i+1})      n the unit normal of the facet
//! λ·∂²E/∂u∂t_k = −∫_Γ λ_k dA               for what is added to t everywhere
//!
//! t(X, t) [Pa] may depend on the rest position, but is neither turned nor
//! stretched by the deformation, unlike gas pressure, a follower load.

use std::sync::Arc;

use mesh::Vec3;

use super::{Energy, Hessian, Iterate, Nature, Owner, Slot};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::schedule::Field;

/// A force per rest area of some facets.
#[derive(Clone)]
pub struct Traction {
    /// t [Pa].
    pub traction: Field,
    /// Facets as vertices and nodes.
    facets: Vec<([usize; 3], Vec<usize>)>,
}

/// One quadrature point of one facet.
struct Point<'a> {
    facet: [usize; 3],
    nodes: &'a [usize],
    /// Basis functions.
    values: &'a [f64],
    /// Share of the facet's area.
    weight: f64,
    /// Twice the rest area vector [m²].
    normal: Vec3,
    /// Rest position [m]; zero where the traction is the same everywhere.
    place: Vec3,
    /// t [Pa].
    traction: Vec3,
}

impl Point<'_> {
    fn value_of(&self, field: &[f64]) -> Vec3 {
        self.nodes.iter().zip(self.values).map(|(&n, v)| at(field, n) * *v).sum()
    }

    /// Weight times area [m²].
    fn area(&self) -> f64 {
        0.5 * self.weight * self.normal.norm()
    }
}

impl Traction {
    /// Who owns the three components of what is added to a traction, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("traction", place)
    }

    /// The force t [Pa] on boundary facets (vertex ids).
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]], traction: Field) -> Self {
        let facets = facets.iter().map(|&f| (f, space.facet_nodes(f))).collect();
        Self { traction, facets }
    }

    fn for_each_point(&self, iterate: &Iterate, mut f: impl FnMut(&Point)) {
        let table = iterate.space.facet_table();
        let varies = self.traction.uses_position();
        let uniform = self.traction.at(Vec3::zeros(), iterate.time);
        let positions = iterate.space.node_positions(iterate.rest);
        for (facet, nodes) in &self.facets {
            let [a, b, c] = facet.map(|v| iterate.rest[v]);
            let normal = (b - a).cross(&(c - a));
            for (values, &weight) in table.values.iter().zip(&table.weights) {
                let (mut place, mut traction) = (Vec3::zeros(), uniform);
                if varies {
                    place = nodes.iter().zip(values).map(|(&n, v)| positions[n] * *v).sum();
                    traction = self.traction.at(place, iterate.time);
                }
                f(&Point { facet: *facet, nodes, values, weight, normal, place, traction });
            }
        }
    }
}

impl Energy for Traction {
    fn kind(&self) -> (&'static str, Nature) {
        ("traction", Nature::DeadLoad)
    }

    fn held(&self, time: f64) -> Option<Arc<dyn Energy>> {
        Some(Arc::new(Self { traction: self.traction.held_at(time), ..self.clone() }))
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        let mut work = 0.0;
        self.for_each_point(iterate, |p| work += p.area() * p.traction.dot(&p.value_of(iterate.u)));
        -work
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        self.for_each_point(iterate, |p| {
            let force = -p.area() * p.traction;
            for (&node, v) in p.nodes.iter().zip(p.values) {
                add_at(out, node, &(force * *v));
            }
        });
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let varies = self.traction.uses_position();
        let mut nodal = vec![0.0; iterate.u.len()];
        self.for_each_point(iterate, |p| {
            let lambda = p.value_of(lambda);
            let x = p.facet.map(|v| iterate.rest[v]);
            let unit = p.normal.normalize();
            let density = -p.weight * p.traction.dot(&lambda);
            for i in 0..3 {
                let by = 0.5 * unit.cross(&(x[(i + 2) % 3] - x[(i + 1) % 3]));
                add_at(out, p.facet[i], &(density * by));
            }
            if varies {
                let by_place = self.traction.gradient(p.place, iterate.time).transpose() * lambda;
                for (&node, v) in p.nodes.iter().zip(p.values) {
                    add_at(&mut nodal, node, &(-p.area() * *v * by_place));
                }
            }
        });
        iterate.space.add_to_vertices(&nodal, out);
    }

    fn slots(&self) -> Vec<Slot> {
        Slot::components("traction", "Pa").to_vec()
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let mut added = Vec3::zeros();
        self.for_each_point(iterate, |p| added -= p.area() * p.value_of(lambda));
        // as the rest of the traction, it is ramped up in the first step
        let by = |axis: usize| (1.0 - self.traction.0[axis].to_come(iterate.time)) * added[axis];
        (0..3).map(by).collect()
    }
}
