//! The time stepper: from the end of one time step to the end of the next, in load steps
//! where Newton's method needs them.

use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use super::stepping::{
    Attempt, EASY, Failed, GROWTH, LoadStep, Stepping, Unreached, attempt, loosened, residual,
};
use super::watch::Event;
use super::{Configuration, Failure, Integrator, Linearizations, Problem, Trajectory, Workspace};
use crate::energy::{Iterate, Multiplier, TimeStep};

/// Fraction of the free path of supports and obstacles that the next load step goes.
const NEARLY: f64 = 0.9;
/// States that are extrapolated from, at most.
const STATES: usize = 3;
/// Smallest factor of an increment by which the next is tried.
const SHORTEST: f64 = 0.02;

/// All that determines the next time step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Progress {
    /// The states at the ends of the last time steps.
    pub integrator: Integrator,
    /// End of the last time step [s].
    pub time: f64,
    /// Fraction of the next time step that was made.
    pub done: f64,
    /// Next increment, as a fraction of a time step.
    pub increment: f64,
    /// The last load steps, up to three, the latest last.
    pub last: Vec<Reached>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
    /// [`Workspace::indefinite_starts`].
    pub indefinite_starts: usize,
}

/// A state that was reached.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Reached {
    /// Time t [s].
    pub time: f64,
    /// Displacement [m].
    pub u: Vec<f64>,
    /// Multipliers of the chambers with a prescribed volume.
    pub multipliers: Vec<Multiplier>,
}

impl Reached {
    /// The state of an iterate.
    pub fn of(at: &Iterate) -> Self {
        Self { time: at.time, u: at.u.to_vec(), multipliers: at.multipliers.to_vec() }
    }

    /// The state on a rest shape [m], in a time step if it is in one.
    pub fn configuration<'a>(
        &self,
        rest: &'a [Vec3],
        step: Option<&'a Arc<TimeStep>>,
    ) -> Configuration<'a> {
        let (u, multipliers) = (self.u.clone(), self.multipliers.clone());
        Configuration { rest, time: self.time, step, u, multipliers, balanced_at: Some(self.time) }
    }
}

impl Progress {
    /// The last state [m].
    pub fn reached(&self) -> &[f64] {
        self.last.last().map_or(&self.integrator.last().u, |step| &step.u)
    }

    /// The load of the last state.
    pub fn time(&self) -> f64 {
        self.last.last().map_or(0.0, |step| step.time)
    }

    fn keep(&mut self, step: LoadStep) {
        self.last.push(step.into_reached());
        if self.last.len() > STATES {
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
    /// Factors that each time step begins with, where there is one.
    factors: Arc<Linearizations>,
    /// The last time step that was begun.
    step: Option<Arc<TimeStep>>,
}

impl TimeStepper {
    /// Begins at t = 0.
    pub fn new(stepping: Stepping, integrator: Integrator) -> Self {
        let progress = Progress {
            integrator,
            time: 0.0,
            done: 0.0,
            increment: stepping.first,
            last: Vec::new(),
            newton_iterations: 0,
            indefinite_starts: 0,
        };
        Self { stepping, progress, guide: None, factors: Arc::default(), step: None }
    }

    /// Begins at a state of a time step that is being made.
    pub fn within(stepping: Stepping, integrator: Integrator, reached: Reached) -> Self {
        let mut stepper = Self::new(stepping, integrator);
        (stepper.progress.last, stepper.progress.done) = (vec![reached], 0.5);
        stepper
    }

    /// This stepper, next to a run through the same time steps.
    pub fn guided(self, guide: Option<Arc<Trajectory>>) -> Self {
        Self { guide, ..self }
    }

    /// This stepper, whose systems at the start of a time step are solved with the factors at the end of that time step
    /// of another run.
    pub fn with_factors(self, factors: Arc<Linearizations>) -> Self {
        Self { factors, ..self }
    }

    /// The last state that was reached.
    pub fn iterate<'a>(&'a self, problem: &'a Problem, rest: &'a [Vec3]) -> Iterate<'a> {
        let (u, time) = (self.progress.reached(), self.progress.time());
        let step = self.step.as_deref();
        let last = self.progress.last.last();
        let multipliers = last.map_or(&problem.multipliers, |step| &step.multipliers);
        Iterate { space: &problem.space, rest, u, time, multipliers, step, before: None }
    }

