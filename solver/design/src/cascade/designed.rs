//! What an optimisation came to: its files, its report, and what is said of it.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use measure::constraint::Constraint;
use mesh::io::vtu;
use program::Unusable;
use reports::{
    Castable, Designed, DesignedProbe, Ended, Iteration, Kept, LevelEnd, Optimization, Remeshed,
    numbers,
};
use run::report::crossing;
use run::report::{results, summary};
use scene::config::{ObjectiveConfig, ProbeConfig};
use serde::Serialize;
use serde_json::json;

use super::{CASTABLE, Cascade, Finished, LATEST};
use crate::Level;
use crate::folder::forget_start;
use crate::meshes::{mesh_file, tidied, write_bodies};

/// A smaller fall of the objective is hardly a design [1].
const LITTLE: f64 = 0.01;
/// A larger difference of the objective between two meshes of the design, over what was gained, says that its elements are
/// poor [1].
const OFF: f64 = 0.1;

impl Cascade<'_> {
    /// Designs to the end, from the start or from where the folder's checkpoint says; writes and says what that came to.
    pub fn design(&self, since: Instant) -> Result<()> {
        let finished = self.run().map_err(|error| {
            // the first error is the one that counts
            let _ = forget_start(&self.folder);
            self.problem.file.place(error)
        })?;
        let lines = self.history().read()?;
        self.write(&finished, &lines)?;
        let Finished { level, at, .. } = &finished;
        let crossing = level.runs(at).find_map(|(scenario, run)| scenario.crossing(run));
        let mut designed = self.designed(&finished, &lines, since)?;
        designed.crossing.clone_from(&crossing);
        designed.remeshed = self.remeshed(&finished, &designed);
        let violated = level.violated(at);
        let status = match (&crossing, &violated) {
            (Some(_), _) => Ended::SurfacesCrossed,
            (None, Some(_)) => Ended::NotKept,
            (None, None) => self.ended(&finished),
        };
        let usable = crossing.is_none() && violated.is_none();
        let report =
            Optimization { status, usable, designed: Some(designed.clone()), failed: None };
        results::write_report(&self.folder, &report)?;
        let is_better = self.say(&finished, &designed, status);
        let why = match (crossing, violated) {
            (Some(crossing), _) => crossing::in_words(&crossing),
            (None, Some(violated)) => format!("the design does not keep {violated}"),
            (None, None) if is_better => return Ok(()),
            (None, None) => {
                let report = self.folder.join("report.json");
                format!("no step lowered the objective; see the reasons in {}", report.display())
            }
        };
        Err(Unusable(format!("{}: {why}", self.problem.path.display())).into())
    }

    /// Writes the designed bodies and loads, and the run at the end.
    fn write(&self, finished: &Finished, lines: &[Iteration]) -> Result<()> {
        let folder = &self.folder;
        write_bodies(folder, "design", self.scene, &finished.level.shape(&finished.at))?;
        let is_refused =
            matches!(lines.last(), Some(Iteration { mold: Some(Castable::Refused { .. }), .. }));
        for part in &self.scene.body.parts {
            let name = part.name.as_deref();
            mesh::io::remove_output(&folder.join(mesh_file(LATEST, name)))?;
            let castable = folder.join(mesh_file(CASTABLE, name));
            if !is_refused {
                mesh::io::remove_output(&castable)?;
            } else if castable.exists() {
                let castable = castable.display();
                log::warn!("the design cannot be cast; the last shape that can is {castable}");
            }
        }
        let Finished { level, at, .. } = finished;
        vtu::write_vtu(&folder.join("result.vtu"), &at.runs[0].grid())?;
        let times = &at.runs[0].states.times;
        let one = |(on, values): (String, Vec<f64>)| json!({ "on": on, "pressure": { "t": times, "value": values } });
        let chambers: Vec<_> = level.map.pressures(&at.theta).into_iter().map(one).collect();
        let tables = [("chamber", chambers)].into_iter().filter(|(_, table)| !table.is_empty());
        write_toml(&folder.join("pressures.toml"), tables.collect())?;
        let (numbers, parameters): (BTreeMap<_, _>, BTreeMap<_, _>) =
            level.map.parameters(&at.theta).into_iter().partition(|(name, _)| name.contains('.'));
        let tables = [("parameters", parameters), ("numbers", numbers)].into_iter();
        write_toml(
            &folder.join("parameters.toml"),
            tables.filter(|(_, table)| !table.is_empty()).collect(),
        )
    }

    /// The report of the design. Its states on another mesh and its crossings are added later.
    fn designed(
        &self,
        finished: &Finished,
        lines: &[Iteration],
        since: Instant,
    ) -> Result<Designed> {
        let (inputs, set) = self.problem.provenance(&self.folder)?;
        let (first, last) = (&lines[0], &lines[lines.len() - 1]);
        let (level, body) = (&finished.level, &finished.level.body);
        let weights = level.weights().into_iter().map(Some);
        Ok(Designed {
            program: scene::PROGRAM.to_owned(),
            inputs,
            set,
            levels: finished.endings.clone(),
            constraints: kept(finished),
            objective_before: first.objective,
            objective_after: last.objective,
            gains: gains(lines),
            weights: level.term_names().into_iter().zip(weights).collect(),
            terms_before: first.terms.clone(),
            terms_after: last.terms.clone(),
            mean_displacement_before: first.mean_displacement.clone(),
            mean_displacement_after: last.mean_displacement.clone(),
            probes: self.probes(lines),
            mold_before: first.mold.clone(),
            mold_after: last.mold.clone(),
            scenarios_before: first.scenarios.clone(),
            scenarios_after: last.scenarios.clone(),
            symmetry: (!body.planes.is_empty()).then(|| results::symmetry(body)),
            crossing: None,
            remeshed: None,
            iterations: lines.len(),
            forward_s: lines.iter().map(|line| line.forward_s).sum(),
            gradient_s: lines.iter().map(|line| line.gradient_s).sum(),
            wall_s_of_this_run: since.elapsed().as_secs_f64(),
            peak_rss_mb: program::peak_rss_mb(),
        })
    }

    /// What the probes of the scene were and have become, in the units of their kinds, with what the design wanted;
    /// nothing without an iteration.
    fn probes(&self, lines: &[Iteration]) -> Option<BTreeMap<String, DesignedProbe>> {
        let [first, .., last] = lines else { return None };
        let value = |line: &Iteration, name: &str| *line.probes.as_ref()?.get(name)?;
        let wanted = |probe: &str| {
            let of_probe = self.design.objective.iter().filter_map(ObjectiveConfig::probe);
            of_probe.filter(|(name, _)| *name == probe).find_map(|(_, wanted)| wanted)
        };
        let one = |probe: &ProbeConfig| {
            let name = probe.name();
            let found = DesignedProbe {
                unit: probe.kind().unit.to_owned(),
                before: value(first, name),
                after: value(last, name),
                wanted: wanted(name),
            };
            (name.to_owned(), found)
        };
        let probes = &self.scene.config.probe;
        (!probes.is_empty()).then(|| probes.iter().map(one).collect())
    }

    /// How the last level with iterations ended.
    fn ended(&self, finished: &Finished) -> Ended {
        let levels = self.design.levels();
        let worked = |end: &&LevelEnd| {
            levels[end.level - 1].iterations > 0 && end.ending != Ended::NoEquilibrium
        };
        finished.endings.iter().rev().find(worked).map_or(Ended::IterationLimit, |e| e.ending)
    }

    /// Says what was gained, what holds the design back and how it ended; whether it is better than its start.
    fn say(&self, finished: &Finished, designed: &Designed, status: Ended) -> bool {
        let [before, after] =
            [designed.objective_before, designed.objective_after].map(|j| j.unwrap_or(f64::NAN));
        let fall = (before - after) / before.abs();
        if finished.checkpoint.began_outside {
            log::info!(
                "the objective went from {before:.4e} to {after:.4e}; the start violated what the design keeps"
            );
        } else if fall < LITTLE {
            log::warn!(
                "the objective fell by {:.1} % only: the design is hardly better than the start; see \
                 the terms and the reasons in {}",
                100.0 * fall,
                self.folder.join("report.json").display()
            );
        } else {
            log::info!("{}", summary::of_design(designed.probes.as_ref(), fall));
        }
        let kept = designed.constraints.iter();
        let kept = kept.filter_map(|(name, kept)| summary::of_constraint(name, kept));
        kept.for_each(|said| log::info!("{said}"));
        if let Some(end) = designed.levels.iter().rev().find(|end| end.ending == status)
            && matches!(status, Ended::StillFalling | Ended::Jammed)
        {
            log::warn!("level {} {}: {}", end.level, end.ending.in_words(), end.why);
        }
        // to keep its bounds a design may have to give away some of its objective
        fall > 0.0 || finished.checkpoint.began_outside
    }

    /// What the design comes to with a re-meshed interior; none where no shape moves, or no equilibrium is found. Flat
    /// elements that a design came to are stiff, and what it gained by them is no gain of the body.
    fn remeshed(&self, finished: &Finished, designed: &Designed) -> Option<Remeshed> {
        if finished.level.map.moving().is_empty() {
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
        let body = tidied(&before.shape(at), before.map.moving())?;
        let mut level = Level::new(&scene, &self.objectives, body, self.design, settings)?;
        level.set_weights(&before.weights());
        let theta = level.map.start(&before.map.loads(&at.theta));
        let carried = before.carry(at, &level.body, scene.config.degree);
        let (times, states): (Vec<f64>, Vec<Vec<f64>>) = carried.into_iter().unzip();
        let near = level.carried(&theta, &times, states.into_iter().map(anyhow::Ok))?;
        let found = level.evaluate(&theta, &near).or_else(|_| level.evaluate(&theta, &[]))?;
        let probes = numbers(&level.scenarios[0].measured(&found.runs[0])?);
        Ok((found.objective, Remeshed { objective: Some(found.objective), probes }))
    }
}

