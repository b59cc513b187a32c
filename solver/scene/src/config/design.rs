//! The format of `design.toml`.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use measure::objective::check_shares;
use mechanics::symmetry::AXES;
use program::table::{Range, Table, direction, each, nested};
use program::{Change, KeyPath, Keys, Misfit, Names, Settings, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::meaning::meaning;

use super::{
    ChamberDesign, ConstraintConfig, LevelConfig, ObjectiveConfig, ParameterDesign, RobustConfig,
    ScenarioConfig, SymmetricConfig, refuse_outside_of_chambers, scenario,
};

const KEYS: Keys = Keys {
    paths: &["scene", "target", "config", "mesh", "model"],
    named: &[],
    meaning: Some(meaning),
};

program::table! {
    /// A design problem: the design variables of a scene and the objective function.
    #[derive(Clone, Debug)]
    pub struct DesignConfig {
        /// The scene, a `sim.toml`.
        scene: PathBuf;
        /// What may move, and in which levels.
        shape: Option<ShapeConfig> = None, nested;
        /// Chambers whose pressure over time may change, together with the shape or alone.
        chamber: Vec<ChamberDesign> = Vec::new(), each(ChamberDesign::title);
        /// Numbers in the scene's `[parameters]` that may change.
        parameter: Vec<ParameterDesign> = Vec::new(), each(ParameterDesign::title);
        /// Levels of a design without a shape: what counts in them, and how finely the scene is
        /// simulated.
        level: Vec<LevelConfig> = Vec::new(), each(|_: &LevelConfig| KeyPath::list("level"));
        /// Cases that the design must be good in; the scene alone without them.
        scenario: Vec<ScenarioConfig> = Vec::new(),
            each(|one: &ScenarioConfig| KeyPath::list("scenario").named(&one.name));
        /// How their objectives become one.
        robust: Option<RobustConfig> = None, nested;
        /// How the body is to be cast: `fab plan` is asked about every accepted shape.
        mold: Option<MoldConfig> = None;
        /// How to go down.
        optimizer: OptimizerConfig = OptimizerConfig::default(), nested;
        /// What the rest shape keeps to.
        constraint: Vec<ConstraintConfig> = Vec::new();
        /// Weighted terms of the objective.
        objective: Vec<ObjectiveConfig>;
    }
}

program::table! {
    /// What `fab plan` is asked about during a design.
    #[derive(Clone, Debug)]
    pub struct MoldConfig {
        /// What the mold is to be like, a `mold.toml`.
        config: PathBuf;
        /// The body that is cast, of a scene with several.
        body: Option<String> = None;
        /// Surface that the scene's mesh was made from (`model.stl`): it is cast where the design moves nothing, as by
        /// `fab mold --model --from`.
        model: Option<PathBuf> = None;
        /// Whether shapes that cannot be cast are rejected.
        required: Option<bool> = None => "where the mold's file names a method";
    }
}

program::table! {
    /// How to go down, and when to stop.
    #[derive(Clone, Debug)]
    pub struct OptimizerConfig {
        /// The model of the objective that steps minimise.
        method: Option<OptimizerMethod> = None => "chosen by its terms";
        /// Accepted iterations of a design without levels, which have their own.
        iterations: Option<usize> = None;
        /// How far the first step of a level moves a vertex, or a pressure by its
        /// equivalent, as a fraction of a mean edge [1].
        first_step: f64 = 0.5, Range::NOT_NEGATIVE;
        /// How far a later step may move a vertex, as a fraction of a mean edge [1]. Smaller where
        /// trials cost much and long ones find no equilibrium.
        largest_step: f64 = 3.0, Range::POSITIVE;
        /// A level ends when the objective falls by less than this fraction in each of two iterations, one after the other [1].
        stagnation: f64 = 0.0, Range::NOT_NEGATIVE;
        /// A level ends when the norm of the gradient falls below this fraction of that
        /// at its start [1].
        gradient_tolerance: f64 = 0.0, Range::NOT_NEGATIVE;
        /// No iteration begins after this much computing time of a level [s].
        time_limit: Option<f64> = None => "no limit", Range::NOT_NEGATIVE.unit("s");
        /// Memory for the states of a run; what exceeds it lies in a file in `TMPDIR`
        /// meanwhile. Without contact, a quarter of what the states leave is for factors of the
        /// tangents at the ends of time steps [B].
        state_memory: f64 = 4e9, Range::NOT_NEGATIVE.unit("B");
    }
}

/// The quadratic model of the objective that a step minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OptimizerMethod {
    /// From the gradients of the last iterations, for any objective and any number of variables.
    LBfgs,
    /// From the curvature of the terms, by the first-order change of the run for each variable: the default where all
    /// terms are squares and a level has up to some hundred variables.
    GaussNewton,
}