    /// The last time step that was begun.
    pub(crate) fn step(&self) -> Option<&Arc<TimeStep>> {
        self.step.as_ref()
    }

    /// Goes from time step to time step, which end at `times` [s]: the states at their ends, with
    /// `memory` for them [B]. `observe` is called after every accepted load step.
    pub fn run(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        times: &[f64],
        memory: f64,
        mut observe: impl FnMut(&LoadStep),
    ) -> Result<Trajectory, Unreached> {
        let mut states = Trajectory::begin(&self.progress.integrator, memory);
        for &end in times {
            self.advance(problem, workspace, rest, end, &mut observe)?;
            states.push(end, self.progress.integrator.last().clone());
        }
        if let Some(error) = states.unwritten() {
            let _told = workspace.notify(&Event::KeptInMemory { error });
        }
        Ok(states)
    }

    /// Goes to the end of the next time step. `observe` is called after every
    /// accepted load step.
    pub fn advance(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        end: f64,
        mut observe: impl FnMut(&LoadStep),
    ) -> Result<(), Unreached> {
        loop {
            let step = self.next(problem, workspace, rest, end)?;
            observe(&step);
            if step.ends_time_step {
                return Ok(());
            }
        }
    }

    /// Makes the next load step of the time step that ends at `end`. Where it begins a time step,
    /// it depends on `self` and on the couplings in the workspace alone; within one, in its last
    /// digits, on the factor that the workspace still has.
    pub fn next(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        end: f64,
    ) -> Result<LoadStep, Unreached> {
        let step = self.begun(problem, workspace, rest, end);
        loop {
            let done = self.progress.done;
            let next = match done + self.progress.increment {
                beyond if beyond > 1.0 - 1e-9 => 1.0,
                next => next,
            };
            let ends = next >= 1.0;
            let time =
                if ends { end } else { self.progress.time + next * (end - self.progress.time) };
            let newton = if ends { self.stepping.newton } else { loosened(&self.stepping.newton) };
            let start = self.predict(problem, workspace, rest, &step, time, done == 0.0);
            let made = attempt(problem, workspace, &start, time, &newton);
            match made {
                Ok(step) => {
                    let step = LoadStep { ends_time_step: ends, ..step };
                    return Ok(self.accept(step, next, problem, workspace, rest));
                }
                Err(failed) => self.shorten(problem, rest, failed, time)?,
            }
        }
    }

    /// The time step to `end` that is being made, begun if it is not.
    pub(crate) fn begun(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        end: f64,
    ) -> Arc<TimeStep> {
        match &self.step {
            Some(step) if self.progress.done > 0.0 => Arc::clone(step),
            _ => self.begin(problem, workspace, rest, end),
        }
    }

    /// Takes in a load step, which ends at a fraction of its time step.
    pub(crate) fn accept(
        &mut self,
        step: LoadStep,
        fraction: f64,
        problem: &Problem,
        workspace: &Workspace,
        rest: &[Vec3],
    ) -> LoadStep {
        let progress = &mut self.progress;
        progress.newton_iterations += step.newton_iterations;
        if step.newton_iterations <= EASY {
            progress.increment = (GROWTH * progress.increment).min(self.stepping.largest);
        }
        progress.keep(step.clone());
        progress.done = fraction;
        progress.indefinite_starts = workspace.indefinite_starts;
        if step.ends_time_step {
            let made = self.step.as_ref().expect("it was begun");
            let internal = problem.energies.internal(&step.iterate(problem, rest));
            progress.integrator.accept(made, &step.u, internal);
            progress.time = step.time;
            progress.done = 0.0;
        }
        step
    }

