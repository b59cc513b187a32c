//! Calibration: numbers of scenes from measurements on one's own device.
//!
//! Each `[[experiment]]` names a scene, one of its probes, and a measured table of that probe.
//! The numbers minimise the sum of the squared differences over their standard uncertainties
//! ([`least_squares`](super::least_squares)), with derivatives by the adjoint method ([`crate::run::sensitivity`]).

mod sought;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use measure::probe::Probe;
use mechanics::math::least_squares::Residuals;
use nalgebra::{DMatrix, DVector};
use program::table::{Range, Table as _, each};
use program::{Change, Changes, KeyPath, Keys, Settings, misfit};
use scene::Scene;
use scene::config::beside;
use scene::number::{Group, Number, Swept, Walls};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::run::{Run, Start};
use crate::study::least_squares;
use crate::study::table::{Table, some, unit};
pub use sought::Sought;

const KEYS: Keys = Keys { paths: &["scene", "measured"], named: &[], meaning: None };

/// Two times are the same when they differ by less than this part of the last.
const SAME: f64 = 1e-6;

program::table! {
    /// What is sought, and from what: a file in TOML.
    #[derive(Clone, Debug)]
    pub struct Config {
        /// What is sought.
        number: Vec<Sought> = Vec::new();
        /// From what.
        experiment: Vec<ExperimentConfig> = Vec::new(), each(ExperimentConfig::title);
    }
}

program::table! {
    /// Measurements of one probe.
    #[derive(Clone, Debug)]
    pub struct ExperimentConfig {
        /// The name in tables and pictures.
        name: String;
        /// The scene, relative to the file.
        scene: PathBuf;
        /// The probe of the scene that was measured.
        probe: String;
        /// Measured table (CSV), relative to the file.
        measured: PathBuf;
        /// Entries that its lines must have, by the titles of columns.
        #[schemars(with = "BTreeMap<String, serde_json::Value>")]
        r#where: BTreeMap<String, toml::Value> = BTreeMap::new();
        /// Titles of the measured columns, with their unit: one, or several for repeated trials.
        columns: Vec<String>, some;
        /// Standard uncertainty of a measurement, in the unit of the columns.
        uncertainty: f64, Range::POSITIVE;
        /// When.
        time: Option<Time> = None => "the end of the scene";
    }
}

impl ExperimentConfig {
    fn title(&self) -> KeyPath {
        KeyPath::list("experiment").named(&self.name)
    }
}

/// At which t of the scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a time [s], or the title of a column")]
pub enum Time {
    /// All lines [s].
    At(f64),
    /// What a column says, by its title.
    Column(String),
}

/// Measurements of one probe, in SI.
pub struct Experiment {
    /// As it was written.
    pub config: ExperimentConfig,
    /// Index of its scene.
    scene: usize,
    /// Index of its probe in the scene.
    probe: usize,
    /// Unit of the column, and what one is in that of the probe.
    pub unit: (String, f64),
    /// Measurements.
    pub points: Vec<Point>,
    /// Place of the first of them among those of all experiments.
    pub first: usize,
}

/// A measurement.
pub struct Point {
    /// Time step at whose end it was made, counted from 1.
    step: usize,
    /// t there [s].
    pub t: f64,
    /// In the unit of the probe.
    pub measured: f64,
}

/// The experiments and what is sought.
pub struct Calibration {
    /// What is sought.
    pub numbers: Vec<Sought>,
    /// Unit and value of each number in the scenes.
    pub start: Vec<(&'static str, f64)>,
    /// From what.
    pub experiments: Vec<Experiment>,
    /// Their scenes, each once.
    pub scenes: Vec<Scene>,
    /// What was set from outside.
    pub set: Vec<String>,
    /// What the numbers stand for in each scene, in their order; none where it lacks them.
    groups: Vec<Vec<Option<Group>>>,
    /// Walls of each scene; none where no walls are moved.
    walls: Vec<Option<Walls>>,
}

impl Calibration {
    /// Reads a calibration with its scenes and tables.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(path, &Changes::default())
    }

    /// Reads a calibration with other values; those of `scene.` are for all its scenes.
    pub fn read_with(path: &Path, changes: &Changes) -> Result<Self> {
        let (own, of_scenes) = changes.own_and_scene();
        let file = Settings::read(path, &own, KEYS)?;
        file.checked(|file| Self::of(file, path, &of_scenes))
    }

