//! What stands at a position of a vector: a number, or a number of each of several systems.

use super::columns::Columns;
use super::rows::{Row, Work, substitute};
use super::scalar::Scalar;

/// One unknown, of one system or of several.
pub trait Unknown<T>: Copy + Send + Sync {
    /// 0.
    fn zero() -> Self;
    /// `self` + x.
    fn plus(self, x: Self) -> Self;
    /// x₁ ← L₁₁⁻¹ x₁ and x₂ ← x₂ − L₂₁ x₁, as [`Columns::forward`] has it.
    fn forward(columns: Columns<'_, T>, row: usize, x: &mut [Self]);
    /// x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂).
    fn backward(columns: Columns<'_, T>, row: usize, x: &mut [Self]);
    /// y ← y − L x.
    fn subtract(columns: Columns<'_, T>, row: usize, x: &[Self], y: &mut [Self]);
    /// x ← x − Lᵀ y.
    fn subtract_transposed(columns: Columns<'_, T>, row: usize, y: &[Self], x: &mut [Self]);
}

impl<T: Scalar> Unknown<T> for T {
    fn zero() -> Self {
        T::narrow(0.0)
    }

    fn plus(self, x: Self) -> Self {
        self + x
    }

    fn forward(columns: Columns<'_, T>, row: usize, x: &mut [Self]) {
        columns.forward(row, x);
    }

    fn backward(columns: Columns<'_, T>, row: usize, x: &mut [Self]) {
        columns.backward(row, x);
    }

    fn subtract(columns: Columns<'_, T>, row: usize, x: &[Self], y: &mut [Self]) {
        columns.subtract(row, x, y);
    }

    fn subtract_transposed(columns: Columns<'_, T>, row: usize, y: &[Self], x: &mut [Self]) {
        columns.subtract_transposed(row, y, x);
    }
}

impl<T: Scalar> Unknown<T> for Row<T> {
    fn zero() -> Self {
        Self::zero()
    }

    fn plus(self, x: Self) -> Self {
        self.plus(T::narrow(1.0), x)
    }

    fn forward(columns: Columns<'_, T>, row: usize, x: &mut [Self]) {
        substitute(columns, row, Work::Forward(x));
    }

    fn backward(columns: Columns<'_, T>, row: usize, x: &mut [Self]) {
        substitute(columns, row, Work::Backward(x));
    }

    fn subtract(columns: Columns<'_, T>, row: usize, x: &[Self], y: &mut [Self]) {
        substitute(columns, row, Work::Subtract { x, y });
    }

    fn subtract_transposed(columns: Columns<'_, T>, row: usize, y: &[Self], x: &mut [Self]) {
        substitute(columns, row, Work::SubtractTransposed { y, x });
    }
}
