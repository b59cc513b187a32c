//! `solver simulate`: a scene to its equilibrium, or through time, and a report.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::builder::RangedU64ValueParser;
use mechanics::forward::{LoadStep, Problem, Unreached, Workspace};
use program::{FolderLock, Unusable};
use reports::Simulation;
use scene::{Scene, log_share};

use super::{SceneArguments, hash_inputs};
use run::end::Outcome;
use run::error_bars;
use run::report::failure::Diagnosis;
use run::report::meeting;
use run::report::record::{Checkpoint, Recorder, Work};
use run::report::results;
use run::report::simulation;
use run::report::writer::write_beside;
use run::steps::{Made, Steps};

/// Solve a scene for its equilibrium under the full load, or through time
///
/// Writes to the output folder: report.json, nodes.npy and displacement.npy
/// (exact, of the last state), result.pvd with one .vtu per load step or, in a
/// scene with [time], per time step, steps.jsonl with one line for each, curve.csv with a row, and
/// result.vtu. A run that was interrupted continues after its last step when the same
/// command is given again.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    of: SceneArguments,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Only the first of the scene's time steps
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    steps: Option<usize>,
    /// Ten load steps, the points of a curve, where the scene gives no largest_load_step
    #[arg(long)]
    curve: bool,
    /// Only the final state, no file per step
    #[arg(long)]
    final_only: bool,
    /// Do not prove that no surfaces intersect: of every step with contact, of the last without
    #[arg(long)]
    no_certify: bool,
    /// Forget an interrupted run in the folder
    #[arg(long)]
    restart: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let mut scene = arguments.of.read()?;
    scene.certify = !arguments.no_certify;
    if arguments.curve {
        scene.config.solver.step_for_curves();
    }
    let begin = Instant::now();
    let (problem, mut workspace) = scene.problem(&scene.body)?;
    let probes = scene.probes(&scene.body, &problem.space)?;
    scene.check_loads()?;
    error_bars::check(&scene)?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    let inputs = hash_inputs(&scene)?;
    let checkpoint = if arguments.restart { None } else { Checkpoint::read(folder, &inputs)? };
    let done = checkpoint.as_ref().map_or(0, |c| c.steps);
    results::remove_stale(folder, done)?;
    announce(&scene, &workspace);
    if done == 0 {
        let warning = meeting::foreseen(&scene, &problem, &mut workspace);
        warning.iter().for_each(|warning| log::warn!("{warning}"));
    }
    let timed = scene.config.time.is_some();
    let count = scene.times().len();
    let last = arguments.steps.map_or(count, |n| n.min(count));
    let before_s = checkpoint.as_ref().map_or(0.0, |c| c.elapsed_s);
    let prepared_s = before_s + begin.elapsed().as_secs_f64();
    let pictures = !arguments.final_only;
    let mut recorder =
        Recorder::new(&scene, (&problem, &probes), folder, pictures, checkpoint.as_ref())?;
    let steps = Steps::new(&scene, &problem).up_to(last);
    let steps = continued(steps, (&problem, &mut workspace), checkpoint);
    let keep = keeps_states(&scene, done);
    let steps = if keep { steps.keeping_states() } else { steps };
    let mut steps = steps.with_progress(&mut workspace);
    let mut report = simulation::begun(&scene, &problem, folder)?;
    let checkpoint = |steps: &Steps, workspace: &Workspace| Checkpoint {
        inputs: inputs.clone(),
        steps: steps.made,
        progress: steps.stepper.progress.clone(),
        path: steps.path().cloned(),
        couplings: workspace.couplings().to_vec(),
        work: Work::default(),
        timings: workspace.timings,
        elapsed_s: before_s + begin.elapsed().as_secs_f64(),
    };
    let solver = (&mut steps, &mut workspace);
    let (unreached, last_on_path) = make_all(solver, &mut recorder, timed, checkpoint)?;
    let equilibrium_s = before_s + begin.elapsed().as_secs_f64();
    simulation::follow(&mut report, &recorder, &workspace);
    Checkpoint::remove(folder)?;
    let rest = &scene.body.mesh.vertices;
    let stepper = &steps.stepper;
    if let Some(unreached) = unreached {
        let unreached = stepper.confirmed(&problem, &mut workspace, rest, &unreached);
        let solver = (&problem, &mut workspace);
        return Err(failed(&scene, solver, arguments, report, &unreached)?);
    }
    let progress = &stepper.progress;
    let inertia = progress.integrator.method.has_inertia();
    let outcome = Outcome {
        end: stepper.iterate(&problem, rest),
        last: last_on_path.as_ref(),
        states: steps.states.as_ref(),
        recorder: &recorder,
        newton_iterations: progress.newton_iterations,
        velocity: inertia.then(|| &progress.integrator.last().v[..]),
        equilibrium_s,
        predicted_s: steps.foreseen().map(|foreseen| prepared_s + foreseen),
        since: start,
        before_s,
    };
    let refusal = outcome.write(&scene, (&problem, &mut workspace, &probes), folder, report)?;
    let Some(refusal) = refusal else { return Ok(()) };
    Err(Unusable(format!("{}: {refusal}", arguments.of.scene.display())).into())
}

