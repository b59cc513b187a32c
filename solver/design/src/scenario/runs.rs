//! Runs of a scenario: from rest, next to another run, or the one equilibrium next to a displacement; and what is told of
//! them.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;
use measure::probe::measure;
use measure::quantity::{Equilibrium, Forces};
use mechanics::body::Body;
use mechanics::energy::Iterate;
use mechanics::forward::{
    Failure, Linearizations, Newton, Problem, State, Stepping, TimeStepper, Trajectory, follow,
};
use mesh::Vec3;
use program::Heartbeat;
use reports::Crossing;

use super::{NotReached, Rejected, Scenario};
use run::next_to::next_to;
use run::report::crossing;
use run::report::failure::inverted;
use run::report::results::{displacements, grid_with_fields};

/// Newton iterations from a nearby equilibrium. Accepted shapes of the frog
/// took 2 to 8; what takes more is better reached by a shorter step.
const NEARBY: usize = 12;
/// Newton iterations in a load step of a run next to another, where bodies hit each other:
/// simulated from rest, the worm took at most 22, the gripper 11.
const NEARBY_IN_TIME: usize = 30;
/// Smallest load step of such a run, as a fraction of a time step.
const NEARBY_INCREMENT: f64 = 0.25;

/// Volume at which a softening chamber is taken to balloon, over that at its start: next to another run ...
const BALLOONED_NEARBY: f64 = 1.0;
/// ... and from rest, where a chamber may grow a lot.
const BALLOONED: f64 = 4.0;

/// Part of the memory that states leave which factors of tangents may take.
const FOR_TANGENTS: f64 = 0.25;

/// Where a run is looked for.
pub enum Near {
    /// From rest.
    Rest,
    /// The one equilibrium of a scene without time, next to a displacement [m]: keeps a
    /// search on one branch of equilibria, and is several times cheaper.
    Displacement(Vec<f64>),
    /// From rest through time, next to the states of another run, with tangents of one next to it; without time, the one
    /// equilibrium next to the end of that run.
    Run(Arc<Trajectory>, Arc<Linearizations>),
    /// From rest through time, next to the states of a run on another mesh. As many iterations are allowed as from rest.
    Carried(Arc<Trajectory>),
}

/// States of a run, and the Newton iterations that they took.
type Solved = (Trajectory, usize);

/// A run and its objective.
#[derive(Clone)]
pub struct Run {
    /// What was solved: the scenario with the designed loads.
    pub problem: Arc<Problem>,
    /// Rest vertex positions, with walls that are off [m].
    pub rest: Vec<Vec3>,
    /// All states.
    pub states: Arc<Trajectory>,
    /// Tangents at the ends of its time steps; none before [`Scenario::linearize`].
    pub tangents: Arc<Linearizations>,
    /// The slope of the pressure at its end [1], where it is kept.
    pub slope: Option<f64>,
    /// Σ of the terms.
    pub objective: f64,
    /// Weighted value of each term, by the user's name.
    pub terms: BTreeMap<String, f64>,
    /// c of each bound, which is to be 0 or more, in its unit.
    pub kept: Vec<f64>,
    /// Newton iterations.
    pub newton_iterations: usize,
}

impl Run {
    /// What terms look at in a state of it, the end of time step n.
    pub(super) fn equilibrium<'a>(
        &'a self,
        n: usize,
        state: &'a State,
        forces: &'a Forces,
    ) -> Equilibrium<'a> {
        let at = self.problem.iterate(&self.rest, &state.u, self.states.times[n]);
        Equilibrium::new(&self.problem, &at, forces)
    }

    /// Looks at the end of the run.
    fn at_end<T>(&self, look: impl FnOnce(&Iterate) -> T) -> T {
        let Self { problem, states, rest, .. } = self;
        let (u, load) = (states.last(), states.times[states.steps()]);
        let step = states.step(problem, rest, states.steps());
        look(&Iterate { step: Some(&step), ..problem.iterate(rest, &u, load) })
    }

    /// Next to this one, with its tangents.
    pub fn near(&self) -> Near {
        Near::Run(Arc::clone(&self.states), Arc::clone(&self.tangents))
    }

    /// The solution's grid for ParaView, at the end.
    pub fn grid(&self) -> mesh::io::vtu::Grid {
        self.at_end(|end| grid_with_fields(&self.problem.energies, end))
    }
}

