//! Gas in a chamber: its energy depends on the volume alone.
//!
//! E(u; X) = Φ(V(x); V₀),   V₀ = V(X),   x = ΠX + u,   pressure P = −Φ'
//!
//! ∂E/∂u   = Φ' ∂V/∂u
//! ∂²E/∂u² = P S + Φ'' (∂V/∂u)(∂V/∂u)ᵀ
//!
//! isobaric            Φ = −P (V − V₀)
//! ideal gas           Φ' = p_a − (P₀ + p_a)(V₀/V)^γ
//! prescribed volume   Φ = −P̂ (V − V*) + ½ k (V − V*)²
//!
//! P₀     gauge pressure of the fill in the rest volume [Pa]
//! p_a    ambient pressure [Pa]
//! γ      1 isothermal, 1.4 adiabatic for air
//! V*     V₀ plus a change, or V₀ times a factor [m³]
//! P̂, k   multiplier and penalty of the augmented Lagrangian [Pa, Pa/m³]
//!
//! P, P₀ and V* follow their schedules; P > 0 inflates. P̂ and k belong to the
//! iterate: `forward` finds the P̂ for which V = V*, and P is then the pressure
//! that holds it, whatever k. The one parameter is P, of an ideal gas P₀, of a prescribed
//! volume its change or factor, at the iterate's load. The dense second term is never
//! assembled, see [`Energy::rank_one`].

use mesh::Vec3;

use super::wall::{Wall, positions};
use super::{Constraint, Energy, Hessian, Iterate, Multiplier, RankOne};
use crate::element::at;
use crate::math::linear::dot;
use crate::math::sparse::BlockMatrix;
use crate::schedule::Schedule;

/// How the pressure behind a wall follows its volume.
#[derive(Clone, Debug, PartialEq)]
pub enum GasLaw {
    /// The same gauge pressure at any volume.
    Isobaric {
        /// Gauge pressure [Pa].
        pressure: Schedule,
    },
    /// The pressure that a volume needs.
    Volume {
        /// The volume.
        prescribed: Prescribed,
        /// Index of its multiplier.
        multiplier: usize,
    },
    /// A fixed amount of ideal gas.
    Ideal {
        /// Gauge pressure in the rest volume [Pa].
        fill: Schedule,
        /// Ambient pressure [Pa].
        ambient: f64,
        /// Polytropic exponent γ.
        exponent: f64,
    },
}

/// A volume V* that a chamber shall have.
#[derive(Clone, Debug, PartialEq)]
pub enum Prescribed {
    /// V₀ plus a change [m³].
    Change(Schedule),
    /// V₀ times a factor, which is 1 at rest.
    Factor(Schedule),
}

impl Prescribed {
    /// V* and ∂V*/∂V₀.
    #[must_use]
    pub fn at(&self, rest: f64, load: f64) -> (f64, f64) {
        match self {
            Self::Change(change) => (rest + change.at(load), 1.0),
            Self::Factor(factor) => {
                let factor = factor.at(load) + factor.to_come(load);
                (rest * factor, factor)
            }
        }
    }
}

/// Φ and its derivatives at one volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Potential {
    /// Φ [J]; infinite for V ≤ 0 of a fixed amount of gas.
    pub value: f64,
    /// Gauge pressure −Φ' [Pa].
    pub pressure: f64,
    /// Φ'' [Pa/m³].
    pub stiffness: f64,
    /// ∂P/∂V₀ [Pa/m³].
    pub pressure_by_rest: f64,
}

impl GasLaw {
    /// What it is prescribed by: pressure, fill, change or factor of the volume.
    #[must_use]
    pub fn schedule(&self) -> &Schedule {
        match self {
            Self::Isobaric { pressure: by }
            | Self::Ideal { fill: by, .. }
            | Self::Volume {
                prescribed: Prescribed::Change(by) | Prescribed::Factor(by), ..
            } => by,
        }
    }

    /// The same, to be changed.
    pub fn schedule_mut(&mut self) -> &mut Schedule {
        match self {
            Self::Isobaric { pressure: by }
            | Self::Ideal { fill: by, .. }
            | Self::Volume {
                prescribed: Prescribed::Change(by) | Prescribed::Factor(by), ..
            } => by,
        }
    }