program::table! {
    /// A cascade of shape levels on one tag or several.
    #[derive(Clone, Debug)]
    pub struct ShapeConfig {
        /// Tags whose vertices move; their rims stay.
        on: Names;
        /// Vertices that are nearer to the rim than this, along the surface, stay with it [m].
        margin: f64 = 0.0, Range::NOT_NEGATIVE.unit("m");
        /// Planes in which flat faces of what moves stay, each a tag of a flat face or a table: their vertices
        /// move along them only, so that a flat floor stays flat and its mold can be pulled off it.
        keep: Vec<KeepConfig> = Vec::new(), each(|_: &KeepConfig| KeyPath::table("shape").key("keep"));
        /// Tags that move alike: one has the variables, the others are its images.
        symmetric: Vec<SymmetricConfig> = Vec::new(),
            each(|_: &SymmetricConfig| KeyPath::list("shape.symmetric"));
        /// How far from where it is the surface that moves may be re-meshed, where elements at it are
        /// poor; 0: it keeps its vertices [m].
        surface_tolerance: Option<f64> = None => "a twentieth of its mean edge", Range::NOT_NEGATIVE.unit("m");
        /// Levels from coarse to fine; some stand for several.
        level: Vec<LevelConfig>, each(|_: &LevelConfig| KeyPath::list("shape.level"));
    }
}

/// A plane in which a flat face stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a tag of a flat face, { axis = \"z\", at = 0.01 } or { normal = [0, 0.6, 0.8], at = 0.01 }"
)]
pub enum KeepConfig {
    /// That of a tag whose facets are flat.
    Face(String),
    /// One across an axis.
    Across {
        /// The axis across which it lies.
        axis: Axis,
        /// The coordinate on that axis [m].
        at: f64,
    },
    /// One at an angle.
    Plane {
        /// The normal, of any length but 0.
        normal: [f64; 3],
        /// The distance from the origin along the normal [m].
        at: f64,
    },
}

impl Table for KeepConfig {
    fn check_ranges(&self, at: &KeyPath) -> Result<(), Misfit> {
        match self {
            Self::Face(_) | Self::Across { .. } => Ok(()),
            Self::Plane { normal, .. } => direction(&at.clone().key("normal"), &Some(*normal)),
        }
    }
}

