//! A run of a scenario.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;
use measure::probe::measure;
use measure::quantity::{Equilibrium, Forces};
use mechanics::body::Body;
use mechanics::energy::Iterate;
use mechanics::forward::{Linearizations, Problem, State, Trajectory};
use mesh::Vec3;

use super::{Near, Scenario};
use reports::Crossing;
use run::report::crossing;
use run::report::results::{displacements, grid_with_fields};

/// A run and its objective.
#[derive(Clone)]
pub struct Run {
    /// What was solved: the scenario with the designed loads.
    pub problem: Arc<Problem>,
    /// Rest vertex positions, with walls that are off [m].
    pub rest: Vec<Vec3>,
    /// All states.
    pub states: Arc<Trajectory>,
    /// Tangents at the ends of its time steps; none before [`Scenario::linearized`].
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
