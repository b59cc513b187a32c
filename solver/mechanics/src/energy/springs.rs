//! Springs that pull released supports to their places b, the augmented Lagrangian of
//! Dirichlet conditions.
//!
//! E(u) = Σ_i λ_i (u_i − b_i) + ½ k_i (u_i − b_i)²      i released degrees of freedom
//!
//! λ   multipliers [N], which the method of multipliers renews
//! k   stiffness [N/m]

use super::{Energy, Hessian, Iterate, Nature};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::Mat3;

/// What pulls released degrees of freedom to their places.
#[derive(Clone, Debug, Default)]
pub struct Springs(Vec<Spring>);

/// What pulls one degree of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    /// Degree of freedom i.
    pub dof: usize,
    /// b [m].
    pub place: f64,
    /// k [N/m].
    pub stiffness: f64,
    /// λ [N].
    pub force: f64,
}

impl Springs {
    /// At most one for each degree of freedom.
    pub fn new(springs: Vec<Spring>) -> Self {
        Self(springs)
    }

    /// All of them.
    pub fn each(&self) -> &[Spring] {
        &self.0
    }

    /// Length [m] and pull [N] of each spring, with it.
    fn pulls<'a>(&'a self, u: &'a [f64]) -> impl Iterator<Item = (&'a Spring, f64, f64)> {
        self.0.iter().map(|s| {
            let length = u[s.dof] - s.place;
            (s, length, s.force + s.stiffness * length)
        })
    }

    /// Length of the longest [m].
    pub fn longest(&self, u: &[f64]) -> f64 {
        self.pulls(u).map(|(_, length, _)| length.abs()).fold(0.0, f64::max)
    }

    /// The displacement u with the degrees of freedom at their places [m].
    pub fn placed(&self, u: &[f64]) -> Vec<f64> {
        let mut placed = u.to_vec();
        self.0.iter().for_each(|s| placed[s.dof] = s.place);
        placed
    }

    /// λ ← λ + k (u − b), then k ← `growth` k.
    pub fn renewed(&self, u: &[f64], growth: f64) -> Self {
        let renewed = |spring: &Spring| Spring {
            force: spring.force + spring.stiffness * (u[spring.dof] - spring.place),
            stiffness: spring.stiffness * growth,
            ..*spring
        };
        Self(self.0.iter().map(renewed).collect())
    }
}

impl Energy for Springs {
    fn kind(&self) -> (&'static str, Nature) {
        ("springs", Nature::Load)
    }

    fn value(&self, at: &Iterate) -> f64 {
        self.pulls(at.u).map(|(s, length, pull)| 0.5 * (s.force + pull) * length).sum()
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        self.pulls(at.u).for_each(|(s, _, pull)| out[s.dof] += pull);
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        for spring in &self.0 {
            let (node, axis) = (spring.dof / 3, spring.dof % 3);
            let mut block = Mat3::zeros();
            block[(axis, axis)] = spring.stiffness;
            out.add_lower(node, node, &block);
        }
    }

    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {}
}
