//! Dirichlet conditions (essential boundary conditions): degrees of freedom that are
//! fixed, at zero or at a displacement that follows the load. They are eliminated: only
//! the other degrees of freedom are unknowns.

use std::sync::Arc;

/// Displacement [m] of all degrees of freedom at a time; only those of the fixed
/// ones are used.
pub type Motion = Arc<dyn Fn(f64) -> Vec<f64> + Send + Sync>;

/// Which degrees of freedom are fixed, and how they move.
#[derive(Clone)]
pub struct Dirichlet {
    /// Whether each degree of freedom is fixed.
    fixed: Vec<bool>,
    /// Fixed degrees of freedom.
    supports: Vec<usize>,
    /// The others: the unknowns.
    free: Vec<usize>,
    /// How the fixed ones move, if they do.
    motion: Option<Motion>,
}

impl Dirichlet {
    /// Fixed at zero; `fixed` has one entry per degree of freedom.
    #[must_use]
    pub fn new(fixed: &[bool]) -> Self {
        let (supports, free) = (0..fixed.len()).partition(|&dof| fixed[dof]);
        Self { fixed: fixed.to_vec(), supports, free, motion: None }
    }

    /// These conditions with supports that move.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion: Some(motion), ..self }
    }

    /// These conditions with other degrees of freedom fixed.
    #[must_use]
    pub fn with_fixed(&self, fixed: &[bool]) -> Self {
        Self { motion: self.motion.clone(), ..Self::new(fixed) }
    }

    /// Whether each degree of freedom is fixed.
    #[must_use]
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Fixed degrees of freedom, ascending.
    #[must_use]
    pub fn supports(&self) -> &[usize] {
        &self.supports
    }

    /// The degree of freedom of each unknown, ascending.
    #[must_use]
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Whether supports may move.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Displacement of the fixed degrees of freedom at a time [m]; entries of the
    /// others mean nothing.
    #[must_use]
    pub fn displacement(&self, time: f64) -> Vec<f64> {
        self.motion.as_ref().map_or_else(|| vec![0.0; self.fixed.len()], |motion| motion(time))
    }

    /// The free part of a vector over all degrees of freedom.
    #[must_use]
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        self.free.iter().map(|&dof| full[dof]).collect()
    }

    /// A vector over all degrees of freedom from its free part, zero where fixed.
    #[must_use]
    pub fn prolong(&self, free: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.fixed.len()];
        self.free.iter().zip(free).for_each(|(&dof, &value)| full[dof] = value);
        full
    }
}
