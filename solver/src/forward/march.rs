//! The way through time, one time step after the other.

use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use super::stepping::{
    Attempt, EASY, Failed, LoadStep, Stepping, Unreached, attempt, loosened, residual,
};
use super::{Failure, Integrator, System, Trajectory};
use crate::energy::{Multiplier, TimeStep};

/// Of the way that supports and obstacles can go in a step, what the next try goes.
const NEARLY: f64 = 0.9;
/// Smallest factor of an increment by which the next is tried.
const SHORTEST: f64 = 0.02;

/// All that decides what comes next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Progress {
    /// The states at the ends of the last time steps.
    pub integrator: Integrator,
    /// End of the last time step [s].
    pub time: f64,
    /// Next increment, as a fraction of a time step.
    pub increment: f64,
    /// Up to two last load steps, the latest last.
    pub last: Vec<Reached>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
}

/// A state that was reached.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Reached {
    /// Load parameter.
    pub load: f64,
    /// Displacement [m].
    pub u: Vec<f64>,
    /// Of the chambers with a prescribed volume.
    pub multipliers: Vec<Multiplier>,
}

impl Progress {
    /// The last state [m].
    #[must_use]
    pub fn reached(&self) -> &[f64] {
        self.last.last().map_or(&self.integrator.last().u, |step| &step.u)
    }

    /// The load of the last state.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.last.last().map_or(0.0, |step| step.load)
    }

    fn keep(&mut self, step: LoadStep) {
        let LoadStep { load, u, multipliers, .. } = step;
        self.last.push(Reached { load, u, multipliers });
        if self.last.len() > 2 {
            self.last.remove(0);
        }
    }
}

/// Goes through time, one time step after the other, in load steps that shrink
/// where Newton fails and grow where it is easy.
pub struct March {
    /// How to approach the end of a time step.
    pub stepping: Stepping,
    /// How far it is.
    pub progress: Progress,
    /// A run like this one, whose motion in each time step is where this one looks
    /// first.
    guide: Option<Arc<Trajectory>>,
}

impl March {
    /// Begins at t = 0.
    #[must_use]
    pub fn new(stepping: Stepping, integrator: Integrator) -> Self {
        let (time, increment, last) = (0.0, stepping.first, Vec::new());
        let progress = Progress { integrator, time, increment, last, newton_iterations: 0 };
        Self { stepping, progress, guide: None }
    }

    /// The same, next to a run through the same time steps.
    #[must_use]
    pub fn guided(self, guide: Option<Arc<Trajectory>>) -> Self {
        Self { guide, ..self }
    }

    /// Goes to the end of the next time step. `observe` is called after every
    /// accepted load step. Nothing but what `self` and the couplings of the
    /// system hold decides what comes next.
    ///
    /// # Errors
    /// [`Unreached`] with the load that was reached.
    pub fn advance(
        &mut self,
        system: &mut System,
        rest: &[Vec3],
        end: f64,
        mut observe: impl FnMut(&LoadStep),
    ) -> Result<(), Unreached> {
        system.linear.forget();
        self.begin(system, rest, end);
        let mut done = 0.0; // fraction of the time step
        while done < 1.0 {
            let next = if done + self.progress.increment > 1.0 - 1e-9 {
                1.0
            } else {
                done + self.progress.increment
            };
            let ends = next >= 1.0;
            let load =
                if ends { end } else { self.progress.time + next * (end - self.progress.time) };
            let newton = if ends { self.stepping.newton } else { loosened(&self.stepping.newton) };
            let multipliers = system.multipliers.clone();
            let start = self.predict(system, rest, load, done == 0.0);
            match attempt(system, rest, start, load, &newton) {
                Ok(step) => {
                    self.progress.newton_iterations += step.newton_iterations;
                    if step.newton_iterations <= EASY {
                        self.progress.increment =
                            (1.5 * self.progress.increment).min(self.stepping.largest);
                    }
                    done = next;
                    let step = LoadStep { ends_time_step: ends, ..step };
                    observe(&step);
                    self.progress.keep(step);
                }
                Err(Failed { failure, u, residuals }) => {
                    self.progress.newton_iterations += residuals.len().saturating_sub(1);
                    system.multipliers = multipliers;
                    self.progress.increment *= match failure {
                        // what is free is known: no need to halve up to it
                        Failure::Blocked { free } => (NEARLY * free).clamp(SHORTEST, 0.5),
                        _ => 0.5,
                    };
                    let increment = self.progress.increment;
                    log::debug!("load {load:.4} failed ({failure}); increment {increment:.4}");
                    if increment < self.stepping.smallest {
                        let reached = self.progress.reached().to_vec();
                        let attempt = Box::new(Attempt { reached, load, u, residuals });
                        return Err(Unreached { load: self.progress.load(), failure, attempt });
                    }
                }
            }
        }
        let step = system.step.as_ref().expect("begun above");
        let u = self.progress.reached().to_vec();
        self.progress.integrator.accept(step, &u);
        self.progress.time = end;
        Ok(())
    }

