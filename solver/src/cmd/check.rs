//! `solver check`: the Taylor test on the user's own design problem.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use mechanics::forward::about;
use mechanics::math::linear::dot;
use mechanics::math::random::Random;
use mechanics::math::taylor::log_slope;
use program::{Changes, Heartbeat, Unusable};
use scene::ObjectiveBuilder;
use scene::config::{HandlesConfig, LevelConfig, VerticesConfig};

use super::optimize::{Problem, read};
use crate::optimize::{Evaluation, Level, Parameter, Perturbed, Start};

/// Slopes of the first-order remainder that an exact gradient may have.
const ACCEPTED: std::ops::RangeInclusive<f64> = 1.9..=2.1;

/// How often the test of a term is repeated with steps of a quarter of the length, while
/// its slope is not accepted.
const SHORTER: i32 = 4;

/// Change of a term, relative to the term, that rounding and the tolerance of the
/// run may hide.
const NOISE: f64 = 1e-9;

/// Largest remainder of a term that is linear along q, and largest noise there, relative to
/// the change of the term at the longest step.
const LINEAR: f64 = 1e-4;

/// Remainders above the noise that a slope needs.
const POINTS: usize = 3;

/// Slopes between remainders that are below the noise, of which [`POINTS`] in a row are enough.
const EXACT: std::ops::RangeInclusive<f64> = 1.99..=2.01;

/// Remainders in a row, each a quarter of the one before, that are no noise although they are
/// below the usual one: a term of the rest shape alone has less.
const QUADRATIC: usize = 5;

/// Check the gradients of a design problem against its objective
///
/// For each term of the objective and each group of parameters (shape, loads, and the
/// numbers of the scene, as `solver list --numbers` explains them) prints the remainders
/// |J(θ + εq) − J(θ) − ε g·q| along the gradient of the whole objective and along
/// random directions; their slope against ε is 2 when the gradient is exact. Where
/// remainders are within rounding there is no slope: such a test passes if the term does
/// not change at all and g·q is zero, or if it is linear, so that its change is ε g·q;
/// else it is "not measurable". Steps that are too long are shortened, and what was found
/// with them is printed. Exit code 1 unless every test passes.
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
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let Problem { file, design, scene } =
        read(&arguments.design, &arguments.mesh, &arguments.changes)?;
    let objectives =
        file.checked(|_| ObjectiveBuilder::new(&arguments.design, &design.objective, &scene))?;
    let mut settings = design.levels()[0].clone();
    if let Some(handles) = arguments.handles {
        let (handles, vertices) =
            (HandlesConfig::Each(handles as usize), VerticesConfig::default());
        settings = LevelConfig { handles: Some(handles), vertices, ..settings };
    }
    let mut level = Level::new(&scene, &objectives, scene.body.clone(), &design, &settings)
        .map_err(|error| file.place(error))?;
    let theta = vec![0.0; level.variables()];
    level
        .admit(&level.body.mesh.vertices)
        .context("the starting shape")
        .map_err(|error| file.place(error))?;
    let start = level.evaluate(&theta, Start::Rest).map_err(|e| {
        Unusable(format!("{}: the starting shape: {e}", arguments.design.display()))
    })?;
    let start = level.weigh(&design.objective, start).map_err(|error| file.place(error))?;
    log::info!(
        "{} variables, J {:.8e}; a run takes about {}",
        theta.len(),
        start.objective,
        about(start.forward_s)
    );
    let perturbed =
        Perturbed { scene: &scene, design: &design, settings: &settings, objectives: &objectives };
    let mut parameters = Parameter::of(&scene, &level, &design);
    let is_design = |p: &Parameter| matches!(p, Parameter::Shape | Parameter::Loads);
    parameters.retain(|p| !arguments.design_only || is_design(p));
    let swept = sweeps(&mut level, &start)?;
    let runs = parameters.len() as f64 * (1 + arguments.random) as f64 * f64::from(arguments.steps);
    log::info!(
        "up to {runs} runs follow, about {}, and more where steps are too long",
        about(runs * start.forward_s)
    );
    let (mut table, mut heartbeat) = (Table::default(), Heartbeat::start());
    for parameter in &parameters {
        let gradients: BTreeMap<&str, Vec<f64>> = swept
            .iter()
            .map(|(name, swept)| (name.as_str(), parameter.gradient(&scene, &level, swept)))
            .collect();
        let count = parameter.count(&level);
        let mut case = Case {
            perturbed: &perturbed,
            level: &mut level,
            start: &start,
            parameter,
            heartbeat: &mut heartbeat,
        };
        for direction in 0..=arguments.random {
            let (name, q) = match direction {
                0 => ("gradient".to_owned(), sum(&gradients, count)),
                seed => (format!("random {seed}"), Random::new(seed).numbers(count)),
            };
            if q.iter().all(|q| *q == 0.0) {
                continue;
            }
            let results = case.along(&gradients, &q, arguments)?;
            table.add(&parameter.name(), &name, results)?;
        }
    }
    if table.failed.is_empty() {
        return Ok(());
    }
    Err(Unusable(format!(
        "{}: slope is not 2 ± 0.1, or cannot be measured:\n  {}",
        arguments.design.display(),
        table.failed.join("\n  ")
    ))
    .into())
}

