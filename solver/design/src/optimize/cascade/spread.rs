//! Starts of a design beside the body as modelled: the surface that moves, and the loads, are changed at random.

use anyhow::{Result, bail};
use mechanics::body::Body;
use mechanics::math::linear::norm;
use mechanics::math::random::Random;
use scene::config::LevelConfig;

use super::Cascade;
use crate::optimize::meshes::tidied;
use crate::optimize::{Level, Rejected};

/// Largest motion of the surface, over its mean edge [1].
const SPREAD: f64 = 1.0;
/// The same of a variable of the loads.
const LOADS: f64 = 2.0;
/// How often a motion is halved until the shape is valid.
const HALVINGS: usize = 8;

impl Cascade<'_> {
    /// The body, as it is and with its interior re-meshed, and the loads of the start with this number, the second or a later
    /// one: all handles of the first level that
    /// has some move at random, as far as shapes are valid and keep the constraints.
    pub(super) fn spread_start(&self, number: usize) -> Result<(Body, Body, Vec<f64>)> {
        let levels = self.design.levels();
        let settings = levels.iter().find(|level| level.handles.is_some()).unwrap_or(&levels[0]);
        let settings = LevelConfig { mesh: None, body: None, ..settings.clone() };
        let scene = self.scene.with_fidelity(&settings)?;
        let body = scene.body.clone();
        let level = Level::new(&scene, &self.objectives, body, self.design, &settings)?;
        let mut random = Random::new(number as u64);
        let (shapes, count) = (level.map().shape_variables(), level.variables());
        let direction = random.numbers(count);
        let loads = level.map().mean_edge() * LOADS / norm(&direction[shapes..]).max(1.0);
        let zero = vec![0.0; count];
        let mut only_shape = direction.clone();
        only_shape[shapes..].fill(0.0);
        let edge = level.map().mean_edge();
        // at a small amplitude the motion is proportional to it
        let unit = 1e-3 * edge / norm(&direction).max(1.0);
        let small: Vec<f64> = only_shape.iter().map(|d| unit * d).collect();
        let per_unit = level.map().motion(&zero, &small) / unit;
        let mut amplitude = if shapes == 0 { 0.0 } else { SPREAD * edge / per_unit };
        let mut why = String::new();
        for _ in 0..HALVINGS {
            let mut theta: Vec<f64> = only_shape.iter().map(|d| amplitude * d).collect();
            let of_loads = theta[shapes..].iter_mut().zip(&direction[shapes..]);
            of_loads.for_each(|(own, d)| *own = loads * d);
            if let Some((low, high)) = level.map().bounds(&zero) {
                let each = theta.iter_mut().enumerate();
                each.for_each(|(i, own)| *own = own.clamp(low[i], high[i]));
            }
            match tried(&level, &theta) {
                Ok(theta) => {
                    let mut body = scene.body.clone();
                    body.mesh.vertices = level.map().shape(&theta);
                    let tidied = tidied(&body, level.map().moving())?;
                    return Ok((body, tidied, level.map().loads(&theta)));
                }
                Err(rejected) => (why, amplitude) = (rejected.why, 0.5 * amplitude),
            }
        }
        bail!("start {number}: no shape next to the body as modelled is valid: {why}")
    }
}

/// The variables next to these that keep the constraints, if they give a valid shape.
fn tried(level: &Level, theta: &[f64]) -> Result<Vec<f64>, Rejected> {
    let zero = vec![0.0; theta.len()];
    let theta = level.restored(theta)?;
    if level.free_fraction(&zero, &theta) < 1.0 {
        return Err(Rejected::new("the surface would pass through itself"));
    }
    level.admit(&level.map().shape(&theta))?;
    Ok(theta)
}
