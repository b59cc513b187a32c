//! The time stepper: from the end of one time step to the end of the next, in load steps
//! where Newton's method needs them.

use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use super::stepping::{
    Attempt, EASY, Failed, LoadStep, Stepping, Unreached, attempt, loosened, residual,
};
use super::{Configuration, Failure, Integrator, Problem, Trajectory, Workspace};
use crate::energy::{Iterate, Multiplier, TimeStep};

/// Fraction of the free path of supports and obstacles that the next load step goes.
const NEARLY: f64 = 0.9;
/// Smallest factor of an increment by which the next is tried.
const SHORTEST: f64 = 0.02;

/// All that determines the next time step.
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
pub struct TimeStepper {
    /// How to approach the end of a time step.
    pub stepping: Stepping,
    /// The state that was reached.
    pub progress: Progress,
    /// A run like this one: the start of each time step is predicted from its motion.
    guide: Option<Arc<Trajectory>>,
    /// The last time step that was begun.
    step: Option<Arc<TimeStep>>,
}

impl TimeStepper {
    /// Begins at t = 0.
    #[must_use]
    pub fn new(stepping: Stepping, integrator: Integrator) -> Self {
        let (time, increment, last) = (0.0, stepping.first, Vec::new());
        let progress = Progress { integrator, time, increment, last, newton_iterations: 0 };
        Self { stepping, progress, guide: None, step: None }
    }

    /// The same, next to a run through the same time steps.
    #[must_use]
    pub fn guided(self, guide: Option<Arc<Trajectory>>) -> Self {
        Self { guide, ..self }
    }

    /// The last state that was reached.
    #[must_use]
    pub fn iterate<'a>(&'a self, problem: &'a Problem, rest: &'a [Vec3]) -> Iterate<'a> {
        let (u, load) = (self.progress.reached(), self.progress.load());
        let step = self.step.as_deref();
        let last = self.progress.last.last();
        let multipliers = last.map_or(&problem.multipliers, |step| &step.multipliers);
        Iterate { space: &problem.space, rest, u, load, multipliers, step }
    }

    /// Goes to the end of the next time step. `observe` is called after every
    /// accepted load step. The next step depends on `self` and on the couplings in the
    /// workspace alone.
    ///
    /// # Errors
    /// [`Unreached`] with the load that was reached.
    pub fn advance(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        end: f64,
        mut observe: impl FnMut(&LoadStep),
    ) -> Result<(), Unreached> {
        workspace.linear_mut().forget();
        let step = self.begin(problem, rest, end);
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
            let start = self.predict(problem, workspace, (rest, &step), load, done == 0.0);
            match attempt(problem, workspace, &start, load, &newton) {
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
                    self.progress.increment *= match failure {
                        // what is free is known: no need to halve up to it
                        Failure::Blocked { free } => (NEARLY * free).clamp(SHORTEST, 0.5),
                        _ => 0.5,
                    };
                    let increment = self.progress.increment;
                    log::debug!("load {load:.4} failed ({failure}); increment {increment:.4}");
                    if increment < self.stepping.smallest {
                        let at = self.iterate(problem, rest);
                        let (reached, multipliers) = (at.u.to_vec(), at.multipliers.to_vec());
                        let attempt = Attempt { reached, multipliers, step, load, u, residuals };
                        let attempt = Box::new(attempt);
                        return Err(Unreached { load: at.load, failure, attempt });
                    }
                }
            }
        }
        let u = self.progress.reached().to_vec();
        self.progress.integrator.accept(&step, &u);
        self.progress.time = end;
        Ok(())
    }

    /// The time step that follows.
    fn begin(&mut self, problem: &Problem, rest: &[Vec3], end: f64) -> Arc<TimeStep> {
        if self.progress.integrator.method.has_inertia() || self.guide.is_some() {
            // with inertia, or a guide, the prediction is near the solution
            self.progress.increment = 1.0;
        }
        let lagged_contacts = problem.lagged_contacts(&self.iterate(problem, rest));
        let step = self.progress.integrator.step(end - self.progress.time);
        let step = Arc::new(TimeStep { lagged_contacts, ..step });
        self.step = Some(Arc::clone(&step));
        step
    }

    /// A state near the next one, that surfaces can reach, at the load of the last: where
    /// a guide went, or inertia carries the bodies, or by linear extrapolation in the
    /// load, multipliers of prescribed volumes included. Loads may bend where time steps
    /// meet, and surfaces may be hit, so the last state itself is taken if its residual
    /// is smaller.
    fn predict<'a>(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        (rest, step): (&'a [Vec3], &'a Arc<TimeStep>),
        load: f64,
        begins: bool,
    ) -> Configuration<'a> {
        let last = Iterate { step: Some(step), ..self.iterate(problem, rest) };
        let start = |u: &[f64]| Configuration {
            rest,
            load: last.load,
            step: Some(step),
            u: u.to_vec(),
            multipliers: last.multipliers.to_vec(),
        };
        let from = last.u;
        let moved = |by: Vec<f64>| from.iter().zip(by).map(|(u, d)| u + d).collect();
        let guided = self.guide.as_ref().filter(|_| begins).and_then(|g| g.motion_to(load));
        let has_inertia = step.free_flight.is_some();
        let flight = step.free_flight.clone().filter(|_| begins);
        let known = guided.map(moved).or(flight);
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
            _ => return start(from),
        };
        let free = workspace.max_step(problem, &last, &Iterate { u: &further, ..last });
        let ahead: Vec<f64> = from.iter().zip(&further).map(|(a, b)| a + free * (b - a)).collect();
        let bent = self.progress.time > 0.0 || inertial || free < 1.0;
        // obstacles that have moved into a state leave forces there that mean nothing
        let now = Iterate { load, ..last };
        let open = bent && workspace.max_step(problem, &last, &now) >= 1.0;
        if open
            && residual(problem, workspace, &now)
                <= residual(problem, workspace, &Iterate { u: &ahead, ..now })
        {
            return start(from);
        }
        let mut start = start(&ahead);
        if let (false, Some((b, a))) = (inertial, self.progress.last.split_last()) {
            let earlier = |i: usize| a.first().map_or(0.0, |a| a.multipliers[i].pressure);
            for (i, (m, b)) in start.multipliers.iter_mut().zip(&b.multipliers).enumerate() {
                m.pressure = b.pressure + fraction * (b.pressure - earlier(i));
            }
        }
        start
    }
}
