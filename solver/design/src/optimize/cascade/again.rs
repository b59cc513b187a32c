//! The design at the end with a re-meshed interior: flat elements that a design came to are stiff, and what it
//! gained by them is no gain of the body.

use std::collections::BTreeMap;

use anyhow::Result;

use super::spread::tidied;
use super::{Cascade, Finished};
use crate::optimize::{Level, Start};

/// What the design comes to there.
pub struct Again {
    /// The objective.
    pub objective: f64,
    /// Probes of the scene in the first scenario, in the units of their kinds.
    pub probes: BTreeMap<String, f64>,
}

impl Cascade<'_> {
    /// The design with a re-meshed interior; none where no shape moves.
    pub fn again(&self, finished: &Finished) -> Result<Option<Again>> {
        let (before, at) = &finished.last;
        if before.map().moving().is_empty() {
            return Ok(None);
        }
        let settings = &self.design.levels()[finished.level];
        let scene = self.scene.with_fidelity(settings)?;
        let body = tidied(&finished.body, before.map().moving())?;
        let mut level = Level::new(&scene, self.objectives, body, self.design, settings)?;
        level.set_weights(&before.weights());
        let theta = level.map().start(&before.map().loads(&finished.theta));
        let carried = before.carry(at, &level.body, scene.config.degree);
        let (times, states): (Vec<f64>, Vec<Vec<f64>>) = carried.into_iter().unzip();
        let runs = level.carried(&theta, &times, states.into_iter().map(anyhow::Ok))?;
        let found = level.evaluate(&theta, Start::Carried(&runs));
        let found = match found {
            Ok(found) => found,
            Err(_) => level.evaluate(&theta, Start::Rest)?,
        };
        let probes = level.measured(&found)?.swap_remove(0);
        Ok(Some(Again { objective: found.objective, probes }))
    }
}
