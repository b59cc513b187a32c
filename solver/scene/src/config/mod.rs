//! The formats of `sim.toml` and `design.toml`, as plain data.
//!
//! Everything is SI. Paths are relative to the file that names them.

mod chamber;
mod check;
mod contact;
mod design;
mod fibre;
mod gas;
mod level;
mod limit;
mod line;
mod material;
mod membrane;
mod mullins;
mod parameter;
mod profile;
mod relaxation;
mod rigid;
mod scenario;
mod solver;
mod symmetric;
mod symmetry;
mod uncertainty;
mod winding;

use measure::written::{FieldSchema, MethodSchema};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use program::{Change, KeyPath, Keys, Settings, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use chamber::{ChamberConfig, ChamberDesign};
pub use contact::{ContactChoice, ContactConfig};
pub use fibre::{FibreConfig, Source};
pub use gas::GasConfig;
pub use limit::LimitConfig;
pub use line::AroundConfig;
pub use material::{MaterialConfig, VolumeMaterial};
pub use measure::constraint::ConstraintConfig;
pub use measure::objective::{ObjectiveConfig, Weight};
pub use measure::probe::ProbeConfig;
pub use membrane::MembraneConfig;
pub use mullins::MullinsConfig;
pub use parameter::ParameterDesign;
pub use profile::{Along, ProfileConfig};
pub use relaxation::RelaxationConfig;
pub use rigid::RigidConfig;
pub use scenario::{EXCESS, FactorConfig, RobustConfig, ScenarioConfig, WallConfig};
pub use solver::{Dilatation, Follow, InsideOut, Locking, SolverConfig};
pub use symmetric::{MirrorConfig, SymmetricConfig, TurnConfig};
pub use symmetry::SymmetryConfig;

pub use design::{
    Axis, DesignConfig, Interior, KeepConfig, MoldConfig, OptimizerConfig, OptimizerMethod,
    ShapeConfig, Spread,
};
pub use level::{HandleMotion, HandlesConfig, LevelConfig, LevelTime, Moves, VerticesConfig};
pub use mechanics::contact::barrier::Form as ContactForm;
use mechanics::forward::{Method, Steps};
use mechanics::schedule::{WrittenField, axes};
pub use uncertainty::{Modulus, UncertaintyConfig, is_pressure};
pub use winding::{Climb, WindingConfig};

use crate::meaning::meaning;

/// Name of the body in a scene with one.
pub const BODY: &str = "body";

const SCENE_KEYS: Keys =
    Keys { paths: &["mesh", "surface"], named: &["parameters", "numbers"], meaning: Some(meaning) };

/// A scene: a tagged body, its material, supports and loads.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimConfig {
    /// Tagged tetrahedral mesh of the one body, as `tagger` writes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// Polynomial degree of the displacement: 1, 2 or 3.
    #[serde(default = "quadratic")]
    pub degree: usize,
    /// Degree to which energies are integrated exactly, from 5 to 12.
    #[serde(default = "quintic")]
    pub quadrature: usize,
    /// Law of the one body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialConfig>,
    /// Several bodies, in place of `mesh` and `material`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub body: Vec<BodyConfig>,
    /// Surfaces that bodies cannot pass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacle: Vec<ObstacleConfig>,
    /// Tags that cannot move, or move as prescribed.
    #[serde(default)]
    pub fixed: Vec<Fixed>,
    /// Planes in which the bodies are cut.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub symmetry: Vec<SymmetryConfig>,
    /// Acceleration by gravity [m/s²].
    #[serde(default)]
    #[schemars(with = "FieldSchema")]
    pub gravity: WrittenField,
    /// What happens where surfaces meet. Without it they pass through each other, and a run at whose
    /// end they have is not usable, unless it is "ignored".
    pub contact: Option<ContactChoice>,
    /// Chambers; their energies have the order of the file.
    #[serde(default)]
    pub chamber: Vec<ChamberConfig>,
    /// Thin sheets bonded to tags.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub membrane: Vec<MembraneConfig>,
    /// Parts that keep their shape: fittings, glued discs, bodies that are lifted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<RigidConfig>,
    /// Families of fibres in bodies and volumes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fibre: Vec<FibreConfig>,
    /// Threads wound on tags.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub winding: Vec<WindingConfig>,
    /// Overstress of viscoelastic bodies; several tables make a Prony series.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub relaxation: Vec<RelaxationConfig>,
    /// Softening of bodies after a first stretch (Mullins effect).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mullins: Vec<MullinsConfig>,
    /// Forces on the whole body.
    #[serde(default)]
    pub body_force: Vec<BodyForceConfig>,
    /// Forces on parts of the boundary.
    #[serde(default)]
    pub traction: Vec<TractionConfig>,
    /// Numbers that are measured at every reported step.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probe: Vec<ProbeConfig>,
    /// How far numbers may be off: reports have error bars of the probes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyConfig>,
    /// At which factor of the pressures the state at the end balloons or buckles, and at which it tears.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<LimitConfig>,
    /// Numbers that expressions may name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Values of numbers by their paths, as `solver list --numbers` explains them, in place of those that the
    /// tables give.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// Time steps; without them the loads grow together from nothing.
    pub time: Option<TimeConfig>,
    /// Numerical settings.
    #[serde(default)]
    pub solver: SolverConfig,
}