    /// Makes the increment smaller after a load step to `load` has failed.
    fn shorten(
        &mut self,
        problem: &Problem,
        rest: &[Vec3],
        failed: Failed,
        time: f64,
    ) -> Result<(), Unreached> {
        let Failed { failure, u, residuals } = failed;
        self.progress.newton_iterations += residuals.len().saturating_sub(1);
        self.progress.increment *= match failure {
            // what is free is known: no need to halve up to it
            Failure::Blocked { free } => (NEARLY * free).clamp(SHORTEST, 0.5),
            _ => 0.5,
        };
        let increment = self.progress.increment;
        let interrupted = matches!(failure, Failure::Interrupted);
        log::debug!("load {time:.4} failed ({failure}); increment {increment:.4}");
        if increment >= self.stepping.smallest && !interrupted {
            return Ok(());
        }
        Err(self.unreached(problem, rest, Failed { failure, u, residuals }, time))
    }

    /// No next state: what failed after the last one, on the way to a time.
    pub(crate) fn unreached(
        &self,
        problem: &Problem,
        rest: &[Vec3],
        Failed { failure, u, residuals }: Failed,
        time: f64,
    ) -> Unreached {
        let at = self.iterate(problem, rest);
        let (reached, multipliers) = (at.u.to_vec(), at.multipliers.to_vec());
        let step = self.step.clone().expect("it was begun");
        let attempt = Attempt { reached, multipliers, step, time, u, residuals };
        Unreached { time: at.time, failure, attempt: Box::new(attempt) }
    }

    /// The latest state before a failure that is in balance to the tolerance of the ends of time steps, which
    /// intermediate load steps need not meet; the start of the time step if there is none.
    pub fn confirmed(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        unreached: &Unreached,
    ) -> Unreached {
        let Unreached { failure, attempt: failed, .. } = unreached;
        let step = &failed.step;
        let balanced = self.progress.last.iter().rev().filter(|at| at.time > self.progress.time);
        let found = balanced.into_iter().find_map(|at| {
            let start = at.configuration(rest, Some(step));
            attempt(problem, workspace, &start, at.time, &self.stepping.newton).ok()
        });
        let ended = self.progress.last.iter().rev().find(|at| at.time <= self.progress.time);
        let start = || {
            let multipliers = ended.map_or(&problem.multipliers, |at| &at.multipliers);
            (self.progress.time, self.progress.integrator.last().u.clone(), multipliers.clone())
        };
        let (time, reached, multipliers) =
            found.map_or_else(start, |step| (step.time, step.u, step.multipliers));
        let attempt = Box::new(Attempt { reached, multipliers, ..Attempt::clone(failed) });
        Unreached { time, failure: failure.clone(), attempt }
    }

    /// The time step that follows, or that was interrupted.
    fn begin(
        &mut self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        end: f64,
    ) -> Arc<TimeStep> {
        workspace.forget();
        if let Some(known) = self.factors.at_time(end) {
            workspace.reuse(known);
        }
        workspace.indefinite_starts = self.progress.indefinite_starts;
        let interrupted = self.progress.done > 0.0;
        if !interrupted && (self.progress.integrator.method.has_inertia() || self.guide.is_some()) {
            // with inertia, or a guide, the prediction is near the solution
            self.progress.increment = 1.0;
        }
        let start = self.iterate(problem, rest);
        let begun =
            Iterate { u: &self.progress.integrator.last().u, time: self.progress.time, ..start };
        let lagged_contacts = problem.lagged_contacts(&begun);
        let step = self.progress.integrator.step(self.progress.time, end);
        let step = Arc::new(TimeStep { lagged_contacts, ..step });
        self.step = Some(Arc::clone(&step));
        step
    }

