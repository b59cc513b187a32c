//! The report of a simulation.

use std::collections::BTreeMap;

use program::InputFile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::failed::{Crossing, Failed};
use crate::measured::{Chamber, ErrorBars, Locking, Probe, StretchRange, Tag};
use crate::mullins::Inflation;
use crate::stability::{Limit, Stability};
use crate::step::{ForceBalance, Step};
use crate::terms::Terms;

/// What `solver simulate` found, and what it was found from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("additionalProperties" = false))]
pub struct Simulation {
    /// Whether there is an equilibrium, and one that can be.
    pub status: Status,
    /// Whether the result may be used.
    pub usable: bool,
    /// Name and version of the program.
    pub program: String,
    /// Files that the result was made from, with their hashes; paths from the folder of the report.
    pub inputs: Inputs,
    /// Values that `--set` gave.
    pub set: Vec<String>,
    /// The scene with all defaults, as in sim.toml.
    pub config: Value,
    /// Law of each body or volume.
    pub material: OneOrList<Material>,
    /// Degrees of freedom, those that are fixed included.
    pub dofs: usize,
    /// Number of tetrahedra.
    pub tets: usize,
    /// Number of vertices of the mesh.
    pub vertices: usize,
    /// Planes of symmetry, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub symmetry: Option<Vec<CutPlane>>,
    /// The state at rest, before any load, where forces balance there; not of a scene with inertia.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<Step>,
    /// Every load step, or of a scene in time every time step.
    pub steps: Vec<Step>,
    /// Entries of the factor of the Hessian.
    pub factor_entries: usize,
    /// Memory that the run was expected to need [MB].
    pub memory_estimate_mb: f64,
    /// What is known of the state at the end, if there is one.
    #[serde(flatten)]
    pub end: Option<End>,
    /// What is known of a run without an equilibrium.
    #[serde(flatten)]
    pub failed: Option<Failed>,
}

/// The state at the end.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct End {
    /// Whether every step met its tolerance; not where rounding did not allow it.
    pub tolerance_met: bool,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
    /// Work of the loads beside the energy that is stored.
    pub energy_balance: EnergyBalance,
    /// Stored energy of each term, and their sum `total` [J].
    pub energies: BTreeMap<String, f64>,
    /// Resultants of the loads and reactions.
    pub force_balance: ForceBalance,
    /// Measures of each tag.
    pub tags: BTreeMap<String, Tag>,
    /// Measures of each chamber, by the tag of its wall.
    pub chambers: BTreeMap<String, Chamber>,
    /// Measures of the terms of the energy.
    #[serde(flatten)]
    pub terms: Terms,
    /// Inflations of each chamber in their order, of a scene with `[[mullins]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inflations: Option<Vec<Inflation>>,
    /// Value of each probe in the last state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<BTreeMap<String, Probe>>,
    /// Principal stretches, beside what the material allows.
    pub stretch_range: StretchRange,
    /// By how much the elements are too stiff, where they may lock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub locking: Option<Locking>,
    /// How far the state at the end is from losing its stability, with `[solver] stability` or
    /// `follow = "arc-length"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stability: Option<Stability>,
    /// Part of the full load at the end of a path that is followed by its arc length [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_reached: Option<f64>,
    /// How much more pressure it bears, of a scene with `[limit]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<Limit>,
    /// Error bars of each probe, of a scene with `[uncertainty]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_bars: Option<BTreeMap<String, ErrorBars>>,
    /// Surfaces that have passed through each other in a scene without contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crossing: Option<Crossing>,
    /// Where the time went.
    pub timings: Timings,
    /// Time of ordering and load steps, without files [s].
    pub equilibrium_s: f64,
    /// Time of the whole run, with what an interrupted one took before [s].
    pub wall_s: f64,
    /// Largest memory in use [MB], where the system tells it.
    pub peak_rss_mb: Option<f64>,
}

/// Whether a run ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Status {
    /// An equilibrium was found.
    #[serde(rename = "ok")]
    Ok,
    /// A path by its arc length ended before it came to the full load.
    #[serde(rename = "full load not reached")]
    FullLoadNotReached,
    /// Surfaces have passed through each other.
    #[serde(rename = "surfaces_crossed")]
    SurfacesCrossed,
    /// No equilibrium was reached.
    #[serde(rename = "no equilibrium")]
    NoEquilibrium,
    /// A body, or a part of it, moves without any force.
    #[serde(rename = "not enough supports")]
    NotEnoughSupports,
}

