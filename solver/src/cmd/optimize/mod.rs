//! `solver optimize`: a design problem to a better body.

mod folder;
mod found;
mod starts;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use mesh::io::vtu;
use program::{Changes, FolderLock, InputFile, KeyPath, Settings, Unusable};
use reports::{Castable, Designed, Ended, Inputs, Iteration, Optimization, Remeshed};
use scene::config::{DesignConfig, LevelConfig, beside};
use scene::{ObjectiveBuilder, Scene, log_share};
use serde::Serialize;
use serde_json::json;

use self::folder::{
    finished, forget, forget_failure, forget_start, is_kept_before_a_level, outdated,
};
use self::found::Found;
use design::optimize::{
    CASTABLE, Cascade, Evaluation, Finished, History, LATEST, Level, Meshes, Molding, Start,
    mesh_file, write_bodies,
};
use run::report::crossing::Crossing;
use run::report::{results, summary};

/// A smaller fall of the objective is hardly a design [1].
const LITTLE: f64 = 0.01;
/// A larger difference of the objective between two meshes of the design, over what was gained, says that its elements are
/// poor [1].
const OFF: f64 = 0.1;

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
    /// Design from so many starts side by side, the shape as modelled and others that handles and loads are moved to at random;
    /// the best is kept, and starts.csv has a line for each
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    starts: usize,
    /// The number of the start, of which 1 is the shape as modelled
    #[arg(long, hide = true, default_value_t = 1, conflicts_with = "starts")]
    start: usize,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let problem = Problem::read(&arguments.design, &[], &arguments.changes)?;
    let Problem { file, design, scene, .. } = &problem;
    log_share(&scene.body);
    let molding = file.checked(|_| Molding::new(&arguments.design, design, &scene.body))?;
    let meshes = file.checked(|_| meshes(arguments, design, scene))?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    ensure!(arguments.starts > 0, "--starts 0: expected 1 or more");
    let best = (arguments.starts > 1).then(|| {
        file.checked(|_| starts::check(design))?;
        starts::best(arguments)
    });
    let best = best.transpose()?;
    let objectives = problem.objectives()?;
    let inputs = hash_inputs(file, design, scene)?;
    if arguments.restart || outdated(folder, &inputs)? {
        if finished(folder)? {
            log::warn!("{}: the finished design there is replaced", folder.display());
        }
        forget(folder)?;
    }
    if is_kept_before_a_level(folder)? {
        log::info!("{}: is finished, before a level that cannot begin", folder.display());
        return Ok(());
    }
    forget_failure(folder)?;
    if let Some(best) = best {
        forget(folder)?;
        starts::take_over(&best, folder)?;
    }
    let cascade = Cascade {
        scene,
        design,
        meshes,
        objectives: &objectives,
        molding,
        folder: folder.clone(),
        start: arguments.start,
        inputs,
    };
    let finished = cascade.run().map_err(|error| {
        // the first error is the one that counts
        let _ = forget_start(folder);
        file.place(error)
    })?;
    write(folder, scene, &finished)?;
    let (level, evaluation) = &finished.last;
    let crossing = level.crossing(evaluation);
    let (inputs, set) = provenance(folder, file, design, scene)?;
    let found = Found { finished: &finished, scene, design };
    let mut designed = found.designed(History::new(folder).read()?, inputs, set, start);
    designed.crossing = crossing.as_ref().map(Crossing::report);
    designed.remeshed = remeshed(&cascade, &finished, &designed);
    let violated = level.violated(evaluation);
    let status = match (&crossing, &violated) {
        (Some(_), _) => Ended::SurfacesCrossed,
        (None, Some(_)) => Ended::NotKept,
        (None, None) => found.ended(),
    };
    let report = Optimization {
        status,
        usable: crossing.is_none() && violated.is_none(),
        designed: Some(designed.clone()),
        failed: None,
    };
    results::write_report(folder, &report)?;
    let [before, after] =
        [designed.objective_before, designed.objective_after].map(|j| j.unwrap_or(f64::NAN));
    let fall = (before - after) / before.abs();
    // to keep its bounds a design may have to give away some of its objective
    let is_better = fall > 0.0 || finished.began_outside;
    if finished.began_outside {
        log::info!(
            "the objective went from {before:.4e} to {after:.4e}; the start violated what the design keeps"
        );
    } else if fall < LITTLE {
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
    let why = match (crossing, violated) {
        (Some(crossing), _) => crossing.in_words(),
        (None, Some(violated)) => format!("the design does not keep {violated}"),
        (None, None) if is_better => return Ok(()),
        (None, None) => {
            let report = folder.join("report.json");
            format!("no step lowered the objective; see the reasons in {}", report.display())
        }
    };
    Err(Unusable(format!("{}: {why}", arguments.design.display())).into())
}

