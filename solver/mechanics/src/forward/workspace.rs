//! What solving a problem needs beside the problem: the sparsity pattern of its
//! Hessian, the factorisation, and the times that it took.
//!
//! The pattern is extended where a problem fixes other degrees of freedom, or an iterate
//! has contacts that it has no entries for.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use mesh::Vec3;

use super::Problem;
use super::dirichlet::Dirichlet;
use super::symbolic::symbolic;
use super::timings::{Clock, Timings};
use super::watch::{Event, Watch};
use crate::energy::{Hessian, Iterate, Multiplier, Nature, RankOne, TimeStep};
use crate::math::linear::{Factorization, Memory, Precision, SparseSolver, Symmetric, dot, norm};
use crate::math::sparse::{BlockMatrix, FreeTriangle, Pattern};
use crate::memory::Need;

/// Relative difference of displacements that is nothing but rounding.
const SUPPORT_ROUNDING: f64 = 1e-13;

/// Gaps up to this many times the distance at which surfaces begin to interact
/// get entries in the Hessian, so that it need not be made for every new contact.
const REACH: f64 = 2.0;

/// Relative residual of the motion that follows the supports.
const PREDICTION: f64 = 1e-6;

/// Pattern, factor and timings.
pub struct Workspace {
    /// Time spent so far.
    pub timings: Timings,
    /// Who is told what happens, if anybody is.
    pub watch: Option<Watch>,
    /// How many more times Newton's method is taken to begin with an indefinite Hessian.
    pub indefinite_starts: usize,
    /// Factorisation, kept from the last Newton step.
    linear: SparseSolver,
    /// Which factorisation of an exact Hessian is in `linear`, if it is one.
    linearization: Option<u64>,
    linearizations: u64,
    pattern: Pattern,
    /// Memory of the last assembled matrix on the pattern, for the next.
    blocks: Vec<[f64; 9]>,
    /// Memory of values that were not factored, for the next Hessian.
    spare: Vec<f64>,
    /// Pairs of nodes in the pattern that share no element, sorted.
    couplings: Vec<[usize; 2]>,
    free: FreeTriangle,
    /// The conditions that `free` was made for.
    dirichlet: Arc<Dirichlet>,
}

/// The exact Hessian at an iterate, factored by [`Workspace::linearize`].
#[derive(Clone)]
pub struct Linearization {
    id: u64,
    u: Vec<f64>,
    time: f64,
    multipliers: Vec<Multiplier>,
    step: Option<TimeStep>,
    /// The factor of its tangent, where [`Workspace::keep`] has kept it.
    kept: Option<Arc<Factorization>>,
}

impl fmt::Debug for Linearization {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        let Self { id, time, kept, .. } = self;
        write!(
            to,
            "Linearization {id} at {time} s, {}",
            if kept.is_some() { "kept" } else { "not kept" }
        )
    }
}

impl Linearization {
    /// Where it was made [s].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The iterate on its rest shape [m].
    pub fn iterate<'a>(&'a self, problem: &'a Problem, rest: &'a [Vec3]) -> Iterate<'a> {
        let Self { u, multipliers, step, .. } = self;
        let (space, step) = (&problem.space, step.as_ref());
        Iterate { space, rest, u, time: self.time, multipliers, step, before: None }
    }
}

impl Workspace {
    /// Orders and factors symbolically.
    pub fn new(problem: &Problem) -> Self {
        let clock = Clock::start();
        let (pattern, free, linear) =
            symbolic(&problem.space, &problem.dirichlet, &[], Memory::default());
        let timings = Timings { ordering: clock.elapsed(), ..Timings::default() };
        Self {
            timings,
            watch: None,
            indefinite_starts: 0,
            linear,
            linearization: None,
            linearizations: 0,
            pattern,
            blocks: Vec::new(),
            spare: Vec::new(),
            couplings: Vec::new(),
            free,
            dirichlet: Arc::clone(&problem.dirichlet),
        }
    }

    /// Tells the watch of an event, and gives back whether to go on.
    pub(crate) fn notify(&mut self, event: &Event) -> ControlFlow<()> {
        self.watch.as_mut().map_or(ControlFlow::Continue(()), |watch| watch(event))
    }

