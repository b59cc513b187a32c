//! `solver check`: the Taylor test on the user's own design problem.

mod finding;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use anyhow::Result;
use clap::builder::RangedU64ValueParser;
use mechanics::math::linear::{dot, sum};
use mechanics::math::random::Random;
use program::{Heartbeat, Unusable, about};
use scene::config::{HandlesConfig, LevelConfig, VerticesConfig};

use self::finding::Finding;
use super::DesignArguments;
use design::{Evaluation, Level, Parameter, Perturbed};

/// How often the test of a term is repeated while its slope is not accepted, ...
const SHORTER: usize = 4;
/// ... each time without so many of the longest steps.
const LONGEST: usize = 2;

/// Check the gradients of a design problem against its objective
///
/// For each term of the objective and each group of parameters (shape, loads, and the
/// numbers of the scene, as `solver list --numbers` explains them) prints the remainders
/// |J(θ + εq) − J(θ) − ε g·q| along the gradient of the whole objective and along
/// random directions; their slope against ε is 2 when the gradient is exact. Where
/// remainders are within rounding there is no slope: such a test passes if the term does
/// not change at all and g·q is zero, if it is linear, so that its change is ε g·q, or if
/// longer steps have a slope above 2; else it is "not measurable". At a kink, where the
/// derivatives to either side differ, the slope is 2 along −q. Steps that are too long
/// are shortened, and what was found with them is printed. Exit code 1 unless every
/// test passes.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    of: DesignArguments,
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
    #[arg(long, default_value_t = 7, value_parser = RangedU64ValueParser::<usize>::new().range(3..=30))]
    steps: usize,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let problem = arguments.of.read()?;
    let (design, scene) = (&problem.design, &problem.scene);
    let objectives = problem.objectives()?;
    let mut settings = design.levels()[0].clone();
    if let Some(handles) = arguments.handles {
        let (handles, vertices) =
            (HandlesConfig::Each(handles as usize), VerticesConfig::default());
        settings = LevelConfig { handles: Some(handles), vertices, ..settings };
    }
    let (level, start) = problem.start(&objectives, &settings)?;
    log::info!(
        "{} variables, J {:.8e}; a run takes about {}",
        level.variables(),
        start.objective,
        about(start.forward_s)
    );
    let perturbed = Perturbed { problem: &problem, settings: &settings, objectives: &objectives };
    let mut parameters = Parameter::of(&problem, &level);
    let is_design = |p: &Parameter| matches!(p, Parameter::Shape | Parameter::Loads);
    parameters.retain(|p| !arguments.design_only || is_design(p));
    let swept = sweeps(&level, &start)?;
    let runs = parameters.len() as f64 * (1 + arguments.random) as f64 * arguments.steps as f64;
    log::info!(
        "up to {runs} runs follow, about {}, and more where steps are too long",
        about(runs * start.forward_s)
    );
    let (mut failed, mut heartbeat) = (Vec::new(), Heartbeat::start());
    for parameter in &parameters {
        let gradients: BTreeMap<&str, Vec<f64>> = swept
            .iter()
            .map(|(name, swept)| (name.as_str(), parameter.gradient(scene, &level, swept)))
            .collect();
        let count = parameter.count(&level);
        let mut case = Case {
            perturbed: &perturbed,
            level: &level,
            start: &start,
            parameter,
            heartbeat: &mut heartbeat,
        };
        for direction in 0..=arguments.random {
            let (name, q) = match direction {
                0 => ("gradient".to_owned(), sum(gradients.values())),
                seed => (format!("random {seed}"), Random::new(seed).numbers(count)),
            };
            if q.iter().all(|q| *q == 0.0) {
                continue;
            }
            let results = case.along(&gradients, &q, arguments)?;
            failed.extend(print(&parameter.name(), &name, results)?);
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    Err(Unusable(format!(
        "{}: slope is not 2 ± 0.1, or cannot be measured:\n  {}",
        arguments.of.design.display(),
        failed.join("\n  ")
    ))
    .into())
}

/// Sweeps of the terms, by their names.
fn sweeps(
    level: &Level,
    start: &Evaluation,
) -> Result<BTreeMap<String, Vec<mechanics::adjoint::Gradient>>> {
    let names: BTreeSet<String> = level.numbers(start).into_keys().collect();
    let sweep = |name: String| Ok((name.clone(), level.sweep(start, Some(&name))?));
    names.into_iter().map(sweep).collect()
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a positive number of metres is needed".to_owned()),
    }
}

/// A value of a term at a step length ε; none where the step is too long.
type Step = (f64, Option<f64>);

/// The test of one term along one direction.
struct Outcome {
    term: String,
    /// g·q.
    directional: f64,
    epsilon: Vec<f64>,
    remainder: Vec<f64>,
    finding: Finding,
    /// Longest ε and finding of the tests with longer steps that did not pass.
    before: Vec<(f64, Finding)>,
}