    /// At volume `v` of a chamber with rest volume `rest`, at a load.
    #[must_use]
    pub fn at(&self, v: f64, rest: f64, load: f64, multipliers: &[Multiplier]) -> Potential {
        match self {
            Self::Isobaric { pressure } => {
                let pressure = pressure.at(load);
                Potential {
                    value: -pressure * (v - rest),
                    pressure,
                    stiffness: 0.0,
                    pressure_by_rest: 0.0,
                }
            }
            Self::Volume { prescribed, multiplier } => {
                let Multiplier { pressure, penalty } = multipliers[*multiplier];
                let (wanted, by_rest) = prescribed.at(rest, load);
                let gap = v - wanted;
                Potential {
                    value: (0.5 * penalty * gap - pressure) * gap,
                    pressure: pressure - penalty * gap,
                    stiffness: penalty,
                    pressure_by_rest: penalty * by_rest,
                }
            }
            &Self::Ideal { ref fill, ambient, exponent } => {
                if v <= 0.0 {
                    let value = f64::INFINITY;
                    return Potential {
                        value,
                        pressure: 0.0,
                        stiffness: 0.0,
                        pressure_by_rest: 0.0,
                    };
                }
                let full = fill.at(load) + ambient;
                let ratio = rest / v;
                let absolute = full * ratio.powf(exponent);
                // ∫ (V₀/V)^γ dV from V₀, a logarithm at γ = 1
                let work = if exponent == 1.0 {
                    -rest * ratio.ln()
                } else {
                    rest * (ratio.powf(exponent - 1.0) - 1.0) / (1.0 - exponent)
                };
                Potential {
                    value: ambient * (v - rest) - full * work,
                    pressure: absolute - ambient,
                    stiffness: exponent * absolute / v,
                    pressure_by_rest: exponent * absolute / rest,
                }
            }
        }
    }
}

/// A chamber with gas.
#[derive(Clone)]
pub struct Chamber {
    /// Its wall.
    pub wall: Wall,
    /// Its gas.
    pub gas: GasLaw,
}

impl Chamber {
    /// Volume [m³] and gas at an iterate.
    #[must_use]
    pub fn state(&self, at_: &Iterate) -> (f64, Potential) {
        self.state_at(at_, &positions(at_))
    }

    fn state_at(&self, at_: &Iterate, x: &[Vec3]) -> (f64, Potential) {
        let volume = self.wall.volume(at_.space, x);
        (volume, self.gas.at(volume, self.rest_volume(at_), at_.load, at_.multipliers))
    }

    /// Volume behind the rest wall [m³].
    #[must_use]
    pub fn rest_volume(&self, at_: &Iterate) -> f64 {
        self.wall.volume(at_.space, &at_.space.node_positions(at_.rest))
    }
}

