//! `solver simulate`: a scene to its equilibrium, or through time, and a report.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use mesh::io::vtu;
use program::Unusable;
use serde_json::{Value, json};
use solver::failure::{self, Diagnosis};
use solver::forward::{LoadStep, March, System, Unreached};
use solver::memory;
use solver::record::{Checkpoint, Recorder, STEPS};
use solver::results;
use solver::scene::Scene;
use solver::stretch::Stretches;

/// Solve a scene for its equilibrium under the full load, or through time
///
/// Writes to the output folder: report.json, nodes.npy and displacement.npy
/// (exact, of the last state), result.pvd with one .vtu per load step or, in a
/// scene with [time], per time step, steps.jsonl with one line for each, and
/// result.vtu. A run with [time] that was interrupted goes on after its last
/// time step when the same command is given again.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene
    scene: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Another tagged mesh in place of the scene's
    #[arg(long, value_parser = super::other_mesh)]
    mesh: Vec<super::OtherMesh>,
    /// Another degree of the displacement in place of the scene's: 1, 2 or 3
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..=3))]
    degree: Option<usize>,
    /// Only the first of the scene's time steps
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    steps: Option<usize>,
    /// Only the final state, no file per step
    #[arg(long)]
    final_only: bool,
    /// Do not prove of every step that no surfaces intersect
    #[arg(long)]
    no_certify: bool,
    /// Forget an interrupted run in the folder
    #[arg(long)]
    restart: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let mut scene = Scene::read_with(&arguments.scene, &arguments.mesh)?;
    scene.config.degree = arguments.degree.unwrap_or(scene.config.degree);
    scene.certify = !arguments.no_certify;
    let begin = Instant::now();
    let mut system = scene.system(&scene.body)?;
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let inputs = hash_inputs(&scene)?;
    let checkpoint = if arguments.restart { None } else { Checkpoint::read(folder, &inputs)? };
    remove_stale(folder, checkpoint.as_ref().map_or(0, |c| c.steps))?;
    log::info!(
        "{} tets, degree {}, {}",
        scene.body.mesh.tets.len(),
        scene.config.degree,
        system.memory().describe(memory::available())
    );
    let mut march = March::new(scene.stepping(), scene.integrator(&scene.body, &system));
    let pictures = !arguments.final_only;
    let mut recorder = Recorder::new(&scene, &mut system, folder, pictures, checkpoint.as_ref())?;
    let before_s = checkpoint.as_ref().map_or(0.0, |c| c.elapsed_s);
    if let Some(checkpoint) = checkpoint {
        log::info!("goes on after {} time steps", checkpoint.steps);
        system.couple(checkpoint.couplings);
        system.timings = checkpoint.timings;
        march.progress = checkpoint.progress;
    }
    let mut report = header(&scene, &system, arguments)?;
    let outcome =
        go(&scene, &mut system, &mut march, &mut recorder, arguments, |system, march, steps| {
            let checkpoint = Checkpoint {
                inputs: inputs.clone(),
                steps,
                progress: march.progress.clone(),
                couplings: system.couplings().to_vec(),
                timings: system.timings,
                elapsed_s: before_s + begin.elapsed().as_secs_f64(),
            };
            checkpoint.write(folder)
        })?;
    let equilibrium_s = before_s + begin.elapsed().as_secs_f64();
    report["steps"] = json!(recorder.lines);
    Checkpoint::remove(folder)?;
    if let Some(unreached) = outcome {
        let diagnosis = Diagnosis::new(&scene, &scene.body, &mut system, &unreached);
        diagnosis.write_state(folder)?;
        merge(&mut report, &diagnosis.report);
        results::write_json(&folder.join("report.json"), &report)?;
        return Err(Unusable(format!(
            "{}: {}\n  the state at {} is in {}; its array worst_element marks the element",
            arguments.scene.display(),
            diagnosis.message,
            scene.progress(unreached.load),
            folder.join(failure::STATE).display()
        ))
        .into());
    }
    let u = march.progress.reached().to_vec();
    let rest = &scene.body.mesh.vertices;
    results::write_state(folder, &system.space, rest, &u)?;
    let grid = results::grid_with_forces(&system, rest, &u, march.progress.load());
    vtu::write_vtu(&folder.join("result.vtu"), &grid)?;
    fill(&mut report, &scene, &mut system, &march, &recorder)?;
    report["equilibrium_s"] = json!(equilibrium_s);
    report["wall_s"] = json!(before_s + start.elapsed().as_secs_f64());
    report["peak_rss_mb"] = json!(program::peak_rss_mb());
    results::write_json(&folder.join("report.json"), &report)
}

/// Goes through all time steps that are left, and tells where that ends early.
fn go(
    scene: &Scene,
    system: &mut System,
    march: &mut March,
    recorder: &mut Recorder,
    arguments: &Arguments,
    save: impl Fn(&System, &March, usize) -> Result<()>,
) -> Result<Option<Unreached>> {
    let start = Instant::now();
    let rest = &scene.body.mesh.vertices;
    let times = scene.times();
    let count = arguments.steps.map_or(times.len(), |n| n.min(times.len()));
    let timed = scene.config.time.is_some();
    let done = if timed { recorder.lines.len() } else { 0 };
    for (n, &end) in times.iter().enumerate().take(count).skip(done) {
        let mut steps: Vec<LoadStep> = Vec::new();
        let outcome = march.advance(system, rest, end, |step| {
            log::info!(
                "{}{}  newton {:2}  |g| {:.1e} N  {:.1} s",
                if timed { format!("step {}/{count}  ", n + 1) } else { String::new() },
                scene.progress(step.load),
                step.newton_iterations,
                step.residual,
                start.elapsed().as_secs_f64()
            );
            steps.push(step.clone());
        });
        if let (Err(unreached), false) = (&outcome, timed) {
            return Ok(Some(unreached.clone()));
        }
        let last = steps.len();
        for (i, step) in steps.iter().enumerate() {
            recorder.follow(system, step);
            if !timed || (i + 1 == last && step.ends_time_step) {
                let v = &march.progress.integrator.last().v;
                let inertia = march.progress.integrator.method.has_inertia();
                recorder.record(system, step, inertia.then_some(v))?;
            }
        }
        if let Err(unreached) = outcome {
            return Ok(Some(unreached));
        }
        if timed && n + 1 < count {
            save(system, march, n + 1)?;
        }
    }
    Ok(None)
}