/// The design with a re-meshed interior.
fn remeshed(cascade: &Cascade, finished: &Finished, designed: &Designed) -> Option<Remeshed> {
    let again = match cascade.again(finished) {
        Ok(again) => again?,
        Err(error) => {
            log::warn!("with a re-meshed interior the design was not simulated: {error:#}");
            return None;
        }
    };
    let (own, other) = (finished.last.1.objective, again.objective);
    let gain = (designed.objective_before.unwrap_or(f64::NAN) - own).abs();
    let probes: Vec<String> = designed
        .probes
        .iter()
        .flatten()
        .filter_map(|(name, probe)| {
            Some(format!(", {name} {}", summary::quantity(*again.probes.get(name)?, &probe.unit)))
        })
        .collect();
    let said = format!(
        "with a re-meshed interior the objective is {other:.4e} in place of {own:.4e}{}",
        probes.concat()
    );
    match (other - own).abs() > OFF * gain {
        true => log::warn!("{said}: elements of the design are poor; a finer mesh tells more"),
        false => log::info!("{said}"),
    }
    Some(Remeshed { objective: Some(other), probes: reports::numbers(&again.probes) })
}

/// A design problem and its scene.
pub struct Problem {
    path: PathBuf,
    pub file: Settings,
    pub design: DesignConfig,
    pub scene: Scene,
}

impl Problem {
    /// A design file and its scene, perhaps with another mesh and other values.
    pub fn read(path: &Path, others: &[super::OtherMesh], changes: &Changes) -> Result<Self> {
        let (own, of_scene) = changes.own_and_scene();
        let file = DesignConfig::settings(path, &own)?;
        let design = DesignConfig::of(&file)?;
        let scene = Scene::read_with(&beside(path, &design.scene), others, &of_scene)?;
        scene.warn_of_growth();
        Ok(Self { path: path.to_owned(), file, design, scene })
    }

    /// The terms of its objective.
    pub fn objectives(&self) -> Result<ObjectiveBuilder<'_>> {
        let terms = &self.design.objective;
        self.file.checked(|_| ObjectiveBuilder::new(&self.path, terms, &self.scene))
    }

    /// A level on the body of the scene, and its start with the weights that shares come to.
    pub fn start(
        &self,
        objectives: &ObjectiveBuilder,
        settings: &LevelConfig,
    ) -> Result<(Level, Evaluation)> {
        let Self { path, file, design, scene } = self;
        let mut level = Level::new(scene, objectives, scene.body.clone(), design, settings)
            .map_err(|error| file.place(error))?;
        level
            .admit(&level.body.mesh.vertices)
            .context("the starting shape")
            .map_err(|error| file.place(error))?;
        let start = level.evaluate(&vec![0.0; level.variables()], Start::Rest);
        let start =
            start.map_err(|e| Unusable(format!("{}: the starting shape: {e}", path.display())))?;
        let start = level.weigh(&design.objective, start).map_err(|error| file.place(error))?;
        Ok((level, start))
    }
}

/// The body on the meshes of the scene and of the levels.
fn meshes(arguments: &Arguments, design: &DesignConfig, scene: &Scene) -> Result<Meshes> {
    let (_, of_scene) = arguments.changes.own_and_scene();
    Meshes::new(&scene.body, design, |level| {
        let levels = if design.shape.is_some() { "shape.level" } else { "level" };
        check_body(level, &KeyPath::list(levels), scene)?;
        let path = level.mesh.iter().map(|path| beside(&arguments.design, path));
        let others: Vec<_> = path.map(|path| (level.body.clone(), path)).collect();
        Ok(Scene::read_with(&scene.path, &others, &of_scene)?.body)
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
        mesh::io::remove_output(&folder.join(mesh_file(LATEST, name)))?;
        let castable = folder.join(mesh_file(CASTABLE, name));
        if !is_refused {
            mesh::io::remove_output(&castable)?;
        } else if castable.exists() {
            let castable = castable.display();
            log::warn!("the design cannot be cast; the last shape that can is {castable}");
        }
    }
    let evaluation = &finished.last.1;
    vtu::write_vtu(&folder.join("result.vtu"), &evaluation.runs[0].grid())?;
    write_pressures(folder, finished)?;
    write_parameters(folder, finished)
}

/// The designed parameters and numbers as the tables that a scene would have.
fn write_parameters(folder: &Path, finished: &Finished) -> Result<()> {
    let all = finished.last.0.map().parameters(&finished.theta);
    let (numbers, parameters): (BTreeMap<_, _>, BTreeMap<_, _>) =
        all.into_iter().partition(|(name, _)| name.contains('.'));
    let mut tables = BTreeMap::from([("parameters", parameters), ("numbers", numbers)]);
    tables.retain(|_, table| !table.is_empty());
    write_toml(&folder.join("parameters.toml"), &tables)
}

/// The designed pressures as the tables that a scene would have.
fn write_pressures(folder: &Path, finished: &Finished) -> Result<()> {
    let (level, at) = &finished.last;
    let times = &at.runs[0].states.times;
    let one = |(on, values): (String, Vec<f64>)| json!({ "on": on, "pressure": { "t": times, "value": values } });
    let chambers: Vec<_> = level.map().pressures(&finished.theta).into_iter().map(one).collect();
    let mut tables = BTreeMap::from([("chamber", chambers)]);
    tables.retain(|_, chambers| !chambers.is_empty());
    write_toml(&folder.join("pressures.toml"), &tables)
}

/// Writes tables, unless there are none.
fn write_toml<T: Serialize>(path: &Path, tables: &BTreeMap<&str, T>) -> Result<()> {
    if tables.is_empty() {
        return Ok(());
    }
    let text = toml::to_string(tables)?;
    Ok(mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?)
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
