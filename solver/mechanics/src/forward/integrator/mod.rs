//! Time integration: each state from those before it, by a linear formula with one new acceleration.
//!
//! uₙ = ũₙ + h vₙ          ũ: history              vₙ = (uₙ − history) / h
//! vₙ = ṽₙ + k aₙ          ṽ: past velocity        aₙ = (uₙ − free flight) / (h k)
//! Zₙ = Z°ₙ + h_Z Żₙ        Z: internal variables    free flight = history + h ṽ
//!
//! History, past velocity and Z° are sums over the last states, with the [`Weights`] of a
//! [`Formula`]. A method has its formula in a file beside this one, a [`Method`], and its name in scenes.

mod bdf;
mod generalized_alpha;

use serde::{Deserialize, Serialize};

use self::generalized_alpha::SPECTRAL_RADIUS;
use crate::energy::{FreeFlight, TimeStep};

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
    /// Third order; some oscillations grow, see [`Method::growth`].
    Bdf3,
    /// Implicit Newmark of average acceleration: second order, damps nothing.
    Newmark,
    /// Generalized-α: second order, damps what the step does not resolve, and little else.
    GeneralizedAlpha,
}

impl Method {
    /// Number of earlier states in the formula, at most.
    pub fn states(self) -> usize {
        match self {
            Self::Quasistatic | Self::ImplicitEuler => 1,
            Self::Bdf2 | Self::Newmark | Self::GeneralizedAlpha => 2,
            Self::Bdf3 => 3,
        }
    }

    /// Whether masses resist acceleration.
    pub fn has_inertia(self) -> bool {
        self != Self::Quasistatic
    }

    /// Whether the energy may grow of what is much stiffer than steps resolve and turns.
    pub fn shakes_stiff_parts(self) -> bool {
        matches!(self, Self::Newmark | Self::GeneralizedAlpha)
    }

    /// Whether states have their accelerations, as the formula needs them.
    fn keeps_acceleration(self) -> bool {
        matches!(self, Self::Newmark | Self::GeneralizedAlpha)
    }

    /// Growth of the oscillations that nothing drives and that grow all the same; none where none
    /// grows, whatever the length of the step.
    pub fn growth(self) -> Option<Growth> {
        (self == Self::Bdf3).then_some(bdf::GROWTH_OF_THREE_STATES)
    }
}

/// Growth of an oscillation by a formula that is not stable for every step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Its amplitude after a step over that before, at the worst [1].
    pub factor: f64,
    /// There the frequency times the length of a step, ω Δt [1].
    pub phase: f64,
    /// Oscillations with a smaller ω Δt than this grow, larger ones do not [1].
    pub largest_phase: f64,
}

/// The linear formula of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Displacement by velocity at the end of the step, h [s].
    pub h: f64,
    /// Velocity by acceleration at the end of the step, k [s].
    pub k: f64,
    /// Internal variables by their rates at the end of the step, h_Z [s].
    pub internal_h: f64,
    /// How the last states count, the latest first.
    pub past: Vec<Weights>,
}

/// How an earlier state counts in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// The displacement [1], velocity [s] and acceleration [s²] in the history.
    pub history: [f64; 3],
    /// The velocity [1] and acceleration [s] in the past velocity.
    pub velocity: [f64; 2],
    /// The internal variables in Z° [1].
    pub internal: f64,
}

/// A displacement and its velocity, three components per node, and what bodies remember.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Displacement [m].
    pub u: Vec<f64>,
    /// Velocity [m/s].
    pub v: Vec<f64>,
    /// Acceleration [m/s²]; empty where the method does not need it, and at the start.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub a: Vec<f64>,
    /// Internal variables of all terms; empty where all are zero.
    #[serde(default)]
    pub internal: Vec<f64>,
}

