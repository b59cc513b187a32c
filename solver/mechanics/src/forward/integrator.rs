//! Time integration by backward differentiation formulas (BDF) of order k.
//!
//! vₙ = (uₙ − Σ αᵢ uₙ₋ᵢ) / h,   aₙ = (vₙ − Σ αᵢ vₙ₋ᵢ) / h,   h = β Δt
//!
//! k = 1 (implicit Euler)   α = 1;                     β = 1
//! k = 2                    α = 4/3, −1/3;             β = 2/3
//! k = 3                    α = 18/11, −9/11, 2/11;    β = 6/11
//!
//! The first steps use as many states as there are. Source: Hairer, Nørsett and
//! Wanner, "Solving Ordinary Differential Equations I", III.1.

use serde::{Deserialize, Serialize};

use crate::energy::TimeStep;

/// α and β of the formulas with 1, 2 and 3 states.
const FORMULAS: [(&[f64], f64); 3] = [
    (&[1.0], 1.0),
    (&[4.0 / 3.0, -1.0 / 3.0], 2.0 / 3.0),
    (&[18.0 / 11.0, -9.0 / 11.0, 2.0 / 11.0], 6.0 / 11.0),
];

/// Time integration of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Inertia is neglected: an equilibrium at every time.
    Quasistatic,
    /// First order; damps what the step does not resolve.
    #[default]
    ImplicitEuler,
    /// Second order.
    Bdf2,
    /// Third order.
    Bdf3,
}

impl Method {
    /// Number of earlier states in the formula: its order.
    #[must_use]
    pub fn order(self) -> usize {
        match self {
            Self::Quasistatic | Self::ImplicitEuler => 1,
            Self::Bdf2 => 2,
            Self::Bdf3 => 3,
        }
    }

    /// Whether masses resist acceleration.
    #[must_use]
    pub fn has_inertia(self) -> bool {
        self != Self::Quasistatic
    }
}

/// A displacement and its velocity, three components per node, and what bodies remember.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Displacement [m].
    pub u: Vec<f64>,
    /// Velocity [m/s].
    pub v: Vec<f64>,
    /// Relaxed stresses of all viscous terms [Pa]; empty where all are zero.
    #[serde(default)]
    pub relaxed: Vec<f64>,
}

impl State {
    /// Without relaxed stresses.
    #[must_use]
    pub fn new(u: Vec<f64>, v: Vec<f64>) -> Self {
        Self { u, v, relaxed: Vec::new() }
    }
}

/// The past that the next step needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Integrator {
    /// The formula.
    pub method: Method,
    /// The last states, the latest first.
    pub states: Vec<State>,
}

impl Integrator {
    /// Begins at a state.
    #[must_use]
    pub fn new(method: Method, start: State) -> Self {
        Self { method, states: vec![start] }
    }

    /// The last state.
    #[must_use]
    pub fn last(&self) -> &State {
        &self.states[0]
    }

    /// α and β of the next step.
    #[must_use]
    pub fn formula(&self) -> (&'static [f64], f64) {
        FORMULAS[self.states.len().min(self.method.order()) - 1]
    }

    /// The next step, of length Δt [s], without contacts.
    #[must_use]
    pub fn step(&self, dt: f64) -> TimeStep {
        let (alpha, beta) = self.formula();
        let h = beta * dt;
        let sum = |of: fn(&State) -> &Vec<f64>| -> Vec<f64> {
            let len = of(self.last()).len();
            let value = |s: &State, d: usize| of(s).get(d).copied().unwrap_or(0.0);
            let at = |d: usize| alpha.iter().zip(&self.states).map(|(a, s)| a * value(s, d)).sum();
            (0..len).map(at).collect()
        };
        let history = sum(|s| &s.u);
        let free_flight = self.method.has_inertia().then(|| {
            let velocity = sum(|s| &s.v);
            history.iter().zip(&velocity).map(|(u, v)| u + h * v).collect()
        });
        let relaxed = sum(|s| &s.relaxed);
        TimeStep { h, history, free_flight, lagged_contacts: Vec::new(), relaxed }
    }

    /// Goes to the end `u` [m] of a step, with the relaxed stresses there [Pa].
    pub fn accept(&mut self, step: &TimeStep, u: &[f64], relaxed: Vec<f64>) {
        let v = u.iter().zip(&step.history).map(|(u, past)| (u - past) / step.h).collect();
        self.states.insert(0, State { u: u.to_vec(), v, relaxed });
        self.states.truncate(self.method.order());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u' = λ u has the exact solution e^{λt}: each formula integrates u'' = λ² u
    /// with its order.
    #[test]
    fn formulas_have_their_order() {
        for (method, order) in
            [(Method::ImplicitEuler, 1.0), (Method::Bdf2, 2.0), (Method::Bdf3, 3.0)]
        {
            let error = |steps: usize| {
                let dt = 1.0 / steps as f64;
                let exact = |t: f64| State::new(vec![t.sin()], vec![t.cos()]);
                let mut integrator = Integrator::new(method, exact(0.0));
                // states before the start, so that the first steps are as good as the others
                let before = (1..method.order()).map(|i| exact(-dt * i as f64));
                integrator.states.extend(before);
                for _ in 0..steps {
                    let step = integrator.step(dt);
                    // u'' = −u: (u − ũ)/h² = −u
                    let free = step.free_flight.as_ref().expect("inertia")[0];
                    integrator.accept(&step, &[free / (1.0 + step.h * step.h)], Vec::new());
                }
                (integrator.last().u[0] - 1.0_f64.sin()).abs()
            };
            let slope = (error(40) / error(80)).log2();
            assert!((slope - order).abs() < 0.15, "{method:?}: {slope}");
        }
    }

    #[test]
    fn free_fall_follows_the_recursion_of_implicit_euler() {
        let (dt, g) = (0.01, -9.8);
        let mut integrator =
            Integrator::new(Method::ImplicitEuler, State::new(vec![0.0], vec![0.0]));
        for n in 1..=20 {
            let step = integrator.step(dt);
            let u = step.free_flight.as_ref().expect("inertia")[0] + step.h * step.h * g;
            integrator.accept(&step, &[u], Vec::new());
            let expected = 0.5 * g * dt * dt * f64::from(n * (n + 1));
            assert!((integrator.last().u[0] / expected - 1.0).abs() < 1e-13);
        }
    }
}
