//! The design at the end with a re-meshed interior: flat elements that a design came to are stiff, and what it
//! gained by them is no gain of the body.

use anyhow::Result;
use reports::{Designed, Remeshed, numbers};
use run::report::summary;

use super::{Cascade, Finished};
use crate::optimize::Level;
use crate::optimize::meshes::tidied;

/// A larger difference of the objective between two meshes of the design, over what was gained, says that its elements are
/// poor [1].
const OFF: f64 = 0.1;

impl Cascade<'_> {
    /// What the design comes to there; none where no shape moves, or no equilibrium is found.
    pub(super) fn remeshed(&self, finished: &Finished, designed: &Designed) -> Option<Remeshed> {
        if finished.level.map().moving().is_empty() {
            return None;
        }
        let again = self.again(finished);
        let unknown = |why: anyhow::Error| {
            log::warn!("with a re-meshed interior the design was not simulated: {why:#}")
        };
        let (other, again) = again.map_err(unknown).ok()?;
        let own = finished.at.objective;
        let gain = (designed.objective_before.unwrap_or(f64::NAN) - own).abs();
        let probes = designed.probes.iter().flatten().filter_map(|(name, probe)| {
            let value = (*again.probes.get(name)?)?;
            Some(format!(", {name} {}", summary::quantity(value, &probe.unit)))
        });
        let said = format!(
            "with a re-meshed interior the objective is {other:.4e} in place of {own:.4e}{}",
            probes.collect::<String>()
        );
        match (other - own).abs() > OFF * gain {
            true => log::warn!("{said}: elements of the design are poor; a finer mesh tells more"),
            false => log::info!("{said}"),
        }
        Some(again)
    }

    fn again(&self, finished: &Finished) -> Result<(f64, Remeshed)> {
        let Finished { level: before, at, checkpoint, .. } = finished;
        let settings = &self.design.levels()[checkpoint.level];
        let scene = self.scene.with_fidelity(settings)?;
        let body = tidied(&before.shape(at), before.map().moving())?;
        let mut level = Level::new(&scene, &self.objectives, body, self.design, settings)?;
        level.set_weights(&before.weights());
        let theta = level.map().start(&before.map().loads(&at.theta));
        let carried = before.carry(at, &level.body, scene.config.degree);
        let (times, states): (Vec<f64>, Vec<Vec<f64>>) = carried.into_iter().unzip();
        let near = level.carried(&theta, &times, states.into_iter().map(anyhow::Ok))?;
        let found = level.evaluate(&theta, &near).or_else(|_| level.evaluate(&theta, &[]))?;
        let probes = numbers(&level.measured(&found)?.swap_remove(0));
        Ok((found.objective, Remeshed { objective: Some(found.objective), probes }))
    }
}
