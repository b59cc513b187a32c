//! The report of an optimisation, and its history.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::failed::{Crossing, Failed};
use crate::numbers::Numbers;
use crate::simulation::{CutPlane, Inputs};

/// What `solver optimize` found, and what it was found from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Optimization {
    /// How it ended.
    pub status: Ended,
    /// Whether the design may be used.
    pub usable: bool,
    /// What is known of the design at the end, if there is one.
    #[serde(flatten)]
    pub designed: Option<Designed>,
    /// What is known of a start without an equilibrium.
    #[serde(flatten)]
    pub failed: Option<NoStart>,
}

/// How an optimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Ended {
    /// The last level converged: no step gains more than was asked for.
    #[serde(rename = "converged")]
    Converged,
    /// The last level took all of its iterations, and the last of them gained little.
    #[serde(rename = "iteration_limit")]
    IterationLimit,
    /// The last level took all of its iterations while the objective still fell.
    #[serde(rename = "still_falling")]
    StillFalling,
    /// The last level is jammed: its model promises more than the steps that are allowed give.
    #[serde(rename = "jammed")]
    Jammed,
    /// The last level ended by `least_rate` or `time_limit`.
    #[serde(rename = "stopped_early")]
    StoppedEarly,
    /// The runs at the end violate a bound of a probe, or of the pressures.
    #[serde(rename = "not_kept")]
    NotKept,
    /// Surfaces of the design under load have passed through each other.
    #[serde(rename = "surfaces_crossed")]
    SurfacesCrossed,
    /// The body at the start of a level has no equilibrium.
    #[serde(rename = "no equilibrium")]
    NoEquilibrium,
    /// A body, or a part of it, moves without any force.
    #[serde(rename = "not enough supports")]
    NotEnoughSupports,
}

impl Ended {
    /// What a level, or a design, has come to.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::IterationLimit => "took all of its iterations",
            Self::StillFalling => "took all of its iterations while the objective still fell",
            Self::Jammed => "is jammed",
            Self::StoppedEarly => "was stopped",
            Self::NotKept => "does not keep what it is to keep",
            Self::SurfacesCrossed => "has surfaces that passed through each other",
            Self::NoEquilibrium => "has no equilibrium",
            Self::NotEnoughSupports => "has not enough supports",
        }
    }
}

/// The design at the end, beside that at the start.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Designed {
    /// Name and version of the program.
    pub program: String,
    /// Files that the result was made from, with their hashes; paths from the folder of the report.
    pub inputs: Inputs,
    /// Values that `--set` gave.
    pub set: Vec<String>,
    /// How each level ended.
    pub levels: Vec<LevelEnd>,
    /// What the design keeps, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub constraints: BTreeMap<String, Kept>,
    /// What is minimised, at the start.
    pub objective_before: Option<f64>,
    /// What is minimised, at the end.
    pub objective_after: Option<f64>,
    /// What each level has gained, over its first objective [1].
    pub gains: Vec<Option<f64>>,
    /// Weight of each term, those that shares came to among them.
    pub weights: Numbers,
    /// Weighted terms of the objective at the start.
    pub terms_before: Numbers,
    /// Weighted terms of the objective at the end.
    pub terms_after: Numbers,
    /// Mean displacement of each tag at the start [m].
    pub mean_displacement_before: Numbers,
    /// Mean displacement of each tag at the end [m].
    pub mean_displacement_after: Numbers,
    /// What each probe of the scene was and has become.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<BTreeMap<String, DesignedProbe>>,
    /// How the shape at the start can be cast, of a design with `[mold]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mold_before: Option<Castable>,
    /// How the shape at the end can be cast, of a design with `[mold]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mold_after: Option<Castable>,
    /// What each scenario came to at the start, of a design with `[[scenario]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenarios_before: Option<BTreeMap<String, ScenarioRun>>,
    /// What each scenario comes to at the end, of a design with `[[scenario]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenarios_after: Option<BTreeMap<String, ScenarioRun>>,
    /// Planes of symmetry, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub symmetry: Option<Vec<CutPlane>>,
    /// Surfaces that have passed through each other in a scene without contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crossing: Option<Crossing>,
    /// The design with a re-meshed interior, where a shape moves: another value says that elements are poor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remeshed: Option<Remeshed>,
    /// Lines of the history.
    pub iterations: usize,
    /// Time for shapes, their runs and the terms [s].
    pub forward_s: f64,
    /// Time for gradients [s].
    pub gradient_s: f64,
    /// Time since the program was started last [s].
    pub wall_s_of_this_run: f64,
    /// Largest memory in use [MB], where the system tells it.
    pub peak_rss_mb: Option<f64>,
}

