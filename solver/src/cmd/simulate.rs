//! `solver simulate`: a scene to its equilibrium and a report.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use mesh::cli::Unusable;
use mesh::io::vtu;
use serde_json::{Value, json};
use solver::failure::{self, Diagnosis};
use solver::forward::{LoadStep, Solution, System, solve_in_time};
use solver::memory;
use solver::results;
use solver::scene::Scene;
use solver::stretch::Stretches;

/// Solve a scene for its equilibrium under the full load, or over time
///
/// Writes to the output folder: report.json, nodes.npy and displacement.npy
/// (exact, of the last state), result.pvd with one .vtu per load step or, in a
/// scene with [time], per time step, and result.vtu.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene
    scene: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Another tagged mesh in place of the scene's
    #[arg(long)]
    mesh: Option<PathBuf>,
    /// Another degree of the displacement in place of the scene's: 1, 2 or 3
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..=3))]
    degree: Option<usize>,
    /// Only the final state, no file per load step
    #[arg(long)]
    final_only: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let mut scene = Scene::read(&arguments.scene, arguments.mesh.as_deref())?;
    scene.config.degree = arguments.degree.unwrap_or(scene.config.degree);
    let begin = Instant::now();
    let mut system = scene.system(&scene.body)?;
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    remove_stale(folder)?;
    log::info!(
        "{} tets, degree {}, {}",
        scene.body.mesh.tets.len(),
        scene.config.degree,
        system.memory().describe(memory::available())
    );
    let rest = scene.body.mesh.vertices.clone();
    let times = scene.times();
    let outcome = solve_in_time(&mut system, &rest, &scene.stepping(), &times, |step| {
        log::info!(
            "{}  newton {:2}  |g| {:.1e} N  {:.1} s",
            scene.progress(step.load),
            step.newton_iterations,
            step.residual,
            start.elapsed().as_secs_f64()
        );
    });
    let equilibrium_s = begin.elapsed().as_secs_f64();
    let mut report = header(&scene, &system, arguments)?;
    let solution = match outcome {
        Ok(solution) => solution,
        Err(unreached) => {
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
    };
    write(folder, &scene, &system, &solution, arguments.final_only)?;
    fill(&mut report, &scene, &mut system, &solution)?;
    report["equilibrium_s"] = json!(equilibrium_s);
    report["wall_s"] = json!(start.elapsed().as_secs_f64());
    report["peak_rss_mb"] = json!(results::peak_rss_mb());
    results::write_json(&folder.join("report.json"), &report)
}

/// The steps to report: those that the scene asks for.
fn reported<'a>(scene: &Scene, solution: &'a Solution) -> impl Iterator<Item = &'a LoadStep> {
    let all = scene.config.time.is_none();
    solution.steps.iter().filter(move |step| all || step.ends_time_step)
}

fn merge(report: &mut Value, more: &Value) {
    for (key, value) in more.as_object().into_iter().flatten() {
        report[key] = value.clone();
    }
}

/// Results of an earlier run must not stand beside a report that says
/// otherwise.
fn remove_stale(folder: &Path) -> Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let ours = [
            "report.json",
            "nodes.npy",
            "displacement.npy",
            "result.vtu",
            "result.pvd",
            failure::STATE,
        ];
        if ours.contains(&name) || (name.starts_with("step_") && name.ends_with(".vtu")) {
            std::fs::remove_file(&path).with_context(|| path.display().to_string())?;
        }
    }
    Ok(())
}

