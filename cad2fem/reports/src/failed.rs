//! What is known where a run did not end well.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is known of a run without an equilibrium.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Failed {
    /// Why there is no equilibrium.
    pub reason: String,
    /// What is known of the load step that failed.
    pub failure: Failure,
}

/// What is known of the load step that failed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Failure {
    /// Load or time of the last equilibrium.
    pub load_reached: f64,
    /// Load or time that was tried.
    pub load_tried: f64,
    /// Residuals of the last iterations [N].
    pub residuals: Vec<f64>,
    /// The element that most likely causes the failure.
    pub worst_element: WorstElement,
    /// Smallest pivot of the Hessian at the last equilibrium, if that is stable.
    pub smallest_pivot: Option<Pivot>,
    /// Stiffness of the softest motion.
    pub softest_stiffness: SoftestStiffness,
    /// Compliance to the loads, over that at rest [1].
    pub softening: Option<f64>,
    /// What to try.
    #[serde(rename = "try")]
    pub advice: Vec<String>,
    /// File of the last equilibrium, in which `worst_element` marks the element.
    pub state: String,
}

/// The element that most likely causes a failure, and its state in the failing step.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct WorstElement {
    /// Index of the tetrahedron in the mesh.
    pub id: usize,
    /// Centre at rest [m].
    pub at: [f64; 3],
    /// Smallest J = det(I + ∇u) at its quadrature points, or where the certificate found less.
    pub volume_ratio: f64,
    /// Largest unbalanced force at its nodes [N].
    pub unbalanced_force: f64,
    /// Radius ratio at rest: 1 regular, 0 flat.
    pub quality: f64,
}

/// Smallest pivot of a Hessian.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Pivot {
    /// The pivot [N/m].
    pub value: f64,
    /// The largest one [N/m].
    pub largest: f64,
    /// Rest position of its node [m].
    pub at: [f64; 3],
    /// Axis along which it moves.
    pub axis: String,
}

/// Stiffness of the softest motion.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SoftestStiffness {
    /// At rest [N/m].
    pub at_rest: Option<f64>,
    /// At the last equilibrium [N/m].
    pub reached: Option<f64>,
}

/// Pairs of triangles of surfaces that run through each other.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Crossing {
    /// How many there are.
    pub pairs: usize,
    /// The bodies of the first.
    pub bodies: [String; 2],
    /// Place of the first [m].
    pub place: [f64; 3],
}
