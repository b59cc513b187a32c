//! Cholesky factorisation by fronts, in parallel over the elimination tree.
//!
//! A supernode s has the front [F₁₁ ·; F₂₁ F₂₂]: its own columns and the rows
//! below that they reach. With the entries of A and the updates of its children
//! added up, L₁₁ L₁₁ᵀ = F₁₁, L₂₁ = F₂₁ L₁₁⁻ᵀ, and F₂₂ − L₂₁ L₂₁ᵀ is its update
//! for its parent. The dense kernels and the symbolic part are faer's; subtrees
//! own disjoint ranges of the factor, so that they run on separate threads.
//!
//! Source: Duff and Reid 1983, "The multifrontal solution of indefinite sparse
//! symmetric linear equations", doi:10.1145/356044.356047.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par, Spec};
use rayon::prelude::*;

use super::direct::BadPivots;
use super::entries::{Run, place_entries};
use super::extend_add::extend_add;
use super::matrix::Triangle;
use super::replacing;
use super::scalar::{Scalar, narrow};
use super::supernode::Supernode;
use crate::math::pool::Pool;

/// Floating-point operations that are worth a task of their own.
const TASK: f64 = 2e7;

/// Columns of a front that are worked on at once.
const BLOCK: usize = 192;

/// Part of all operations from which on several threads share a front. Below, subtrees keep them
/// busy, and each shared product would wait for the slowest.
const SHARED: f64 = 1.0 / 128.0;

/// Pivots that are replaced, at most. Where a body is crushed thousands are negative, and
/// a direction that leaves them alone leads nowhere.
const FEW: usize = 100;

/// The supernodes of a factor as a tree.
#[derive(Default)]
pub struct Fronts {
    pub(super) supernodes: Vec<Supernode>,
    pub(super) roots: Vec<usize>,
    /// Entries of A in each supernode.
    entries: Vec<Run>,
}

/// F₂₂ − L₂₁ L₂₁ᵀ of a supernode: a square by columns, of which the lower
/// triangle has meaning, and what the buffer is longer.
struct Update<T> {
    supernode: usize,
    values: Vec<T>,
}

impl Fronts {
    /// The tree of supernodes, given by their columns and the rows below, for a lower triangle
    /// in compressed columns, with the unknown i at `position[i]`.
    pub fn new(
        structure: Vec<(Range<usize>, Vec<usize>)>,
        pattern: &Triangle,
        position: &[u32],
    ) -> Self {
        let count = structure.len();
        let mut of_column = vec![0; position.len()];
        let mut supernodes: Vec<Supernode> = Vec::with_capacity(count);
        let mut stored = 0;
        for (s, (columns, pattern)) in structure.into_iter().enumerate() {
            of_column[columns.clone()].fill(s);
            let end = stored + columns.len() * (columns.len() + pattern.len());
            supernodes.push(Supernode {
                columns,
                pattern,
                places: Vec::new(),
                children: Vec::new(),
                first: s,
                values: stored..end,
                entries: 0..0,
                work: 0.0,
            });
            stored = end;
        }
        let mut roots = Vec::new();
        for s in 0..count {
            let (width, below) = (supernodes[s].width() as f64, supernodes[s].pattern.len() as f64);
            supernodes[s].work += width * (width * width / 3.0 + width * below + below * below);
            let (work, first) = (supernodes[s].work, supernodes[s].first);
            match supernodes[s].pattern.first() {
                Some(&row) => {
                    let parent = &mut supernodes[of_column[row]];
                    parent.children.push(s);
                    parent.work += work;
                    parent.first = parent.first.min(first);
                }
                None => roots.push(s),
            }
        }
        for s in &supernodes {
            let mut next = s.first;
            for &child in &s.children {
                assert_eq!(supernodes[child].first, next, "columns in postorder");
                next = child + 1;
            }
        }
        place_updates(&mut supernodes);
        let entries = place_entries(&mut supernodes, &of_column, pattern, position);
        Self { supernodes, roots, entries }
    }

    /// Number of stored entries of a factor.
    pub fn factor_len(&self) -> usize {
        self.supernodes.last().map_or(0, |s| s.values.end)
    }

    /// Floating-point operations of a factorisation.
    pub fn flops(&self) -> f64 {
        self.roots.iter().map(|&r| self.supernodes[r].work).sum()
    }

    /// Operations of the supernodes on the costliest way from a leaf to a root. They follow one
    /// another: subtrees on any number of threads take at least their time, and only threads
    /// within a front make it shorter.
    pub fn chain_flops(&self) -> f64 {
        let mut chains: Vec<f64> = Vec::with_capacity(self.supernodes.len());
        for s in &self.supernodes {
            let below: f64 = s.children.iter().map(|&c| self.supernodes[c].work).sum();
            let longest = s.children.iter().map(|&c| chains[c]).fold(0.0, f64::max);
            chains.push(s.work - below + longest);
        }
        chains.into_iter().fold(0.0, f64::max)
    }

