//! The burst on the way of growing loads, between the first two states between which the largest stretch passes that at
//! break.
//!
//! Newton's method from the state between both, on the line through them, most often comes to it. Where it does not,
//! an equilibrium at the load between takes the place of one of the two, and it is tried again.

use mesh::Vec3;

use super::Burst;
use crate::energy::Iterate;
use crate::forward::{Failure, Problem, Reached, Stepping, Workspace, solve_from};
use crate::stretch::LargestStretch;

/// States between two others that are tried, at most.
const TRIED: usize = 40;
/// First step of the load downward, as a part of that at the start ...
const DOWN: f64 = 0.1;
/// ... and states on the way down, at most.
const STATES: usize = 200;
/// Fraction of the free path of surfaces that a start goes.
const NEARLY: f64 = 0.9;
/// Relative difference of loads that is none.
const ROUNDING: f64 = 1e-9;

/// Where a body bursts.
pub enum FirstBurst {
    /// A state.
    At(Box<Burst>),
    /// Between two loads, at which no state was found.
    Between([f64; 2]),
    /// The first state is stretched beyond the break, and no state with less stretch was found.
    Beyond(Option<Failure>),
    /// Not on the way.
    Never,
}

/// A state and its largest stretch.
#[derive(Clone)]
struct Stretched {
    at: Reached,
    stretch: f64,
}

impl Stretched {
    fn of(at: &Iterate) -> Self {
        let stretch = LargestStretch::of(at.space, at.rest, at.u).value;
        Self { at: Reached::of(at), stretch }
    }
}

/// Looks at the states of a path, one after the other.
pub struct BurstSearch {
    at_break: f64,
    last: Stretched,
    /// The states before and after the burst.
    between: Option<[Stretched; 2]>,
}

impl BurstSearch {
    /// Begins at the first state, whose stretch may be beyond that at break.
    pub fn new(start: &Iterate, at_break: f64) -> Self {
        Self { at_break, last: Stretched::of(start), between: None }
    }

    /// Largest stretch of the last state.
    pub fn stretch(&self) -> f64 {
        self.last.stretch
    }

    /// Whether a state has been beyond the stretch at break.
    pub fn has_passed(&self) -> bool {
        self.between.is_some() || self.last.stretch >= self.at_break
    }

    /// Takes in the next state of a stable path.
    pub fn pass(&mut self, at: &Iterate) {
        if self.has_passed() {
            return;
        }
        let next = Stretched::of(at);
        if next.stretch >= self.at_break {
            self.between = Some([self.last.clone(), next.clone()]);
        }
        self.last = next;
    }

    /// The burst of what has passed. From a first state that is beyond the stretch at break, the load is lowered.
    pub fn found(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        stepping: &Stepping,
    ) -> FirstBurst {
        let bracketing = Bracketing { problem, rest, at_break: self.at_break, stepping };
        match &self.between {
            Some(between) => bracketing.narrowed(workspace, between.clone()),
            None if !self.has_passed() => FirstBurst::Never,
            None => match bracketing.lowered(workspace, self.last.clone()) {
                Ok(between) => bracketing.narrowed(workspace, between),
                Err(failure) => FirstBurst::Beyond(failure),
            },
        }
    }
}

/// What is the same for all states of a path.
struct Bracketing<'a> {
    problem: &'a Problem,
    rest: &'a [Vec3],
    at_break: f64,
    stepping: &'a Stepping,
}

impl Bracketing<'_> {
    /// The equilibrium at the load of a state near by.
    fn balanced(&self, workspace: &mut Workspace, near: &Reached) -> Result<Stretched, Failure> {
        let start = near.configuration(self.rest, None);
        let found = solve_from(self.problem, workspace, &start, &self.stepping.newton)?;
        Ok(Stretched::of(&found.iterate(self.problem, self.rest)))
    }

    /// The fraction of the way from one state to another that surfaces are free.
    fn free(&self, workspace: &mut Workspace, from: &Reached, to: &Reached) -> f64 {
        let [from, to] = [from, to].map(|at| at.configuration(self.rest, None));
        let problem = self.problem;
        let free = workspace.max_step(problem, &from.iterate(problem), &to.iterate(problem));
        if free < 1.0 { NEARLY * free } else { 1.0 }
    }

    /// States before and after the burst, below a state that is beyond it.
    fn lowered(
        &self,
        workspace: &mut Workspace,
        mut above: Stretched,
    ) -> Result<[Stretched; 2], Option<Failure>> {
        let start = above.at.time;
        let mut part = DOWN;
        for _ in 0..STATES {
            let time = (above.at.time - part * start).max(0.0);
            match self.balanced(workspace, &Reached { time, ..above.at.clone() }) {
                Ok(below) if below.stretch < self.at_break => return Ok([below, above]),
                Ok(_) if time == 0.0 => return Err(None),
                Ok(beyond) => above = beyond,
                Err(failure) if part < self.stepping.smallest * DOWN => return Err(Some(failure)),
                Err(_) => part *= 0.5,
            }
        }
        Err(None)
    }

    /// The burst between two states.
    fn narrowed(
        &self,
        workspace: &mut Workspace,
        [mut below, mut above]: [Stretched; 2],
    ) -> FirstBurst {
        let newton = &self.stepping.newton;
        let mut part = (self.at_break - below.stretch) / (above.stretch - below.stretch);
        for _ in 0..TRIED {
            part *= self.free(workspace, &below.at, &between(&below.at, &above.at, part));
            let between = between(&below.at, &above.at, part);
            let start = between.configuration(self.rest, None);
            let loads = [below.at.time, above.at.time];
            match Burst::near(self.problem, workspace, &start, self.at_break, newton) {
                Ok(found) if found.negative == 0 && is_between(found.at.time, loads) => {
                    return FirstBurst::At(Box::new(found));
                }
                Ok(found) => log::debug!("a burst at {} is not between {loads:?}", found.at.time),
                Err(failure) => log::debug!("no burst between {loads:?}: {failure}"),
            }
            match self.balanced(workspace, &between) {
                Ok(next) if next.stretch < self.at_break => (below, part) = (next, 0.5),
                Ok(next) => (above, part) = (next, 0.5),
                // nearer to a state that is one
                Err(_) => part *= 0.5,
            }
        }
        FirstBurst::Between([below.at.time, above.at.time])
    }
}

/// The state on the line through two others.
fn between(below: &Reached, above: &Reached, part: f64) -> Reached {
    let line = |a: f64, b: f64| a + part * (b - a);
    let u = below.u.iter().zip(&above.u).map(|(a, b)| line(*a, *b)).collect();
    let mut multipliers = below.multipliers.clone();
    for (m, other) in multipliers.iter_mut().zip(&above.multipliers) {
        m.pressure = line(m.pressure, other.pressure);
    }
    Reached { time: line(below.time, above.time), u, multipliers }
}

fn is_between(load: f64, [from, to]: [f64; 2]) -> bool {
    let slack = ROUNDING * to.abs();
    load >= from - slack && load <= to + slack
}
