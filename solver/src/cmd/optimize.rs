//! `solver optimize`: a design problem to a better body.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use measure::constraint::Constraint;
use mesh::io::vtu;
use program::{Changes, FolderLock, InputFile, KeyPath, Settings, Unusable};
use reports::{
    Castable, Designed, DesignedProbe, Ended, Inputs, Iteration, Kept, LevelEnd, Numbers,
    Optimization,
};
use scene::config::{DesignConfig, LevelConfig, ObjectiveConfig, ProbeConfig, beside};
use scene::{ObjectiveBuilder, Scene, log_share};
use serde::Deserialize;

use crate::number;
use crate::optimize::{
    CASTABLE, Cascade, Checkpoint, Finished, History, LATEST, Meshes, Molding, mesh_file,
    write_bodies,
};
use crate::report::crossing::Crossing;
use crate::report::{results, summary};

/// A smaller fall of the objective is hardly a design [1].
const LITTLE: f64 = 0.01;

/// Optimise shapes of chambers and pressures over time
///
/// Writes to the output folder: design.msh (tagged; design.NAME.msh for each of
/// several bodies), pressures.toml and parameters.toml (designed loads, as tables of a scene),
/// history.jsonl (one line per accepted iteration), report.json, and result.vtu (the
/// design at the end). Killed at any moment, the same command continues where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// The design problem
    design: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Begin anew, whatever the folder holds
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let Problem { file, design, scene } = read(&arguments.design, &[], &arguments.changes)?;
    log_share(&scene.body);
    let molding = file.checked(|_| Molding::new(&arguments.design, &design, &scene.body))?;
    let meshes = file.checked(|_| meshes(arguments, &design, &scene))?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    let objectives =
        file.checked(|_| ObjectiveBuilder::new(&arguments.design, &design.objective, &scene))?;
    let inputs = hash_inputs(&file, &design, &scene)?;
    if arguments.restart || outdated(folder, &inputs)? {
        if folder.join("report.json").exists() && !failed(folder)? {
            log::warn!("{}: the finished design there is replaced", folder.display());
        }
        forget(folder)?;
    }
    if is_kept_before_a_level(folder)? {
        log::info!("{}: is finished, before a level that cannot begin", folder.display());
        return Ok(());
    }
    forget_failure(folder)?;
    let cascade = Cascade {
        scene: &scene,
        design: &design,
        meshes,
        objectives: &objectives,
        molding,
        folder: folder.clone(),
        inputs,
    };
    let finished = cascade.run().map_err(|error| {
        // the first error is the one that counts
        let _ = forget_start(folder);
        file.place(error)
    })?;
    write(folder, &scene, &finished)?;
    let (level, evaluation) = &finished.last;
    let crossing = level.crossing(evaluation);
    let (inputs, set) = provenance(folder, &file, &design, &scene)?;
    let found = Found { finished: &finished, scene: &scene, design: &design };
    let mut designed = found.designed(History::new(folder).read()?, inputs, set, start);
    designed.crossing = crossing.as_ref().map(Crossing::report);
    let status = match crossing {
        Some(_) => Ended::SurfacesCrossed,
        None => found.ended(),
    };
    let report = Optimization {
        status,
        usable: crossing.is_none(),
        designed: Some(designed.clone()),
        failed: None,
    };
    results::write_report(folder, &report)?;
    let [before, after] =
        [designed.objective_before, designed.objective_after].map(|j| j.unwrap_or(f64::NAN));
    let fall = (before - after) / before.abs();
    if fall < LITTLE {
        log::warn!(
            "the objective fell by {:.1} % only: the design is hardly better than the start; see \
             the terms and the reasons in {}",
            100.0 * fall,
            folder.join("report.json").display()
        );
    } else {
        log::info!("{}", summary::of_design(designed.probes.as_ref(), fall));
    }
    for (name, kept) in &designed.constraints {
        if let Some(said) = summary::of_constraint(name, kept) {
            log::info!("{said}");
        }
    }
    if let Some(end) = designed.levels.iter().rev().find(|end| end.ending == status)
        && matches!(status, Ended::StillFalling | Ended::Jammed)
    {
        log::warn!("level {} {}: {}", end.level, end.ending.in_words(), end.why);
    }
    if let Some(crossing) = crossing {
        let design = arguments.design.display();
        return Err(Unusable(format!("{design}: {}", crossing.in_words())).into());
    }
    if fall.is_nan() || fall <= 0.0 {
        return Err(Unusable(format!(
            "{}: no step lowered the objective; see the reasons in {}",
            arguments.design.display(),
            folder.join("report.json").display()
        ))
        .into());
    }
    Ok(())
}

/// A design problem and its scene.
pub struct Problem {
    pub file: Settings,
    pub design: DesignConfig,
    pub scene: Scene,
}

