//! What an optimisation came to, for its report.

use std::collections::BTreeMap;
use std::time::Instant;

use measure::constraint::Constraint;
use reports::{Designed, DesignedProbe, Ended, Inputs, Iteration, Kept, LevelEnd, Numbers};
use scene::Scene;
use scene::config::{DesignConfig, ObjectiveConfig, ProbeConfig};

use design::optimize::Finished;
use run::report::results;

/// What an optimisation came to.
pub(super) struct Found<'a> {
    pub finished: &'a Finished,
    pub scene: &'a Scene,
    pub design: &'a DesignConfig,
}

impl Found<'_> {
    /// The report of the design.
    pub fn designed(
        &self,
        lines: Vec<Iteration>,
        inputs: Inputs,
        set: Vec<String>,
        start: Instant,
    ) -> Designed {
        let (first, last) = (&lines[0], &lines[lines.len() - 1]);
        let body = &self.finished.body;
        Designed {
            program: scene::PROGRAM.to_owned(),
            inputs,
            set,
            levels: self.finished.endings.clone(),
            constraints: self.kept(),
            objective_before: first.objective,
            objective_after: last.objective,
            gains: gains(&lines),
            weights: self.weights(),
            terms_before: first.terms.clone(),
            terms_after: last.terms.clone(),
            mean_displacement_before: first.mean_displacement.clone(),
            mean_displacement_after: last.mean_displacement.clone(),
            probes: self.probes(&lines),
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
            wall_s_of_this_run: start.elapsed().as_secs_f64(),
            peak_rss_mb: program::peak_rss_mb(),
        }
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
    pub fn ended(&self) -> Ended {
        let levels = self.design.levels();
        let worked = |end: &&LevelEnd| {
            levels[end.level - 1].iterations > 0 && end.ending != Ended::NoEquilibrium
        };
        self.finished.endings.iter().rev().find(worked).map_or(Ended::IterationLimit, |e| e.ending)
    }

    /// What the design keeps, with what its constraints are worth.
    fn kept(&self) -> BTreeMap<String, Kept> {
        let (level, at) = &self.finished.last;
        let worth = self.finished.multipliers.iter().copied().chain(std::iter::repeat(0.0));
        let one = |(kept, worth): (&Constraint, f64)| {
            let near = kept.near(&at.rest, level.map().mean_edge()).into_iter();
            let least = near.map(|c| c.value).reduce(f64::min);
            let found = least.map(|value| kept.least() + value);
            let (unit, least) = (kept.unit.to_owned(), Some(kept.least()));
            (kept.name.clone(), Kept { unit, least, most: None, found, worth })
        };
        let of_shape = level.constraints().iter().zip(worth.clone()).map(one);
        let of_runs = level.bounds().iter().enumerate().zip(worth.skip(level.constraints().len()));
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

    /// Weights of the terms by their names, those that shares came to among them.
    fn weights(&self) -> Numbers {
        let level = &self.finished.last.0;
        level.term_names().into_iter().zip(level.weights().into_iter().map(Some)).collect()
    }
}

/// What each level has gained, over its first objective.
fn gains(lines: &[Iteration]) -> Vec<Option<f64>> {
    let gain = |level: &[Iteration]| {
        let (first, last) = (level[0].objective?, level[level.len() - 1].objective?);
        Some((first - last) / first.abs())
    };
    lines.chunk_by(|a, b| a.level == b.level).map(gain).collect()
}
