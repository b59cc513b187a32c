//! Inertia in one step in time, from the incremental potential.
//!
//! E(u; X) = 1/(2 s) (u − ũ)ᵀ M (u − ũ)     M_ab = ∫ ρ φ_a φ_b dX
//! ∂E/∂u   = M (u − ũ) / s                  ∂²E/∂u² = M / s
//! δ(λ·∂E/∂u) = Σ_T (ρ/s) (λᵀ m (u − ũ))_T δ|T|
//!
//! ρ   density [kg/m³]
//! ũ   where it would go without forces [m], s what it goes per acceleration [s²]: [`FreeFlight`](super::FreeFlight)
//! m   mass matrix of a tetrahedron with volume and density 1 [1]
//!
//! Where inertia is neglected, bodies without enough supports are regularised by a tiny
//! mass:
//!
//! E(u; X) = c/2 (u − u₋₁)ᵀ M (u − u₋₁)       c = [`REGULARIZATION`]
//!
//! u₋₁ is the last state; what moves by 1 cm is held with a thousandth of its
//! weight. M is consistent, not lumped: row sums of quadratic tetrahedra are negative at
//! the vertices. Without a step, or where inertia is neglected, E is zero. The one
//! parameter is ρ.
//!
//! Source: Hairer and Wanner, "Solving Ordinary Differential Equations II", V.1.

use std::ops::Range;

use mesh::Vec3;
use mesh::measure::{tet_volume, tet_volume_gradient};

use super::{Energy, Hessian, Iterate, Nature, Owner, PastCotangent, Slot};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::linear::dot;
use crate::math::sparse::{BlockMatrix, pair_count, pair_index};
use crate::parallel::{fill, map_merge, map_merge_waves};

/// Stiffness per mass of the regularisation [1/s²].
const REGULARIZATION: f64 = 1.0;

/// Nodes of an element, at most.
const MOST_NODES: usize = 20;

/// Inertia of elements with one density.
#[derive(Clone)]
pub struct Inertia {
    density: f64,
    /// Whether it is the tiny mass of a body without enough supports.
    tiny: bool,
    elements: Range<usize>,
    /// m, row by row.
    reference: Vec<f64>,
}

/// 1/s [1/s²] and u − ũ [m].
type Deviation = (f64, Vec<f64>);

impl Inertia {
    /// Who owns the density of a body in its inertia, or in its tiny mass, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("density", place)
    }

    /// Inertia of consecutive elements with a density [kg/m³].
    pub fn new(space: &FunctionSpace, density: f64, elements: Range<usize>) -> Self {
        Self { density, tiny: false, elements, reference: space.reference_mass() }
    }

    /// The tiny mass of a body without enough supports where inertia is neglected.
    pub fn tiny(space: &FunctionSpace, density: f64, elements: Range<usize>) -> Self {
        Self { tiny: true, ..Self::new(space, density, elements) }
    }

    /// Whether it is the tiny mass of a body without enough supports.
    pub fn is_tiny(&self) -> bool {
        self.tiny
    }

    /// 1/s and ũ.
    fn frame<'a>(&self, iterate: &Iterate<'a>) -> Option<(f64, &'a [f64])> {
        let step = iterate.step?;
        if self.tiny {
            return Some((REGULARIZATION, &step.history));
        }
        let flight = step.free_flight.as_ref()?;
        Some((1.0 / flight.square, &flight.at))
    }

    fn deviation(&self, iterate: &Iterate) -> Option<Deviation> {
        let (rate, from) = self.frame(iterate)?;
        Some((rate, iterate.u.iter().zip(from).map(|(u, f)| u - f).collect()))
    }

    /// Mass of an element [kg] and its nodes.
    fn element<'a>(&self, iterate: &Iterate<'a>, e: usize) -> (f64, &'a [usize]) {
        let [a, b, c, d] = iterate.space.tets()[e].map(|v| iterate.rest[v]);
        let n = iterate.space.nodes_per_element();
        let nodes = &iterate.space.element_nodes()[n * e..n * (e + 1)];
        (self.density * tet_volume(a, b, c, d), nodes)
    }

    /// Σ_b m_ab w_b for all nodes a of an element.
    fn times_reference(&self, w: &[f64], nodes: &[usize]) -> impl Iterator<Item = Vec3> {
        let mut values = [Vec3::zeros(); MOST_NODES];
        nodes.iter().zip(&mut values).for_each(|(&b, value)| *value = at(w, b));
        let row = move |m: &[f64]| m.iter().zip(&values).map(|(m, w)| *m * w).sum();
        self.reference.chunks_exact(nodes.len()).map(row)
    }

    fn each<T: Send>(&self, one: impl Fn(usize) -> T + Sync, mut merge: impl FnMut(usize, T)) {
        let first = self.elements.start;
        map_merge(
            self.elements.len(),
            |r| r.map(|e| one(first + e)).collect::<Vec<T>>(),
            |r, parts| r.zip(parts).for_each(|(e, part)| merge(first + e, part)),
        );
    }

    /// ½ vᵀ M v of a velocity [J].
    pub fn kinetic_energy(&self, space: &FunctionSpace, rest: &[Vec3], velocity: &[f64]) -> f64 {
        let iterate = Iterate::new(space, rest, velocity, 0.0);
        self.half_square(&iterate, velocity)
    }

    /// ∫ ρ w dX of a nodal field w: momentum, if it is a velocity.
    pub fn momentum(&self, space: &FunctionSpace, rest: &[Vec3], w: &[f64]) -> Vec3 {
        let iterate = Iterate::new(space, rest, w, 0.0);
        let mut total = Vec3::zeros();
        self.each(
            |e| {
                let (mass, nodes) = self.element(&iterate, e);
                mass * self.times_reference(w, nodes).sum::<Vec3>()
            },
            |_, part| total += part,
        );
        total
    }

    fn half_square(&self, iterate: &Iterate, w: &[f64]) -> f64 {
        let mut total = 0.0;
        self.each(
            |e| {
                let (mass, nodes) = self.element(iterate, e);
                let mw = self.times_reference(w, nodes);
                0.5 * mass * mw.zip(nodes).map(|(m, &a)| m.dot(&at(w, a))).sum::<f64>()
            },
            |_, part| total += part,
        );
        total
    }
}