    fn of(file: &Settings, path: &Path, of_scenes: &[Change]) -> Result<Self> {
        let config: Config = file.parse()?;
        config.check_ranges(&KeyPath::default())?;
        ensure!(!config.number.is_empty(), "no [[number]]; expected what is sought");
        ensure!(!config.experiment.is_empty(), "no [[experiment]]");
        for (k, number) in config.number.iter().enumerate() {
            number.check().context(KeyPath::list("number").number(k + 1))?;
        }
        let mut paths: Vec<PathBuf> = Vec::new();
        let mut scenes: Vec<Scene> = Vec::new();
        let mut experiments: Vec<Experiment> = Vec::new();
        for own in config.experiment {
            let scene = beside(path, &own.scene);
            let known = paths.iter().position(|known| *known == scene);
            let index = known.unwrap_or(scenes.len());
            if known.is_none() {
                scenes.push(Scene::read_with(&scene, &[], of_scenes)?);
                paths.push(scene);
            }
            let title = own.title();
            let twice = experiments.iter().any(|e| e.config.name == own.name);
            ensure!(!twice, misfit!(title, " is given twice; expected names that differ"));
            let first = experiments.last().map_or(0, |last| last.first + last.points.len());
            let experiment = Experiment::read(own, path, (index, &scenes[index]), first);
            experiments.push(experiment.context(title)?);
        }
        let numbers = config.number;
        let of_scene =
            |scene: &Scene| -> Vec<_> { numbers.iter().map(|n| n.group(scene)).collect() };
        let groups: Vec<Vec<Option<Group>>> = scenes.iter().map(of_scene).collect();
        let start = starts(&numbers, &scenes, &groups)?;
        let of_scene = |(scene, groups): (&Scene, &Vec<Option<Group>>)| {
            Walls::of(groups.iter().flatten().flat_map(|group| &group.numbers), scene)
        };
        let walls = scenes.iter().zip(&groups).map(of_scene).collect::<Result<_>>()?;
        let set =
            file.changes().into_iter().chain(of_scenes.iter().map(Change::to_string)).collect();
        Ok(Self { numbers, start, experiments, scenes, set, groups, walls })
    }

    /// The scene of the first experiment with the values of what is of the material, its density among it.
    pub fn material(&self, values: &[f64]) -> Result<Scene> {
        let mut scene = self.scenes[0].clone();
        for ((number, &value), group) in self.numbers.iter().zip(values).zip(&self.groups[0]) {
            if let (true, Some(group)) = (number.is_of_material() || number.is_density(), group) {
                group.apply(&mut scene, None, value)?;
            }
        }
        Ok(scene)
    }

    /// Values of all measured points, experiment by experiment, in the units of the probes, and
    /// their derivatives by the numbers; none where a scene has no equilibrium.
    pub fn model(&self, values: &[f64]) -> Result<Option<(DVector<f64>, DMatrix<f64>)>> {
        let count = self.measurements().len();
        let (mut simulated, mut by) = (DVector::zeros(count), DMatrix::zeros(count, values.len()));
        for scene in 0..self.scenes.len() {
            if !self.simulate(scene, values, (&mut simulated, &mut by))? {
                return Ok(None);
            }
        }
        Ok(Some((simulated, by)))
    }

    /// Puts in the values of the points of one scene and their derivatives. False where it has no equilibrium.
    fn simulate(
        &self,
        index: usize,
        values: &[f64],
        (simulated, by): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) -> Result<bool> {
        let (groups, walls) = (&self.groups[index], self.walls[index].as_ref());
        let mut scene = self.scenes[index].clone();
        for ((number, group), &value) in self.numbers.iter().zip(groups).zip(values) {
            let Some(group) = group else { continue };
            if let Err(why) = group.apply(&mut scene, walls, value) {
                log::info!("{} = {value:.4e}: {why:#}", number.title());
                return Ok(false);
            }
        }
        let path = scene.path.display().to_string();
        let run = match Run::new(scene, Start::default())? {
            Ok(run) => run,
            Err(why) => {
                log::info!("{path}: {}", why.unreached);
                return Ok(false);
            }
        };
        for n in (1..=run.states.steps()).rev() {
            let (mut places, mut probes) = (Vec::new(), Vec::<&Probe>::new());
            for own in self.experiments.iter().filter(|own| own.scene == index) {
                let at_step = (own.first..).zip(&own.points).filter(|(_, point)| point.step == n);
                places.extend(at_step.map(|(place, _)| place));
                probes.resize(places.len(), &run.probes[own.probe]);
            }
            if places.is_empty() {
                continue;
            }
            for (place, (value, gradient)) in places.into_iter().zip(run.sensitivities(&probes, n)?)
            {
                let swept = Swept::new(&run.scene, &run.problem, walls, &gradient);
                simulated[place] = value;
                for (k, (group, &value)) in groups.iter().zip(values).enumerate() {
                    by[(place, k)] =
                        group.as_ref().map_or(0.0, |group| group.derivative(&swept, value));
                }
            }
        }
        Ok(true)
    }

    /// [`Self::model`] less the measurements, over their standard uncertainties.
    pub fn residuals(&self, values: &[f64]) -> Result<Option<Residuals>> {
        let model = self.model(values)?;
        Ok(model.and_then(|model| least_squares::residuals(model, &self.measurements())))
    }

    /// All measurements with their standard uncertainties, in the units of the probes.
    pub fn measurements(&self) -> Vec<(f64, f64)> {
        let of = |e: &Experiment| -> Vec<_> {
            let uncertainty = e.config.uncertainty * e.unit.1;
            e.points.iter().map(|point| (point.measured, uncertainty)).collect()
        };
        self.experiments.iter().flat_map(of).collect()
    }
}