/// A design file and its scene, perhaps with another mesh and other values.
pub fn read(path: &Path, others: &[super::OtherMesh], changes: &Changes) -> Result<Problem> {
    let (own, of_scene) = changes.own_and_scene();
    let file = DesignConfig::settings(path, &own)?;
    let design = DesignConfig::of(&file)?;
    let scene = number::read(&beside(path, &design.scene), others, &of_scene)?;
    scene.warn_of_growth();
    Ok(Problem { file, design, scene })
}

/// The body on the meshes of the scene and of the levels.
fn meshes(arguments: &Arguments, design: &DesignConfig, scene: &Scene) -> Result<Meshes> {
    let (_, of_scene) = arguments.changes.own_and_scene();
    Meshes::new(&scene.body, design, |level| {
        let levels = if design.shape.is_some() { "shape.level" } else { "level" };
        check_body(level, &KeyPath::list(levels), scene)?;
        let path = level.mesh.iter().map(|path| beside(&arguments.design, path));
        let others: Vec<_> = path.map(|path| (level.body.clone(), path)).collect();
        Ok(number::read(&scene.path, &others, &of_scene)?.body)
    })
}

/// The mesh of a level is of a body that the scene has.
fn check_body(level: &LevelConfig, levels: &KeyPath, scene: &Scene) -> Result<()> {
    let refused = |word: &str, what: String| levels.clone().with(KeyPath::word(word)).told(what);
    let names: Vec<&str> = scene.body.parts.iter().filter_map(|p| p.name.as_deref()).collect();
    match level.body.as_deref() {
        Some(body) if names.is_empty() => {
            let what = "the scene has only one body; expected none";
            bail!(refused(body, format!("level: body = \"{body}\": {what}")))
        }
        Some(body) if !names.contains(&body) => {
            let known = names.join(", ");
            bail!(refused(body, format!("level: body = \"{body}\": expected one of {known}")))
        }
        None if names.len() > 1 => {
            let known = names.join(", ");
            let what = format!("level: mesh without body; expected body = one of {known}");
            bail!(refused("mesh", what))
        }
        _ => Ok(()),
    }
}

/// Whether the folder holds an optimisation of other inputs that is finished or
/// has no result. Any other is removed with --restart only.
fn outdated(folder: &Path, inputs: &str) -> Result<bool> {
    let finished = folder.join("report.json").exists() && !failed(folder)?;
    Ok(Checkpoint::read(folder)?
        .is_some_and(|c| c.inputs != inputs && (finished || c.history == 0)))
}

/// What is read of a report.
#[derive(Deserialize)]
struct Usable {
    usable: bool,
}

/// Whether the report in the folder is that of a start without equilibrium.
fn failed(folder: &Path) -> Result<bool> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(false);
    }
    let report = serde_json::from_str::<Usable>(&mesh::io::read_own_text(&path)?);
    Ok(!report.with_context(|| path.display().to_string())?.usable)
}

/// Whether the report in the folder is of a design whose next level could not begin: to try it again would lose it.
fn is_kept_before_a_level(folder: &Path) -> Result<bool> {
    let path = folder.join("report.json");
    if !path.exists() || failed(folder)? {
        return Ok(false);
    }
    let report = serde_json::from_str::<Levels>(&mesh::io::read_own_text(&path)?);
    let levels = report.with_context(|| path.display().to_string())?.levels;
    Ok(levels.last().is_some_and(|end| end.ending == Ended::NoEquilibrium))
}

/// What is read of a report for that; reports of programs before have no levels.
#[derive(Deserialize)]
struct Levels {
    #[serde(default)]
    levels: Vec<LevelEnd>,
}

/// Removes the report of a failure once the run continues.
fn forget_failure(folder: &Path) -> Result<()> {
    if failed(folder)? {
        remove(folder, &["report.json", results::FAILED])?;
    }
    Ok(())
}

/// Removes what a run without a first evaluation cannot be continued from.
fn forget_start(folder: &Path) -> Result<()> {
    if Checkpoint::read(folder)?.is_none_or(|c| c.history > 0) {
        return Ok(());
    }
    remove(folder, &["checkpoint.json", "history.jsonl"])?;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.starts_with("level-") && name.ends_with(".msh") {
            remove(folder, &[&name])?;
        }
    }
    Ok(())
}

fn forget(folder: &Path) -> Result<()> {
    let names = [
        "checkpoint.json",
        "history.jsonl",
        "report.json",
        "result.vtu",
        "pressures.toml",
        "parameters.toml",
    ];
    remove(folder, &names)?;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let design = ["design.", "latest.", "castable.", "remeshed-"]
            .iter()
            .any(|first| name.starts_with(first));
        let design = design && name.ends_with(".msh");
        if design || (name.starts_with("run-") && name.ends_with(".npy")) {
            remove(folder, &[&name])?;
        }
    }
    remove(folder, &[results::FAILED])
}

fn remove(folder: &Path, names: &[&str]) -> Result<()> {
    for name in names {
        mesh::io::remove_output(&folder.join(name))?;
    }
    Ok(())
}