    /// The pivots of a factor in the order of elimination.
    pub fn pivots<T: Scalar>(&self, factor: &[T]) -> impl Iterator<Item = T> {
        self.supernodes.iter().flat_map(|s| {
            let own = &factor[s.values.clone()];
            own.iter().step_by(s.height() + 1).take(s.width()).map(|&l| l * l)
        })
    }

    /// Numbers in the updates that wait at once, at most.
    pub fn updates_len(&self) -> usize {
        let update = |s: &Supernode| (s.height() - s.width()).pow(2);
        let mut peaks: Vec<usize> = Vec::with_capacity(self.supernodes.len());
        for s in &self.supernodes {
            let finished: usize = s.children.iter().map(|&c| update(&self.supernodes[c])).sum();
            // as many children as there are threads may be in progress
            let mut beyond: Vec<usize> =
                s.children.iter().map(|&c| peaks[c] - update(&self.supernodes[c])).collect();
            beyond.sort_unstable_by(|a, b| b.cmp(a));
            let running: usize = beyond.iter().take(rayon::current_num_threads()).sum();
            peaks.push(finished + running.max(update(s)));
        }
        self.roots.iter().map(|&r| peaks[r]).sum()
    }

    /// L of the matrix with the lower triangle `a`, in the layout of faer's
    /// supernodal factor, and the number of pivots that were replaced.
    pub fn factor<T: Scalar>(
        &self,
        a: &[f64],
        factor: &mut [T],
        pool: &Pool<T>,
        bad_pivots: BadPivots,
    ) -> Result<usize, usize> {
        let (failed, replaced) = (AtomicBool::new(false), AtomicUsize::new(0));
        let shared = SHARED * self.flops();
        let job = Job { fronts: self, a, pool, bad_pivots, shared, failed, replaced };
        job.subtrees(&self.roots, factor)?;
        Ok(job.replaced.into_inner())
    }
}

/// Finds the place of every row of an update in the parent's front.
fn place_updates(supernodes: &mut [Supernode]) {
    for parent in 0..supernodes.len() {
        for child in supernodes[parent].children.clone() {
            let front = &supernodes[parent];
            let mut below = front.pattern.iter().enumerate();
            let place = |&row: &usize| {
                if row < front.columns.end {
                    return narrow(row - front.columns.start);
                }
                let (i, _) =
                    below.find(|p| *p.1 == row).expect("a front holds the rows of its children");
                narrow(front.width() + i)
            };
            supernodes[child].places = supernodes[child].pattern.iter().map(place).collect();
        }
    }
}

/// One factorisation.
struct Job<'a, T> {
    fronts: &'a Fronts,
    a: &'a [f64],
    /// Memory of updates.
    pool: &'a Pool<T>,
    bad_pivots: BadPivots,
    /// Operations from which on threads share a front.
    shared: f64,
    /// Set by the first thread that meets a bad pivot, so that others stop.
    failed: AtomicBool,
    replaced: AtomicUsize,
}

