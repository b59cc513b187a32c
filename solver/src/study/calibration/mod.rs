//! Calibration: numbers of scenes from measurements on one's own device.
//!
//! Each `[[experiment]]` names a scene and what was measured: a table or a value of one of its probes, the mass of the
//! body, or the thickness of a wall. So walls are found that are off in a body as it was cast.
//! The numbers minimise the sum of the squared differences over their standard uncertainties
//! ([`least_squares`]), with derivatives by the adjoint method ([`run::sensitivity`]).

mod experiment;
mod shape;
mod sought;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use measure::probe::Probe;
use mechanics::math::least_squares::Residuals;
use nalgebra::{DMatrix, DVector};
use program::table::{Table as _, each};
use program::{Change, Changes, KeyPath, Keys, Settings, misfit};
use scene::Scene;
use scene::config::beside;
use scene::number::{Group, Number, Swept, Walls};

use crate::study::least_squares;
use experiment::Quantity;
pub use experiment::{Experiment, ExperimentConfig, Point};
use run::{Run, Start};
pub use sought::Sought;

const KEYS: Keys = Keys { paths: &["scene", "measured"], named: &[], meaning: None };

/// Step of the differences of masses and gauges: of walls [m], of factors [1].
const STEP: f64 = 1e-6;
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

    /// A scene with values of the numbers; none where it cannot have them.
    fn scene(&self, index: usize, values: &[f64]) -> Option<Scene> {
        let mut scene = self.scenes[index].clone();
        for ((number, group), &value) in self.numbers.iter().zip(&self.groups[index]).zip(values) {
            let Some(group) = group else { continue };
            if let Err(why) = group.apply(&mut scene, self.walls[index].as_ref(), value) {
                log::info!("{} = {value:.4e}: {why:#}", number.title());
                return None;
            }
        }
        Some(scene)
    }

    /// The numbers of the first scene as they were found, by their paths, for `[numbers]` of a scene.
    pub fn found(&self, values: &[f64]) -> BTreeMap<String, f64> {
        let scene = &self.scenes[0];
        let mut found = BTreeMap::new();
        for (group, value) in self.groups[0].iter().zip(values) {
            for (number, value) in group.iter().flat_map(|group| group.values(scene, *value)) {
                // a number that is added to what the scene has is 0 there, whatever its [numbers] have added
                let is_added = number.value(scene) == 0.0;
                let before = scene.config.numbers.get(&number.path).filter(|_| is_added);
                found.insert(number.path.clone(), value + before.unwrap_or(&0.0));
            }
        }
        found
    }

    /// Puts in the values of the points of one scene and their derivatives. False where it has no equilibrium.
    fn simulate(
        &self,
        index: usize,
        values: &[f64],
        (simulated, by): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) -> Result<bool> {
        let (groups, walls) = (&self.groups[index], self.walls[index].as_ref());
        let Some(scene) = self.scene(index, values) else { return Ok(false) };
        let own: Vec<&Experiment> = self.experiments.iter().filter(|e| e.scene == index).collect();
        for Experiment { quantity, first, .. } in &own {
            let Quantity::Shape(shape) = quantity else { continue };
            simulated[*first] = shape.value(&scene)?;
            for k in (0..values.len()).filter(|&k| groups[k].is_some()) {
                let moved = |by: f64| {
                    let mut moved = values.to_vec();
                    moved[k] += by;
                    self.scene(index, &moved).map(|scene| shape.value(&scene)).transpose()
                };
                let [Some(more), Some(less)] = [moved(STEP)?, moved(-STEP)?] else {
                    return Ok(false);
                };
                by[(*first, k)] = (more - less) / (2.0 * STEP);
            }
        }
        if own.iter().all(|e| matches!(e.quantity, Quantity::Shape(_))) {
            return Ok(true);
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
            for own in &own {
                let Quantity::Probe(probe) = own.quantity else { continue };
                let at_step = (own.first..).zip(&own.points).filter(|(_, point)| point.step == n);
                places.extend(at_step.map(|(place, _)| place));
                probes.resize(places.len(), &run.probes[probe]);
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
