//! From the terms of a design file to objectives.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, ensure};
use measure::objective::{Builder, Context, Law, Objective};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;

use super::Scene;
use crate::config::{Dilatation, ObjectiveConfig, Weight};

/// A term with its factors.
pub struct Weighted {
    /// Factor of the term; that of one with a share is 1 until a level weighs it.
    pub weight: f64,
    /// Factor on it in a level and a scenario.
    pub factor: f64,
    /// ω of each moment, that of rest first: Σ ω J is the term over time.
    pub factors: Vec<f64>,
    /// The term.
    pub objective: Box<dyn Objective>,
}

/// Builds objectives; files are read once for all levels.
pub struct ObjectiveBuilder<'a> {
    terms: Vec<Term<'a>>,
}

/// A term whose files have been read.
struct Term<'a> {
    config: &'a ObjectiveConfig,
    build: Builder,
}

impl<'a> ObjectiveBuilder<'a> {
    /// Reads the files that the terms of a design file name.
    ///
    /// # Errors
    /// When a file cannot be read or a setting is not admissible.
    pub fn new(design: &Path, configs: &'a [ObjectiveConfig], scene: &'a Scene) -> Result<Self> {
        let folder = design.parent().unwrap_or(Path::new(""));
        let term = |config: &'a ObjectiveConfig| {
            let context = || design.display().to_string();
            config.check().with_context(context)?;
            let name = config.name();
            factors(config, scene).with_context(context)?;
            ensure!(
                scene.config.contact().is_some() || !config.kind().needs_contact,
                "{}: objective \"{name}\": {}: there are no forces between surfaces without \
                 [contact] in {}",
                design.display(),
                config.kind().key,
                scene.path.display()
            );
            ensure!(
                scene.config.solver.dilatation == Dilatation::Pointwise || !config.reads_stress(),
                "{}: objective \"{name}\": {}: it is made with the stress of the law at each point, which \
                 elements with [solver] dilatation = \"mean\" do not have; expected \"pointwise\" in {}, or \
                 another objective",
                design.display(),
                config.kind().key,
                scene.path.display()
            );
            Ok(Term { config, build: config.prepare(folder)? })
        };
        Ok(Self { terms: configs.iter().map(term).collect::<Result<_>>()? })
    }

    /// Checks that the times of all terms are times of a scene.
    ///
    /// # Errors
    /// When a time step is missing.
    pub fn check_times(&self, scene: &Scene) -> Result<()> {
        self.terms.iter().try_for_each(|term| factors(term.config, scene).map(drop))
    }

    /// The terms on one body, over the times of a scene.
    ///
    /// # Errors
    /// When a tag, a body or a time step is missing.
    pub fn build(
        &self,
        scene: &Scene,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Vec<Weighted>> {
        let name = |part: usize| scene.parts[part].config.name.as_str();
        let bodies: Vec<&str> = (0..scene.parts.len()).map(name).collect();
        let laws = scene.laws.iter().map(|law| Law {
            body: name(law.part),
            name: scene.law_name(law),
            material: &law.material,
            elements: law.elements(body),
        });
        let laws: Vec<Law> = laws.collect();
        let ends = scene.times();
        let probes = scene.probes(body, space)?;
        let probes = probes.into_iter().map(|probe| (probe.name, probe.quantity)).collect();
        let build = |term: &Term| {
            let (name, factors) = (term.config.name(), factors(term.config, scene)?);
            let times = [0.0].iter().chain(&ends).zip(&factors);
            let times: Vec<f64> = times.filter(|(_, f)| **f != 0.0).map(|(t, _)| *t).collect();
            let (bodies, laws) = (&bodies[..], &laws[..]);
            let context = Context { body, space, bodies, laws, times: &times, probes: &probes };
            let objective =
                (term.build)(name, &context).with_context(|| format!("objective \"{name}\""))?;
            let weight = match term.config.weight() {
                Weight::Factor(factor) => factor,
                Weight::Share(_) => 1.0,
            };
            Ok(Weighted { weight, factor: 1.0, factors, objective })
        };
        self.terms.iter().map(build).collect()
    }
}

/// ω of each moment of a scene.
fn factors(config: &ObjectiveConfig, scene: &Scene) -> Result<Vec<f64>> {
    let factors = config.over().factors(&scene.times());
    factors.map_err(|what| anyhow!("objective \"{}\": over: {what}", config.name()))
}

#[cfg(test)]
mod tests;