impl<T: Scalar> Job<'_, T> {
    /// Factors disjoint subtrees, whose columns are stored one after the other.
    fn subtrees(&self, roots: &[usize], mut factor: &mut [T]) -> Result<Vec<Update<T>>, usize> {
        let mut tasks = Vec::with_capacity(roots.len());
        for &root in roots {
            let values = &self.fronts.supernodes;
            let len = values[root].values.end - values[values[root].first].values.start;
            let (own, others) = factor.split_at_mut(len);
            tasks.push((root, own));
            factor = others;
        }
        tasks.into_par_iter().map(|(root, own)| self.subtree(root, own)).collect()
    }

    fn subtree(&self, root: usize, factor: &mut [T]) -> Result<Update<T>, usize> {
        let s = &self.fronts.supernodes[root];
        if s.work < TASK {
            return self.in_order(s.first..root + 1, factor);
        }
        let (below, own) = factor.split_at_mut(factor.len() - s.values.len());
        let updates = self.subtrees(&s.children, below)?;
        let below: f64 = s.children.iter().map(|&c| self.fronts.supernodes[c].work).sum();
        let par = if s.work - below < self.shared { Par::Seq } else { Par::rayon(0) };
        self.eliminate(root, own, updates, par)
    }

    /// Factors one subtree on this thread.
    fn in_order(&self, range: Range<usize>, mut factor: &mut [T]) -> Result<Update<T>, usize> {
        let mut waiting: Vec<Update<T>> = Vec::new();
        for s in range {
            let node = &self.fronts.supernodes[s];
            let (own, others) = factor.split_at_mut(node.values.len());
            factor = others;
            let children = waiting.len() - node.children.len();
            let children = waiting.split_off(children);
            waiting.push(self.eliminate(s, own, children, Par::Seq)?);
        }
        Ok(waiting.pop().expect("a subtree is not empty"))
    }

    fn eliminate(
        &self,
        s: usize,
        own: &mut [T],
        updates: Vec<Update<T>>,
        par: Par,
    ) -> Result<Update<T>, usize> {
        let node = &self.fronts.supernodes[s];
        if self.failed.load(Ordering::Relaxed) {
            return Err(node.columns.start);
        }
        let (width, height) = (node.width(), node.height());
        let below = height - width;
        self.factor_top(node, own, &updates, par)?;
        let front = MatMut::from_column_major_slice_mut(own, height, width);
        let (top, mut bottom) = front.split_at_row_mut(width);
        let mut values = self.pool.at_least(below * below, T::narrow(0.0));
        if below > 0 {
            solve_lower_triangular_in_place(top.as_ref(), bottom.as_mut().transpose_mut(), par);
            let bottom = bottom.as_ref();
            by_blocks(&mut values[..below * below], below, par, |first, columns| {
                // the product comes first: it overwrites, so that nothing is to be cleared
                product(bottom, first, columns);
                self.add_updates(node, &updates, [width, width + first], columns);
            });
        }
        updates.into_iter().for_each(|update| self.pool.give(update.values));
        Ok(Update { supernode: s, values })
    }

    /// Adds up the columns of a front and factors F₁₁.
    fn factor_top(
        &self,
        node: &Supernode,
        own: &mut [T],
        updates: &[Update<T>],
        par: Par,
    ) -> Result<(), usize> {
        let scale = self.assemble_columns(node, own, updates, par);
        let (width, height) = (node.width(), node.height());
        let mut scratch =
            MemBuffer::new(cholesky_in_place_scratch::<T>(width, par, Spec::default()));
        let front = MatMut::from_column_major_slice_mut(&mut *own, height, width);
        let done = cholesky_in_place(
            front.subrows_mut(0, width),
            LltRegularization::default(),
            par,
            MemStack::new(&mut scratch),
            Spec::default(),
        );
        let Err(LltError::NonPositivePivot { index }) = done else { return Ok(()) };
        if self.bad_pivots == BadPivots::Refuse || scale.is_nan() || scale <= 0.0 {
            self.failed.store(true, Ordering::Relaxed);
            return Err(node.columns.start + index);
        }
        self.assemble_columns(node, own, updates, par);
        let front = MatMut::from_column_major_slice_mut(own, height, width);
        let replaced = replacing::cholesky(front.subrows_mut(0, width), scale, par);
        if self.replaced.fetch_add(replaced, Ordering::Relaxed) + replaced > FEW {
            self.failed.store(true, Ordering::Relaxed);
            return Err(node.columns.start + index);
        }
        Ok(())
    }

    /// Adds up F₁₁ and F₂₁ and returns the mean of the diagonal of A there.
    fn assemble_columns(
        &self,
        node: &Supernode,
        own: &mut [T],
        updates: &[Update<T>],
        par: Par,
    ) -> f64 {
        own.fill(T::narrow(0.0));
        for run in &self.fronts.entries[node.entries.clone()] {
            run.add(self.a, own, node.height());
        }
        let diagonal = own.iter().step_by(node.height() + 1).take(node.width());
        let mean = diagonal.map(|d| d.widen().abs()).sum::<f64>() / node.width() as f64;
        by_blocks(own, node.height(), par, |first, columns| {
            self.add_updates(node, updates, [0, first], columns);
        });
        mean
    }

    /// Adds the updates of children to a block of columns, whose first entry has the given row and
    /// column in the front.
    fn add_updates(
        &self,
        node: &Supernode,
        updates: &[Update<T>],
        [row, column]: [usize; 2],
        block: &mut [T],
    ) {
        let height = node.height() - row;
        let end = column + block.len() / height;
        for update in updates {
            let places = &self.fronts.supernodes[update.supernode].places;
            let before = |limit: usize| places.partition_point(|&p| (p as usize) < limit);
            let columns = before(column)..before(end);
            extend_add(places, &update.values, columns, block, height, [row, column]);
        }
    }
}

/// Goes through the columns of a height by blocks that stay in the cache, on all threads or on
/// this one.
fn by_blocks<T: Scalar>(
    columns: &mut [T],
    height: usize,
    par: Par,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    let work = |(i, block): (usize, &mut [T])| work(i * BLOCK, block);
    if matches!(par, Par::Seq) {
        columns.chunks_mut(BLOCK * height).enumerate().for_each(work);
    } else {
        columns.par_chunks_mut(BLOCK * height).enumerate().for_each(work);
    }
}

/// Some columns of the lower triangle of − L Lᵀ, which begin with the column `first`.
fn product<T: Scalar>(l: MatRef<'_, T>, first: usize, columns: &mut [T]) {
    let height = l.nrows();
    let count = columns.len() / height;
    let columns = MatMut::from_column_major_slice_mut(columns, height, count);
    let (_, columns) = columns.split_at_row_mut(first);
    let (diagonal, below) = columns.split_at_row_mut(count);
    let own = l.subrows(first, count);
    let minus = T::narrow(-1.0);
    triangular_matmul(
        diagonal,
        BlockStructure::TriangularLower,
        Accum::Replace,
        own,
        BlockStructure::Rectangular,
        own.transpose(),
        BlockStructure::Rectangular,
        minus,
        Par::Seq,
    );
    let others = l.subrows(first + count, height - first - count);
    matmul(below, Accum::Replace, others, own.transpose(), minus, Par::Seq);
}