/// What a design keeps, with what its constraints are worth.
fn kept(finished: &Finished) -> BTreeMap<String, Kept> {
    let Finished { level, at, checkpoint, .. } = finished;
    let worth = checkpoint.multipliers.iter().copied().chain(std::iter::repeat(0.0));
    let one = |(kept, worth): (&Constraint, f64)| {
        let near = kept.near(&at.rest, level.map.mean_edge).into_iter();
        let least = near.map(|c| c.value).reduce(f64::min);
        let found = least.map(|value| kept.least + value);
        let (unit, least) = (kept.unit.to_owned(), Some(kept.least));
        (kept.name.clone(), Kept { unit, least, most: None, found, worth })
    };
    let of_shape = level.constraints.iter().zip(worth.clone()).map(one);
    let of_runs = level.bounds().iter().enumerate().zip(worth.skip(level.constraints.len()));
    let of_runs = of_runs.map(|((k, bound), worth)| {
        let worst = at.runs.iter().map(|run| run.kept[k]).reduce(f64::min);
        let kept = Kept {
            unit: bound.unit.to_owned(),
            least: bound.is_least.then_some(bound.value),
            most: (!bound.is_least).then_some(bound.value),
            found: worst.map(|c| bound.number(c)),
            worth,
        };
        (bound.name.clone(), kept)
    });
    of_shape.chain(of_runs).collect()
}

/// What each level has gained, over its first objective.
fn gains(lines: &[Iteration]) -> Vec<Option<f64>> {
    let gain = |level: &[Iteration]| {
        let (first, last) = (level[0].objective?, level[level.len() - 1].objective?);
        Some((first - last) / first.abs())
    };
    lines.chunk_by(|a, b| a.level == b.level).map(gain).collect()
}

/// Writes the tables that a scene would have, unless there are none.
fn write_toml<T: Serialize>(path: &Path, tables: BTreeMap<&str, T>) -> Result<()> {
    if tables.is_empty() {
        return Ok(());
    }
    let text = toml::to_string(&tables)?;
    Ok(mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?)
}