impl Outcome {
    /// From steps each half the one before, of which `count` make a test. While the slope is not accepted, the test is
    /// repeated without the longest two: too long ones hide the second order behind the third, or leave the range of
    /// valid shapes. What counts is the last test.
    fn new(term: &str, at: f64, slope: f64, steps: &[Step], count: usize) -> Self {
        let mut before = Vec::new();
        let mut left = steps;
        loop {
            let epsilon: Vec<f64> = left[..count].iter().map(|step| step.0).collect();
            let values: Option<Vec<f64>> = left[..count].iter().map(|step| step.1).collect();
            let (finding, remainder) = values.map_or((Finding::TooLong, Vec::new()), |values| {
                let change: Vec<f64> = values.iter().map(|v| v - at).collect();
                let off = |(c, e): (&f64, &f64)| (c - e * slope).abs();
                let remainder: Vec<f64> = change.iter().zip(&epsilon).map(off).collect();
                // a state far away, which a long step may find, tells no noise of those near by
                let size = at.abs().max(values[count - 1].abs());
                (Finding::new(size, slope, &epsilon, &change, &remainder), remainder)
            });
            if finding.is_open() && left.len() >= count + LONGEST {
                before.push((epsilon[0], finding));
                left = &left[LONGEST..];
                continue;
            }
            let term = term.to_owned();
            return Self { term, directional: slope, epsilon, remainder, finding, before };
        }
    }

    /// The same, of which there are no shorter steps to come.
    fn at_last(self) -> Self {
        Self { finding: self.finding.after(&self.before), ..self }
    }
}

/// One parameter of one design problem.
struct Case<'a> {
    perturbed: &'a Perturbed<'a>,
    level: &'a Level,
    start: &'a Evaluation,
    parameter: &'a Parameter,
    heartbeat: &'a mut Heartbeat,
}

impl Case<'_> {
    /// The test of all terms along q, and along −q where one does not pass: it may have a kink.
    fn along(
        &mut self,
        gradients: &BTreeMap<&str, Vec<f64>>,
        q: &[f64],
        arguments: &Arguments,
    ) -> Result<Vec<Outcome>> {
        let mut found = self.outcomes(gradients, q, arguments)?;
        if found.iter().any(|outcome| outcome.finding.is_open()) {
            let back: Vec<f64> = q.iter().map(|q| -q).collect();
            let back = self.outcomes(gradients, &back, arguments)?;
            for (own, back) in found.iter_mut().zip(back) {
                own.finding = own.finding.beside(back.finding);
            }
        }
        Ok(found)
    }

    /// The test of all terms along q, with shorter steps while there is one whose slope is not accepted.
    fn outcomes(
        &mut self,
        gradients: &BTreeMap<&str, Vec<f64>>,
        q: &[f64],
        arguments: &Arguments,
    ) -> Result<Vec<Outcome>> {
        let (count, longest) = (arguments.steps, self.longest(q, arguments.motion));
        let most = count + arguments.motion.map_or(SHORTER * LONGEST, |_| 0);
        let here = self.level.numbers(self.start);
        let (mut trials, mut failure) = (Vec::new(), None);
        loop {
            let epsilon = longest * 0.5_f64.powi(trials.len() as i32);
            let (step, of) = (trials.len() + 1, trials.len().max(count - 1) + 1);
            self.heartbeat.say(|| format!("  step length {step} of {of}: {epsilon:.1e}"));
            let by: Vec<f64> = q.iter().map(|q| epsilon * q).collect();
            let trial = self.perturbed.evaluate(self.level, self.start, self.parameter, &by);
            let values = trial.map(|there| self.level.numbers(&there));
            trials.push((epsilon, values.map_err(|error| failure = Some(error)).ok()));
            if trials.len() < count || (trials.len() - count) % LONGEST != 0 {
                continue;
            }
            let outcome = |(name, gradient): (&&str, &Vec<f64>)| {
                let steps =
                    trials.iter().map(|(e, values)| (*e, values.as_ref().map(|v| v[*name])));
                let steps: Vec<Step> = steps.collect();
                Outcome::new(name, here[*name], dot(gradient, q), &steps, count)
            };
            let found: Vec<Outcome> = gradients.iter().map(outcome).collect();
            if trials.len() < most && found.iter().any(|outcome| outcome.finding.is_open()) {
                continue;
            }
            return match failure {
                Some(why) if found.iter().all(|o| o.finding == Finding::TooLong) => {
                    Err(why.context("a trial"))
                }
                _ => Ok(found.into_iter().map(Outcome::at_last).collect()),
            };
        }
    }

    /// The longest ε.
    fn longest(&self, q: &[f64], motion: Option<f64>) -> f64 {
        let largest = q.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        let map = &self.level.map;
        match self.parameter {
            Parameter::Shape => {
                let mut step = vec![0.0; self.level.variables()];
                step[..q.len()].copy_from_slice(q);
                let (per_unit, _) = map.motion_along(&vec![0.0; step.len()], &step);
                motion.unwrap_or(0.1 * map.mean_edge) / per_unit
            }
            Parameter::Loads => motion.unwrap_or(0.1 * map.mean_edge) / largest,
            _ => 1e-2 / largest,
        }
    }
}

/// Prints outcomes; those that did not pass.
fn print(parameter: &str, direction: &str, outcomes: Vec<Outcome>) -> Result<Vec<String>> {
    let (mut out, mut failed) = (program::stdout(), Vec::new());
    for outcome in outcomes {
        let term = &outcome.term;
        writeln!(out, "\"{term}\" by {parameter}, {direction}")?;
        writeln!(out, "  {:>12}  {:>12}", "epsilon", "remainder")?;
        for (e, r) in outcome.epsilon.iter().zip(&outcome.remainder) {
            writeln!(out, "  {e:12.4e}  {r:12.4e}")?;
        }
        for (epsilon, finding) in &outcome.before {
            writeln!(out, "  before, with epsilon from {epsilon:.4e}: {finding}")?;
        }
        let finding = outcome.finding;
        writeln!(out, "  {finding}, g·q {:.4e}", outcome.directional)?;
        if !finding.passes() {
            failed.push(format!("\"{term}\" by {parameter}, {direction}: {finding}"));
        }
    }
    Ok(failed)
}