    /// Extends the pattern by what energies couple at an iterate beyond elements,
    /// and fits it to the problem's fixed degrees of freedom; the symbolic work is done
    /// anew only where it must be.
    fn extend_pattern(&mut self, problem: &Problem, at: &Iterate) {
        if !Arc::ptr_eq(&self.dirichlet, &problem.dirichlet) {
            self.dirichlet = Arc::clone(&problem.dirichlet);
            self.symbolic(problem);
        }
        let clock = Clock::start();
        let couplings = |reach: f64| {
            problem.energies.terms().flat_map(move |term| term.energy.couplings(at, reach))
        };
        let known = couplings(1.0).all(|[a, b]| self.pattern.has(a, b));
        let wider = (!known).then(|| couplings(REACH).collect());
        self.timings.contact += clock.elapsed();
        if let Some(pairs) = wider {
            self.set_couplings(problem, pairs);
        }
    }

    /// Replaces the pairs of nodes that are coupled although they share no
    /// element. The factor is forgotten.
    pub fn set_couplings(&mut self, problem: &Problem, mut pairs: Vec<[usize; 2]>) {
        pairs.sort_unstable();
        pairs.dedup();
        if pairs == self.couplings {
            return;
        }
        log::debug!("{} pairs of nodes coupled by contact", pairs.len());
        self.couplings = pairs;
        self.symbolic(problem);
    }

    /// Pattern and factorisation for the couplings and fixed degrees of freedom.
    fn symbolic(&mut self, problem: &Problem) {
        let clock = Clock::start();
        self.forget();
        let memory = self.linear.memory();
        (self.pattern, self.free, self.linear) =
            symbolic(&problem.space, &self.dirichlet, &self.couplings, memory);
        self.timings.ordering += clock.elapsed();
    }

    /// The pairs of nodes that are coupled although they share no element.
    pub fn couplings(&self) -> &[[usize; 2]] {
        &self.couplings
    }

    /// The solver of linear systems, and the last factorisation.
    pub fn linear(&self) -> &SparseSolver {
        &self.linear
    }

    /// Forgets the factor, and the linearisation that it is of.
    pub fn forget(&mut self) {
        self.linearization = None;
        self.linear.forget();
    }

    /// Lets the solver of linear systems factor, timed: no linearisation is kept.
    pub fn factor<T>(&mut self, by: impl FnOnce(&mut SparseSolver) -> T) -> T {
        self.linearization = None;
        let clock = Clock::start();
        let factored = by(&mut self.linear);
        self.timings.factor += clock.elapsed();
        factored
    }

    /// What the first factorisation and the Hessians beside it will take.
    pub fn memory(&self) -> Need {
        // beside the factor: node blocks while they are assembled, and the free
        // triangle up to three times: kept, assembled, shifted
        let blocks = 9 * self.pattern.block_count();
        let triangle = 3 * self.linear.entries();
        let hessians = size_of::<f64>() * (blocks + triangle);
        let cost = self.linear.cost();
        Need {
            unknowns: self.linear.size(),
            factor_entries: cost.entries,
            bytes: cost.bytes + hessians,
        }
    }

    /// Memory of a factorisation that is kept, with its matrix [B].
    pub fn memory_of_factor(&self) -> usize {
        self.linear.cost().bytes + size_of::<f64>() * self.linear.entries()
    }

    /// [`Problem::value`], timed.
    pub fn value(&mut self, problem: &Problem, at: &Iterate) -> f64 {
        problem.value_by(|term| self.timings.of(term.nature(), || term.energy.value(at)))
    }

    /// [`Problem::gradient`], timed.
    pub fn gradient(&mut self, problem: &Problem, at: &Iterate) -> (Vec<f64>, f64) {
        problem.gradient_by(|term, out| {
            self.timings.of(term.nature(), || term.energy.add_gradient(at, out));
        })
    }

    /// [`Problem::max_step`], timed.
    pub fn max_step(&mut self, problem: &Problem, from: &Iterate, to: &Iterate) -> f64 {
        let clock = Clock::start();
        let largest = problem.max_step(from, to);
        self.timings.collision += clock.elapsed();
        largest
    }

    /// The Hessian on the free degrees of freedom.
    pub fn hessian(&mut self, problem: &Problem, at: &Iterate, kind: Hessian) -> Symmetric {
        let (hessian, _) = self.hessian_times(problem, at, kind, None);
        hessian
    }

