//! What is known of a state on a path of equilibria that is followed by its arc length.

use serde::{Deserialize, Serialize};

/// A state on a path of equilibria that is followed by its arc length.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ArcPoint {
    /// Arc length from rest [1].
    pub arc: f64,
    /// Change of the load with the arc length [1]; negative where the load falls.
    pub load_rate: f64,
    /// How far it is from losing its stability at this load.
    pub stability: Stability,
    /// The softest stiffness at rest [N/m].
    pub rest_stiffness: f64,
    /// What lies between the state before and this one.
    pub passed: Vec<SingularPoint>,
}

/// How stable an equilibrium is at a held load.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stability {
    /// Number of negative eigenvalues.
    pub negative: usize,
    /// The eigenvalue nearest to zero, with its sign [N/m].
    pub stiffness: f64,
    /// The motion of least stiffness over all degrees of freedom, of length 1.
    pub mode: Vec<f64>,
    /// |φ · du/dt| / |du/dt|; 0 where no load acts.
    pub along_path: f64,
}

/// What becomes of a path where the tangent is singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Singularity {
    /// The load turns.
    LimitPoint,
    /// Another branch leaves.
    Bifurcation,
}

/// A singular point of a path between two loads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SingularPoint {
    /// Whether the load turns or another branch leaves.
    pub kind: Singularity,
    /// From and to.
    pub loads: [f64; 2],
}
