//! The discrete problem: energies, fixed degrees of freedom, linear algebra.

use std::time::Instant;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use crate::element::FunctionSpace;
use crate::energy::{Energy, Hessian, Iterate, RankOne};
use crate::math::linear::{Precision, SparseSolver, Symmetric, dot};
use crate::math::ordering::nested_dissection;
use crate::math::sparse::{BlockMatrix, FreeTriangle, Pattern};

/// Relative difference of displacements that is nothing but rounding.
const ROUNDING: f64 = 1e-13;

/// Relative residual of the motion that follows the supports.
const PREDICTION: f64 = 1e-6;

/// Where the time went [s].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Energies, gradients and Hessians.
    pub assembly_s: f64,
    /// Numerical factorisation.
    pub factor_s: f64,
    /// Triangular solves.
    pub solve_s: f64,
    /// Certificates of positive volume.
    #[serde(default)]
    pub certificate_s: f64,
}

/// Energies on a function space with some degrees of freedom fixed, at zero or
/// at a displacement that grows with the load. Symbolic work is done once, for any rest shape.
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
    /// Fixed degrees of freedom and their displacement at full load [m].
    supports: Vec<(usize, f64)>,
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
        let supports = (0..fixed.len()).filter(|&d| fixed[d]).map(|d| (d, 0.0)).collect();
        Self { space, energies, linear, timings: Timings::default(), pattern, free, supports }
    }

    /// Prescribes the displacement of the fixed degrees of freedom at full load
    /// [m]; entries of the others are not looked at.
    #[must_use]
    pub fn with_displacement(mut self, displacement: &[f64]) -> Self {
        self.supports.iter_mut().for_each(|(dof, value)| *value = displacement[*dof]);
        self
    }

    /// Sets the fixed degrees of freedom of `u` to their displacement at a load,
    /// and moves the others as the tangent at `u` says, so that elements at the
    /// supports are not crushed. Nothing happens where they are already there.
    pub fn move_supports(&mut self, rest: &[Vec3], u: &mut [f64], load: f64) {
        let mut motion = vec![0.0; u.len()];
        for &(dof, value) in &self.supports {
            motion[dof] = load * value - u[dof];
        }
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size(&motion) > ROUNDING * size(u).max(f64::MIN_POSITIVE) {
            let du = self.follow_supports(rest, u, load, &motion).unwrap_or(motion);
            u.iter_mut().zip(&du).for_each(|(u, d)| *u += d);
        }
        for &(dof, value) in &self.supports {
            u[dof] = load * value;
        }
    }

    /// δ with the given motion of the fixed part and H δ = 0 on the free part;
    /// none where H is not positive definite.
    fn follow_supports(
        &mut self,
        rest: &[Vec3],
        u: &[f64],
        load: f64,
        motion: &[f64],
    ) -> Option<Vec<f64>> {
        let matrix = self.assemble(rest, u, load, Hessian::Exact);
        let dense = self.rank_ones(rest, u, load);
        let mut force = matrix.multiply(motion);
        for RankOne { scale, vector } in &dense {
            let along = scale * dot(vector, motion);
            force.iter_mut().zip(vector).for_each(|(f, v)| *f += along * v);
        }
        let values = self.restrict_hessian(&matrix, &dense);
        drop(matrix);
        self.linear.factor_positive(values, Precision::Single).ok()?;
        let mut free = self.restrict(&force);
        self.linear.solve_to(&mut free, PREDICTION);
        let back = self.prolong(&free);
        Some(motion.iter().zip(&back).map(|(m, b)| m - b).collect())
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
    /// scale of the forces that have to balance: the largest norm of one term's
    /// free part, or of the reactions where supports move.
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
        if self.supports.iter().any(|s| s.1 != 0.0) {
            let reactions: Vec<f64> = self.supports.iter().map(|s| total[s.0]).collect();
            scale = scale.max(crate::math::linear::norm(&reactions));
        }
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        (total, scale)
    }

    /// The Hessian on the free degrees of freedom.
    pub fn hessian(&mut self, rest: &[Vec3], u: &[f64], load: f64, kind: Hessian) -> Symmetric {
        let start = Instant::now();
        let dense = self.rank_ones(rest, u, load);
        let values = self.restrict_hessian(&self.assemble(rest, u, load, kind), &dense);
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        values
    }

    fn assemble(&self, rest: &[Vec3], u: &[f64], load: f64, kind: Hessian) -> BlockMatrix<'_> {
        let at = self.iterate(rest, u, load);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        for energy in &self.energies {
            energy.add_hessian(&at, kind, &mut matrix);
        }
        matrix
    }

    /// The part of a Hessian on the free degrees of freedom.
    fn restrict_hessian(&self, matrix: &BlockMatrix, dense: &[RankOne]) -> Symmetric {
        let updates = dense.iter().map(|d| (d.scale, self.free.restrict(&d.vector))).collect();
        Symmetric { lower: self.free.gather(matrix), updates }
    }

    fn rank_ones(&self, rest: &[Vec3], u: &[f64], load: f64) -> Vec<RankOne> {
        let at = self.iterate(rest, u, load);
        self.energies.iter().filter_map(|e| e.rank_one(&at)).collect()
    }

    /// Factors the exact Hessian under the full load, for derivatives at an
    /// equilibrium and as the start of the next one.
    pub fn linearize(&mut self, rest: &[Vec3], u: &[f64]) {
        let hessian = self.hessian(rest, u, 1.0, Hessian::Exact);
        let start = Instant::now();
        if self.linear.factor_positive(hessian.clone(), Precision::Single).is_err() {
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