impl Inertia {
    /// Adds `factor` M w, three components per node.
    fn add_mass_times(&self, iterate: &Iterate, w: &[f64], factor: f64, out: &mut [f64]) {
        let (first, n) = (self.elements.start, iterate.space.nodes_per_element());
        let forces = fill(self.elements.len(), n, Vec3::zeros(), |range, forces| {
            for (e, forces) in range.zip(forces.chunks_exact_mut(n)) {
                let (mass, nodes) = self.element(iterate, first + e);
                let products = self.times_reference(w, nodes);
                forces.iter_mut().zip(products).for_each(|(f, mw)| *f = factor * mass * mw);
            }
        });
        let places = n * first..n * self.elements.end;
        iterate.space.incidence().add(places, &forces, out);
    }
}

impl Energy for Inertia {
    fn kind(&self) -> (&'static str, Nature) {
        (if self.tiny { "tiny_mass" } else { "inertia" }, Nature::Inertia)
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        self.deviation(iterate).map_or(0.0, |(rate, d)| rate * self.half_square(iterate, &d))
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        let Some((rate, deviation)) = self.deviation(iterate) else { return };
        self.add_mass_times(iterate, &deviation, rate, out);
    }

    fn add_hessian(&self, iterate: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let Some((rate, _)) = self.frame(iterate) else { return };
        let (first, n) = (self.elements.start, iterate.space.nodes_per_element());
        let factors = |range: Range<usize>| -> Vec<f64> {
            let mut factors = Vec::with_capacity(pair_count(n) * range.len());
            for e in range {
                let factor = rate * self.element(iterate, first + e).0;
                for a in 0..n {
                    for b in 0..=a {
                        debug_assert_eq!(factors.len() % pair_count(n), pair_index(a, b));
                        factors.push(factor * self.reference[n * a + b]);
                    }
                }
            }
            factors
        };
        map_merge_waves(self.elements.len(), factors, |r, parts| {
            let parts: Vec<&[f64]> = parts.iter().map(|part| &part[..]).collect();
            out.add_multiples_of_identity(first + r.start..first + r.end, &parts);
        });
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let Some((rate, deviation)) = self.deviation(iterate) else { return };
        self.each(
            |e| {
                let (mass, nodes) = self.element(iterate, e);
                let [a, b, c, d] = iterate.space.tets()[e].map(|v| iterate.rest[v]);
                let md = self.times_reference(&deviation, nodes);
                let along: f64 = md.zip(nodes).map(|(m, &n)| m.dot(&at(lambda, n))).sum();
                let volume = tet_volume(a, b, c, d);
                tet_volume_gradient(a, b, c, d).map(|by| rate * mass / volume * along * by)
            },
            |e, parts| {
                let tet = iterate.space.tets()[e];
                tet.iter().zip(parts).for_each(|(&vertex, part)| add_at(out, vertex, &part));
            },
        );
    }

    fn add_past_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some((rate, _)) = self.frame(iterate) else { return };
        let from = if self.tiny { &mut out.history } else { &mut out.free_flight };
        self.add_mass_times(iterate, lambda, -rate, from);
    }

    fn slots(&self) -> Vec<Slot> {
        vec![Slot::new("density", "kg/m³")]
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; iterate.u.len()];
        self.add_gradient(iterate, &mut gradient);
        vec![dot(&gradient, lambda) / self.density]
    }
}