impl State {
    /// Without acceleration and internal variables.
    pub fn new(u: Vec<f64>, v: Vec<f64>) -> Self {
        Self { u, v, ..Self::default() }
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
    pub fn new(method: Method, start: State) -> Self {
        Self { method, states: vec![start] }
    }

    /// The last state.
    pub fn last(&self) -> &State {
        &self.states[0]
    }

    /// The formula of the next step, of length Δt [s]. The first steps use as many states as there are.
    pub fn formula(&self, dt: f64) -> Formula {
        match self.method {
            // the acceleration at the start is not known
            method if method.keeps_acceleration() && self.last().a.is_empty() => {
                bdf::formula(1, dt)
            }
            Method::Newmark => generalized_alpha::formula(dt, 1.0),
            Method::GeneralizedAlpha => generalized_alpha::formula(dt, SPECTRAL_RADIUS),
            method => bdf::formula(self.states.len().min(method.states()), dt),
        }
    }

    /// The next step, from one time to another [s], without contacts.
    pub fn step(&self, from: f64, to: f64) -> TimeStep {
        let dt = to - from;
        let Formula { h, k, internal_h, past } = self.formula(dt);
        let states = || past.iter().zip(&self.states);
        let terms = states().flat_map(|(w, s)| w.history.into_iter().zip([&s.u, &s.v, &s.a]));
        let history = sum(terms);
        let free_flight: Option<FreeFlight> = self.method.has_inertia().then(|| {
            let terms = states().flat_map(|(w, s)| w.velocity.into_iter().zip([&s.v, &s.a]));
            let velocity = sum(terms);
            let at = history.iter().zip(&velocity).map(|(u, v)| u + h * v).collect();
            FreeFlight { at, square: h * k }
        });
        let internal = sum(states().map(|(w, s)| (w.internal, &s.internal)));
        TimeStep { h, history, free_flight, lagged_contacts: Vec::new(), internal_h, internal }
    }

    /// Goes to the end `u` [m] of a step, with the internal variables there.
    pub fn accept(&mut self, step: &TimeStep, u: &[f64], internal: Vec<f64>) {
        let v = u.iter().zip(&step.history).map(|(u, past)| (u - past) / step.h).collect();
        let flight = step.free_flight.as_ref().filter(|_| self.method.keeps_acceleration());
        let a = flight.map_or_else(Vec::new, |flight| flight.acceleration(u));
        self.states.insert(0, State { u: u.to_vec(), v, a, internal });
        self.states.truncate(self.method.states());
    }
}

/// Sum of vectors, each with its factor; those that are empty are zero.
fn sum<'a>(terms: impl Iterator<Item = (f64, &'a Vec<f64>)>) -> Vec<f64> {
    let terms: Vec<(f64, &Vec<f64>)> = terms.filter(|(w, x)| *w != 0.0 && !x.is_empty()).collect();
    let len = terms.first().map_or(0, |(_, x)| x.len());
    (0..len).map(|d| terms.iter().map(|(w, x)| w * x[d]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of u'' = −u: (u − flight) / (h k) = −u.
    fn swing(integrator: &mut Integrator, dt: f64) {
        let step = integrator.step(0.0, dt);
        let FreeFlight { at, square } = step.free_flight.as_ref().expect("inertia");
        integrator.accept(&step, &[at[0] / (1.0 + square)], Vec::new());
    }

    /// The solution is sin t.
    #[test]
    fn formulas_have_their_order() {
        for (method, order) in [
            (Method::ImplicitEuler, 1.0),
            (Method::Bdf2, 2.0),
            (Method::Bdf3, 3.0),
            (Method::Newmark, 2.0),
            (Method::GeneralizedAlpha, 2.0),
        ] {
            let error = |steps: usize| {
                let dt = 1.0 / steps as f64;
                let exact = |t: f64| State::new(vec![t.sin()], vec![t.cos()]);
                let mut integrator = Integrator::new(method, exact(0.0));
                // states before the start, so that the first steps are as good as the others
                let before = (1..method.states()).map(|i| exact(-dt * i as f64));
                integrator.states.extend(before);
                (0..steps).for_each(|_| swing(&mut integrator, dt));
                (integrator.last().u[0] - 1.0_f64.sin()).abs()
            };
            let slope = (error(40) / error(80)).log2();
            assert!((slope - order).abs() < 0.15, "{method:?}: {slope}");
        }
    }

    /// A spring and a mass swing on for a hundred periods with the same energy.
    #[test]
    fn newmark_keeps_the_energy_of_a_swing() {
        let energy = |s: &State| 0.5 * (s.u[0].powi(2) + s.v[0].powi(2));
        let mut integrator = Integrator::new(Method::Newmark, State::new(vec![1.0], vec![0.0]));
        let mut energies = Vec::new();
        for _ in 0..2000 {
            swing(&mut integrator, std::f64::consts::TAU / 20.0);
            energies.push(energy(integrator.last()));
        }
        // the first step is one of implicit Euler
        assert!(energies[0] < 0.5);
        assert!(energies.iter().all(|e| (e / energies[0] - 1.0).abs() < 1e-11));
    }

    /// The amplitude of u'' = −u after steps of a length, over that before the last of them.
    fn growth(method: Method, dt: f64) -> f64 {
        let mut integrator = Integrator::new(method, State::new(vec![1.0], vec![0.0]));
        let amplitude = |s: &State| s.u[0].hypot(s.v[0]);
        let mut logs = Vec::new();
        for _ in 0..1000 {
            swing(&mut integrator, dt);
            logs.push(amplitude(integrator.last()).ln());
        }
        ((logs[999] - logs[499]) / 500.0).exp()
    }

    #[test]
    fn only_the_formula_that_says_so_lets_oscillations_grow() {
        let Growth { factor, phase, largest_phase } = Method::Bdf3.growth().expect("it grows");
        assert!((growth(Method::Bdf3, phase) - factor).abs() < 1e-4);
        assert!(
            growth(Method::Bdf3, 0.9 * phase) < factor
                && growth(Method::Bdf3, 1.1 * phase) < factor
        );
        assert!((growth(Method::Bdf3, largest_phase) - 1.0).abs() < 1e-4);
        for method in [Method::ImplicitEuler, Method::Bdf2, Method::GeneralizedAlpha] {
            assert!(method.growth().is_none());
            // an amplitude below what a number holds has no logarithm, and does not grow
            for phase in [0.01, 0.1, 0.6, 1.2, 3.0, 30.0] {
                let factor = growth(method, phase);
                assert!(factor.is_nan() || factor < 1.0 + 1e-7, "{method:?} {phase}: {factor}");
            }
        }
    }

    /// What the step does not resolve falls by the spectral radius, what it resolves stays.
    #[test]
    fn generalized_alpha_damps_what_the_step_does_not_resolve() {
        let fast = growth(Method::GeneralizedAlpha, 3e3);
        assert!((fast - SPECTRAL_RADIUS).abs() < 0.01, "{fast}");
        let (slow, backward) = (growth(Method::GeneralizedAlpha, 0.2), growth(Method::Bdf2, 0.2));
        assert!(1.0 - slow < 0.1 * (1.0 - backward), "{slow}, {backward}");
    }
}
