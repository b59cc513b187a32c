//! Columns of a factor that have the same rows below them.

use std::ops::Range;

use super::columns::Columns;
use super::scalar::Scalar;

/// A node of the tree of fronts.
pub struct Supernode {
    /// Positions of its columns in the factor.
    pub columns: Range<usize>,
    /// Rows below its own, ascending.
    pub pattern: Vec<usize>,
    /// Places of these rows in the front of its parent.
    pub places: Vec<u32>,
    /// Supernodes whose updates enter its front.
    pub children: Vec<usize>,
    /// First supernode of its subtree, which ends with itself.
    pub first: usize,
    /// Where its columns are stored in the factor.
    pub values: Range<usize>,
    /// Which of the runs of entries of A are added to its front.
    pub entries: Range<usize>,
    /// Floating-point operations of its subtree.
    pub work: f64,
}

impl Supernode {
    /// Number of its columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// Number of the rows of its front.
    pub fn height(&self) -> usize {
        self.width() + self.pattern.len()
    }

    /// L₁₁ over L₂₁ in its part of the factor.
    pub fn front<'a, T: Scalar>(&self, own: &'a [T]) -> Columns<'a, T> {
        Columns::new(own, self.height())
    }
}
