//! The discrete problem: energies, fixed degrees of freedom, linear algebra.

use std::time::Instant;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use crate::contact::friction::LaggedContact;
use crate::element::FunctionSpace;
use crate::energy::{
    Constraint, Energies, Hessian, Iterate, Kind, Multiplier, RankOne, Term, TimeStep,
};
use crate::math::linear::{Precision, SparseSolver, Symmetric, dot};
use crate::math::ordering::nested_dissection;
use crate::math::sparse::{BlockMatrix, FreeTriangle, Pattern};
use crate::memory::Need;

/// Relative difference of displacements that is nothing but rounding.
const ROUNDING: f64 = 1e-13;

/// Gaps up to this many times the distance at which surfaces begin to interact
/// get room in the Hessian, so that it need not be made for every new contact.
const REACH: f64 = 2.0;

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
    /// Certificates of positive volume, and of surfaces that do not intersect.
    #[serde(default)]
    pub certificate_s: f64,
    /// Where steps end before surfaces meet.
    #[serde(default)]
    pub collision_s: f64,
    /// Symbolic factorisations after the first.
    #[serde(default)]
    pub symbolic_s: f64,
    /// Numerical factorisations, failed ones included.
    #[serde(default)]
    pub factorizations: usize,
    /// Those that met a pivot that is not positive.
    #[serde(default)]
    pub failed_factorizations: usize,
}

/// Displacement [m] of all degrees of freedom at a load; only those of the fixed
/// ones are looked at.
type Motion = Box<dyn Fn(f64) -> Vec<f64> + Send + Sync>;

/// Energies on a function space with some degrees of freedom fixed, at zero or
/// at a displacement that follows the load. Symbolic work is done once, for any
/// rest shape.
pub struct System {
    /// Where displacements live.
    pub space: FunctionSpace,
    /// Terms of the potential energy.
    pub energies: Energies,
    /// Factorisation, kept from the last Newton step.
    pub linear: SparseSolver,
    /// Time spent so far.
    pub timings: Timings,
    /// Of the chambers with a prescribed volume.
    pub multipliers: Vec<Multiplier>,
    /// The same before the first step.
    pub(super) multipliers_at_rest: Vec<Multiplier>,
    /// The step in time, if there is one.
    pub step: Option<TimeStep>,
    pattern: Pattern,
    /// Pairs of nodes in the pattern that share no element, sorted.
    couplings: Vec<[usize; 2]>,
    free: FreeTriangle,
    /// Whether each degree of freedom is fixed.
    fixed: Vec<bool>,
    /// Fixed degrees of freedom.
    supports: Vec<usize>,
    /// How they move, if they do.
    motion: Option<Motion>,
}

impl System {
    /// Orders and factors symbolically. `fixed` has one entry per degree of
    /// freedom.
    #[must_use]
    pub fn new(space: FunctionSpace, energies: Energies, fixed: &[bool]) -> Self {
        let (pattern, free, linear) = symbolic(&space, fixed, &[]);
        Self {
            space,
            energies,
            linear,
            timings: Timings::default(),
            multipliers: Vec::new(),
            multipliers_at_rest: Vec::new(),
            step: None,
            pattern,
            couplings: Vec::new(),
            free,
            fixed: fixed.to_vec(),
            supports: (0..fixed.len()).filter(|&d| fixed[d]).collect(),
            motion: None,
        }
    }

    /// Makes room in the Hessian for what energies couple at a state beyond
    /// elements; the symbolic work is done anew only where it must be.
    fn make_room(&mut self, rest: &[Vec3], u: &[f64], load: f64) {
        let at = self.iterate(rest, u, load);
        let couplings =
            |reach: f64| self.energies.iter().flat_map(move |e| e.couplings(&at, reach));
        if couplings(1.0).all(|[a, b]| self.pattern.has(a, b)) {
            return;
        }
        let wider: Vec<[usize; 2]> = couplings(REACH).collect();
        self.couple(wider);
    }

