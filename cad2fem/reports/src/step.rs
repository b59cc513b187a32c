//! A reported step: an entry of `steps`, and a line of `steps.jsonl`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::measured::Chamber;
use crate::numbers::Numbers;
use crate::stability::PathState;

/// One state of a run.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Step {
    /// Time [s]; of a static scene the fraction of the full load.
    pub t: f64,
    /// Fraction of the full load, of a static scene [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<f64>,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Norm of the unbalanced force [N].
    pub residual: f64,
    /// Residual that was wanted [N].
    pub residual_wanted: f64,
    /// Estimated floor of the residual, where rounding allows no less and it is larger than wanted [N].
    pub rounding_floor: Option<f64>,
    /// Lower bound of J = det(I + ∇u) over all points of all elements [1].
    pub smallest_volume_ratio: f64,
    /// Measures of each chamber, by the tag of its wall.
    pub chambers: BTreeMap<String, Chamber>,
    /// Mean displacement of each tag, a vector with signs [m].
    pub mean_displacement: BTreeMap<String, [f64; 3]>,
    /// Force of each support on the body [N].
    pub reactions: BTreeMap<String, [f64; 3]>,
    /// Motion of each rigid part, by its tag or body.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rigid: BTreeMap<String, RigidPart>,
    /// Resultants of the loads and reactions.
    pub force_balance: ForceBalance,
    /// Stored energy of each term, and their sum `total`; with inertia `kinetic` [J].
    pub energies: BTreeMap<String, f64>,
    /// Momentum of all bodies, of a scene with inertia [kg m/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<[f64; 3]>,
    /// Forces between surfaces, of a scene with contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub collisions: Option<Collisions>,
    /// Work of gas, dead loads and moving supports so far [J].
    pub work_of_loads: f64,
    /// Energy that time integration has added so far, less what friction and damping have taken: the stored and
    /// kinetic one less that at the start and the work of the loads; of a scene with inertia whose obstacles stand
    /// still [J].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_gain: Option<f64>,
    /// Place and stability of a state on a path that is followed by its arc length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathState>,
    /// Value of each probe, in its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<Numbers>,
}

/// Motion of a rigid part.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct RigidPart {
    /// Displacement of its middle [m].
    pub displacement: [f64; 3],
    /// Rotation vector: the axis it has turned about times the angle [rad].
    pub rotation: [f64; 3],
}

/// Resultants of the loads by kind, and of the reactions.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ForceBalance {
    /// Norm of their sum [N].
    pub out_of_balance: f64,
    /// Resultant of each kind of load, and `reaction` [N].
    #[serde(flatten)]
    pub resultants: BTreeMap<String, [f64; 3]>,
}

/// Forces between surfaces.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Collisions {
    /// Number of pairs of features that repel each other.
    pub pairs: usize,
    /// Smallest gap of these over the activation [1].
    pub smallest_gap: Option<f64>,
    /// Forces of contact, for each pair of bodies.
    pub contact: Vec<PairForce>,
    /// Forces of friction, for each pair of bodies.
    pub friction: Vec<PairForce>,
}

/// Force between two bodies.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct PairForce {
    /// The two bodies.
    pub bodies: [String; 2],
    /// Force on the first [N].
    pub force: [f64; 3],
    /// Sum of the magnitudes of the forces on its vertices [N].
    pub magnitude: f64,
}