/// Unit and value of each number, which all scenes that have it must share.
fn starts(
    numbers: &[Sought],
    scenes: &[Scene],
    groups: &[Vec<Option<Group>>],
) -> Result<Vec<(&'static str, f64)>> {
    if let (true, Some(number)) = (
        numbers.iter().any(Sought::is_modulus),
        numbers.iter().find(|number| number.is_parameter()),
    ) {
        bail!(
            "modulus and {}: a factor on all stresses and a stress are not told apart; expected \
             one of them",
            number.title()
        );
    }
    let mut found = Vec::new();
    for (k, number) in numbers.iter().enumerate() {
        let title = number.title();
        let at = |what: String| KeyPath::list("number").number(k + 1).told(what);
        ensure!(
            numbers[..k].iter().all(|other| other.title() != title),
            at(format!("{title} is given twice"))
        );
        let of_scene = |(scene, groups): (&'_ Scene, &Vec<Option<Group>>)| {
            Some((groups[k].as_ref()?.start(scene)?, scene.path.display().to_string()))
        };
        let mut of_scenes = scenes.iter().zip(groups).filter_map(of_scene);
        let Some((start, first)) = of_scenes.next() else {
            bail!(at(format!("{title}: no scene has it; they have: {}", known(scenes))));
        };
        for (other, path) in of_scenes {
            ensure!(
                other == start,
                at(format!(
                    "{title} is {} in {first} and {} in {path}; expected one value to begin with",
                    start.1, other.1
                ))
            );
        }
        found.push(start);
    }
    Ok(found)
}

/// Paths of the numbers of all scenes.
fn known(scenes: &[Scene]) -> String {
    let all: BTreeSet<String> =
        scenes.iter().flat_map(Number::all).map(|number| number.path).collect();
    all.into_iter().collect::<Vec<_>>().join(", ")
}

impl Experiment {
    fn read(
        own: ExperimentConfig,
        path: &Path,
        (index, scene): (usize, &Scene),
        first: usize,
    ) -> Result<Self> {
        let names: Vec<&str> = scene.config.probe.iter().map(|probe| probe.name()).collect();
        let Some(probe) = names.iter().position(|name| *name == own.probe) else {
            bail!(misfit!(
                KeyPath::of("probe"),
                " = \"{}\": the scene has no [[probe]] of this name; there are: {}",
                own.probe,
                if names.is_empty() { "none".to_owned() } else { names.join(", ") }
            ));
        };
        let wanted = scene.config.probe[probe].kind().unit;
        let table = Table::read(&beside(path, &own.measured), &own.r#where)?;
        let times = scene.times();
        let unit = in_unit(&own.columns[0], wanted)?;
        let mut points = Vec::new();
        for title in &own.columns {
            ensure!(
                in_unit(title, wanted)? == unit,
                misfit!(KeyPath::of("columns"), " = {:?}: expected one unit", own.columns)
            );
            let measured = table.numbers(title)?;
            let at = match &own.time {
                Some(Time::Column(title)) => table.numbers(title)?,
                Some(Time::At(t)) => vec![*t; measured.len()],
                None => vec![times[times.len() - 1]; measured.len()],
            };
            for (t, measured) in at.into_iter().zip(measured) {
                let step = step_at(t, &times)?;
                points.push(Point { step, t: times[step - 1], measured: measured * unit.1 });
            }
        }
        Ok(Self { config: own, scene: index, probe, unit, points, first })
    }
}

/// The unit in the title of a column, and what one is in the unit of a probe.
fn in_unit(title: &str, wanted: &str) -> Result<(String, f64)> {
    let own = unit(title)
        .with_context(|| format!("the column \"{title}\" has no unit, as in \"{title} [mm]\""))?;
    let known: &[(&str, f64)] = match wanted {
        "m" => &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)],
        "N" => &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3)],
        "deg" => &[("deg", 1.0), ("°", 1.0), ("rad", 180.0 / std::f64::consts::PI)],
        "m³" => {
            &[("m³", 1.0), ("m3", 1.0), ("l", 1e-3), ("ml", 1e-6), ("cm3", 1e-6), ("cm³", 1e-6)]
        }
        "1/m" => &[("1/m", 1.0), ("1/mm", 1e3)],
        other => bail!("a probe in {other} cannot be calibrated with"),
    };
    let factor = known.iter().find(|(name, _)| *name == own).map(|(_, factor)| *factor);
    let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let factor = factor.with_context(|| {
        format!("\"{title}\" is in {own}, the probe in {wanted}: expected one of {}", names())
    })?;
    Ok((own.to_owned(), factor))
}

/// The time step that ends at t, counted from 1.
fn step_at(t: f64, times: &[f64]) -> Result<usize> {
    let same = |end: &f64| (end - t).abs() <= SAME * times[times.len() - 1];
    times.iter().position(same).map(|n| n + 1).ok_or_else(|| {
        let ends: Vec<String> = times.iter().take(12).map(|t| format!("{t}")).collect();
        let more = if times.len() > 12 { ", …" } else { "" };
        anyhow!(
            "measured at t = {t} s, where no time step of the scene ends; they end at {}{more} s: \
             set `at` or `steps` in [time]",
            ends.join(", ")
        )
    })
}