    /// The Hessian on the free degrees of freedom, and the whole one times a vector.
    fn hessian_times(
        &mut self,
        problem: &Problem,
        at: &Iterate,
        kind: Hessian,
        vector: Option<&[f64]>,
    ) -> (Symmetric, Option<Vec<f64>>) {
        self.extend_pattern(problem, at);
        let memory = std::mem::take(&mut self.blocks);
        let mut matrix = BlockMatrix::zeros_in(&self.pattern, memory);
        for term in problem.energies.terms() {
            let add = || term.energy.add_hessian(at, kind, &mut matrix);
            self.timings.of(term.nature(), add);
        }
        let clock = Clock::start();
        let dense = problem.rank_ones(at);
        let product = vector.map(|vector| times(&matrix, &dense, vector));
        let restricted = |d: RankOne| (d.scale, self.dirichlet.restrict(&d.vector));
        let updates = dense.into_iter().map(restricted).collect();
        matrix.fold(self.dirichlet.followers());
        let mut lower = std::mem::take(&mut self.spare);
        self.free.gather(&matrix, &mut lower);
        self.blocks = matrix.into_memory();
        self.timings.assembly += clock.elapsed();
        (Symmetric { lower, updates }, product)
    }

    /// Takes back a Hessian that is not used any more, for its memory.
    pub fn recycle(&mut self, hessian: Symmetric) {
        self.spare = hessian.lower;
    }

    /// Position of each diagonal entry among the values of the last Hessian.
    pub fn diagonal(&self) -> &[usize] {
        &self.linear.column_start()[..self.dirichlet.free().len()]
    }

    /// Factors the exact Hessian, for derivatives at an equilibrium and as the start
    /// of the next one.
    pub fn linearize(&mut self, problem: &Problem, at: &Iterate) -> Linearization {
        let hessian = self.hessian(problem, at, Hessian::Exact);
        self.factor(|linear| linear.factor(hessian, Precision::Single).is_positive());
        self.linearizations += 1;
        self.linearization = Some(self.linearizations);
        Linearization {
            id: self.linearizations,
            u: at.u.to_vec(),
            time: at.time,
            multipliers: at.multipliers.to_vec(),
            step: at.step.cloned(),
            kept: None,
        }
    }

    /// A linearisation that keeps its factor, which is the last.
    pub fn keep(&self, linearization: Linearization) -> Linearization {
        let is_last = self.linearization == Some(linearization.id);
        let kept = self.linear.share().filter(|_| is_last);
        Linearization { kept, ..linearization }
    }

    /// Whether the last factorisation is that of a linearisation, and at this iterate; a factor that was kept becomes the
    /// last.
    pub fn has_factor_of(&mut self, linearization: &Linearization, at: &Iterate) -> bool {
        let is_last = self.linearization == Some(linearization.id);
        linearization.u == at.u && (is_last || self.reuse(linearization))
    }

    /// Makes the factor that a linearisation has kept the last one; false where it has none, or one of another pattern.
    pub fn reuse(&mut self, linearization: &Linearization) -> bool {
        let taken = linearization.kept.as_ref().is_some_and(|kept| self.linear.reuse(kept));
        if taken {
            self.linearization = Some(linearization.id);
        }
        taken
    }

    /// Solves with the last factorisation to a relative residual, and returns that
    /// reached; where it is larger than `enough`, again with a factor in double
    /// precision. None without a factorisation.
    pub fn solve_accurately(&mut self, x: &mut Vec<f64>, sought: f64, enough: f64) -> Option<f64> {
        let clock = Clock::start();
        let rhs = x.clone();
        let mut residual = self.linear.last()?.solve_to(x, sought);
        if (residual.is_nan() || residual > enough)
            && let Some(sharper) = self.linear.refactor_double()
        {
            *x = rhs;
            residual = sharper.solve_to(x, sought);
        }
        self.timings.solve += clock.elapsed();
        Some(residual)
    }

    /// The exact Hessian of contact and friction times a vector; none if that is
    /// zero.
    pub fn contact_hessian_times(
        &mut self,
        problem: &Problem,
        at: &Iterate,
        vector: &[f64],
    ) -> Option<Vec<f64>> {
        if vector.iter().all(|v| *v == 0.0) {
            return None;
        }
        self.extend_pattern(problem, at);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        let contact = problem.energies.contact_terms();
        contact.for_each(|e| e.add_hessian(at, Hessian::Exact, &mut matrix));
        Some(matrix.multiply(vector))
    }

