//! `solver check`: the Taylor test on the user's own design problem.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use mesh::cli::Unusable;
use solver::config::LevelConfig;
use solver::math::linear::dot;
use solver::math::random::Random;
use solver::math::taylor::log_slope;
use solver::optimize::{Evaluation, Level, Parameter, Perturbed, Start};
use solver::scene::ObjectiveBuilder;

use super::optimize::read;

/// Slopes of the first-order remainder that an exact gradient may have.
const ACCEPTED: std::ops::RangeInclusive<f64> = 1.9..=2.1;

/// Times that the test is done again with steps of a quarter of the length.
const SHORTER: i32 = 4;

/// Change of a term, relative to the term, that rounding and the tolerance of the
/// run may hide.
const NOISE: f64 = 1e-9;

/// Check the gradients of a design problem against its objective
///
/// For each term of the objective and each group of parameters (shape, loads,
/// materials, densities, friction, velocities at the start) prints the remainders
/// |J(θ + εq) − J(θ) − ε g·q| along the gradient of the whole objective and along
/// random directions; their slope against ε is 2 when the gradient is exact. Exit
/// code 1 when one is not.
#[derive(clap::Args)]
pub struct Arguments {
    /// The design problem
    design: PathBuf,
    /// Check at this tagged mesh, such as an optimised design.msh, in place of
    /// the scene's
    #[arg(long, value_parser = super::other_mesh)]
    mesh: Vec<super::OtherMesh>,
    /// Number of handles; as in the first level if not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    handles: Option<u32>,
    /// Only the design's own variables, not the parameters of the scene
    #[arg(long)]
    design_only: bool,
    /// Random directions besides the gradient
    #[arg(long, default_value_t = 1)]
    random: u64,
    /// Largest motion of a vertex [m]; a tenth of an edge if not given, and less
    /// where that is too far
    #[arg(long, value_parser = positive)]
    motion: Option<f64>,
    /// Number of step lengths, each half the one before
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(i32).range(3..=30))]
    steps: i32,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (design, scene) = read(&arguments.design, &arguments.mesh)?;
    let objectives = ObjectiveBuilder::new(&arguments.design, &design.objective, &scene)?;
    let mut settings = design.levels()[0].clone();
    if let Some(handles) = arguments.handles {
        settings = LevelConfig { handles: Some(handles as usize), vertices: false, ..settings };
    }
    let mut level = Level::new(&scene, &objectives, scene.body.clone(), &design, &settings)?;
    let theta = vec![0.0; level.variables()];
    level.admit(&level.body.mesh.vertices).context("the starting shape")?;
    let start = level.evaluate(&theta, Start::Rest).map_err(|e| {
        Unusable(format!("{}: the starting shape: {e}", arguments.design.display()))
    })?;
    log::info!("{} variables, J {:.8e}", theta.len(), start.objective);
    let perturbed =
        Perturbed { scene: &scene, design: &design, settings: &settings, objectives: &objectives };
    let mut parameters = Parameter::of(&scene, &level);
    let is_design = |p: &Parameter| matches!(p, Parameter::Shape | Parameter::Loads);
    parameters.retain(|p| !arguments.design_only || is_design(p));
    let swept = sweeps(&mut level, &start)?;
    let mut table = Table::default();
    for parameter in &parameters {
        let gradients: BTreeMap<&str, Vec<f64>> = swept
            .iter()
            .map(|(name, swept)| (name.as_str(), parameter.gradient(&scene, &level, swept)))
            .collect();
        let count = parameter.count(&scene, &level);
        let mut case = Case { perturbed: &perturbed, level: &mut level, start: &start, parameter };
        for direction in 0..=arguments.random {
            let (name, q) = match direction {
                0 => ("gradient".to_owned(), sum(&gradients, count)),
                seed => (format!("random {seed}"), Random::new(seed).numbers(count)),
            };
            if q.iter().all(|q| *q == 0.0) {
                continue;
            }
            let results = case.along(&gradients, &q, arguments)?;
            table.add(&parameter.name(&scene), &name, results)?;
        }
    }
    if table.failed.is_empty() {
        return Ok(());
    }
    Err(Unusable(format!(
        "{}: slope is not 2 ± 0.1:\n  {}",
        arguments.design.display(),
        table.failed.join("\n  ")
    ))
    .into())
}

/// Sweeps of the terms, by their names.
fn sweeps(
    level: &mut Level,
    start: &Evaluation,
) -> Result<BTreeMap<String, solver::adjoint::Gradient>> {
    let names = level.term_names();
    let mut swept = BTreeMap::new();
    for name in &names {
        let terms: Vec<usize> = (0..names.len()).filter(|&i| names[i] == *name).collect();
        if !swept.contains_key(name) {
            let gradient = level.sweep(start, &terms)?;
            swept.insert(name.clone(), gradient);
        }
    }
    Ok(swept)
}

fn sum(gradients: &BTreeMap<&str, Vec<f64>>, count: usize) -> Vec<f64> {
    let mut total = vec![0.0; count];
    for gradient in gradients.values() {
        total.iter_mut().zip(gradient).for_each(|(t, g)| *t += g);
    }
    total
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a positive number of metres is needed".to_owned()),
    }
}

/// The test of one term along one direction.
struct Outcome {
    term: String,
    /// g·q for the longest step.
    directional: f64,
    epsilon: Vec<f64>,
    remainder: Vec<f64>,
    /// None where the remainder is noise: the term is linear, or does not depend
    /// on the parameter.
    slope: Option<f64>,
}