/// Sweeps of the terms, by their names.
fn sweeps(
    level: &mut Level,
    start: &Evaluation,
) -> Result<BTreeMap<String, Vec<mechanics::adjoint::Gradient>>> {
    let names: BTreeSet<String> = level.term_names().into_iter().collect();
    let sweep = |name: String| Ok((name.clone(), level.sweep(start, Some(&name))?));
    names.into_iter().map(sweep).collect()
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

/// What the remainders of a term along a direction say.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Finding {
    /// Slope of the remainders against ε.
    Slope(f64),
    /// The term does not change and g·q is zero, both within the noise.
    Constant,
    /// The change is ε g·q; the largest difference relative to the change.
    Linear(f64),
    /// A step was too long for an equilibrium or a valid shape.
    TooLong,
    /// Changes and remainders are too near to the noise for any of these.
    NotMeasurable,
}

impl Finding {
    /// From changes J(θ + εq) − J(θ) of a term of a size.
    fn new(size: f64, slope: f64, epsilon: &[f64], change: &[f64], remainder: &[f64]) -> Self {
        let noise = NOISE * size;
        // a remainder in the noise says nothing, nor do those after it
        let above = remainder.iter().take_while(|r| **r > noise).count();
        let measured = above.max(quadratic(epsilon, remainder));
        if measured >= POINTS {
            return Self::Slope(log_slope(&epsilon[..measured], &remainder[..measured]));
        }
        let predicted = epsilon.iter().map(|e| e * slope);
        if change.iter().copied().chain(predicted).all(|c| c.abs() <= noise) {
            return Self::Constant;
        }
        // the longest step changes the term most
        let limit = LINEAR * change[0].abs();
        match remainder[0].max(noise) <= limit {
            true => Self::Linear(remainder[0] / change[0].abs()),
            false => Self::NotMeasurable,
        }
    }

    fn passes(self) -> bool {
        match self {
            Self::Slope(slope) => ACCEPTED.contains(&slope),
            Self::Constant | Self::Linear(_) => true,
            Self::TooLong | Self::NotMeasurable => false,
        }
    }

    /// Whether shorter steps may find something else.
    fn is_open(self) -> bool {
        !self.passes() && self != Self::NotMeasurable
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Slope(slope) => write!(f, "slope {slope:.3} (2 expected)"),
            Self::Constant => write!(f, "no change within rounding, and none predicted"),
            Self::Linear(off) => write!(f, "linear: the change is ε g·q within {off:.0e} of it"),
            Self::TooLong => write!(f, "no result with steps of this length"),
            Self::NotMeasurable => write!(f, "not measurable: the remainder is within rounding"),
        }
    }
}

/// Number of first remainders of which each is a quarter of the one before, as noise never is
/// several times in a row: [`QUADRATIC`] about, or [`POINTS`] exactly; else none.
fn quadratic(epsilon: &[f64], remainder: &[f64]) -> usize {
    let enough = |slopes: std::ops::RangeInclusive<f64>, least: usize| {
        let pairs = epsilon.windows(2).zip(remainder.windows(2));
        let fall = pairs.take_while(|(e, r)| slopes.contains(&log_slope(e, r))).count() + 1;
        if fall >= least { fall } else { 0 }
    };
    enough(ACCEPTED, QUADRATIC).max(enough(EXACT, POINTS))
}

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
    fn new(term: &str, at: f64, slope: f64, epsilon: &[f64], values: &[f64]) -> Self {
        let change: Vec<f64> = values.iter().map(|v| v - at).collect();
        let remainder: Vec<f64> =
            change.iter().zip(epsilon).map(|(c, e)| (c - e * slope).abs()).collect();
        let size = values.iter().fold(at.abs(), |m, v| m.max(v.abs()));
        Self {
            term: term.to_owned(),
            directional: slope,
            epsilon: epsilon.to_vec(),
            finding: Finding::new(size, slope, epsilon, &change, &remainder),
            remainder,
            before: Vec::new(),
        }
    }
}

/// One parameter of one design problem.
struct Case<'a> {
    perturbed: &'a Perturbed<'a>,
    level: &'a mut Level,
    start: &'a Evaluation,
    parameter: &'a Parameter,
    heartbeat: &'a mut Heartbeat,
}