/// A checkpoint is only good for the problem it was made for.
fn hash_inputs(file: &Settings, design: &DesignConfig, scene: &Scene) -> Result<String> {
    let mut hashes = vec![file.hash(), scene.file.hash()];
    for part in &scene.parts {
        hashes.push(program::sha256_file(&part.mesh_path)?);
    }
    for path in named_files(file, design).iter().flatten() {
        hashes.push(program::sha256_file(path)?);
    }
    Ok(hashes.join(" "))
}

/// The meshes of levels and the files of objectives that a design names beside its scene.
fn named_files(file: &Settings, design: &DesignConfig) -> [BTreeSet<PathBuf>; 2] {
    let at = file.file().path;
    let all = |paths: Vec<PathBuf>| paths.iter().map(|path| beside(&at, path)).collect();
    let meshes = design.levels().into_iter().filter_map(|level| level.mesh).collect();
    let targets = design.objective.iter().flat_map(|term| term.files()).map(PathBuf::from);
    [all(meshes), all(targets.collect())]
}

fn write(folder: &Path, scene: &Scene, finished: &Finished) -> Result<()> {
    write_bodies(folder, "design", scene, &finished.body)?;
    let is_refused = matches!(
        History::new(folder).read()?.last(),
        Some(Iteration { mold: Some(Castable::Refused { .. }), .. })
    );
    for part in &scene.body.parts {
        let name = part.name.as_deref();
        remove(folder, &[&mesh_file(LATEST, name)])?;
        let castable = mesh_file(CASTABLE, name);
        if !is_refused {
            remove(folder, &[&castable])?;
        } else if folder.join(&castable).exists() {
            log::warn!(
                "the design cannot be cast; the last shape that can is {}",
                folder.join(&castable).display()
            );
        }
    }
    let (level, evaluation) = &finished.last;
    vtu::write_vtu(&folder.join("result.vtu"), &level.grid(evaluation))?;
    write_pressures(folder, finished)?;
    write_parameters(folder, finished)
}

/// The designed parameters and numbers as the tables that a scene would have.
fn write_parameters(folder: &Path, finished: &Finished) -> Result<()> {
    let all = finished.last.0.map().parameters(&finished.theta);
    if all.is_empty() {
        return Ok(());
    }
    let (numbers, parameters): (BTreeMap<_, _>, BTreeMap<_, _>) =
        all.into_iter().partition(|(name, _)| name.contains('.'));
    let tables = [("parameters", parameters), ("numbers", numbers)];
    let tables = tables.into_iter().filter(|(_, table)| !table.is_empty());
    let text = toml::to_string(&tables.collect::<BTreeMap<_, _>>())?;
    mesh::io::write_atomic(&folder.join("parameters.toml"), |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The designed pressures as the tables that a scene would have.
fn write_pressures(folder: &Path, finished: &Finished) -> Result<()> {
    let map = finished.last.0.map();
    let number = |list: &[f64]| toml::Value::from(list.to_vec());
    let one = |(on, values): (String, Vec<f64>)| {
        let mut curve = toml::Table::new();
        curve.insert("t".to_owned(), number(&finished.last.1.runs[0].states.times));
        curve.insert("value".to_owned(), number(&values));
        let mut table = toml::Table::new();
        table.insert("on".to_owned(), on.into());
        table.insert("pressure".to_owned(), curve.into());
        toml::Value::Table(table)
    };
    let tables: Vec<toml::Value> = map.pressures(&finished.theta).into_iter().map(one).collect();
    if tables.is_empty() {
        return Ok(());
    }
    let text = toml::to_string(&toml::Table::from_iter([("chamber".to_owned(), tables.into())]))?;
    mesh::io::write_atomic(&folder.join("pressures.toml"), |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The files that a design was made from, and the values that were set.
fn provenance(
    folder: &Path,
    file: &Settings,
    design: &DesignConfig,
    scene: &Scene,
) -> Result<(Inputs, Vec<String>)> {
    let (inputs, set) = results::provenance(folder, Some(file), scene)?;
    let hashed = |paths: BTreeSet<PathBuf>| -> Result<Vec<InputFile>> {
        Ok(paths.iter().map(|path| InputFile::new(path, folder)).collect::<Result<_, _>>()?)
    };
    let [level_meshes, targets] = named_files(file, design).map(hashed);
    Ok((Inputs { level_meshes: level_meshes?, targets: targets?, ..inputs }, set))
}

/// What an optimisation came to.
struct Found<'a> {
    finished: &'a Finished,
    scene: &'a Scene,
    design: &'a DesignConfig,
}

impl Found<'_> {
    fn designed(
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
    fn ended(&self) -> Ended {
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
            (kept.name.clone(), Kept { least: kept.least(), found, worth })
        };
        level.constraints().iter().zip(worth).map(one).collect()
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