/// A design on another mesh of the same shape.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Remeshed {
    /// The objective.
    pub objective: Option<f64>,
    /// Probes of the scene, in the units of their kinds.
    pub probes: Numbers,
}

/// How a level ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LevelEnd {
    /// The number of the level, counted from 1.
    pub level: usize,
    /// How it ended: one of the endings of a design, or "stopped_early".
    pub ending: Ended,
    /// Why, in words.
    pub why: String,
}

/// A constraint at the end of a design.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Kept {
    /// Unit of its numbers.
    pub unit: String,
    /// The least that is to be kept: of a wall, of the sine of a draft, of a probe, or of an edge of the pressures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// The most, of a probe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// The number there is that is nearest to that or beyond, none where all of it is far from it.
    pub found: Option<f64>,
    /// By how much the objective would fall for a unit less of `least`, or more of `most`, to first order: the multiplier.
    pub worth: f64,
}

/// What a probe was and has become.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DesignedProbe {
    /// Unit of its values.
    pub unit: String,
    /// Value at the start.
    pub before: Option<f64>,
    /// Value at the end.
    pub after: Option<f64>,
    /// Value that the design wanted, if it wanted one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted: Option<f64>,
}

/// Why a level could not begin.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NoStart {
    /// Number of the level.
    pub level: usize,
    /// What is known of the run that failed.
    #[serde(flatten)]
    pub failed: Failed,
}

/// A line of `history.jsonl`: the shape that a level begins with, or an accepted iteration.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Iteration {
    /// Number of the level.
    pub level: usize,
    /// Handles of the level, if it has some.
    pub handles: Option<Handles>,
    /// Number of design variables.
    pub variables: usize,
    /// Number of the iteration within the level; 0 is its start.
    pub iteration: usize,
    /// What is minimised: the sum of the terms.
    pub objective: Option<f64>,
    /// Weighted terms of the objective, of several scenarios their means.
    pub terms: Numbers,
    /// Norm of the gradient by the design variables.
    pub gradient_norm: Option<f64>,
    /// Largest motion of a vertex in this iteration [m].
    pub motion_m: f64,
    /// Steps that were tried.
    pub trials: usize,
    /// Newton iterations of all runs of the accepted shape.
    pub newton_iterations: usize,
    /// Time for shapes, their runs and the terms [s].
    pub forward_s: f64,
    /// Time for gradients [s].
    pub gradient_s: f64,
    /// Time of `fab plan` [s], of a design with `[mold]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mold_s: Option<f64>,
    /// Computing time of all levels so far [s].
    pub time_s: f64,
    /// Degrees of freedom, those that are fixed included.
    pub dofs: usize,
    /// Time steps of a run.
    pub time_steps: usize,
    /// Designed numbers, by the names that the scene has for them.
    pub parameters: Numbers,
    /// Mean displacement of each tag, of several scenarios in the first [m].
    pub mean_displacement: Numbers,
    /// Value of each probe of the scene, of several scenarios in the first, in its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<Numbers>,
    /// What each scenario comes to, of a design with `[[scenario]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenarios: Option<BTreeMap<String, ScenarioRun>>,
    /// Largest less smallest mean displacement of each tag over the scenarios, over that of the first [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<Numbers>,
    /// How `fab plan` would cast the shape, of a design with `[mold]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mold: Option<Castable>,
}

/// How many handles there are.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Handles {
    /// As many on each tag that moves.
    Each(usize),
    /// On some of the tags.
    Tags(BTreeMap<String, usize>),
}

/// What a scenario comes to.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioRun {
    /// Sum of the terms.
    pub objective: Option<f64>,
    /// Weighted terms.
    pub terms: Numbers,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Mean displacement of each tag [m].
    pub mean_displacement: Numbers,
    /// Value of each probe of the scene, in its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<Numbers>,
}

/// How a shape can be cast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Castable {
    /// It can be cast.
    Planned {
        /// Every number that led to the choice, by its name.
        measures: Numbers,
        /// The method.
        method: String,
        /// Why, with numbers.
        reason: String,
    },
    /// It cannot be cast.
    Refused {
        /// Why.
        refused: String,
    },
}
