//! The discrete problem: energies, fixed degrees of freedom, linear algebra.

use std::time::Instant;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use crate::element::FunctionSpace;
use crate::energy::{Energy, Hessian, Iterate};
use crate::math::linear::{SparseSolver, Symmetric};
use crate::math::ordering::nested_dissection;
use crate::math::sparse::{BlockMatrix, FreeTriangle, Pattern};

/// Where the time went [s].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Energies, gradients and Hessians.
    pub assembly_s: f64,
    /// Numerical factorisation.
    pub factor_s: f64,
    /// Triangular solves.
    pub solve_s: f64,
}

/// Energies on a function space with some degrees of freedom fixed at zero
/// displacement. Symbolic work is done once, for any rest shape.
pub struct System {
    /// Where displacements live.
    pub space: FunctionSpace,
    /// Terms of the potential energy.
    pub energies: Vec<Box<dyn Energy>>,
    /// Factorisation, kept from the last Newton step.
    pub linear: SparseSolver,
    /// Time spent so far.
    pub timings: Timings,
    pattern: Pattern,
    free: FreeTriangle,
}

impl System {
    /// Orders and factors symbolically. `fixed` has one entry per degree of
    /// freedom.
    #[must_use]
    pub fn new(space: FunctionSpace, energies: Vec<Box<dyn Energy>>, fixed: &[bool]) -> Self {
        let pattern =
            Pattern::new(space.node_count(), space.element_nodes(), space.nodes_per_element());
        let free = FreeTriangle::new(&pattern, fixed);
        let order = order_of_unknowns(&pattern, &free, fixed);
        let linear = SparseSolver::new(free.column_start.clone(), free.rows.clone(), &order);
        Self { space, energies, linear, timings: Timings::default(), pattern, free }
    }

    /// Number of degrees of freedom, fixed ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        3 * self.space.node_count()
    }

    /// Whether there are no degrees of freedom.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// An iterate of this system.
    #[must_use]
    pub fn iterate<'a>(&'a self, rest: &'a [Vec3], u: &'a [f64], load: f64) -> Iterate<'a> {
        Iterate { space: &self.space, rest, u, load }
    }

    /// Total potential energy [J].
    pub fn value(&mut self, rest: &[Vec3], u: &[f64], load: f64) -> f64 {
        let start = Instant::now();
        let at = self.iterate(rest, u, load);
        let value = self.energies.iter().map(|e| e.value(&at)).sum();
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        value
    }

    /// Gradient over all degrees of freedom [N], reactions included, and the
    /// largest norm of one term's free part, which is the scale of the forces
    /// that have to balance.
    pub fn gradient(&mut self, rest: &[Vec3], u: &[f64], load: f64) -> (Vec<f64>, f64) {
        let start = Instant::now();
        let at = self.iterate(rest, u, load);
        let mut total = vec![0.0; self.len()];
        let mut scale = 0.0_f64;
        for energy in &self.energies {
            let mut part = vec![0.0; self.len()];
            energy.add_gradient(&at, &mut part);
            scale = scale.max(crate::math::linear::norm(&self.free.restrict(&part)));
            total.iter_mut().zip(&part).for_each(|(t, p)| *t += p);
        }
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        (total, scale)
    }

    /// The Hessian on the free degrees of freedom.
    pub fn hessian(&mut self, rest: &[Vec3], u: &[f64], load: f64, kind: Hessian) -> Symmetric {
        let start = Instant::now();
        let at = self.iterate(rest, u, load);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        for energy in &self.energies {
            energy.add_hessian(&at, kind, &mut matrix);
        }
        let lower = self.free.gather(&matrix);
        let dense = self.energies.iter().filter_map(|e| e.rank_one(&at));
        let updates = dense.map(|d| (d.scale, self.free.restrict(&d.vector))).collect();
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        Symmetric { lower, updates }
    }

    /// Factors the exact Hessian under the full load, for derivatives at an
    /// equilibrium and as the start of the next one.
    pub fn linearize(&mut self, rest: &[Vec3], u: &[f64]) {
        let hessian = self.hessian(rest, u, 1.0, Hessian::Exact);
        let start = Instant::now();
        if self.linear.factor_positive(hessian.clone()).is_err() {
            self.linear.factor_indefinite(hessian);
        }
        self.timings.factor_s += start.elapsed().as_secs_f64();
    }

    /// Position of each diagonal entry among the Hessian's values.
    #[must_use]
    pub fn diagonal(&self) -> &[usize] {
        &self.free.column_start[..self.free.dof.len()]
    }

    /// The free part of a vector.
    #[must_use]
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        self.free.restrict(full)
    }

    /// A full vector from its free part.
    #[must_use]
    pub fn prolong(&self, free: &[f64]) -> Vec<f64> {
        self.free.prolong(free, self.len())
    }
}

/// Nested dissection of the nodes; the unknowns of a node stay together.
fn order_of_unknowns(pattern: &Pattern, free: &FreeTriangle, fixed: &[bool]) -> Vec<usize> {
    let mut unknown_of = vec![None; fixed.len()];
    for (i, &dof) in free.dof.iter().enumerate() {
        unknown_of[dof] = Some(i);
    }
    nested_dissection(&pattern.adjacency())
        .into_iter()
        .flat_map(|node| (3 * node..3 * node + 3).filter_map(|dof| unknown_of[dof]))
        .collect()
}