/// What there is of each body or volume: alone where there is one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OneOrList<T> {
    /// There is one.
    One(T),
    /// There are several, in the order of the scene.
    List(Vec<T>),
}

impl<T> OneOrList<T> {
    /// Alone where there is one.
    pub fn new(mut values: Vec<T>) -> Self {
        match (values.pop(), values.is_empty()) {
            (Some(one), true) => Self::One(one),
            (last, _) => Self::List(values.into_iter().chain(last).collect()),
        }
    }

    /// All of them.
    pub fn all(&self) -> &[T] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::List(values) => values,
        }
    }
}

/// Files that a result was made from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Inputs {
    /// Mesh of each body.
    pub mesh: OneOrList<InputFile>,
    /// The scene.
    pub scene: InputFile,
    /// The design, in the report of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<InputFile>,
    /// Meshes of levels of the design.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub level_meshes: Vec<InputFile>,
    /// Files that objectives of the design name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<InputFile>,
    /// Files that these include.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub included: Vec<InputFile>,
}

/// Law of a body or volume.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Material {
    /// The law.
    pub kind: String,
    /// Values of the parameters, by their names.
    pub parameters: Map<String, Value>,
    /// Moduli at rest.
    pub moduli: Moduli,
    /// The silicone, if the scene names one.
    pub silicone: Option<Silicone>,
    /// The volume that has it, if it is not a whole body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
}

/// Moduli at rest.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Moduli {
    /// Shear modulus [Pa].
    pub shear: f64,
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

/// Where the law of a silicone comes from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Silicone {
    /// Key of the silicone.
    pub name: String,
    /// Key of the source of its numbers.
    pub source: String,
    /// How the modulus was found.
    pub test: String,
    /// Shear modulus of this source [Pa].
    pub shear_modulus: f64,
    /// Smallest and largest shear modulus of all sources [Pa].
    pub shear_modulus_range: [f64; 2],
}

/// A plane of symmetry that cuts the body.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CutPlane {
    /// Tags of the cut.
    pub on: Vec<String>,
    /// Axis across it.
    pub axis: String,
    /// Coordinate of the plane on that axis [m].
    pub level: f64,
}

/// Work of the loads beside the energy that is stored.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct EnergyBalance {
    /// Work of gas, dead loads and moving supports, by the trapezoidal rule over the load steps [J].
    pub work_of_loads: f64,
    /// Energy of bodies and sheets, with what softening has taken of it [J].
    pub elastic: f64,
    /// Kinetic energy, of a scene with inertia [J].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinetic: Option<f64>,
    /// Largest `energy_gain` of all steps, over the largest stored and kinetic energy; of a scene with inertia [1].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_gain: Option<f64>,
    /// Work without energy, over the energy; of a scene without inertia [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_gap: Option<f64>,
}

/// Time of a task.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Task {
    /// Time on the clock [s].
    pub wall_s: f64,
    /// Time of all threads together [s].
    pub processor_s: f64,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Timings {
    /// Sparsity pattern, nested dissection and symbolic factorisation, again where contact adds entries.
    pub ordering: Task,
    /// Values, gradients and Hessians of all energies but contact and friction.
    pub assembly: Task,
    /// Contact and friction, and the search for close pairs.
    pub contact: Task,
    /// Numerical factorisations.
    pub factor: Task,
    /// Triangular solves, with the products of matrix and vector around them.
    pub solve: Task,
    /// Step lengths by continuous collision detection.
    pub collision: Task,
    /// Proofs that no element is inverted and no surface intersects.
    pub certificate: Task,
    /// Files that were written during the run.
    pub output: Task,
    /// Numerical factorisations, failed ones included.
    pub factorizations: usize,
    /// Factorisations that met a pivot that is not positive.
    pub failed_factorizations: usize,
    /// Time that the run was foreseen to take after a tenth of its steps, or after the first iteration of a single one [s].
    pub predicted_s: Option<f64>,
}

impl Timings {
    /// All tasks, by the names of their keys.
    pub fn tasks(&self) -> [(&'static str, Task); 8] {
        [
            ("assembly", self.assembly),
            ("certificate", self.certificate),
            ("collision", self.collision),
            ("contact", self.contact),
            ("factor", self.factor),
            ("ordering", self.ordering),
            ("output", self.output),
            ("solve", self.solve),
        ]
    }
}