    /// Tells the system of the time step that follows.
    fn begin(&mut self, system: &mut System, rest: &[Vec3], end: f64) {
        if self.progress.time == 0.0 {
            system.release_volumes();
        }
        if self.progress.integrator.method.has_inertia() || self.guide.is_some() {
            // inertia keeps what comes near what was, and a guide near what it did
            self.progress.increment = 1.0;
        }
        let lagged_contacts =
            system.lagged_contacts(rest, self.progress.reached(), self.progress.load());
        let step = self.progress.integrator.step(end - self.progress.time);
        system.step = Some(TimeStep { lagged_contacts, ..step });
    }

    /// A state near the next one, that surfaces can reach, and its load: where a guide
    /// went, or inertia carries the bodies, or by linear extrapolation in the load,
    /// pressures that hold volumes included. Loads may bend where time steps meet
    /// and surfaces are hit, so the last state itself is taken if it is nearer to
    /// balance.
    fn predict(
        &self,
        system: &mut System,
        rest: &[Vec3],
        load: f64,
        begins: bool,
    ) -> (Vec<f64>, f64) {
        let (from, before) = (self.progress.reached(), self.progress.load());
        let moved = |by: Vec<f64>| from.iter().zip(by).map(|(u, d)| u + d).collect();
        let guided = self.guide.as_ref().filter(|_| begins).and_then(|g| g.motion_to(load));
        let flight = system.step.as_ref().and_then(|step| step.free_flight.clone());
        let has_inertia = flight.is_some();
        let known = guided.map(moved).or(flight.filter(|_| begins));
        let inertial = known.is_some();
        let (further, fraction) = match (known, &self.progress.last[..]) {
            (Some(known), _) => (known, 0.0),
            (None, [a, b]) => {
                let t = (load - b.load) / (b.load - a.load);
                (b.u.iter().zip(&a.u).map(|(b, a)| b + t * (b - a)).collect(), t)
            }
            (None, [b]) if !has_inertia => {
                let t = (load - b.load) / b.load;
                (b.u.iter().map(|b| b + t * b).collect(), t)
            }
            _ => return (from.to_vec(), before),
        };
        let free = system.max_step(rest, (from, before), (&further, before));
        let ahead: Vec<f64> = from.iter().zip(&further).map(|(a, b)| a + free * (b - a)).collect();
        let bent = self.progress.time > 0.0 || inertial || free < 1.0;
        // obstacles that have moved into a state leave forces there that mean nothing
        let open = bent && system.max_step(rest, (from, before), (from, load)) >= 1.0;
        if open && residual(system, rest, from, load) <= residual(system, rest, &ahead, load) {
            return (from.to_vec(), before);
        }
        if let (false, Some((b, a))) = (inertial, self.progress.last.split_last()) {
            let earlier = |i: usize| a.first().map_or(0.0, |a| a.multipliers[i].pressure);
            for (i, (m, b)) in system.multipliers.iter_mut().zip(&b.multipliers).enumerate() {
                m.pressure = b.pressure + fraction * (b.pressure - earlier(i));
            }
        }
        (ahead, before)
    }
}