impl Outcome {
    fn new(term: &str, at: f64, slope: f64, epsilon: &[f64], values: &[f64]) -> Self {
        let change: Vec<f64> = values.iter().map(|v| v - at).collect();
        let remainder: Vec<f64> =
            change.iter().zip(epsilon).map(|(c, e)| (c - e * slope).abs()).collect();
        // a remainder in the noise says nothing, nor do those after it
        let size = values.iter().fold(at.abs(), |m, v| m.max(v.abs()));
        let told = remainder.iter().take_while(|r| **r > NOISE * size).count();
        let slope_of = |n: usize| log_slope(&epsilon[..n], &remainder[..n]);
        Self {
            term: term.to_owned(),
            directional: slope,
            epsilon: epsilon.to_vec(),
            slope: (told >= 3).then(|| slope_of(told)),
            remainder,
        }
    }

    fn passes(&self) -> bool {
        self.slope.is_none_or(|slope| ACCEPTED.contains(&slope))
    }
}

/// One parameter of one design problem.
struct Case<'a> {
    perturbed: &'a Perturbed<'a>,
    level: &'a mut Level,
    start: &'a Evaluation,
    parameter: &'a Parameter,
}

impl Case<'_> {
    /// The test of all terms along q, with shorter steps while one fails.
    fn along(
        &mut self,
        gradients: &BTreeMap<&str, Vec<f64>>,
        q: &[f64],
        arguments: &Arguments,
    ) -> Result<Vec<Outcome>> {
        let longest = self.longest(q, arguments.motion);
        let retries = SHORTER * i32::from(arguments.motion.is_none());
        let mut best: BTreeMap<String, Outcome> = BTreeMap::new();
        let mut failure = None;
        for k in 0..=retries {
            // too long for the shape to stay valid, or for second order to show
            let epsilon = longest * 0.25_f64.powi(k);
            match self.outcomes(gradients, q, epsilon, arguments.steps) {
                Ok(outcomes) => {
                    for outcome in outcomes {
                        let old = best.get(&outcome.term);
                        if old.is_none_or(|old| !old.passes()) {
                            best.insert(outcome.term.clone(), outcome);
                        }
                    }
                    if best.values().all(Outcome::passes) {
                        break;
                    }
                }
                Err(error) => failure = Some(error),
            }
        }
        match (best.is_empty(), failure) {
            (true, Some(error)) => Err(error),
            _ => Ok(best.into_values().collect()),
        }
    }

    fn outcomes(
        &mut self,
        gradients: &BTreeMap<&str, Vec<f64>>,
        q: &[f64],
        longest: f64,
        steps: i32,
    ) -> Result<Vec<Outcome>> {
        let epsilon: Vec<f64> = (0..steps).map(|k| longest * 0.5_f64.powi(k)).collect();
        let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for e in &epsilon {
            let by: Vec<f64> = q.iter().map(|q| e * q).collect();
            let trial = self.perturbed.evaluate(self.level, self.start, self.parameter, &by);
            let trial = trial.context("a trial")?;
            for name in gradients.keys() {
                values.entry(name).or_default().push(trial.terms[*name]);
            }
        }
        let outcome = |(name, gradient): (&&str, &Vec<f64>)| {
            let at = self.start.terms[*name];
            Outcome::new(name, at, dot(gradient, q), &epsilon, &values[name])
        };
        Ok(gradients.iter().map(outcome).collect())
    }

    /// The longest ε.
    fn longest(&self, q: &[f64], motion: Option<f64>) -> f64 {
        let largest = q.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        let map = self.level.map();
        match self.parameter {
            Parameter::Shape => {
                let zero = vec![0.0; self.level.variables()];
                let small = 1e-3 * map.mean_edge() / largest;
                let mut moved = zero.clone();
                moved.iter_mut().zip(q).for_each(|(m, q)| *m = small * q);
                let per_unit = map.motion(&zero, &moved) / small;
                motion.unwrap_or(0.1 * map.mean_edge()) / per_unit
            }
            Parameter::Loads => motion.unwrap_or(0.1 * map.mean_edge()) / largest,
            _ => 1e-2 / largest,
        }
    }
}

/// What is printed, and what did not pass.
#[derive(Default)]
struct Table {
    failed: Vec<String>,
}

impl Table {
    fn add(&mut self, parameter: &str, direction: &str, outcomes: Vec<Outcome>) -> Result<()> {
        let mut out = std::io::stdout().lock();
        for outcome in outcomes {
            let term = &outcome.term;
            writeln!(out, "\"{term}\" by {parameter}, {direction}")?;
            writeln!(out, "  {:>12}  {:>12}", "epsilon", "remainder")?;
            for (e, r) in outcome.epsilon.iter().zip(&outcome.remainder) {
                writeln!(out, "  {e:12.4e}  {r:12.4e}")?;
            }
            let found = match outcome.slope {
                Some(slope) => format!("slope {slope:.3} (2 expected)"),
                None => "remainder within rounding".to_owned(),
            };
            writeln!(out, "  {found}, g·q {:.4e}", outcome.directional)?;
            if !outcome.passes() {
                self.failed.push(format!("\"{term}\" by {parameter}, {direction}: {found}"));
            }
        }
        Ok(())
    }
}