fn merge(report: &mut Value, more: &Value) {
    for (key, value) in more.as_object().into_iter().flatten() {
        report[key] = value.clone();
    }
}

/// What the states depend on: the scene, its meshes and the changes to it.
fn hash_inputs(scene: &Scene) -> Result<String> {
    let mut hashes = vec![program::sha256_file(&scene.path)?, scene.config.degree.to_string()];
    for part in &scene.parts {
        hashes.push(program::sha256_file(&part.mesh_path)?);
    }
    for obstacle in &scene.config.obstacle {
        let path = solver::config::beside(&scene.path, &obstacle.surface);
        hashes.push(program::sha256_file(&path)?);
    }
    Ok(hashes.join(" "))
}

/// Results of an earlier run must not stand beside a report that says
/// otherwise; those of the steps that an interrupted one has done stay.
fn remove_stale(folder: &Path, done: usize) -> Result<()> {
    let kept: Vec<String> = (0..done).map(|i| format!("step_{i:03}.vtu")).collect();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let ours = ["report.json", "nodes.npy", "displacement.npy", "result.vtu", failure::STATE];
        let unless_kept = ["result.pvd", STEPS];
        let step = name.starts_with("step_") && name.ends_with(".vtu");
        if ours.contains(&name)
            || (done == 0 && unless_kept.contains(&name))
            || (step && !kept.iter().any(|k| k == name))
        {
            std::fs::remove_file(&path).with_context(|| path.display().to_string())?;
        }
    }
    Ok(())
}

fn header(scene: &Scene, system: &System, arguments: &Arguments) -> Result<Value> {
    let file = |path: &Path| -> Result<Value> {
        Ok(json!({ "path": path, "sha256": program::sha256_file(path)? }))
    };
    let meshes = scene.parts.iter().map(|part| file(&part.mesh_path)).collect::<Result<_>>()?;
    let materials = scene.parts.iter().map(|part| {
        let material = &part.material;
        json!({
            "kind": material.law.key,
            "parameters": material.law.table(&material.values),
            "moduli": material.moduli(),
        })
    });
    Ok(json!({
        "status": "ok",
        "usable": true,
        "program": concat!("solver ", env!("CARGO_PKG_VERSION")),
        "inputs": { "scene": file(&arguments.scene)?, "mesh": one_or_list(meshes) },
        "config": scene.config,
        "material": one_or_list(materials.collect()),
        "dofs": system.len(),
        "tets": scene.body.mesh.tets.len(),
        "vertices": scene.body.mesh.vertices.len(),
        "factor_entries": system.linear.factor_len(),
        "memory_estimate_mb": system.memory().bytes as f64 / f64::from(1 << 20),
    }))
}

/// What is told of each body: alone where there is one.
fn one_or_list(mut values: Vec<Value>) -> Value {
    if values.len() == 1 { values.remove(0) } else { Value::Array(values) }
}

fn fill(
    report: &mut Value,
    scene: &Scene,
    system: &mut System,
    march: &March,
    recorder: &Recorder,
) -> Result<()> {
    let rest = &scene.body.mesh.vertices;
    let (u, end) = (march.progress.reached(), march.progress.load());
    let energies = results::energies(system, rest, u, end);
    let work = recorder.work();
    report["tolerance_met"] =
        json!(recorder.lines.iter().all(|line| line["rounding_floor"].is_null()));
    report["newton_iterations"] = json!(march.progress.newton_iterations);
    let elastic = energies["elastic"];
    report["energy_balance"] = json!({ "work_of_loads": work, "elastic": elastic });
    if march.progress.integrator.method.has_inertia() {
        let v = &march.progress.integrator.last().v;
        let kinetic = results::kinetic_energy(&system.energies, &system.space, rest, v);
        report["energy_balance"]["kinetic"] = json!(kinetic);
    } else {
        let gap = (work - elastic) / elastic.max(f64::MIN_POSITIVE);
        report["energy_balance"]["relative_gap"] = json!(gap);
    }
    report["energies"] = json!(energies);
    report["force_balance"] = results::balance(system, rest, u, end);
    report["tags"] = json!(results::tags(scene, &scene.body, system, u, end)?);
    report["chambers"] = json!(results::chambers(system, rest, u, end));
    report["stretch_range"] = json!(stretches(scene, system, u));
    report["timings"] = json!(system.timings);
    Ok(())
}

/// Principal stretches of the state, with a warning where the material was not
/// tested.
fn stretches(scene: &Scene, system: &System, u: &[f64]) -> Stretches {
    let range = scene.stretch_range();
    let found = Stretches::of(&system.space, &scene.body.mesh.vertices, u, range);
    if let Some(warning) = found.warning() {
        log::warn!("{warning}");
    }
    found
}