impl Energy for Chamber {
    fn name(&self) -> &'static str {
        "pressure"
    }

    fn value(&self, at_: &Iterate) -> f64 {
        self.state(at_).1.value
    }

    fn add_gradient(&self, at_: &Iterate, out: &mut [f64]) {
        let x = positions(at_);
        let (_, gas) = self.state_at(at_, &x);
        self.wall.add_wall_gradient(at_.space, &x, -gas.pressure, out);
    }

    fn add_hessian(&self, at_: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let x = positions(at_);
        let (_, gas) = self.state_at(at_, &x);
        self.wall.add_stiffness(at_.space, &x, gas.pressure, out);
    }

    fn rank_one(&self, at_: &Iterate) -> Option<RankOne> {
        let x = positions(at_);
        let (_, gas) = self.state_at(at_, &x);
        if gas.stiffness == 0.0 {
            return None;
        }
        let mut vector = vec![0.0; at_.u.len()];
        self.wall.add_wall_gradient(at_.space, &x, 1.0, &mut vector);
        Some(RankOne { scale: gas.stiffness, vector })
    }

    fn constraint(&self, at_: &Iterate) -> Option<Constraint> {
        let GasLaw::Volume { prescribed, multiplier } = &self.gas else { return None };
        let (wanted, _) = prescribed.at(self.rest_volume(at_), at_.load);
        let x = positions(at_);
        let volume = self.wall.volume(at_.space, &x);
        let mut gradient = vec![0.0; at_.u.len()];
        self.wall.add_wall_gradient(at_.space, &x, 1.0, &mut gradient);
        Some(Constraint { multiplier: *multiplier, volume, wanted, gradient })
    }

    fn add_mixed_vjp(&self, at_: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let x = positions(at_);
        let (_, gas) = self.state_at(at_, &x);
        // x = ΠX + u: the mixed derivative at fixed pressure is P S Π
        let mut nodal = vec![0.0; at_.u.len()];
        self.wall.add_stiffness_vjp(at_.space, &x, lambda, gas.pressure, &mut nodal);
        at_.space.add_to_vertices(&nodal, out);
        if gas.stiffness == 0.0 {
            return;
        }
        // and X changes the pressure through both volumes
        let mut gradient = vec![0.0; at_.u.len()];
        self.wall.add_wall_gradient(at_.space, &x, 1.0, &mut gradient);
        let along: f64 =
            (0..at_.space.node_count()).map(|i| at(&gradient, i).dot(&at(lambda, i))).sum();
        self.wall.add_volume_gradient(at_.space, &x, gas.stiffness * along, out);
        let rest = at_.space.node_positions(at_.rest);
        self.wall.add_volume_gradient(at_.space, &rest, -gas.pressure_by_rest * along, out);
    }

    fn constraint_vjp(&self, at_: &Iterate, mu: &[f64], out: &mut [f64]) -> Option<f64> {
        let GasLaw::Volume { prescribed, multiplier } = &self.gas else { return None };
        let mu = mu[*multiplier];
        let rest_volume = self.rest_volume(at_);
        let (_, by_rest) = prescribed.at(rest_volume, at_.load);
        self.wall.add_volume_gradient(at_.space, &positions(at_), mu, out);
        let rest = at_.space.node_positions(at_.rest);
        self.wall.add_volume_gradient(at_.space, &rest, -mu * by_rest, out);
        Some(match prescribed {
            Prescribed::Change(_) => -mu,
            Prescribed::Factor(_) => -mu * rest_volume,
        })
    }

    fn parameter_vjp(&self, at_: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let x = positions(at_);
        let by = match &self.gas {
            GasLaw::Isobaric { .. } => 1.0,
            GasLaw::Volume { .. } => return Vec::new(),
            GasLaw::Ideal { exponent, .. } => {
                (self.rest_volume(at_) / self.wall.volume(at_.space, &x)).powf(*exponent)
            }
        };
        let mut gradient = vec![0.0; at_.u.len()];
        self.wall.add_wall_gradient(at_.space, &x, -by, &mut gradient);
        vec![dot(&gradient, lambda)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the ideal gas law from the design document, ambient 101.3 kPa.
    #[test]
    fn compressed_air_has_the_pressures_of_the_gas_law() {
        let pressure = |exponent: f64, ratio: f64| {
            GasLaw::Ideal { fill: 0.0.into(), ambient: 101.3e3, exponent }
                .at(ratio * 2e-5, 2e-5, 1.0, &[])
                .pressure
        };
        for (exponent, ratio, expected) in [
            (1.0, 0.9, 11255.556),
            (1.4, 0.9, 16100.496),
            (1.0, 0.8, 25325.0),
            (1.4, 0.8, 37146.973),
        ] {
            assert!((pressure(exponent, ratio) - expected).abs() < 1e-3, "{exponent} {ratio}");
        }
    }

    #[test]
    fn derivatives_of_the_potential_are_those_of_its_value() {
        let ideal = |exponent| GasLaw::Ideal { fill: 3e4.into(), ambient: 101.3e3, exponent };
        let volume = |prescribed| GasLaw::Volume { prescribed, multiplier: 0 };
        let laws = [
            ideal(1.0),
            ideal(1.4),
            volume(Prescribed::Change(0.3.into())),
            volume(Prescribed::Factor(1.4.into())),
        ];
        let multipliers = [Multiplier { pressure: 2e4, penalty: 3e4 }];
        for law in laws {
            let (v, rest) = (1.3, 0.9);
            let at = |v: f64, rest: f64| law.at(v, rest, 0.7, &multipliers);
            let here = at(v, rest);
            let h = 1e-5;
            let slope = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h);
            let by_v = slope(&|e| at(v + e, rest).value);
            let twice = slope(&|e| -at(v + e, rest).pressure);
            let by_rest = slope(&|e| at(v, rest + e).pressure);
            assert!((by_v + here.pressure).abs() < 1e-5 * here.pressure.abs(), "{law:?}");
            assert!((twice - here.stiffness).abs() < 1e-8 * here.stiffness, "{law:?}");
            assert!((by_rest / here.pressure_by_rest - 1.0).abs() < 1e-8, "{law:?}");
        }
        assert!(ideal(1.4).at(-1e-3, 0.9, 0.7, &[]).value.is_infinite());
    }

    #[test]
    fn prescribed_volumes_begin_at_the_rest_volume() {
        for prescribed in [Prescribed::Change(0.8.into()), Prescribed::Factor(1.4.into())] {
            let wanted = [0.0, 0.5, 1.0, 2.0].map(|load| prescribed.at(2.0, load).0);
            for (found, expected) in wanted.into_iter().zip([2.0, 2.4, 2.8, 2.8]) {
                assert!((found - expected).abs() < 1e-15, "{prescribed:?}: {wanted:?}");
            }
        }
    }
}