    /// Replaces the pairs of nodes that are coupled although they share no
    /// element. The factor is forgotten.
    pub fn couple(&mut self, mut pairs: Vec<[usize; 2]>) {
        pairs.sort_unstable();
        pairs.dedup();
        if pairs == self.couplings {
            return;
        }
        let start = Instant::now();
        (self.pattern, self.free, self.linear) = symbolic(&self.space, &self.fixed, &pairs);
        log::debug!("{} pairs of nodes coupled by contact", pairs.len());
        self.couplings = pairs;
        self.timings.symbolic_s += start.elapsed().as_secs_f64();
    }

    /// The pairs of nodes that are coupled although they share no element.
    #[must_use]
    pub fn couplings(&self) -> &[[usize; 2]] {
        &self.couplings
    }

    /// Whether each degree of freedom is fixed.
    #[must_use]
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Largest fraction of the way from a displacement and load to others that no
    /// energy forbids.
    pub fn max_step(&mut self, rest: &[Vec3], from: (&[f64], f64), to: (&[f64], f64)) -> f64 {
        let start = Instant::now();
        let (a, b) = (self.iterate(rest, from.0, from.1), self.iterate(rest, to.0, to.1));
        let largest = self.energies.iter().map(|e| e.max_step(&a, &b)).fold(1.0, f64::min);
        self.timings.collision_s += start.elapsed().as_secs_f64();
        largest
    }

    /// Why a state must not be accepted, if so.
    pub fn objection(&mut self, rest: &[Vec3], u: &[f64], load: f64) -> Option<String> {
        let start = Instant::now();
        let at = self.iterate(rest, u, load);
        let found = self.energies.iter().find_map(|e| e.objection(&at));
        self.timings.certificate_s += start.elapsed().as_secs_f64();
        found
    }

    /// The contacts at a state whose friction acts in the next step.
    #[must_use]
    pub fn lagged_contacts(&self, rest: &[Vec3], u: &[f64], load: f64) -> Vec<LaggedContact> {
        let at = self.iterate(rest, u, load);
        self.energies.iter().flat_map(|e| e.lagged_contacts(&at)).collect()
    }

    /// Starts the multipliers of prescribed volumes, as the energies number them.
    #[must_use]
    pub fn with_multipliers(mut self, multipliers: Vec<Multiplier>) -> Self {
        self.multipliers_at_rest.clone_from(&multipliers);
        self.multipliers = multipliers;
        self
    }

    /// Prescribes the displacement of all degrees of freedom at a load [m];
    /// entries of those that are not fixed are not looked at.
    #[must_use]
    pub fn with_motion(mut self, motion: Motion) -> Self {
        self.motion = Some(motion);
        self
    }

    /// Prescribes the displacement of the fixed degrees of freedom at full load
    /// [m], in proportion to which they move; entries of the others are not
    /// looked at.
    #[must_use]
    pub fn with_displacement(self, displacement: &[f64]) -> Self {
        let full = displacement.to_vec();
        self.with_motion(Box::new(move |load| full.iter().map(|u| load * u).collect()))
    }

    /// Displacement of the fixed degrees of freedom at a load [m]; entries of the
    /// others mean nothing.
    #[must_use]
    pub fn displacement_of_supports(&self, load: f64) -> Vec<f64> {
        self.motion.as_ref().map_or_else(|| vec![0.0; self.len()], |at| at(load))
    }

    /// Fixes other degrees of freedom. The factor is forgotten.
    pub fn fix(&mut self, fixed: &[bool]) {
        let start = Instant::now();
        (self.pattern, self.free, self.linear) = symbolic(&self.space, fixed, &self.couplings);
        self.supports = (0..fixed.len()).filter(|&d| fixed[d]).collect();
        self.fixed = fixed.to_vec();
        self.timings.symbolic_s += start.elapsed().as_secs_f64();
    }