impl SimConfig {
    /// Reads a scene's file.
    pub fn read(path: &Path) -> Result<Self> {
        Self::of(&Self::settings(path, &[])?)
    }

    /// A scene's file with changes from outside.
    pub fn settings(path: &Path, changes: &[Change]) -> Result<Settings> {
        Settings::read(path, changes, SCENE_KEYS)
    }

    /// The scene in a file, of which everything is sound that can be checked without a body.
    pub fn of(settings: &Settings) -> Result<Self> {
        refuse_outside_of_chambers(settings)?;
        let config: Self = settings.parse()?;
        settings.checked(|_| config.check())?;
        Ok(config)
    }

    /// These settings with others in place of some, checked as those of a file.
    pub fn with(&self, change: impl FnOnce(&mut Self)) -> Result<Self> {
        let mut changed = self.clone();
        change(&mut changed);
        changed.check()?;
        Ok(changed)
    }

    /// All bodies; the one without a name of its own is called [`BODY`].
    pub fn bodies(&self) -> Result<Vec<BodyConfig>> {
        match (&self.mesh, &self.material, self.body.is_empty()) {
            (Some(mesh), Some(material), true) => Ok(vec![BodyConfig {
                name: BODY.to_owned(),
                mesh: mesh.clone(),
                material: material.clone(),
                translate: [0.0; 3],
                velocity: [0.0; 3],
            }]),
            (None, None, false) => Ok(self.body.clone()),
            (None, None, true) => {
                bail!("no body: expected mesh and material, or a table [[body]] for each")
            }
            (_, None, true) => {
                bail!(misfit!(KeyPath::of("mesh"), " without material: a body needs both"))
            }
            (None, _, true) => {
                bail!(misfit!(KeyPath::of("material"), " without mesh: a body needs both"))
            }
            _ => bail!(misfit!(
                KeyPath::list("body"),
                " beside mesh or material: write the one body as a [[body]], too"
            )),
        }
    }

    /// Gives the bodies other meshes, in which they are where they belong.
    pub fn set_meshes(&mut self, meshes: Vec<PathBuf>) -> Result<()> {
        let (found, needed) = (meshes.len(), self.body.len().max(1));
        ensure!(found == needed, "{found} meshes for {needed} bodies");
        for (body, mesh) in self.body.iter_mut().zip(&meshes) {
            (body.mesh, body.translate) = (mesh.clone(), [0.0; 3]);
        }
        if self.body.is_empty() {
            self.mesh = meshes.into_iter().next();
        }
        Ok(())
    }

    /// Contact and friction, if there are any.
    pub fn contact(&self) -> Option<&ContactConfig> {
        match &self.contact {
            Some(ContactChoice::Barrier(contact)) => Some(contact),
            _ => None,
        }
    }

    /// Contact and friction, if there are any, to be changed.
    pub fn contact_mut(&mut self) -> Option<&mut ContactConfig> {
        match &mut self.contact {
            Some(ContactChoice::Barrier(contact)) => Some(contact),
            _ => None,
        }
    }

    /// Newton iterations allowed in one load step.
    pub fn newton_iterations(&self) -> usize {
        let default = if self.contact().is_some() { 200 } else { 30 };
        self.solver.newton_iterations.unwrap_or(default)
    }

    /// How bodies go through time.
    pub fn method(&self) -> Method {
        self.time.as_ref().map_or(Method::Quasistatic, |time| time.method)
    }

    /// The steps of a run that makes so many of its time steps.
    pub fn steps(&self, time_steps: usize) -> Steps {
        match &self.time {
            None => Steps::Load((1.0 / self.solver.largest_load_step()).ceil() as usize),
            Some(time) if time.method.has_inertia() => Steps::Dynamic(time_steps),
            Some(_) => Steps::Quasistatic(time_steps),
        }
    }