    /// wᵀ ∂²E/∂u² over all degrees of freedom, with w zero on the free ones; none if it is zero.
    ///
    /// The pressure on a wall is not symmetric at a rim that slides in its support.
    pub fn support_hessian_times(
        &mut self,
        problem: &Problem,
        at: &Iterate,
        w: &[f64],
    ) -> Option<Vec<f64>> {
        if w.iter().all(|v| *v == 0.0) {
            return None;
        }
        self.extend_pattern(problem, at);
        let mut matrix = BlockMatrix::zeros(&self.pattern);
        for term in problem.energies.terms().filter(|term| term.nature() != Nature::Gas) {
            let add = || term.energy.add_hessian(at, Hessian::Exact, &mut matrix);
            self.timings.of(term.nature(), add);
        }
        let mut product = times(&matrix, &problem.rank_ones(at), w);
        for (_, chamber) in problem.energies.chambers() {
            chamber.add_stiffness_vjp(at, w, &mut product);
        }
        Some(product)
    }

    /// The displacement with the fixed degrees of freedom where they are at the time,
    /// and the others moved as the tangent says, so that elements at the supports are
    /// not crushed [m]. Nothing changes where they are already there.
    pub fn move_supports(&mut self, problem: &Problem, at: &Iterate) -> Vec<f64> {
        let (wanted, supports) =
            (problem.dirichlet.displacement(at.time), problem.dirichlet.supports());
        let (mut u, mut motion) = (at.u.to_vec(), vec![0.0; at.u.len()]);
        for &dof in supports {
            motion[dof] = wanted[dof] - u[dof];
        }
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size(&motion) > SUPPORT_ROUNDING * size(&u).max(f64::MIN_POSITIVE) {
            let du = self.follow_supports(problem, at, &motion).unwrap_or(motion);
            u.iter_mut().zip(&du).for_each(|(u, d)| *u += d);
        }
        for &dof in supports {
            u[dof] = wanted[dof];
        }
        u
    }

    /// δ with the given motion of the fixed part and H δ = 0 on the free part;
    /// none where H is not positive definite.
    fn follow_supports(
        &mut self,
        problem: &Problem,
        at: &Iterate,
        motion: &[f64],
    ) -> Option<Vec<f64>> {
        let (hessian, force) = self.hessian_times(problem, at, Hessian::Exact, Some(motion));
        let failed =
            self.factor(|linear| linear.factor_positive(hessian, Precision::Single).is_err());
        self.timings.factorizations += 1;
        self.timings.failed_factorizations += usize::from(failed);
        let clock = Clock::start();
        let mut free = problem.restrict(&force?);
        self.linear.last()?.solve_to(&mut free, PREDICTION);
        self.timings.solve += clock.elapsed();
        let back = problem.prolong(&free);
        Some(motion.iter().zip(&back).map(|(m, b)| m - b).collect())
    }

    /// What rounding leaves of the gradient's free part [N], whatever `u` is: the
    /// norm over i of ε Σ_j |H_ij| |w_j|, with ε = 2⁻⁵². It bounds what the
    /// rounding of w to the nearest f64, and of the sums over it, does to the
    /// forces: w is the displacement for the elastic forces, which depend on
    /// differences of u alone, and the position for all others.
    pub fn rounding_floor(&mut self, problem: &Problem, at: &Iterate) -> f64 {
        let clock = Clock::start();
        self.extend_pattern(problem, at);
        let (u, positions) = (at.u, problem.space.node_positions(at.rest));
        let x: Vec<f64> = (0..u.len()).map(|d| positions[d / 3][d % 3] + u[d]).collect();
        let mut noise = vec![0.0; u.len()];
        for energy in problem.energies.iter() {
            let from = if energy.nature().is_elastic() { u } else { &x };
            let mut matrix = BlockMatrix::zeros(&self.pattern);
            energy.add_hessian(at, Hessian::Exact, &mut matrix);
            let part = matrix.multiply_magnitudes(from);
            noise.iter_mut().zip(&part).for_each(|(n, p)| *n += p);
            if let Some(RankOne { scale, vector }) = energy.rank_one(at) {
                let along: f64 = vector.iter().zip(from).map(|(v, w)| (v * w).abs()).sum();
                noise.iter_mut().zip(&vector).for_each(|(n, v)| *n += (scale * v).abs() * along);
            }
        }
        let floor = f64::EPSILON * norm(&problem.restrict(&noise));
        self.timings.assembly += clock.elapsed();
        floor
    }
}

/// A Hessian of a sparse and a dense part times a vector.
fn times(matrix: &BlockMatrix, dense: &[RankOne], vector: &[f64]) -> Vec<f64> {
    let mut product = matrix.multiply(vector);
    for RankOne { scale, vector: v } in dense {
        let along = scale * dot(v, vector);
        product.iter_mut().zip(v).for_each(|(p, v)| *p += along * v);
    }
    product
}