impl Case<'_> {
    /// The test of all terms along q. A term whose slope is not accepted is tested again
    /// with shorter steps: too long ones hide the second order behind the third, or leave
    /// the range of valid shapes. What counts is the last test of a term.
    fn along(
        &mut self,
        gradients: &BTreeMap<&str, Vec<f64>>,
        q: &[f64],
        arguments: &Arguments,
    ) -> Result<Vec<Outcome>> {
        let longest = self.longest(q, arguments.motion);
        let retries = SHORTER * i32::from(arguments.motion.is_none());
        let mut last: BTreeMap<String, Outcome> = BTreeMap::new();
        let mut too_long = Vec::new();
        let mut failure = None;
        for k in 0..=retries {
            let epsilon = longest * 0.25_f64.powi(k);
            match self.outcomes(gradients, q, epsilon, arguments.steps) {
                Ok(outcomes) => update(&mut last, outcomes, &too_long),
                Err(error) => {
                    too_long.push((epsilon, Finding::TooLong));
                    failure = Some(error);
                }
            }
            if !last.is_empty() && !last.values().any(|outcome| outcome.finding.is_open()) {
                break;
            }
        }
        match (last.is_empty(), failure) {
            (true, Some(error)) => Err(error),
            _ => Ok(last.into_values().collect()),
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
        for (k, e) in epsilon.iter().enumerate() {
            self.heartbeat.say(|| format!("  step length {} of {steps}: {e:.1e}", k + 1));
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

/// Replaces the tests of terms that are open by new ones, which remember them.
fn update(
    last: &mut BTreeMap<String, Outcome>,
    outcomes: Vec<Outcome>,
    too_long: &[(f64, Finding)],
) {
    for mut outcome in outcomes {
        outcome.before = match last.remove(&outcome.term) {
            Some(old) if !old.finding.is_open() => {
                last.insert(old.term.clone(), old);
                continue;
            }
            Some(old) => [old.before, vec![(old.epsilon[0], old.finding)]].concat(),
            None => too_long.to_vec(),
        };
        last.insert(outcome.term.clone(), outcome);
    }
}

/// What is printed, and what did not pass.
#[derive(Default)]
struct Table {
    failed: Vec<String>,
}

impl Table {
    fn add(&mut self, parameter: &str, direction: &str, outcomes: Vec<Outcome>) -> Result<()> {
        let mut out = program::stdout();
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
                self.failed.push(format!("\"{term}\" by {parameter}, {direction}: {finding}"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The finding for J(ε) along a direction, with a slope g·q.
    fn found(j: impl Fn(f64) -> f64, slope: f64) -> Finding {
        let epsilon: Vec<f64> = (0..7).map(|k| 1e-2 * 0.5_f64.powi(k)).collect();
        let values: Vec<f64> = epsilon.iter().map(|&e| j(e)).collect();
        Outcome::new("term", j(0.0), slope, &epsilon, &values).finding
    }

    #[test]
    fn a_curved_term_has_a_slope() {
        let j = |e: f64| (1.0 + e).powi(3);
        assert!(found(j, 3.0).passes() && matches!(found(j, 3.0), Finding::Slope(_)));
        assert!(!found(j, 3.1).passes());
        assert!(!found(j, 0.0).passes());
    }

    /// The remainders are 4e-11 of the term and less.
    #[test]
    fn small_remainders_that_fall_as_they_should_have_a_slope() {
        let j = |e: f64| 5.0 + 1e-3 * e + 2e-6 * e * e;
        assert!(found(j, 1e-3).passes() && matches!(found(j, 1e-3), Finding::Slope(_)));
        assert!(!found(j, 1.01e-3).passes());
    }

    /// Of four steps there are no five remainders.
    #[test]
    fn few_remainders_that_fall_exactly_by_four_have_a_slope() {
        let epsilon = [1e-2, 5e-3, 2.5e-3, 1.25e-3];
        let j = |e: f64| 5.0 + 1e-3 * e + 2e-6 * e * e;
        let values = epsilon.map(j);
        let finding = |slope: f64| Outcome::new("term", j(0.0), slope, &epsilon, &values).finding;
        assert!(finding(1e-3).passes() && matches!(finding(1e-3), Finding::Slope(_)));
        assert!(!finding(1.01e-3).passes());
    }

    #[test]
    fn without_a_slope_only_proven_gradients_pass() {
        assert_eq!(found(|_| 5.0, 0.0), Finding::Constant);
        assert_eq!(found(|_| 0.0, 0.0), Finding::Constant);
        assert!(!found(|_| 5.0, 1e-3).passes());
        let line = |e: f64| 5.0 + 2.0 * e;
        assert!(matches!(found(line, 2.0), Finding::Linear(_)));
        assert!(!found(line, 2.001).passes());
        assert!(!found(line, 0.0).passes());
        // changes of 1e-8 of the term, of which 10 % may be noise, prove nothing
        assert_eq!(found(|e| 5.0 + 5e-6 * e, 5e-6), Finding::NotMeasurable);
        assert_eq!(found(|e| 5.0 + 5e-6 * e, 4.8e-6), Finding::NotMeasurable);
    }
}