    /// Ends of the time steps [s]; of a static scene the full load, 1.
    pub fn times(&self) -> Vec<f64> {
        match &self.time {
            None => vec![1.0],
            Some(TimeConfig { at: Some(times), .. }) => times.clone(),
            Some(TimeConfig { end, steps, .. }) => {
                let (end, steps) = (end.unwrap_or(1.0), steps.unwrap_or(1));
                (1..=steps).map(|n| end * (n as f64 / steps as f64)).collect()
            }
        }
    }
}

/// One of several bodies. Its tags are called `name.tag`, and `name` is its whole
/// boundary.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyConfig {
    /// What tags and reports call it.
    pub name: String,
    /// Tagged tetrahedral mesh.
    pub mesh: PathBuf,
    /// Law of its material.
    pub material: MaterialConfig,
    /// Shift of the mesh [m].
    #[serde(default)]
    pub translate: [f64; 3],
    /// Velocity at t = 0 [m/s].
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// A rigid surface, open or closed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleConfig {
    /// What reports call it.
    pub name: String,
    /// Triangle surface, a file in metres.
    pub surface: PathBuf,
    /// How far it has moved [m].
    #[serde(default)]
    #[schemars(with = "FieldSchema")]
    pub displacement: WrittenField,
}

/// Time steps: `end` and `steps`, or `at`. Displacements are zero at t = 0.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeConfig {
    /// End of the last step [s].
    pub end: Option<f64>,
    /// Number of steps of equal length.
    pub steps: Option<usize>,
    /// Ends of all steps [s].
    pub at: Option<Vec<f64>>,
    /// How the bodies go through time.
    #[serde(default)]
    #[schemars(with = "MethodSchema")]
    pub method: Method,
}

fn quadratic() -> usize {
    2
}

fn quintic() -> usize {
    mechanics::element::quadrature::DEFAULT_DEGREE
}

/// A tag whose nodes do not move along some axes, or move as prescribed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fixed {
    /// Tag name.
    pub on: String,
    /// The axes, such as "xyz" or "z".
    #[serde(default = "all_axes")]
    pub components: String,
    /// Displacement, zero along axes that are not fixed [m].
    #[serde(default)]
    #[schemars(with = "FieldSchema")]
    pub displacement: WrittenField,
}

fn all_axes() -> String {
    "xyz".to_owned()
}

impl Fixed {
    /// Which of x, y, z are fixed.
    pub fn axes(&self) -> [bool; 3] {
        axes(&self.components)
    }

    fn check(&self) -> Result<()> {
        let Self { on, components, displacement } = self;
        let axes = self.axes();
        let title = KeyPath::list("fixed").on(on);
        ensure!(
            components.len() == axes.iter().filter(|a| **a).count() && !components.is_empty(),
            misfit!(
                title.key("components"),
                " = \"{components}\": must be some of x, y, z, each once"
            )
        );
        for (free, value) in axes.iter().map(|a| !a).zip(&displacement.0) {
            ensure!(
                !free || value.is_zero(),
                misfit!(
                    title.key("displacement"),
                    " {value}: must be zero along axes that are not in components = \"{components}\""
                )
            );
        }
        Ok(())
    }
}

/// A force per rest volume.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyForceConfig {
    /// Force per volume, for gravity density times acceleration [N/m³].
    #[schemars(with = "FieldSchema")]
    pub force: WrittenField,
}

/// A force per rest area.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TractionConfig {
    /// Tag name.
    pub on: String,
    /// Force per area [Pa].
    #[schemars(with = "FieldSchema")]
    pub traction: WrittenField,
}

/// `path` as seen from the folder of the file `from`.
pub fn beside(from: &Path, path: &Path) -> PathBuf {
    from.parent().map_or_else(|| path.to_path_buf(), |folder| folder.join(path))
}
/// Refuses pressures, gases and volumes that are in no `[[chamber]]`.
fn refuse_outside_of_chambers(settings: &Settings) -> Result<()> {
    let file: toml::Table = settings.parse()?;
    let found = ["pressure", "gas", "volume"].into_iter().find(|key| file.contains_key(*key));
    let Some(key) = found else { return Ok(()) };
    let what = misfit!(
        KeyPath::of(key),
        ": a pressure, gas or volume is that of a chamber: expected [[chamber]] with on = \"TAG\" and \
         pressure = …, or another key that `solver list --gas-laws` explains; from outside \
         --set chamber.TAG.pressure=…"
    );
    Err(settings.place(what.into()))
}
