//! Second derivatives of the objective of a level.

use std::sync::Arc;

use anyhow::Result;
use mechanics::forward::Trajectory;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::scenario::{Near, Run, Scenario};
use super::vectors::along;
use super::{Evaluation, Level, Rejected};

/// Motion of the surface by which runs are varied, over its mean edge [1]. Forces are differences of residuals, whose second
/// order is large where elements are flat and hardly change their volume: with 1e-5 changes were off by 2 to 4 %, and steps
/// met a target by thirds; with 1e-8 by squares. There they were off by 2e-5 of the largest on that body.
const VARIATION: f64 = 1e-8;

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
        let sizes = self.variations(theta);
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

    /// Mean square of the motion of the moving surface as a quadratic form in a step from θ; the variables of loads
    /// count as motions.
    pub fn metric(&self, theta: &[f64]) -> DMatrix<f64> {
        let sizes = self.variations(theta);
        let shapes = self.map.shape_variables();
        let here = self.map.surface(theta);
        let column = |i: usize| -> Vec<f64> {
            let there = self.map.surface(&moved(theta, i, sizes[i]));
            let motion = |(a, b): (&mesh::Vec3, &mesh::Vec3)| (a - b) / sizes[i];
            there.iter().zip(&here).map(motion).flat_map(|d| [d.x, d.y, d.z]).collect()
        };
        let columns: Vec<Vec<f64>> = (0..shapes).into_par_iter().map(column).collect();
        let moving = columns.iter().fold(vec![false; 3 * here.len()], |mut all, column| {
            all.iter_mut().zip(column).for_each(|(all, d)| *all |= *d != 0.0);
            all
        });
        let count = (moving.iter().filter(|moves| **moves).count() as f64 / 3.0).max(1.0);
        DMatrix::from_fn(theta.len(), theta.len(), |i, j| match (i < shapes, j < shapes) {
            (true, true) => {
                columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>() / count
            }
            _ => f64::from(u8::from(i == j)),
        })
    }

    /// How far each variable is varied.
    fn variations(&self, theta: &[f64]) -> Vec<f64> {
        let small = VARIATION * self.map.mean_edge;
        let size =
            |i| small * small / self.map.motion(theta, &moved(theta, i, small)).max(1e-3 * small);
        (0..theta.len()).map(size).collect()
    }
}

/// θ with one variable moved.
fn moved(theta: &[f64], i: usize, by: f64) -> Vec<f64> {
    let mut theta = theta.to_vec();
    theta[i] += by;
    theta
}
