//! The direct solver of bodies: multifrontal Cholesky factorisation, and L B Lᵀ where a matrix is
//! not positive definite.

use std::array::from_fn;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::direct::{BadPivots, Cost, Memory, Pivot, Precision};
use super::indefinite::Indefinite;
use super::matrix::{PIECE, Triangle, norm};
use super::multifrontal::Fronts;
use super::rows::{Row, SYSTEMS};
use super::scalar::{Scalar, narrow};
use super::several::{dots, one_of};
use super::symbolic::{Symbolic, symbolic};
use crate::math::pool::Pool;

/// The symbolic factorisation of a pattern.
pub struct Multifrontal {
    pattern: Arc<Triangle>,
    tree: Arc<Tree>,
    memory: Memory,
}

/// What a factor needs to be applied.
pub struct Tree {
    fronts: Fronts,
    /// The unknown at each position of the factor.
    order: Vec<usize>,
    /// The position of each unknown.
    position: Vec<u32>,
}

impl Multifrontal {
    /// Factors a pattern symbolically, with the memory of an earlier one. Unknowns of a group are coupled with each
    /// other and with the same others; groups come in the order of elimination, up to changes that leave the fill alone.
    pub fn new(pattern: &Arc<Triangle>, groups: &[Range<usize>], memory: &Memory) -> Self {
        let Symbolic { order, supernodes } = symbolic(pattern, groups);
        let mut position = vec![0; order.len()];
        order.iter().enumerate().for_each(|(i, &unknown)| position[unknown] = narrow(i));
        let fronts = Fronts::new(supernodes, pattern, &position);
        let tree = Arc::new(Tree { fronts, order, position });
        Self { pattern: Arc::clone(pattern), tree, memory: memory.clone() }
    }

    /// Room for a factor in single precision.
    fn room(&self) -> Vec<f32> {
        let len = self.tree.fronts.factor_len();
        self.memory.take_factor(len).unwrap_or_else(|| {
            // pages of new memory are cleared where they are first written: in parallel
            let mut values = Vec::new();
            let zeros = rayon::iter::repeat_n(0.0, len);
            zeros.with_min_len(1 << 16).collect_into_vec(&mut values);
            values
        })
    }

    /// What a factorisation takes.
    pub fn cost(&self) -> Cost {
        let fronts = &self.tree.fronts;
        let entries = fronts.factor_len();
        Cost {
            entries,
            flops: fronts.flops(),
            chain_flops: fronts.chain_flops(),
            bytes: size_of::<f32>() * (entries + fronts.updates_len()),
        }
    }

    /// L Lᵀ = A, or A + E with E at a few replaced pivots, and the number of these. `lower` are
    /// the values of the lower triangle.
    pub fn factor_positive(
        &self,
        lower: &[f64],
        precision: Precision,
        bad_pivots: BadPivots,
    ) -> Result<(Factor, usize), usize> {
        let (tree, memory) = (Arc::clone(&self.tree), self.memory.clone());
        let fronts = &self.tree.fronts;
        match precision {
            Precision::Single => {
                let mut values = InSingle { values: self.room(), memory };
                let updates = &self.memory.updates;
                let replaced = fronts.factor(lower, &mut values.values, updates, bad_pivots)?;
                Ok((Factor::Single { tree, values }, replaced))
            }
            Precision::Double => {
                memory.drop_factors();
                let mut values = vec![0.0; fronts.factor_len()];
                let replaced = fronts.factor(lower, &mut values, &Pool::default(), bad_pivots)?;
                Ok((Factor::Double { tree, values }, replaced))
            }
        }
    }

    /// L B Lᵀ = A for any symmetric A.
    pub fn factor_indefinite(&self, lower: &[f64]) -> Factor {
        self.memory.drop_factors();
        Factor::Indefinite(Indefinite::new(&self.pattern, &self.tree.order, lower))
    }
}

impl Tree {
    fn smallest_pivot<T: Scalar>(&self, values: &[T]) -> Option<Pivot> {
        let pivots: Vec<f64> = self.fronts.pivots(values).map(Scalar::widen).collect();
        let (position, &value) = pivots.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let largest = pivots.iter().fold(0.0_f64, |m, &p| m.max(p));
        Some(Pivot { value, largest, unknown: self.order[position] })
    }

