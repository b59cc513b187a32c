//! The direct solver of bodies: multifrontal Cholesky factorisation, and L B Lᵀ where a matrix is
//! not positive definite.

use std::array::from_fn;
use std::sync::Arc;

use rayon::prelude::*;

use super::direct::{BadPivots, Cost, DirectSolver, Factor, Memory, Pivot, Precision, Structure};
use super::indefinite::Indefinite;
use super::matrix::{PIECE, Triangle, norm};
use super::multifrontal::Fronts;
use super::rows::{Row, SYSTEMS};
use super::scalar::{Scalar, narrow};
use super::several::dots;
use super::symbolic::{Symbolic, symbolic};
use crate::math::pool::Pool;

/// The symbolic factorisation of a pattern.
pub struct Multifrontal {
    pattern: Arc<Triangle>,
    tree: Arc<Tree>,
    memory: Memory,
}

/// What a factor needs to be applied.
struct Tree {
    fronts: Fronts,
    /// The unknown at each position of the factor.
    order: Vec<usize>,
    /// The position of each unknown.
    position: Vec<u32>,
}

impl Multifrontal {
    /// Factors a pattern symbolically.
    ///
    /// # Panics
    /// When the groups are not all unknowns, each once, when unknowns of a group have different
    /// neighbours, or when memory runs out.
    pub fn boxed(structure: &Structure) -> Box<dyn DirectSolver> {
        let Structure { pattern, groups, memory } = structure;
        let Symbolic { order, supernodes } = symbolic(pattern, groups);
        let mut position = vec![0; order.len()];
        order.iter().enumerate().for_each(|(i, &unknown)| position[unknown] = narrow(i));
        let fronts = Fronts::new(supernodes, pattern, &position);
        let (pattern, memory) = (Arc::clone(pattern), (*memory).clone());
        Box::new(Self { pattern, tree: Arc::new(Tree { fronts, order, position }), memory })
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

    fn factor_single(
        &self,
        lower: &[f64],
        bad_pivots: BadPivots,
    ) -> Result<(Single, usize), usize> {
        let (tree, memory) = (Arc::clone(&self.tree), self.memory.clone());
        let mut factor = Single { tree, memory, values: self.room() };
        let fronts = &self.tree.fronts;
        let replaced =
            fronts.factor(lower, &mut factor.values, &self.memory.updates, bad_pivots)?;
        Ok((factor, replaced))
    }

    fn factor_double(
        &self,
        lower: &[f64],
        bad_pivots: BadPivots,
    ) -> Result<(Double, usize), usize> {
        self.memory.drop_factors();
        let mut values = vec![0.0; self.tree.fronts.factor_len()];
        let replaced = self.tree.fronts.factor(lower, &mut values, &Pool::default(), bad_pivots)?;
        Ok((Double { tree: Arc::clone(&self.tree), values }, replaced))
    }
}

impl DirectSolver for Multifrontal {
    fn cost(&self) -> Cost {
        let fronts = &self.tree.fronts;
        let entries = fronts.factor_len();
        Cost {
            entries,
            flops: fronts.flops(),
            chain_flops: fronts.chain_flops(),
            bytes: size_of::<f32>() * (entries + fronts.updates_len()),
        }
    }

    fn factor_positive(
        &self,
        lower: &[f64],
        precision: Precision,
        bad_pivots: BadPivots,
    ) -> Result<(Box<dyn Factor>, usize), usize> {
        Ok(match precision {
            Precision::Single => {
                let (factor, replaced) = self.factor_single(lower, bad_pivots)?;
                (Box::new(factor), replaced)
            }
            Precision::Double => {
                let (factor, replaced) = self.factor_double(lower, bad_pivots)?;
                (Box::new(factor), replaced)
            }
        })
    }

    fn factor_indefinite(&self, lower: &[f64]) -> Box<dyn Factor> {
        self.memory.drop_factors();
        Box::new(Indefinite::new(&self.pattern, &self.tree.order, lower))
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

/// L in single precision.
struct Single {
    tree: Arc<Tree>,
    values: Vec<f32>,
    memory: Memory,
}

impl Factor for Single {
    fn apply_inverse(&self, x: &mut [f64]) {
        // so that no residual is too small for single precision
        let scale = norm(x).max(f64::MIN_POSITIVE);
        self.tree.apply_inverse(&self.values, x, scale);
    }

    fn apply_inverse_all(&self, x: &mut [Row<f64>]) {
        let scale = dots(x, x).0.map(|square| square.sqrt().max(f64::MIN_POSITIVE));
        self.tree.apply_inverse_all(&self.values, x, Row(scale));
    }

    fn smallest_pivot(&self) -> Option<Pivot> {
        self.tree.smallest_pivot(&self.values)
    }
}

impl Drop for Single {
    fn drop(&mut self) {
        self.memory.leave_factor(std::mem::take(&mut self.values));
    }
}

/// L in double precision.
struct Double {
    tree: Arc<Tree>,
    values: Vec<f64>,
}

impl Factor for Double {
    fn apply_inverse(&self, x: &mut [f64]) {
        self.tree.apply_inverse(&self.values, x, 1.0);
    }

    fn apply_inverse_all(&self, x: &mut [Row<f64>]) {
        self.tree.apply_inverse_all(&self.values, x, Row([1.0; SYSTEMS]));
    }

    fn smallest_pivot(&self) -> Option<Pivot> {
        self.tree.smallest_pivot(&self.values)
    }
}
