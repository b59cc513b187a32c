//! Second derivatives of the objective of a level.

use std::sync::Arc;

use anyhow::Result;
use mechanics::forward::Trajectory;
use nalgebra::DMatrix;
use rayon::prelude::*;
use variables::vectors::{along, moved};

use super::scenario::{Near, Run, Scenario};
use super::{Evaluation, Level, Rejected};

/// Variables beyond which the first-order changes of all take too much time and memory.
pub const MOST_VARIABLES: usize = 400;

/// Second derivatives of the objective, and the first-order changes of the runs that they are along.
pub struct Curvature {
    /// The matrix.
    pub matrix: DMatrix<f64>,
    /// How far each variable was varied.
    sizes: Vec<f64>,
    /// States of each scenario with each variable varied.
    states: Vec<Vec<Arc<Trajectory>>>,
}

impl Level {
    /// Curvature of the objective along first-order changes of the runs of a linearised evaluation. None where a run
    /// has no usable tangent.
    pub fn curvature(&self, at: &Evaluation) -> Result<Option<Curvature>, Rejected> {
        let theta = &at.theta[..];
        let sizes = self.map.variations(theta);
        let varied: Vec<Vec<f64>> = (0..theta.len()).map(|i| moved(theta, i, sizes[i])).collect();
        let shapes: Vec<_> = varied.par_iter().map(|theta| self.map.shape(theta)).collect();
        let objectives: Vec<f64> = at.runs.iter().map(|run| run.objective).collect();
        let by = self.robust.derivatives(&objectives);
        let mut sum = DMatrix::zeros(theta.len(), theta.len());
        let mut states = Vec::new();
        for ((scenario, run), by) in self.runs(at).zip(by) {
            let vary = |(theta, shape): (&Vec<f64>, &Vec<_>)| {
                scenario.varied(self.map.load_variables(theta), shape)
            };
            let varied: Vec<_> = varied.iter().zip(&shapes).map(vary).collect::<Result<_, _>>()?;
            let Some((matrix, of)) = scenario.curvature(run, &varied) else {
                return Ok(None);
            };
            sum += by * matrix;
            states.push(of);
        }
        let of_runs =
            DMatrix::from_fn(theta.len(), theta.len(), |i, j| sum[(i, j)] / (sizes[i] * sizes[j]));
        let mut of_costs = DMatrix::zeros(theta.len(), theta.len());
        for (_, i, [.., bend]) in self.map.costs(theta) {
            of_costs[(i, i)] += bend;
        }
        Ok(Some(Curvature { matrix: of_runs + of_costs, sizes, states }))
    }

    /// Where the runs after a step d are looked for: at what the first-order changes of those of a linearised evaluation,
    /// through time along its curvature, come to.
    pub fn ahead(
        &self,
        d: &[f64],
        at: &Evaluation,
        curvature: Option<&Curvature>,
    ) -> Result<Vec<Near>> {
        match curvature {
            Some(curvature) if self.is_transient() => self.foreseen(d, at, curvature),
            _ => Ok(self.predict(&along(&at.theta, d, 1.0), at).unwrap_or_else(|| self.near(at))),
        }
    }

    /// The runs after a step d from an evaluation, to first order.
    fn foreseen(&self, d: &[f64], at: &Evaluation, curvature: &Curvature) -> Result<Vec<Near>> {
        let there = along(&at.theta, d, 1.0);
        let (shape, loads) = (self.map.shape(&there), self.map.load_variables(&there));
        let parts: Vec<f64> = d.iter().zip(&curvature.sizes).map(|(d, size)| d / size).collect();
        let one = |((scenario, run), states): ((&Scenario, &Run), &Vec<Arc<Trajectory>>)| {
            let neighbours: Vec<_> =
                parts.iter().copied().zip(states.iter().map(|s| &**s)).collect();
            let states = scenario.foreseen(run, &neighbours, loads, &shape)?;
            Ok(Near::Run(Arc::new(states), Arc::clone(&run.tangents)))
        };
        self.runs(at).zip(&curvature.states).map(one).collect()
    }

    /// Whether it has so few variables that their curvature is within reach.
    pub fn is_small(&self) -> bool {
        self.variables() <= MOST_VARIABLES
    }
}
