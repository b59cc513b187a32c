//! Force per rest volume (a body force, a dead load), such as gravity.
//!
//! E(u; X) = −∫ f · u dX           ∂E/∂u_a = −∫ φ_a f dX      ∂²E/∂u² = 0
//! δ(λ·∂E/∂u) = −∫ (f · λ) div V + λ · ∇f V dX for a velocity field V of the
//! rest shape
//!
//! f(X, t) [N/m³] may depend on the rest position. The parameters are a factor of f, for gravity
//! the density, and the components of what is added to f over that factor everywhere.

use std::ops::Range;
use std::sync::Arc;

use mesh::Vec3;
use mesh::measure::{tet_volume, tet_volume_gradient};

use super::{Energy, Hessian, Iterate, Nature, Owner, Slot};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::linear::dot;
use crate::math::sparse::BlockMatrix;
use crate::parallel::{fill, map_merge};
use crate::schedule::Field;

/// A force per rest volume.
#[derive(Clone)]
pub struct BodyForce {
    /// f over `factor`, [N/m³] unless it is gravity.
    force: Field,
    /// 1, or for gravity the density [kg/m³].
    factor: f64,
    /// The elements; none means all.
    elements: Option<Range<usize>>,
}

/// One quadrature point of one element.
struct Point<'a> {
    element: usize,
    tet: [usize; 4],
    nodes: &'a [usize],
    /// Basis functions.
    values: &'a [f64],
    /// Share of the element's volume.
    weight: f64,
    /// Rest volume of the element [m³].
    volume: f64,
    /// Rest position [m]; zero where the force is the same everywhere.
    place: Vec3,
    /// f [N/m³].
    force: Vec3,
}

impl Point<'_> {
    fn value_of(&self, field: &[f64]) -> Vec3 {
        self.nodes.iter().zip(self.values).map(|(&n, v)| at(field, n) * *v).sum()
    }
}

impl BodyForce {
    /// Who owns the density of a body in its weight, then the components of what is added to gravity; by its place among
    /// all.
    pub const fn weight_owner(place: usize) -> Owner {
        Owner::new("weight", place)
    }

    /// A force per volume on all elements [N/m³].
    pub fn whole(force: Field) -> Self {
        Self { force, factor: 1.0, elements: None }
    }

    /// The weight of consecutive elements, of a density [kg/m³] in a field of
    /// gravity [m/s²].
    pub fn weight(gravity: Field, density: f64, elements: Range<usize>) -> Self {
        Self { force: gravity, factor: density, elements: Some(elements) }
    }

    fn elements(&self, space: &FunctionSpace) -> Range<usize> {
        self.elements.clone().unwrap_or(0..space.tets().len())
    }

    /// Calls `f` with each point of some elements. Of a force that is the same everywhere,
    /// one point stands for all of an element, with the mean values of its basis.
    fn for_each_point(&self, iterate: &Iterate, elements: Range<usize>, mut f: impl FnMut(&Point)) {
        let (space, table) = (iterate.space, iterate.space.volume_table());
        let varies = self.force.uses_position();
        let uniform = self.factor * self.force.at(Vec3::zeros(), iterate.time);
        let mean = |a: usize| table.values.iter().zip(&table.weights).map(|(v, w)| v[a] * w).sum();
        let means: [Vec<f64>; 1] = [(0..space.nodes_per_element()).map(mean).collect()];
        let (values, weights): (&[Vec<f64>], &[f64]) =
            if varies { (&table.values, &table.weights) } else { (&means, &[1.0]) };
        let nodes = space.element_nodes().chunks_exact(space.nodes_per_element());
        let all = space.tets().iter().zip(nodes);
        for (element, (&tet, nodes)) in all.enumerate().skip(elements.start).take(elements.len()) {
            let [a, b, c, d] = tet.map(|v| iterate.rest[v]);
            let volume = tet_volume(a, b, c, d);
            for (values, &weight) in values.iter().zip(weights) {
                let (mut place, mut force) = (Vec3::zeros(), uniform);
                if varies {
                    let position = |n: usize| space.node_position(iterate.rest, n);
                    place = nodes.iter().zip(values).map(|(&n, v)| position(n) * *v).sum();
                    force = self.factor * self.force.at(place, iterate.time);
                }
                f(&Point { element, tet, nodes, values, weight, volume, place, force });
            }
        }
    }
}

impl Energy for BodyForce {
    fn kind(&self) -> (&'static str, Nature) {
        ("body_force", Nature::DeadLoad)
    }

    fn held(&self, time: f64) -> Option<Arc<dyn Energy>> {
        Some(Arc::new(Self { force: self.force.held_at(time), ..self.clone() }))
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        let own = self.elements(iterate.space);
        let work_on = |range: Range<usize>| {
            let mut work = 0.0;
            self.for_each_point(iterate, own.start + range.start..own.start + range.end, |p| {
                work += p.weight * p.volume * p.force.dot(&p.value_of(iterate.u));
            });
            work
        };
        let mut work = 0.0;
        map_merge(own.len(), work_on, |_, part| work += part);
        -work
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        let (own, n) = (self.elements(iterate.space), iterate.space.nodes_per_element());
        let forces = fill(own.len(), n, Vec3::zeros(), |range, forces| {
            let first = own.start + range.start;
            let last = first + range.len();
            self.for_each_point(iterate, first..last, |p| {
                let force = -p.weight * p.volume * p.force;
                let own = &mut forces[n * (p.element - first)..][..n];
                own.iter_mut().zip(p.values).for_each(|(f, v)| *f += force * *v);
            });
        });
        iterate.space.incidence().add(n * own.start..n * own.end, &forces, out);
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let varies = self.force.uses_position();
        let mut nodal = vec![0.0; iterate.u.len()];
        self.for_each_point(iterate, self.elements(iterate.space), |p| {
            let lambda = p.value_of(lambda);
            let density = -p.weight * p.force.dot(&lambda);
            let [a, b, c, d] = p.tet.map(|v| iterate.rest[v]);
            for (&vertex, by) in p.tet.iter().zip(tet_volume_gradient(a, b, c, d)) {
                add_at(out, vertex, &(density * by));
            }
            if varies {
                let by_place =
                    self.factor * self.force.gradient(p.place, iterate.time).transpose() * lambda;
                for (&node, v) in p.nodes.iter().zip(p.values) {
                    add_at(&mut nodal, node, &(-p.weight * p.volume * *v * by_place));
                }
            }
        });
        iterate.space.add_to_vertices(&nodal, out);
    }

    fn slots(&self) -> Vec<Slot> {
        let added = Slot::components("gravity", "m/s²");
        [Slot::new("density", "kg/m³")].into_iter().chain(added).collect()
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; iterate.u.len()];
        self.add_gradient(iterate, &mut gradient);
        let by_factor = dot(&gradient, lambda) / self.factor;
        // a force that is added everywhere: −∫ λ dX, times the factor
        let mut added = Vec3::zeros();
        self.for_each_point(iterate, self.elements(iterate.space), |p| {
            added -= self.factor * p.weight * p.volume * p.value_of(lambda);
        });
        // as the rest of the force, it is ramped up in the first step
        let full = |axis: usize| 1.0 - self.force.0[axis].to_come(iterate.time);
        vec![by_factor, full(0) * added.x, full(1) * added.y, full(2) * added.z]
    }
}
