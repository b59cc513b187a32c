//! Gas in a chamber: its energy depends on the volume alone.
//!
//! E(u; X) = Φ(V(x); V₀),   V₀ = V(X),   x = ΠX + u,   pressure P = −Φ'
//!
//! ∂E/∂u   = Φ' ∂V/∂u
//! ∂²E/∂u² = P S + Φ'' (∂V/∂u)(∂V/∂u)ᵀ
//!
//! Φ is that of one of the laws in [`gas_law`](super::gas_law). The pressure acts on the
//! deformed wall and turns with it: a follower load. The one parameter is the number that
//! the law follows over time ([`GasLaw::schedule`]), at the iterate's load. The dense
//! second term is never assembled, see [`Energy::rank_one`].

use mesh::Vec3;

use super::gas_law::{GasLaw, Potential};
use super::wall::{Wall, positions, rest_positions};
use super::{Constraint, Energy, Hessian, Iterate, Multiplier, RankOne};
use crate::element::at;
use crate::math::linear::dot;
use crate::math::sparse::BlockMatrix;

/// A chamber with gas.
#[derive(Clone)]
pub struct Chamber {
    /// The wall.
    pub wall: Wall,
    /// The gas.
    pub gas: Box<dyn GasLaw>,
    /// Index of its multiplier, if the law prescribes the volume.
    pub multiplier: Option<usize>,
}

impl Chamber {
    /// Volume [m³] and gas at an iterate.
    #[must_use]
    pub fn state(&self, iterate: &Iterate) -> (f64, Potential) {
        self.state_at(iterate, positions(iterate))
    }

    fn state_at(&self, iterate: &Iterate, x: impl Fn(usize) -> Vec3 + Sync) -> (f64, Potential) {
        let volume = self.wall.volume(iterate.space, x);
        let multiplier =
            self.multiplier.map_or_else(Multiplier::default, |i| iterate.multipliers[i]);
        (volume, self.gas.at(volume, self.rest_volume(iterate), iterate.time, multiplier))
    }

    /// Adds P λᵀ S at the nodes [N/m]: λᵀ ∂²E/∂u² at fixed pressure.
    pub fn add_stiffness_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        self.wall.add_stiffness_vjp(iterate.space, x, lambda, gas.pressure, out);
    }

    /// Volume behind the rest wall [m³].
    #[must_use]
    pub fn rest_volume(&self, iterate: &Iterate) -> f64 {
        self.wall.volume(iterate.space, rest_positions(iterate))
    }

    /// Adds μ_i ∂(V − V*)/∂X of the volume i that it prescribes, three components per
    /// vertex; the result is μ_i ∂(V − V*)/∂p for the number that prescribes it.
    pub fn constraint_vjp(&self, iterate: &Iterate, mu: &[f64], out: &mut [f64]) -> Option<f64> {
        let mu = mu[self.multiplier?];
        let wanted = self.gas.wanted(self.rest_volume(iterate), iterate.time)?;
        self.wall.add_volume_gradient(iterate.space, positions(iterate), mu, out);
        let rest = rest_positions(iterate);
        self.wall.add_volume_gradient(iterate.space, rest, -mu * wanted.by_rest, out);
        Some(-mu * wanted.by_parameter)
    }
}

impl Energy for Chamber {
    fn name(&self) -> &'static str {
        "chamber"
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        self.state(iterate).1.value
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        self.wall.add_wall_gradient(iterate.space, x, -gas.pressure, out);
    }

    fn add_hessian(&self, iterate: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        // how the pressure turns with its wall softens some motions as it stiffens others
        if kind == Hessian::Projected {
            return;
        }
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        self.wall.add_stiffness(iterate.space, x, gas.pressure, out);
    }

    fn couplings(&self, iterate: &Iterate, _reach: f64) -> Vec<[usize; 2]> {
        self.wall.couplings(iterate.space)
    }

    fn rank_one(&self, iterate: &Iterate) -> Option<RankOne> {
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        if gas.stiffness == 0.0 {
            return None;
        }
        let mut vector = vec![0.0; iterate.u.len()];
        self.wall.add_wall_gradient(iterate.space, x, 1.0, &mut vector);
        Some(RankOne { scale: gas.stiffness, vector })
    }

    fn constraint(&self, iterate: &Iterate) -> Option<Constraint> {
        let multiplier = self.multiplier?;
        let wanted = self.gas.wanted(self.rest_volume(iterate), iterate.time)?.volume;
        let x = positions(iterate);
        let volume = self.wall.volume(iterate.space, x);
        let mut gradient = vec![0.0; iterate.u.len()];
        self.wall.add_wall_gradient(iterate.space, x, 1.0, &mut gradient);
        Some(Constraint { multiplier, volume, wanted, gradient })
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        // x = ΠX + u: the mixed derivative at fixed pressure is P S Π
        let mut nodal = vec![0.0; iterate.u.len()];
        self.add_stiffness_vjp(iterate, lambda, &mut nodal);
        iterate.space.add_to_vertices(&nodal, out);
        if gas.stiffness == 0.0 {
            return;
        }
        // and X changes the pressure through both volumes
        let mut gradient = vec![0.0; iterate.u.len()];
        self.wall.add_wall_gradient(iterate.space, x, 1.0, &mut gradient);
        let along: f64 =
            (0..iterate.space.node_count()).map(|i| at(&gradient, i).dot(&at(lambda, i))).sum();
        self.wall.add_volume_gradient(iterate.space, x, gas.stiffness * along, out);
        let rest = rest_positions(iterate);
        self.wall.add_volume_gradient(iterate.space, rest, -gas.pressure_by_rest * along, out);
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let x = positions(iterate);
        let volume = self.wall.volume(iterate.space, x);
        let Some(by) = self.gas.pressure_by_parameter(volume, self.rest_volume(iterate)) else {
            return Vec::new();
        };
        let mut gradient = vec![0.0; iterate.u.len()];
        self.wall.add_wall_gradient(iterate.space, x, -by, &mut gradient);
        vec![dot(&gradient, lambda)]
    }
}
