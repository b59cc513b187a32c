//! Dirichlet conditions (essential boundary conditions): degrees of freedom that are
//! fixed, at zero or at a displacement that follows the load. They are eliminated, and so
//! are those of nodes that follow others ([`RigidSet`]): only the rest are unknowns.
//!
//! u = T q + what is prescribed      restrict: Tᵀ of forces, prolong: T of unknowns

use std::sync::Arc;

use crate::math::sparse::Followers;
use crate::rigid::RigidSet;

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
    /// The others, but for those that follow: the unknowns.
    free: Vec<usize>,
    /// Nodes that follow others.
    followers: Arc<Followers>,
    /// How the fixed ones move, if they do.
    motion: Option<Motion>,
}

impl Dirichlet {
    /// Fixed at zero; `fixed` has one entry per degree of freedom.
    pub fn new(fixed: &[bool]) -> Self {
        let (supports, free) = (0..fixed.len()).partition(|&dof| fixed[dof]);
        Self { fixed: fixed.to_vec(), supports, free, followers: Arc::default(), motion: None }
    }

    /// These conditions with parts that are rigid, which have no node in common.
    pub fn with_rigid(self, parts: &[RigidSet]) -> Self {
        let followers = parts.iter().flat_map(|part| {
            part.followers().iter().map(|(node, weights)| {
                (*node, part.masters().iter().copied().zip(weights.iter().copied()).collect())
            })
        });
        let followers = Followers::new(self.fixed.len() / 3, followers.collect());
        self.following(Arc::new(followers))
    }

    fn following(self, followers: Arc<Followers>) -> Self {
        let free = self.free.into_iter().filter(|dof| !followers.has(dof / 3)).collect();
        Self { free, followers, ..self }
    }

    /// These conditions with supports that move.
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion: Some(motion), ..self }
    }

    /// These conditions with other degrees of freedom fixed.
    pub fn with_fixed(&self, fixed: &[bool]) -> Self {
        let conditions = Self::new(fixed).following(Arc::clone(&self.followers));
        Self { motion: self.motion.clone(), ..conditions }
    }

    /// Nodes that follow others.
    pub fn followers(&self) -> &Followers {
        &self.followers
    }

    /// Whether each degree of freedom is none of the unknowns.
    pub fn eliminated(&self) -> Vec<bool> {
        let mut eliminated = vec![true; self.fixed.len()];
        self.free.iter().for_each(|&dof| eliminated[dof] = false);
        eliminated
    }

    /// Whether each degree of freedom is fixed.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Fixed degrees of freedom, ascending.
    pub fn supports(&self) -> &[usize] {
        &self.supports
    }

    /// The degree of freedom of each unknown, ascending.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Whether supports may move.
    pub fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Displacement of the fixed degrees of freedom at a time [m]; entries of the
    /// others mean nothing.
    pub fn displacement(&self, time: f64) -> Vec<f64> {
        self.motion.as_ref().map_or_else(|| vec![0.0; self.fixed.len()], |motion| motion(time))
    }

    /// The unknowns in a displacement of all degrees of freedom.
    pub fn unknowns(&self, full: &[f64]) -> Vec<f64> {
        self.free.iter().map(|&dof| full[dof]).collect()
    }

    /// Forces on the unknowns from those on all degrees of freedom.
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        if self.followers.is_empty() {
            return self.unknowns(full);
        }
        let mut onto_masters = full.to_vec();
        self.followers.add_to_masters(&mut onto_masters);
        self.unknowns(&onto_masters)
    }

    /// Motion of all degrees of freedom from that of the unknowns, zero where fixed.
    pub fn prolong(&self, free: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.fixed.len()];
        self.free.iter().zip(free).for_each(|(&dof, &value)| full[dof] = value);
        self.followers.follow(&mut full);
        full
    }
}
