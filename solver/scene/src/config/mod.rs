//! The formats of `sim.toml` and `design.toml`, as plain data.
//!
//! Everything is SI. Paths are relative to the file that names them.

mod check;
mod design;
mod level;
mod limit;
mod parameter;
mod scenario;
mod solver;
mod symmetric;
mod symmetry;
mod uncertainty;

use measure::written::{FieldSchema, MethodSchema, some_axes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use program::table::{Range, Rule, each, named, nested};
use program::{Change, KeyPath, Keys, Misfit, Settings, misfit};

pub use limit::LimitConfig;
pub use measure::constraint::ConstraintConfig;
pub use measure::objective::{ObjectiveConfig, Weight};
pub use measure::probe::ProbeConfig;
pub use parameter::{ChamberDesign, ParameterDesign};
pub use scenario::{ByName, EXCESS, RobustConfig, ScenarioConfig};
pub use solver::{Dilatation, Follow, InsideOut, Locking, SolverConfig};
pub use symmetric::{MirrorConfig, SymmetricConfig, TurnConfig};
pub use symmetry::SymmetryConfig;

pub use design::{
    Axis, DesignConfig, KeepConfig, MoldConfig, OptimizerConfig, OptimizerMethod, ShapeConfig,
};
pub use level::{HandleMotion, HandlesConfig, LevelConfig, LevelTime, Moves, VerticesConfig};
pub use mechanics::contact::barrier::Form as ContactForm;
use mechanics::element::HIGHEST_DEGREE;
use mechanics::forward::Method;
use mechanics::schedule::{WrittenField, axes, is_free_name};
pub use uncertainty::{Modulus, UncertaintyConfig};

use crate::meaning::meaning;
use crate::term::Room;
use crate::term::chamber::ChamberConfig;
use crate::term::contact::{ContactChoice, ContactConfig, ObstacleConfig};
use crate::term::dead_load::{BodyForceConfig, TractionConfig};
use crate::term::fibre::FibreConfig;
use crate::term::material::MaterialConfig;
use crate::term::membrane::MembraneConfig;
use crate::term::mullins::MullinsConfig;
use crate::term::relaxation::RelaxationConfig;
use crate::term::rigid::RigidConfig;
use crate::term::winding::WindingConfig;

/// Name of the body in a scene with one.
pub const BODY: &str = "body";

const SCENE_KEYS: Keys =
    Keys { paths: &["mesh", "surface"], named: &["parameters", "numbers"], meaning: Some(meaning) };

/// Degrees of the displacement.
const DEGREE: Range = Range::between(1.0, HIGHEST_DEGREE as f64);
/// Numbers of time steps of a scene or a level: every step has a line of the report.
const STEPS: Range = Range::between(1.0, 1e6);

program::table! {
    /// A scene: a tagged body, its material, supports and loads.
    #[derive(Clone, Debug)]
    pub struct SimConfig {
        /// Tagged tetrahedral mesh of the one body, as `tagger` writes it.
        mesh: Option<PathBuf> = None;
        /// Polynomial degree of the displacement: 1, 2 or 3.
        degree: usize = 2, DEGREE;
        /// Degree to which energies are integrated exactly, from 5 to 12.
        quadrature: usize = mechanics::element::quadrature::DEFAULT_DEGREE, Range::between(5.0, 12.0);
        /// Law of the one body.
        material: Option<MaterialConfig> = None;
        /// Several bodies, in place of `mesh` and `material`.
        body: Vec<BodyConfig> = Vec::new(), each(BodyConfig::title);
        /// Surfaces that bodies cannot pass.
        obstacle: Vec<ObstacleConfig> = Vec::new();
        /// Tags that cannot move, or move as prescribed.
        fixed: Vec<Fixed> = Vec::new(), each(Fixed::title);
        /// Planes in which the bodies are cut.
        symmetry: Vec<SymmetryConfig> = Vec::new();
        /// Acceleration by gravity [m/s²].
        #[schemars(with = "FieldSchema")]
        gravity: WrittenField = WrittenField::default();
        /// What happens where surfaces meet. Without it they pass through each other, and a run at whose
        /// end they have is not usable, unless it is "ignored".
        contact: Option<ContactChoice> = None, nested;
        /// Chambers; their energies have the order of the file.
        chamber: Vec<ChamberConfig> = Vec::new();
        /// Thin sheets bonded to tags.
        membrane: Vec<MembraneConfig> = Vec::new(), each(MembraneConfig::title);
        /// Parts that keep their shape: fittings, glued discs, bodies that are lifted.
        rigid: Vec<RigidConfig> = Vec::new(), each(RigidConfig::title);
        /// Families of fibres in bodies and volumes.
        fibre: Vec<FibreConfig> = Vec::new(), each(FibreConfig::title);
        /// Threads wound on tags.
        winding: Vec<WindingConfig> = Vec::new(), each(WindingConfig::title);
        /// Overstress of viscoelastic bodies; several tables make a Prony series.
        relaxation: Vec<RelaxationConfig> = Vec::new(), each(|_: &RelaxationConfig| KeyPath::list("relaxation"));
        /// Softening of bodies after a first stretch (Mullins effect).
        mullins: Vec<MullinsConfig> = Vec::new(), each(|_: &MullinsConfig| KeyPath::list("mullins"));
        /// Forces on the whole body.
        body_force: Vec<BodyForceConfig> = Vec::new();
        /// Forces on parts of the boundary.
        traction: Vec<TractionConfig> = Vec::new();
        /// Numbers that are measured at every reported step.
        probe: Vec<ProbeConfig> = Vec::new();
        /// How far numbers may be off: reports have error bars of the probes.
        uncertainty: Option<UncertaintyConfig> = None, nested;
        /// At which factor of the pressures the state at the end balloons or buckles, and at which it tears.
        limit: Option<LimitConfig> = None, nested;
        /// Numbers that expressions may name.
        parameters: BTreeMap<String, f64> = BTreeMap::new(), free_names;
        /// Values of numbers by their paths, as `solver list --numbers` explains them, in place of those that the
        /// tables give.
        numbers: BTreeMap<String, f64> = BTreeMap::new();
        /// Time steps; without them the loads grow together from nothing.
        time: Option<TimeConfig> = None, nested;
        /// Numerical settings.
        solver: SolverConfig = SolverConfig::default(), nested;
    }
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

    /// The values of a scene in place of a file.
    pub fn settings_of(values: toml::Table) -> Result<Settings> {
        Settings::of_values(values, SCENE_KEYS)
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

    /// The rooms of terms, in the order in which their numbers are listed and, within a stage, their energies are added.
    pub fn rooms(&self) -> Vec<&dyn Room> {
        let Self { relaxation, mullins, membrane, fibre, winding, rigid, .. } = self;
        let Self { chamber, contact, gravity, body_force, traction, .. } = self;
        vec![
            relaxation, mullins, membrane, fibre, winding, rigid, chamber, contact, gravity,
            body_force, traction,
        ]
    }

    /// The same, to be changed.
    pub fn rooms_mut(&mut self) -> Vec<&mut dyn Room> {
        let Self { relaxation, mullins, membrane, fibre, winding, rigid, .. } = self;
        let Self { chamber, contact, gravity, body_force, traction, .. } = self;
        vec![
            relaxation, mullins, membrane, fibre, winding, rigid, chamber, contact, gravity,
            body_force, traction,
        ]
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

program::table! {
    /// One of several bodies. Its tags are called `name.tag`, and `name` is its whole
    /// boundary.
    #[derive(Clone, Debug)]
    pub struct BodyConfig {
        /// What tags and reports call it.
        name: String;
        /// Tagged tetrahedral mesh.
        mesh: PathBuf;
        /// Law of its material.
        material: MaterialConfig;
        /// Shift of the mesh [m].
        translate: [f64; 3] = [0.0; 3], Range::FINITE.unit("m");
        /// Velocity at t = 0 [m/s].
        velocity: [f64; 3] = [0.0; 3], Range::FINITE.unit("m/s");
    }
}

impl BodyConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("body").named(&self.name)
    }
}

program::table! {
    /// Time steps: `end` and `steps`, or `at`. Displacements are zero at t = 0.
    #[derive(Clone, Debug)]
    pub struct TimeConfig {
        /// End of the last step [s].
        end: Option<f64> = None, Range::POSITIVE.unit("s");
        /// Number of steps of equal length.
        steps: Option<usize> = None, STEPS;
        /// Ends of all steps [s].
        at: Option<Vec<f64>> = None, increasing;
        /// How the bodies go through time.
        #[schemars(with = "MethodSchema")]
        method: Method = Method::default();
    }
}

program::table! {
    /// A tag whose nodes do not move along some axes, or move as prescribed.
    #[derive(Clone, Debug)]
    pub struct Fixed {
        /// Tag name.
        on: String;
        /// The axes, such as "xyz" or "z".
        components: String = "xyz".to_owned(), some_axes;
        /// Displacement, zero along axes that are not fixed [m].
        #[schemars(with = "FieldSchema")]
        displacement: WrittenField = WrittenField::default();
    }
}

impl Fixed {
    /// Which of x, y, z are fixed.
    pub fn axes(&self) -> [bool; 3] {
        axes(&self.components)
    }

    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("fixed").on(&self.on)
    }

    fn check(&self) -> Result<()> {
        for (held, value) in self.axes().into_iter().zip(&self.displacement.0) {
            ensure!(
                held || value.is_zero(),
                misfit!(
                    self.title().key("displacement"),
                    " {value}: must be zero along axes that are not in components = \"{}\"",
                    self.components
                )
            );
        }
        Ok(())
    }
}

/// The rule of the ends of time steps.
fn increasing(at: &KeyPath, times: &Option<Vec<f64>>) -> Result<(), Misfit> {
    let Some(times) = times else { return Ok(()) };
    if times.is_empty() {
        return Err(misfit!(at.clone(), " is empty"));
    }
    let from_rest: Vec<f64> = [0.0].iter().chain(times).copied().collect();
    let is_wrong = |pair: &&[f64]| !(pair[0] < pair[1] && pair[1] < f64::INFINITY);
    match from_rest.windows(2).find(is_wrong) {
        None => Ok(()),
        Some(pair) => Err(misfit!(
            at.clone(),
            " has {} s after {} s: times must be finite and increase from 0",
            pair[1],
            pair[0]
        )),
    }
}

/// The rule of numbers that expressions may name.
fn free_names(at: &KeyPath, parameters: &BTreeMap<String, f64>) -> Result<(), Misfit> {
    match parameters.keys().find(|name| !is_free_name(name)) {
        None => named::<f64>(Range::FINITE).check(&at.clone().as_table(), parameters),
        Some(name) => Err(at.clone().as_table().key(name).told(format!(
            "[parameters]: \"{name}\" cannot be a name; expected letters, digits and _, and no name that \
             expressions know"
        ))),
    }
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