    /// Sets the fixed degrees of freedom of `u` to their displacement at a load,
    /// and moves the others as the tangent at `u` says, so that elements at the
    /// supports are not crushed. Nothing happens where they are already there.
    pub fn move_supports(&mut self, rest: &[Vec3], u: &mut [f64], load: f64) {
        let wanted = self.displacement_of_supports(load);
        let mut motion = vec![0.0; u.len()];
        for &dof in &self.supports {
            motion[dof] = wanted[dof] - u[dof];
        }
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size(&motion) > ROUNDING * size(u).max(f64::MIN_POSITIVE) {
            let du = self.follow_supports(rest, u, load, &motion).unwrap_or(motion);
            u.iter_mut().zip(&du).for_each(|(u, d)| *u += d);
        }
        for &dof in &self.supports {
            u[dof] = wanted[dof];
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
        self.make_room(rest, u, load);
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

    /// What the first factorisation and the Hessians beside it will take.
    #[must_use]
    pub fn memory(&self) -> Need {
        // beside the factor: node blocks while they are assembled, and the free
        // triangle up to three times: kept, assembled, shifted
        let blocks = 9 * self.pattern.block_count();
        let triangle = 3 * self.free.rows.len();
        let hessians = size_of::<f64>() * (blocks + triangle);
        Need {
            unknowns: self.linear.size(),
            factor_entries: self.linear.factor_len(),
            bytes: self.linear.factor_bytes() + hessians,
        }
    }

    /// The degree of freedom of an unknown of the linear system.
    #[must_use]
    pub fn dof(&self, unknown: usize) -> usize {
        self.free.dof[unknown]
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
        let (multipliers, step) = (&self.multipliers, self.step.as_ref());
        Iterate { space: &self.space, rest, u, load, multipliers, step }
    }

    /// The prescribed volumes.
    #[must_use]
    pub fn constraints(&self, rest: &[Vec3], u: &[f64], load: f64) -> Vec<Constraint> {
        let at = self.iterate(rest, u, load);
        self.energies.iter().filter_map(|e| e.constraint(&at)).collect()
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
        for energy in self.energies.iter() {
            let mut part = vec![0.0; self.len()];
            energy.add_gradient(&at, &mut part);
            scale = scale.max(crate::math::linear::norm(&self.free.restrict(&part)));
            total.iter_mut().zip(&part).for_each(|(t, p)| *t += p);
        }
        if self.motion.is_some() {
            let reactions: Vec<f64> = self.supports.iter().map(|&dof| total[dof]).collect();
            scale = scale.max(crate::math::linear::norm(&reactions));
        }
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        (total, scale)
    }

    /// The Hessian on the free degrees of freedom.
    pub fn hessian(&mut self, rest: &[Vec3], u: &[f64], load: f64, kind: Hessian) -> Symmetric {
        let start = Instant::now();
        self.make_room(rest, u, load);
        let dense = self.rank_ones(rest, u, load);
        let values = self.restrict_hessian(&self.assemble(rest, u, load, kind), &dense);
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        values
    }

    fn assemble(&self, rest: &[Vec3], u: &[f64], load: f64, kind: Hessian) -> BlockMatrix<'_> {
        let at = self.iterate(rest, u, load);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        for energy in self.energies.iter() {
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

    /// Factors the exact Hessian, for derivatives at an equilibrium and as the start
    /// of the next one.
    pub fn linearize(&mut self, rest: &[Vec3], u: &[f64], load: f64) {
        let hessian = self.hessian(rest, u, load, Hessian::Exact);
        let start = Instant::now();
        if self.linear.factor_positive(hessian.clone(), Precision::Single).is_err() {
            self.linear.factor_indefinite(hessian);
        }
        self.timings.factor_s += start.elapsed().as_secs_f64();
    }

    /// Forces of contact and friction on the nodes [N], three components per node.
    #[must_use]
    pub fn contact_forces(&self, rest: &[Vec3], u: &[f64], load: f64) -> Vec<f64> {
        self.energies.contact_forces(&self.iterate(rest, u, load))
    }

    /// The exact Hessian of contact and friction times a vector; none if that is
    /// zero.
    pub fn contact_hessian_times(
        &mut self,
        rest: &[Vec3],
        u: &[f64],
        load: f64,
        vector: &[f64],
    ) -> Option<Vec<f64>> {
        if vector.iter().all(|v| *v == 0.0) {
            return None;
        }
        self.make_room(rest, u, load);
        let at = self.iterate(rest, u, load);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        let contact = self.energies.contact_terms();
        contact.for_each(|e| e.add_hessian(&at, Hessian::Exact, &mut matrix));
        Some(matrix.multiply(vector))
    }

    /// What rounding leaves of the gradient's free part [N], whatever `u` is: the
    /// norm over i of ε Σ_j |H_ij| |w_j|, with ε = 2⁻⁵². It bounds what the
    /// rounding of w to the nearest f64, and of the sums over it, does to the
    /// forces: w is the displacement for the elastic forces, which see
    /// differences of u alone, and the position for all others.
    pub fn rounding_floor(&mut self, rest: &[Vec3], u: &[f64], load: f64) -> f64 {
        let start = Instant::now();
        self.make_room(rest, u, load);
        let at = self.iterate(rest, u, load);
        let positions = self.space.node_positions(rest);
        let x: Vec<f64> = (0..u.len()).map(|d| positions[d / 3][d % 3] + u[d]).collect();
        let mut noise = vec![0.0; u.len()];
        for Term { kind, energy } in self.energies.terms() {
            let from = if matches!(kind, Kind::Elastic(_)) { u } else { &x };
            let mut matrix = BlockMatrix::zeros(&self.pattern);
            energy.add_hessian(&at, Hessian::Exact, &mut matrix);
            let part = matrix.multiply_magnitudes(from);
            noise.iter_mut().zip(&part).for_each(|(n, p)| *n += p);
            if let Some(RankOne { scale, vector }) = energy.rank_one(&at) {
                let along: f64 = vector.iter().zip(from).map(|(v, w)| (v * w).abs()).sum();
                noise.iter_mut().zip(&vector).for_each(|(n, v)| *n += (scale * v).abs() * along);
            }
        }
        let floor = f64::EPSILON * crate::math::linear::norm(&self.free.restrict(&noise));
        self.timings.assembly_s += start.elapsed().as_secs_f64();
        floor
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

/// Where the Hessian has entries, and its factorisation without numbers.
fn symbolic(
    space: &FunctionSpace,
    fixed: &[bool],
    couplings: &[[usize; 2]],
) -> (Pattern, FreeTriangle, SparseSolver) {
    let nodes = (space.node_count(), space.element_nodes(), space.nodes_per_element());
    let pattern = Pattern::new(nodes.0, nodes.1, nodes.2, couplings);
    let (free, nodes) = rayon::join(
        || FreeTriangle::new(&pattern, fixed),
        || nested_dissection(&pattern.adjacency()),
    );
    let order = order_of_unknowns(&nodes, &free, fixed);
    let linear = SparseSolver::new(free.column_start.clone(), free.rows.clone(), &order);
    (pattern, free, linear)
}

/// The unknowns in the order of their nodes.
fn order_of_unknowns(nodes: &[usize], free: &FreeTriangle, fixed: &[bool]) -> Vec<usize> {
    let mut unknown_of = vec![None; fixed.len()];
    for (i, &dof) in free.dof.iter().enumerate() {
        unknown_of[dof] = Some(i);
    }
    nodes
        .iter()
        .flat_map(|node| (3 * node..3 * node + 3).filter_map(|dof| unknown_of[dof]))
        .collect()
}
