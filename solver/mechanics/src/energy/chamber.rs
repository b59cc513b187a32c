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
//!
//! A law may remember its gas: the one internal variable of the chamber is then the amount above that at
//! rest, M = (p_a + P) V − p_a V₀ [J].

use mesh::Vec3;

use super::gas_law::{GasLaw, Moment, Past, Potential};
use super::wall::{Wall, positions, rest_positions};
use super::{
    Constraint, Energy, Hessian, InternalCotangent, InternalVariables, Iterate, Nature,
    PastCotangent, RankOne,
};
use crate::element::FunctionSpace;
use crate::math::linear::dot;
use crate::math::sparse::BlockMatrix;

/// A chamber with gas.
#[derive(Clone)]
pub struct Chamber {
    /// What users call it.
    pub name: String,
    /// The wall.
    pub wall: Wall,
    /// The gas.
    pub gas: Box<dyn GasLaw>,
    /// Index of its multiplier, if the law prescribes the volume.
    pub multiplier: Option<usize>,
    /// Place of its gas among all internal variables, if the law remembers it and the scene goes through time.
    pub memory: Option<usize>,
}

impl Chamber {
    /// A chamber without a name, whose gas has no multiplier and no memory.
    pub fn new(wall: Wall, gas: Box<dyn GasLaw>) -> Self {
        Self { name: String::new(), wall, gas, multiplier: None, memory: None }
    }

    /// Volume [m³] and gas at an iterate.
    pub fn state(&self, iterate: &Iterate) -> (f64, Potential) {
        self.state_at(iterate, positions(iterate))
    }

    fn state_at(&self, iterate: &Iterate, x: impl Fn(usize) -> Vec3 + Sync) -> (f64, Potential) {
        let volume = self.wall.volume(iterate.space, x);
        (volume, self.gas.at(volume, self.rest_volume(iterate), &self.moment(iterate)))
    }

    fn moment(&self, iterate: &Iterate) -> Moment {
        let multiplier = self.multiplier.map(|i| iterate.multipliers[i]).unwrap_or_default();
        let past = self.memory.zip(iterate.step).map(|(place, step)| {
            let amount = step.internal.get(place).copied().unwrap_or(0.0);
            Past { h: step.internal_h, amount }
        });
        Moment { time: iterate.time, multiplier, past }
    }

    /// ∂V/∂u at the nodes [m²].
    fn volume_gradient(&self, iterate: &Iterate) -> Vec<f64> {
        let mut gradient = vec![0.0; iterate.u.len()];
        self.wall.add_wall_gradient(iterate.space, positions(iterate), 1.0, &mut gradient);
        gradient
    }

    /// Adds P λᵀ S at the nodes [N/m]: λᵀ ∂²E/∂u² at fixed pressure.
    pub fn add_stiffness_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let x = positions(iterate);
        let (_, gas) = self.state_at(iterate, x);
        self.wall.add_stiffness_vjp(iterate.space, x, lambda, gas.pressure, out);
    }

    /// Ambient pressure of a law that remembers its gas [Pa].
    fn ambient(&self) -> f64 {
        self.gas.remembers().expect("only such a law has a memory")
    }

    /// By what is added to the number that the law follows, which is ramped up in the first step as the rest of it.
    fn pressure_by_parameter(&self, iterate: &Iterate) -> Option<f64> {
        let full = 1.0 - self.gas.schedule().to_come(iterate.time);
        let volume = self.wall.volume(iterate.space, positions(iterate));
        let rest = self.rest_volume(iterate);
        let by = self.gas.pressure_by_parameter(volume, rest, &self.moment(iterate));
        by.map(|by| full * by)
    }

    /// Volume behind the rest wall [m³].
    pub fn rest_volume(&self, iterate: &Iterate) -> f64 {
        self.wall.volume(iterate.space, rest_positions(iterate))
    }

    /// Adds a multiple of ∂(V − V₀)/∂X with u held [m²], three components per vertex.
    pub fn add_growth_by_rest(&self, iterate: &Iterate, factor: f64, out: &mut [f64]) {
        self.wall.add_volume_gradient(iterate.space, positions(iterate), factor, out);
        self.wall.add_volume_gradient(iterate.space, rest_positions(iterate), -factor, out);
    }
}