/// Says what will be solved.
fn announce(scene: &Scene, workspace: &Workspace) {
    let silicones = scene.laws.iter().filter_map(|law| law.config.silicone());
    for line in silicones.map(|named| named.in_words()).collect::<BTreeSet<_>>() {
        log::info!("{line}");
    }
    simulation::foresee(scene);
    let tables = scene.config.rooms().into_iter().flat_map(|room| room.in_words());
    tables.for_each(|words| log::info!("{words}"));
    log::info!(
        "{} tets, degree {}, {}",
        scene.body.mesh.tets.len(),
        scene.config.degree,
        workspace.memory().describe(system::available_memory())
    );
    log_share(&scene.body);
}

/// Least time between two checkpoints of a static run.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(1);

/// Steps after those that an interrupted run has made, if there are any.
fn continued<'a>(
    steps: Steps<'a>,
    (problem, workspace): (&Problem, &mut Workspace),
    checkpoint: Option<Checkpoint>,
) -> Steps<'a> {
    let Some(checkpoint) = checkpoint else { return steps };
    log::info!("continuing after {} steps", checkpoint.steps);
    workspace.set_couplings(problem, checkpoint.couplings);
    workspace.timings = checkpoint.timings;
    steps.after(checkpoint.steps, checkpoint.progress, checkpoint.path)
}

/// Makes all steps, which are written while the next is computed. The result says why one was not reached, and has the
/// last state of a path.
fn make_all(
    (steps, workspace): (&mut Steps, &mut Workspace),
    recorder: &mut Recorder,
    timed: bool,
    checkpoint: impl Fn(&Steps, &Workspace) -> Checkpoint,
) -> Result<(Option<Unreached>, Option<LoadStep>)> {
    let (mut saved, mut last_on_path) = (Instant::now(), None);
    let (unreached, waited) = write_beside(recorder, |writer| {
        while let Some(Made { mut finished, unreached }) = steps.next(workspace) {
            // load steps come so often that the checkpoint of each would cost time
            let due = timed || saved.elapsed() >= BETWEEN_CHECKPOINTS;
            if due && !steps.ended {
                finished.checkpoint = Some(checkpoint(steps, workspace));
                saved = Instant::now();
            }
            let on_path = finished.steps.last().filter(|step| step.path.is_some());
            last_on_path = on_path.cloned().or(last_on_path.take());
            writer.send(finished)?;
            if unreached.is_some() {
                return Ok(unreached);
            }
        }
        Ok(None)
    })?;
    workspace.timings.output += waited;
    Ok((unreached, last_on_path))
}

/// Writes the report of a run without an equilibrium; the result is what to say of it.
fn failed(
    scene: &Scene,
    solver: (&Problem, &mut Workspace),
    arguments: &Arguments,
    mut report: Simulation,
    unreached: &Unreached,
) -> Result<anyhow::Error> {
    let folder = &arguments.output;
    let diagnosis = Diagnosis::new(scene, &scene.body, solver, unreached);
    diagnosis.write_state(folder)?;
    (report.status, report.usable) = (diagnosis.status, false);
    report.failed = Some(diagnosis.failed);
    results::write_report(folder, &report)?;
    Ok(Unusable(format!(
        "{}: {}\n  the state at {} is in {}; its array worst_element marks the element",
        arguments.of.scene.display(),
        diagnosis.message,
        scene.progress(unreached.time),
        folder.join(results::FAILED).display()
    ))
    .into())
}

/// Whether all states of a run are needed, as error bars do.
fn keeps_states(scene: &Scene, done: usize) -> bool {
    let wanted = scene.config.uncertainty.is_some();
    let continues = done > 0 && scene.config.time.is_some();
    if wanted && continues {
        log::warn!("no error bars: they need all states, and this run continues; see --restart");
    }
    wanted && !continues
}