    /// x ← scale A⁻¹ x / scale.
    fn apply_inverse<T: Scalar>(&self, values: &[T], x: &mut [f64], scale: f64) {
        let order = self.order.par_iter().with_min_len(PIECE);
        let mut y: Vec<T> = order.map(|&i| T::narrow(x[i] / scale)).collect();
        self.fronts.solve(values, &mut y);
        let position = self.position.par_iter().with_min_len(PIECE);
        x.par_iter_mut().zip(position).for_each(|(x, &at)| *x = scale * y[at as usize].widen());
    }

    /// X ← A⁻¹ X of several systems, each scaled as [`Self::apply_inverse`] has it.
    fn apply_inverse_all<T: Scalar>(&self, values: &[T], x: &mut [Row<f64>], scale: Row<f64>) {
        let least = PIECE / SYSTEMS;
        let narrow = |&i: &usize| Row(from_fn(|k| T::narrow(x[i].0[k] / scale.0[k])));
        let mut y: Vec<Row<T>> = self.order.par_iter().with_min_len(least).map(narrow).collect();
        self.fronts.solve(values, &mut y);
        let pairs = x.par_iter_mut().zip(&self.position).with_min_len(least);
        pairs.for_each(|(x, &at)| {
            *x = Row(from_fn(|k| scale.0[k] * y[at as usize].0[k].widen()));
        });
    }
}

/// A factored matrix.
#[allow(clippy::large_enum_variant, reason = "there are few, and each has vectors of millions")]
pub enum Factor {
    /// L Lᵀ in single precision.
    Single { tree: Arc<Tree>, values: InSingle },
    /// L Lᵀ in double precision.
    Double { tree: Arc<Tree>, values: Vec<f64> },
    /// L B Lᵀ.
    Indefinite(Indefinite),
}

/// The values of a factor in single precision, whose memory goes to the next.
pub struct InSingle {
    values: Vec<f32>,
    memory: Memory,
}

impl Drop for InSingle {
    fn drop(&mut self) {
        self.memory.leave_factor(std::mem::take(&mut self.values));
    }
}

impl Factor {
    /// x ← A⁻¹ x, with the precision of the factor.
    pub fn apply_inverse(&self, x: &mut [f64]) {
        match self {
            Self::Single { tree, values } => {
                // so that no residual is too small for single precision
                let scale = norm(x).max(f64::MIN_POSITIVE);
                tree.apply_inverse(&values.values, x, scale);
            }
            Self::Double { tree, values } => tree.apply_inverse(values, x, 1.0),
            Self::Indefinite(factor) => factor.apply_inverse(x),
        }
    }

    /// X ← A⁻¹ X of several systems side by side.
    pub fn apply_inverse_all(&self, x: &mut [Row<f64>]) {
        match self {
            Self::Single { tree, values } => {
                let scale = dots(x, x).0.map(|square| square.sqrt().max(f64::MIN_POSITIVE));
                tree.apply_inverse_all(&values.values, x, Row(scale));
            }
            Self::Double { tree, values } => {
                tree.apply_inverse_all(values, x, Row([1.0; SYSTEMS]));
            }
            Self::Indefinite(factor) => {
                for k in 0..SYSTEMS {
                    let mut one = one_of(x, k);
                    factor.apply_inverse(&mut one);
                    x.iter_mut().zip(one).for_each(|(row, x)| row.0[k] = x);
                }
            }
        }
    }

    /// The smallest pivot of L Lᵀ; none of other factors.
    pub fn smallest_pivot(&self) -> Option<Pivot> {
        match self {
            Self::Single { tree, values } => tree.smallest_pivot(&values.values),
            Self::Double { tree, values } => tree.smallest_pivot(values),
            Self::Indefinite(_) => None,
        }
    }

    /// Number of negative eigenvalues of the matrix, by the law of inertia; 0 of L Lᵀ.
    pub fn negative_eigenvalues(&self) -> usize {
        match self {
            Self::Single { .. } | Self::Double { .. } => 0,
            Self::Indefinite(factor) => factor.negative_eigenvalues(),
        }
    }
}