impl Scenario {
    /// The run on a designed rest shape, with these variables of the loads.
    pub fn run(&self, loads: &[f64], designed: &[Vec3], near: &Near) -> Result<Run, Rejected> {
        let (rest, problem) = (self.rest(designed), self.under(loads)?);
        let through_time = |stepping, guide: Option<&Arc<_>>, tangents: &Arc<_>| {
            let stepper = TimeStepper::new(stepping, self.start.clone());
            let stepper = stepper.guided(guide.cloned()).with_factors(Arc::clone(tangents));
            self.solve(&problem, &rest, stepper)
        };
        let solved = match near {
            Near::Rest => through_time(self.patient(), None, &Arc::default()),
            Near::Run(run, _) | Near::Carried(run) if !self.is_transient() => {
                self.solve_next_to(&problem, &rest, &run.last())
            }
            Near::Run(guide, tangents) => through_time(self.nearby(), Some(guide), tangents),
            Near::Carried(guide) => through_time(self.patient(), Some(guide), &Arc::default()),
            Near::Displacement(u) => self.solve_next_to(&problem, &rest, u),
        };
        self.evaluated(problem, rest, solved?)
    }

    /// A run as it was, from its states at the ends of time steps.
    pub fn recall(
        &self,
        loads: &[f64],
        designed: &[Vec3],
        states: Trajectory,
    ) -> Result<Run, Rejected> {
        self.evaluated(self.under(loads)?, self.rest(designed), (states, 0))
    }

    /// States with displacements at times [s, m], as those of a run.
    pub fn states<E: Into<anyhow::Error>>(
        &self,
        loads: &[f64],
        designed: &[Vec3],
        displacements: impl Iterator<Item = (f64, Result<Vec<f64>, E>)>,
    ) -> Result<Trajectory> {
        let (rest, problem) = (self.rest(designed), self.under(loads)?);
        let mut states = Trajectory::begin(&self.start, self.state_memory);
        for (end, u) in displacements {
            states.push_displacement(&problem, &rest, end, &u.map_err(Into::into)?);
        }
        Ok(states)
    }

    fn evaluated(
        &self,
        problem: Arc<Problem>,
        rest: Vec<Vec3>,
        (states, newton_iterations): Solved,
    ) -> Result<Run, Rejected> {
        let slope = self.slope(&problem, &rest, &states)?;
        let run = Run {
            problem,
            rest,
            states: Arc::new(states),
            tangents: Arc::default(),
            slope,
            objective: 0.0,
            terms: BTreeMap::new(),
            kept: Vec::new(),
            newton_iterations,
        };
        Ok(self.rated(&run))
    }

    /// Makes a run ready for [`Self::sweep`], [`Self::curvature`], [`Self::predict`] and runs next to it. What follows
    /// depends on that run alone, not on how it was reached: an interrupted search continues with the same bits.
    pub fn linearize(&self, run: &mut Run) {
        run.tangents = Arc::default();
        let Run { problem, rest, states, .. } = &*run;
        let workspace = &mut self.workspaces().equilibrium;
        let known = if !self.is_transient() {
            Linearizations::at_end(problem, workspace, rest, states)
        } else if problem.energies.contact_terms().next().is_none() {
            let memory = FOR_TANGENTS * states.memory_left();
            Linearizations::of(problem, workspace, rest, states, memory)
        } else {
            // contact changes the pattern from one time step to the next
            return;
        };
        run.tangents = Arc::new(known);
    }

    /// First-order change of the equilibrium of a run, which is linearised, to another
    /// designed shape. None where the equilibrium is not stable, or of a run through time.
    pub fn predict(&self, run: &Run, designed: &[Vec3]) -> Option<Vec<f64>> {
        if self.is_transient() {
            return None;
        }
        let rest = self.rest(designed);
        let motion: Vec<Vec3> = rest.iter().zip(&run.rest).map(|(a, b)| a - b).collect();
        let tangent = run.tangents.step(1)?;
        follow(&run.problem, &mut self.workspaces().equilibrium, tangent, &run.rest, &motion)
    }

