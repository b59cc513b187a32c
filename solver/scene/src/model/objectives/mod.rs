//! From the terms of a design file to objectives.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use measure::quantity::{Quantity, Targets};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use program::misfit;

use super::Scene;
use crate::config::{Dilatation, ObjectiveConfig, Weight};

/// A term with its factors.
pub struct Weighted {
    /// As reports call it.
    pub name: String,
    /// Factor of the term; that of one with a share is 1 until a level weighs it.
    pub weight: f64,
    /// Factor on it in a level and a scenario.
    pub factor: f64,
    /// ω of each moment, that of rest first: Σ ω J is the term over time.
    pub factors: Vec<f64>,
    /// What is minimised.
    pub quantity: Arc<dyn Quantity>,
}

/// Builds objectives; files are read once for all levels.
pub struct ObjectiveBuilder<'a> {
    terms: &'a [ObjectiveConfig],
    targets: Targets,
}

impl<'a> ObjectiveBuilder<'a> {
    /// Checks the terms of a design file.
    pub fn new(design: &Path, terms: &'a [ObjectiveConfig], scene: &Scene) -> Result<Self> {
        for config in terms {
            let context = || design.display().to_string();
            config.check().with_context(context)?;
            let name = config.name();
            factors(config, scene).with_context(context)?;
            ensure!(
                scene.config.contact().is_some() || !config.kind().needs_contact,
                config.title().told(format!(
                    "{}: objective \"{name}\": {}: there are no forces between surfaces without \
                     [contact] in {}",
                    design.display(),
                    config.kind().key,
                    scene.path.display()
                ))
            );
            ensure!(
                scene.config.solver.dilatation == Dilatation::Pointwise
                    || !config.kind().reads_stress,
                config.title().told(format!(
                    "{}: objective \"{name}\": {}: it is made with the stress of the law at each point, which \
                     elements with [solver] dilatation = \"mean\" do not have; expected \"pointwise\" in {}, or \
                     another objective",
                    design.display(),
                    config.kind().key,
                    scene.path.display()
                ))
            );
        }
        let targets = Targets::new(design.parent().unwrap_or(Path::new("")));
        Ok(Self { terms, targets })
    }

    /// Checks that the times of all terms are times of a scene.
    pub fn check_times(&self, scene: &Scene) -> Result<()> {
        self.terms.iter().try_for_each(|term| factors(term, scene).map(drop))
    }

    /// The terms on one body, over the times of a scene.
    pub fn build(
        &self,
        scene: &Scene,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Vec<Weighted>> {
        let mut site = scene.site(body, space, self.targets.clone())?;
        let (ends, probes) = (scene.times(), scene.probes(body, space)?);
        site.probes = probes.into_iter().map(|probe| (probe.name, probe.quantity)).collect();
        let build = |term: &ObjectiveConfig| {
            let factors = factors(term, scene)?;
            let times = [0.0].iter().chain(&ends).zip(&factors);
            site.times = times.filter(|(_, f)| **f != 0.0).map(|(t, _)| *t).collect();
            let weight = match term.weight() {
                Weight::Factor(factor) => factor,
                Weight::Share(_) => 1.0,
            };
            let (name, quantity) = (term.name().to_owned(), term.build(&site)?);
            Ok(Weighted { name, weight, factor: 1.0, factors, quantity })
        };
        self.terms.iter().map(build).collect()
    }
}

/// ω of each moment of a scene.
fn factors(config: &ObjectiveConfig, scene: &Scene) -> Result<Vec<f64>> {
    let factors = config.over().factors(&scene.times());
    factors.map_err(|what| misfit!(config.title().key("over"), ": {what}").into())
}

#[cfg(test)]
mod tests;