impl fmt::Display for KeepConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Face(tag) => write!(f, "the plane of \"{tag}\""),
            Self::Across { axis, at } => write!(f, "the plane {} = {at} m", AXES[*axis as usize]),
            Self::Plane { normal, at } => write!(f, "the plane across {normal:?} at {at} m"),
        }
    }
}

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl DesignConfig {
    /// Reads and checks a design file.
    pub fn read(path: &Path) -> Result<Self> {
        Self::of(&Self::settings(path, &[])?)
    }

    /// A design file with changes from outside.
    pub fn settings(path: &Path, changes: &[Change]) -> Result<Settings> {
        Settings::read(path, changes, KEYS)
    }

    /// The design problem in a file, checked.
    pub fn of(settings: &Settings) -> Result<Self> {
        refuse_outside_of_chambers(settings)?;
        let design: Self = settings.parse()?;
        settings.checked(|_| design.check())?;
        Ok(design)
    }

    /// The levels; that of a design without a shape has neither handles nor vertices. Where some
    /// simulate another problem than the scene's, the first and the last are the scene itself.
    pub fn levels(&self) -> Vec<LevelConfig> {
        let written = self.shape.as_ref().map_or(&self.level, |shape| &shape.level);
        let mut levels: Vec<_> = written.iter().flat_map(LevelConfig::expand).collect();
        if levels.is_empty() {
            let iterations = self.optimizer.iterations.unwrap_or(0);
            levels.push(LevelConfig { iterations, ..Default::default() });
        }
        let [first, last] = [&levels[0], &levels[levels.len() - 1]];
        let framed =
            |level: &LevelConfig| level.has_own_fidelity().then(|| level.at_full_fidelity());
        let (before, after) = (framed(first), framed(last));
        before.into_iter().chain(levels).chain(after).collect()
    }

    /// The scenarios; the scene as it is where there are none.
    pub fn scenarios(&self) -> Vec<ScenarioConfig> {
        if self.scenario.is_empty() {
            return vec![ScenarioConfig::default()];
        }
        self.scenario.clone()
    }

    /// Whether every term is a square or another that has curvature of its own, so that the method of Gauss and Newton
    /// knows that of the objective.
    pub fn is_of_squares(&self) -> bool {
        self.objective.iter().all(ObjectiveConfig::is_square)
    }

    /// The settings of a level in place of the design's.
    pub fn optimizer_of(&self, level: &LevelConfig) -> OptimizerConfig {
        let own = &self.optimizer;
        OptimizerConfig {
            method: own.method,
            iterations: Some(level.iterations),
            first_step: level.first_step.unwrap_or(own.first_step),
            largest_step: level.largest_step.unwrap_or(own.largest_step),
            stagnation: level.stagnation.unwrap_or(own.stagnation),
            gradient_tolerance: level.gradient_tolerance.unwrap_or(own.gradient_tolerance),
            time_limit: level.time_limit.or(own.time_limit),
            state_memory: own.state_memory,
        }
    }

    fn check(&self) -> Result<()> {
        self.check_ranges(&KeyPath::default())?;
        ensure!(
            !self.objective.is_empty(),
            "no [[objective]]: expected at least one, to be minimised"
        );
        if let Some(reads) = self.objective.iter().find(|own| own.kind().reads_stress)
            && let Some(law) = self.parameter.iter().find(|own| own.name.starts_with("material."))
        {
            bail!(misfit!(
                reads.title(),
                ": it is made with the law, which [[parameter]] \"{}\" changes: expected another objective, or \
                 another number",
                law.name
            ));
        }
        let leveled = !self.level.is_empty();
        let iterations = KeyPath::table("optimizer").key("iterations");
        match (&self.shape, self.optimizer.iterations) {
            (None, _) if self.chamber.is_empty() && self.parameter.is_empty() => {
                bail!("no [shape], [[chamber]] or [[parameter]]: expected one, to be changed")
            }
            (None, None) if !leveled => {
                bail!(KeyPath::table("optimizer").told(
                    "no iterations in [optimizer]: a design without [shape] needs their number"
                ))
            }
            (Some(_), Some(_)) => {
                bail!(iterations.told(
                    "iterations in [optimizer] beside [shape]: write them in [[shape.level]]"
                ))
            }
            (None, Some(_)) if leveled => {
                bail!(
                    iterations.told(
                        "iterations in [optimizer] beside [[level]]: write them in [[level]]"
                    )
                )
            }
            (Some(_), None) if leveled => {
                bail!(misfit!(
                    KeyPath::list("level"),
                    " beside [shape]: write it as [[shape.level]]"
                ))
            }
            _ => {}
        }
        let objectives: Vec<&str> = self.objective.iter().map(ObjectiveConfig::name).collect();
        check_shares(&self.objective)?;
        for (i, kept) in self.constraint.iter().enumerate() {
            kept.check()?;
            ensure!(
                self.constraint[..i].iter().all(|other| other.name() != kept.name()),
                misfit!(kept.title(), ": the name is used twice; expected another")
            );
            ensure!(
                !kept.is_of_shape() || self.shape.is_some(),
                misfit!(kept.title(), " without [shape]: no shape changes")
            );
            ensure!(
                kept.is_of_shape() || !objectives.contains(&kept.name()),
                misfit!(kept.title(), ": an objective has this name; expected another")
            );
        }
        for parameter in &self.parameter {
            ensure!(
                parameter.scale.is_none() || parameter.small.is_some(),
                misfit!(
                    parameter.title().key("scale"),
                    " without small: expected small = 1.0, its weight"
                )
            );
            ensure!(
                parameter.small.is_none() || !objectives.contains(&parameter.name.as_str()),
                misfit!(
                    parameter.title().key("small"),
                    " beside an objective of this name; expected another name of the objective"
                )
            );
        }
        let designed: Vec<&str> = self.parameter.iter().map(|p| p.name.as_str()).collect();
        scenario::check(&self.scenario, self.robust, &objectives, &designed)?;
        ensure!(
            self.mold.is_none() || self.shape.is_some(),
            misfit!(
                KeyPath::table("mold"),
                " without [shape]: no shape changes that would be cast"
            )
        );
        if let Some(shape) = &self.shape {
            let on = shape.on.all();
            let at = KeyPath::table("shape").key("on");
            ensure!(!on.is_empty(), at.told("[shape] on = []: name a tag or more"));
            ensure!(!shape.level.is_empty(), "no [[shape.level]]");
            shape.level.iter().try_for_each(|level| level.check(on, &objectives))?;
            shape.check_symmetric()?;
        }
        self.level.iter().try_for_each(|level| level.check_loads(&objectives))?;
        ensure!(
            self.chamber.is_empty() || self.levels().iter().all(|level| level.time.is_none()),
            "time of a level beside [[chamber]]: the slopes of a pressure belong to the \
             time steps of the scene; design a [[parameter]] instead, or leave time out"
        );
        Ok(())
    }
}