fn header(scene: &Scene, system: &System, arguments: &Arguments) -> Result<Value> {
    let file = |path: &Path| -> Result<Value> {
        Ok(json!({ "path": path, "sha256": mesh::io::sha256_file(path)? }))
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

fn fill(report: &mut Value, scene: &Scene, system: &mut System, solution: &Solution) -> Result<()> {
    let rest = &scene.body.mesh.vertices;
    let end = scene.end();
    let energies = results::energies(system, rest, &solution.u, end);
    let work = work_of_loads(scene, system, &solution.steps)?;
    let elastic = energies["elastic"];
    report["tolerance_met"] = json!(solution.steps.iter().all(|s| s.rounding_floor.is_none()));
    report["newton_iterations"] = json!(solution.newton_iterations);
    let steps = reported(scene, solution);
    let steps = steps.map(|step| results::step(scene, &scene.body, system, step));
    report["steps"] = json!(steps.collect::<Result<Vec<_>>>()?);
    report["energy_balance"] = json!({
        "work_of_loads": work,
        "elastic": elastic,
        "relative_gap": (work - elastic) / elastic.max(f64::MIN_POSITIVE),
    });
    report["energies"] = json!(energies);
    report["force_balance"] = results::balance(system, rest, &solution.u, end);
    report["tags"] = json!(results::tags(scene, &scene.body, system, &solution.u)?);
    report["walls"] = json!(results::walls(scene, &scene.body, system, &solution.u, end)?);
    report["stretch_range"] = json!(stretches(scene, system, solution));
    report["timings"] = json!(system.timings);
    Ok(())
}

/// Principal stretches of the state, with a warning where the material was not
/// tested.
fn stretches(scene: &Scene, system: &System, solution: &Solution) -> Stretches {
    let range = scene.stretch_range();
    let found = Stretches::of(&system.space, &scene.body.mesh.vertices, &solution.u, range);
    if let Some(warning) = found.warning() {
        log::warn!("{warning}");
    }
    found
}

/// Work of gas, dead loads and moving supports along the load steps by the
/// trapezoidal rule [J]: second order in the load increment, so it meets the
/// elastic energy only roughly.
fn work_of_loads(scene: &Scene, system: &mut System, steps: &[LoadStep]) -> Result<f64> {
    let rest = &scene.body.mesh.vertices;
    let chambers = scene.chambers(&scene.body, &system.space)?;
    let fixed = scene.supports(&scene.body, &system.space)?.fixed();
    // pairs of a force and the quantity it works on: gas on volumes, dead loads
    // and supports on displacements
    let mut pairs = |step: &LoadStep| -> Vec<[f64; 2]> {
        system.multipliers.clone_from(&step.multipliers);
        let (reactions, _) = system.gradient(rest, &step.u, step.load);
        let here = system.iterate(rest, &step.u, step.load);
        let mut dead = vec![0.0; step.u.len()];
        for energy in &system.energies {
            if ["body_force", "traction"].contains(&energy.name()) {
                energy.add_gradient(&here, &mut dead);
            }
        }
        let gas = chambers.iter().map(|(_, chamber)| {
            let (volume, gas) = chamber.state(&here);
            [gas.pressure, volume]
        });
        let dofs = (0..dead.len()).map(|dof| {
            let reaction = if fixed[dof] { reactions[dof] } else { 0.0 };
            [reaction - dead[dof], step.u[dof]]
        });
        gas.chain(dofs).collect()
    };
    let Some(first) = steps.first() else { return Ok(0.0) };
    let mut multipliers = first.multipliers.clone();
    multipliers.iter_mut().for_each(|m| m.pressure = 0.0);
    let u = vec![0.0; first.u.len()];
    let mut last = pairs(&LoadStep { load: 0.0, u, multipliers, ..first.clone() });
    let mut work = 0.0;
    for step in steps {
        let next = pairs(step);
        for ([f, q], [next_f, next_q]) in last.iter().zip(&next) {
            work += 0.5 * (f + next_f) * (next_q - q);
        }
        last = next;
    }
    Ok(work)
}

fn write(
    folder: &Path,
    scene: &Scene,
    system: &System,
    solution: &Solution,
    final_only: bool,
) -> Result<()> {
    let rest = &scene.body.mesh.vertices;
    results::write_state(folder, &system.space, rest, &solution.u)?;
    vtu::write_vtu(&folder.join("result.vtu"), &results::grid(&system.space, rest, &solution.u))?;
    if final_only {
        return Ok(());
    }
    let mut collection = Vec::new();
    for (i, step) in reported(scene, solution).enumerate() {
        let name = format!("step_{i:03}.vtu");
        vtu::write_vtu(&folder.join(&name), &results::grid(&system.space, rest, &step.u))?;
        collection.push((step.load, name));
    }
    vtu::write_pvd(&folder.join("result.pvd"), &collection)?;
    Ok(())
}
