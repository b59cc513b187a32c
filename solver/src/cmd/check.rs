//! `solver check`: the Taylor test on the user's own design problem.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use mesh::cli::Unusable;
use solver::math::linear::{dot, norm};
use solver::math::random::Random;
use solver::math::taylor::{Taylor, taylor};
use solver::optimize::{Evaluation, Level};
use solver::scene::ObjectiveBuilder;

use super::optimize::read;
use solver::config::LevelConfig;

/// Slopes of the first-order remainder that an exact gradient may have.
const ACCEPTED: std::ops::RangeInclusive<f64> = 1.9..=2.1;

/// Times that the test is done again with steps of a quarter of the length.
const SHORTER: i32 = 4;

/// Check the gradient of a design problem against its objective
///
/// Prints the remainders |J(θ + εq) − J(θ) − ε g·q| along the gradient and
/// along random directions; their slope against ε is 2 when the gradient is
/// exact. Exit code 1 when it is not.
#[derive(clap::Args)]
pub struct Arguments {
    /// The design problem
    design: PathBuf,
    /// Check at this tagged mesh, such as an optimised design.msh, in place of
    /// the scene's
    #[arg(long)]
    mesh: Option<PathBuf>,
    /// Number of handles; that of the first level if not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    handles: Option<u32>,
    /// Random directions besides the gradient
    #[arg(long, default_value_t = 1)]
    random: u64,
    /// Largest motion of a vertex [m]; a tenth of an edge if not given, and less
    /// where that is too far
    #[arg(long, value_parser = positive)]
    motion: Option<f64>,
    /// Number of step lengths, each half the one before
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(i32).range(2..=30))]
    steps: i32,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (design, scene) = read(&arguments.design, arguments.mesh.as_deref())?;
    let objectives = ObjectiveBuilder::new(&arguments.design, &design.objective, &scene)?;
    let mut settings = design.levels()[0].clone();
    if let Some(handles) = arguments.handles {
        settings = LevelConfig { handles: Some(handles as usize), vertices: false, ..settings };
    }
    let mut level = Level::new(&scene, &objectives, scene.body.clone(), &design, &settings)?;
    let theta = vec![0.0; level.variables()];
    level.admit(&level.body.mesh.vertices).context("the starting shape")?;
    let start = level.evaluate(&theta, None).map_err(|e| {
        Unusable(format!("{}: the starting shape: {e}", arguments.design.display()))
    })?;
    level.linearize(&theta, &start);
    let gradient = level.gradient(&theta, &start)?;
    log::info!("{} variables, J {:.8e}, |g| {:.4e}", theta.len(), start.objective, norm(&gradient));
    let motion = arguments.motion.unwrap_or(0.1 * level.map().mean_edge());
    let mut failed = Vec::new();
    for direction in 0..=arguments.random {
        let (name, q) = match direction {
            0 => ("gradient".to_owned(), gradient.clone()),
            seed => (format!("random {seed}"), Random::new(seed).numbers(theta.len())),
        };
        let mut result = along(&mut level, &start, &gradient, &q, motion, arguments.steps);
        // too long for the shape to stay valid, or for second order to show
        for k in 1..=SHORTER * i32::from(arguments.motion.is_none()) {
            if result.as_ref().is_ok_and(|r| ACCEPTED.contains(&r.slope)) {
                break;
            }
            let motion = motion * 0.25_f64.powi(k);
            result = along(&mut level, &start, &gradient, &q, motion, arguments.steps);
        }
        let result = result?;
        print(&name, &result)?;
        if !ACCEPTED.contains(&result.slope) {
            failed.push(format!("{name}: {:.3}", result.slope));
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    Err(Unusable(format!(
        "{}: slope is not 2 ± 0.1 along {}",
        arguments.design.display(),
        failed.join(", ")
    ))
    .into())
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a positive number of metres is needed".to_owned()),
    }
}

/// The test along q, scaled so that the longest step moves a vertex by
/// `motion`.
fn along(
    level: &mut Level,
    start: &Evaluation,
    gradient: &[f64],
    q: &[f64],
    motion: f64,
    steps: i32,
) -> Result<Taylor> {
    let zero = vec![0.0; q.len()];
    let scaled = |s: f64| -> Vec<f64> { q.iter().map(|q| s * q).collect() };
    let small = 1e-3 * level.map().mean_edge() / norm(q);
    let per_unit = level.map().motion(&zero, &scaled(small)) / small;
    let epsilon = motion / per_unit;
    let value = |e: f64| -> Result<f64> {
        if e == 0.0 {
            return Ok(start.objective);
        }
        Ok(level.evaluate(&scaled(e), Some(start.run.last())).context("a trial shape")?.objective)
    };
    taylor(epsilon, steps, dot(gradient, q), value)
}

fn print(name: &str, result: &Taylor) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{name}")?;
    writeln!(out, "  {:>12}  {:>12}", "epsilon", "remainder")?;
    for (e, r) in result.epsilon.iter().zip(&result.remainder) {
        writeln!(out, "  {e:12.4e}  {r:12.4e}")?;
    }
    writeln!(
        out,
        "  slope {:.3} (2 expected), without the gradient {:.3} (1 expected)",
        result.slope, result.slope_without_gradient
    )?;
    Ok(())
}