impl Energy for Chamber {
    fn kind(&self) -> (&'static str, Nature) {
        ("chamber", Nature::Gas)
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
        Some(RankOne { scale: gas.stiffness, vector: self.volume_gradient(iterate) })
    }

    fn constraint(&self, iterate: &Iterate) -> Option<Constraint> {
        let multiplier = self.multiplier?;
        let wanted = self.gas.wanted(self.rest_volume(iterate), iterate.time)?.volume;
        let volume = self.wall.volume(iterate.space, positions(iterate));
        Some(Constraint { multiplier, volume, wanted, gradient: self.volume_gradient(iterate) })
    }

    fn constraint_vjp(&self, iterate: &Iterate, mu: &[f64], out: &mut [f64]) -> Option<f64> {
        let mu = mu[self.multiplier?];
        let wanted = self.gas.wanted(self.rest_volume(iterate), iterate.time)?;
        self.wall.add_volume_gradient(iterate.space, positions(iterate), mu, out);
        let rest = rest_positions(iterate);
        self.wall.add_volume_gradient(iterate.space, rest, -mu * wanted.by_rest, out);
        Some(-mu * wanted.by_parameter)
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
        let along = dot(&self.volume_gradient(iterate), lambda);
        self.wall.add_volume_gradient(iterate.space, x, gas.stiffness * along, out);
        let rest = rest_positions(iterate);
        self.wall.add_volume_gradient(iterate.space, rest, -gas.pressure_by_rest * along, out);
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let by = self.pressure_by_parameter(iterate);
        by.map(|by| -by * dot(&self.volume_gradient(iterate), lambda)).into_iter().collect()
    }

    fn internal_variables(&self) -> Option<&dyn InternalVariables> {
        self.memory.map(|_| self as &dyn InternalVariables)
    }

    fn add_past_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some((place, step)) = self.memory.zip(iterate.step) else { return };
        if step.internal.is_empty() {
            return;
        }
        out.internal.resize(step.internal.len(), 0.0);
        let (_, gas) = self.state(iterate);
        out.internal[place] -= gas.pressure_by_past * dot(&self.volume_gradient(iterate), lambda);
    }
}

/// The gas above that at rest [J], where the law remembers it.
impl InternalVariables for Chamber {
    fn count(&self, _: &FunctionSpace) -> usize {
        1
    }

    fn values(&self, iterate: &Iterate) -> Vec<f64> {
        let (volume, gas) = self.state(iterate);
        let ambient = self.ambient();
        vec![(ambient + gas.pressure) * volume - ambient * self.rest_volume(iterate)]
    }

    fn add_vjp(
        &self,
        iterate: &Iterate,
        cotangents: &[f64],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) -> InternalCotangent {
        let bar = self.memory.map_or(0.0, |place| cotangents[place]);
        let ((volume, gas), ambient) = (self.state(iterate), self.ambient());
        let by_volume = bar * (ambient + gas.pressure - volume * gas.stiffness);
        let by_rest_volume = bar * (volume * gas.pressure_by_rest - ambient);
        let x = positions(iterate);
        self.wall.add_wall_gradient(iterate.space, x, by_volume, by_u);
        self.wall.add_volume_gradient(iterate.space, x, by_volume, by_rest);
        self.wall.add_volume_gradient(
            iterate.space,
            rest_positions(iterate),
            by_rest_volume,
            by_rest,
        );
        let by_parameter = self.pressure_by_parameter(iterate).unwrap_or(0.0);
        InternalCotangent {
            past: vec![bar * volume * gas.pressure_by_past],
            parameters: vec![bar * volume * by_parameter],
        }
    }
}