    /// A state near the next one, that surfaces can reach, at the load of the last: of
    /// [`Self::extrapolations`] and the last state itself the one with the smallest
    /// [`merit`]. Loads may bend where time steps meet, and surfaces may be hit.
    fn predict<'a>(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &'a [Vec3],
        step: &'a Arc<TimeStep>,
        time: f64,
        begins: bool,
    ) -> Configuration<'a> {
        let last = Iterate { step: Some(step), ..self.iterate(problem, rest) };
        let now = Iterate { time, ..last };
        let (mut best, mut smallest) = (Reached::of(&last), None);
        for mut guess in self.extrapolations(&last, time, begins) {
            let free = workspace.max_step(problem, &last, &Iterate { u: &guess.u, ..last });
            guess.u.iter_mut().zip(last.u).for_each(|(u, from)| *u = from + free * (*u - from));
            let merit = merit(problem, workspace, &Iterate { u: &guess.u, ..now });
            if smallest.is_none_or(|smallest| merit < smallest) {
                (best, smallest) = (guess, Some(merit));
            }
        }
        // obstacles that have moved into a state leave forces there that mean nothing
        if let Some(smallest) = smallest
            && workspace.max_step(problem, &last, &now) >= 1.0
            && merit(problem, workspace, &now) <= smallest
        {
            best = Reached::of(&last);
        }
        let is_balanced = !self.progress.integrator.method.has_inertia() && best.u == last.u;
        let mut multipliers = last.multipliers.to_vec();
        multipliers.iter_mut().zip(best.multipliers).for_each(|(m, b)| m.pressure = b.pressure);
        let balanced_at = is_balanced.then_some(last.time);
        Configuration {
            rest,
            time: last.time,
            step: Some(step),
            u: best.u,
            multipliers,
            balanced_at,
        }
    }

    /// Where a guide went, or, at the start of a time step, inertia carries the bodies; else
    /// along a line in the load through the last two states. And along a parabola through
    /// the last three. The first state is the rest shape, where inertia is neglected.
    fn extrapolations(&self, last: &Iterate, time: f64, begins: bool) -> Vec<Reached> {
        let flight = last.step.and_then(|step| step.free_flight.as_ref()).map(|flight| &flight.at);
        let guided = self.guide.as_ref().and_then(|g| g.motion(last.time, time));
        let moved = |by: Vec<f64>| last.u.iter().zip(by).map(|(u, d)| u + d).collect();
        let known = guided.map(moved).or_else(|| flight.filter(|_| begins).cloned());
        let mut points = Vec::new();
        let reached = &self.progress.last;
        if flight.is_none() && reached.len() < STATES {
            let u = vec![0.0; last.u.len()];
            let multipliers = vec![Multiplier::default(); last.multipliers.len()];
            points.push(Reached { time: 0.0, u, multipliers });
        }
        points.extend_from_slice(reached);
        let through = |count: usize| {
            points.len().checked_sub(count).map(|first| extrapolated(&points[first..], time))
        };
        let line = match known {
            Some(u) => Some(Reached { time, u, multipliers: last.multipliers.to_vec() }),
            None => through(2),
        };
        line.into_iter().chain(through(3)).collect()
    }
}

/// How near a state is to the equilibrium: its potential energy [J], which is least there. Small
/// displacements of stiff parts mean large forces, so residuals tell little. With prescribed
/// volumes the equilibrium is a saddle point: then it is the residual [N].
fn merit(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> f64 {
    if !at.multipliers.is_empty() {
        return residual(problem, workspace, at);
    }
    let energy = workspace.value(problem, at);
    if energy.is_nan() { f64::INFINITY } else { energy }
}

/// The polynomial in the load through some states, at another load (Lagrange); of multipliers the
/// pressures alone.
fn extrapolated(points: &[Reached], time: f64) -> Reached {
    let u = vec![0.0; points[0].u.len()];
    let multipliers = vec![Multiplier::default(); points[0].multipliers.len()];
    let mut sum = Reached { time, u, multipliers };
    for (i, own) in points.iter().enumerate() {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 =
            others.map(|(_, other)| (time - other.time) / (own.time - other.time)).product();
        sum.u.iter_mut().zip(&own.u).for_each(|(s, v)| *s += weight * v);
        let multipliers = sum.multipliers.iter_mut().zip(&own.multipliers);
        multipliers.for_each(|(s, m)| s.pressure += weight * m.pressure);
    }
    sum
}
