//! How far a state is from losing its stability, and paths through points where it does.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::measured::{Chamber, ErrorBars};

/// A state on a path that is followed by its arc length.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct PathState {
    /// Arc length from rest [1].
    pub arc_length: f64,
    /// Change of the load with the arc length, negative where the load falls [1].
    pub load_rate: f64,
    /// How far the state is from losing its stability at this load.
    pub stability: Stability,
    /// What lies between the state before and this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passed: Vec<PassedPoint>,
}

/// A point of a path at which the tangent stiffness is singular.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct PassedPoint {
    /// What becomes of the path there.
    pub kind: PointKind,
    /// Loads of the states before and after it [1].
    pub loads: [f64; 2],
}

/// What becomes of a path where its tangent stiffness is singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PointKind {
    /// The load turns: it is the largest or smallest that the body bears there.
    LimitPoint,
    /// Another branch leaves.
    Bifurcation,
}

/// How far an equilibrium is from losing its stability at a held load.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Stability {
    /// Number of negative eigenvalues of the exact tangent stiffness; none of a stable state.
    pub negative_eigenvalues: usize,
    /// The eigenvalue nearest to zero over that at rest [1].
    pub stiffness_over_rest: f64,
    /// Share of its mode in the direction in which the state goes on with the load, |φ · du/dt| / |du/dt|:
    /// 1 at a limit point, 0 at the bifurcation of a symmetric body [1].
    pub mode_along_path: f64,
    /// What will be lost where that eigenvalue vanishes.
    pub kind: PointKind,
}

/// How much more pressure than the full load the state at the end bears, while all else is held.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Limit {
    /// Whether a limit was found.
    pub status: LimitStatus,
    /// Factor on the pressures at which the state loses its stability [1].
    pub factor: Option<f64>,
    /// What becomes of it there: at a limit point there is no equilibrium beyond; at a bifurcation it buckles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<PointKind>,
    /// Factors of the states before and after it on the path [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[f64; 2]>,
    /// Factor up to which the state is known to be stable [1].
    pub stable_to: f64,
    /// Factor at which the largest stretch is that at break, where the material knows it and that comes first [1]; below
    /// 1 where the state at the end is beyond.
    pub burst: Option<f64>,
    /// Slope dP/dV of the pressure at the end over P/ΔV from rest to there [1]: 1 where the body answers in proportion, 0
    /// where it balloons. With several chambers, their work stands for the volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Error bars of `factor`, `burst` and `slope`, where there are such, of a scene with `[uncertainty]`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub error_bars: BTreeMap<String, ErrorBars>,
    /// Largest principal stretch at `stable_to` [1].
    pub largest_stretch: f64,
    /// Why the path could not be followed further, if it could not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Factor from which on states were found by load steps, as the path could not be followed: with contact, facets
    /// that slide over each other make small snaps. A limit beyond is known to a quarter of a percent [1].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_load_from: Option<f64>,
    /// The states on the way, from that at the end of the run on, the limit last where it was found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<LimitState>,
    /// What each iterate of the direct method left, the last one last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub iterates: Vec<DirectIterate>,
}

/// A state on the way to a limit.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LimitState {
    /// Factor on the pressures [1].
    pub factor: f64,
    /// Largest principal stretch [1].
    pub largest_stretch: f64,
    /// Measures of each chamber, by the tag of its wall.
    pub chambers: BTreeMap<String, Chamber>,
}

/// Whether a limit was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LimitStatus {
    /// It was, to the accuracy of the tolerance.
    Found,
    /// It lies between two states; the direct method did not come to it.
    Bracketed,
    /// The state is stable up to the largest factor that was asked for.
    StableTo,
    /// The state at the end is not stable itself.
    Unstable,
    /// The path could not be followed further than `stable_to`.
    NotFound,
}

/// What an iterate of the direct method leaves of its equations.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DirectIterate {
    /// Norm of the unbalanced force [N].
    pub residual: f64,
    /// Stiffness of the softest mode [N/m].
    pub stiffness: f64,
    /// Factor on the pressures [1].
    pub factor: f64,
}