    /// How a run from rest steps, or one next to a run on another mesh.
    fn patient(&self) -> Stepping {
        let newton = Newton { ballooned: Some(BALLOONED), ..self.stepping.newton };
        Stepping { newton, ..self.stepping }
    }

    /// How a run next to another one steps: what needs more is not near.
    fn nearby(&self) -> Stepping {
        let mut stepping = self.stepping;
        stepping.newton.iterations = stepping.newton.iterations.min(NEARBY_IN_TIME);
        stepping.newton.ballooned = Some(BALLOONED_NEARBY);
        stepping.smallest = stepping.smallest.max(NEARBY_INCREMENT);
        stepping
    }

    /// All states from rest.
    fn solve(
        &self,
        problem: &Arc<Problem>,
        rest: &[Vec3],
        mut stepper: TimeStepper,
    ) -> Result<Solved, Rejected> {
        let mut heartbeat = Heartbeat::start();
        let workspace = &mut self.workspaces().equilibrium;
        let title = self.config.title().map(|title| format!("{title}: ")).unwrap_or_default();
        let run = stepper.run(problem, workspace, rest, &self.times, self.state_memory, |step| {
            heartbeat.say(|| format!("  {title}a run is at {}", self.scene.progress(step.time)));
        });
        match run {
            Ok(states) => Ok((states, stepper.progress.newton_iterations)),
            Err(unreached) => {
                let why = self.reject(&unreached).why;
                let problem = Arc::clone(problem);
                let unreached = NotReached { scenario: 0, problem, unreached };
                Err(Rejected { why, unreached: Some(Box::new(unreached)) })
            }
        }
    }

    /// The one equilibrium next to a displacement.
    fn solve_next_to(
        &self,
        problem: &Problem,
        rest: &[Vec3],
        u: &[f64],
    ) -> Result<Solved, Rejected> {
        let newton = Newton {
            iterations: NEARBY,
            ballooned: Some(BALLOONED_NEARBY),
            ..self.stepping.newton
        };
        let (workspace, on) = (&mut self.workspaces().equilibrium, (rest, self.times[0]));
        let found = next_to(&self.start, (problem, workspace), on, u, &newton);
        let solution = found.map_err(|failure| match inverted(&problem.space, rest, u) {
            Some(said) if matches!(failure, Failure::Inadmissible) => {
                self.reject(format!("foreseen from the step before, {said}"))
            }
            _ => self.reject(failure),
        })?;
        let mut run = Trajectory::begin(&self.start, self.state_memory);
        run.push_displacement(problem, rest, self.times[0], &solution.u);
        Ok((run, solution.newton_iterations))
    }

    /// The body at rest in a run.
    fn body_of(&self, run: &Run) -> Body {
        let mut body = self.body.clone();
        body.mesh.vertices.clone_from(&run.rest);
        body
    }

    /// Mean displacement of each tag over its rest area at the end of a run [m].
    pub fn mean_displacements(&self, run: &Run) -> Result<BTreeMap<String, f64>> {
        let body = self.body_of(run);
        let one = |name: &String| {
            let facets = body.facets(name)?;
            let report = displacements(&body, &run.problem.space, &facets, &run.states.last());
            Ok((name.clone(), report.mean_displacement))
        };
        body.used_tags().map(one).collect()
    }

    /// The probes of the scene at the end of a run, in the units of their kinds, and the slope of the pressure, where it is kept.
    pub fn measured(&self, run: &Run) -> Result<BTreeMap<String, f64>> {
        let probes = self.scene.probes(&self.body_of(run), &run.problem.space)?;
        let mut found = run.at_end(|end| measure(&probes, &run.problem, end));
        found.extend(run.slope.map(|slope| ("slope".to_owned(), slope)));
        Ok(found)
    }

    /// Surfaces of the body that have passed through each other at the end of a run.
    pub fn crossing(&self, run: &Run) -> Option<Crossing> {
        run.at_end(|end| crossing::find(&self.scene, &self.body, &run.problem, end))
    }
}
