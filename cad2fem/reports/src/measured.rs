//! What is measured on a state.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Measures of one tag.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Tag {
    /// Rest area [m²].
    pub area: f64,
    /// Force of the support on the body [N]; zero along axes that are free. A
    /// node on the rim of several fixed tags counts for the first of them.
    pub reaction: [f64; 3],
    /// Mean length of the displacement over the rest area, without sign [m].
    pub mean_displacement: f64,
    /// Mean displacement over the rest area, with signs [m].
    pub mean_displacement_vector: [f64; 3],
    /// Largest displacement of a node [m].
    pub max_displacement: f64,
}

/// Measures of one chamber.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Chamber {
    /// Volume behind the rest wall; an open one is closed by a cap over its rim
    /// [m³].
    pub volume_rest: f64,
    /// Volume behind the deformed wall [m³].
    pub volume: f64,
    /// Gauge pressure [Pa].
    pub pressure: f64,
    /// Whether the wall is closed.
    pub closed: bool,
}

/// Value of a probe.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Probe {
    /// What it measures.
    pub kind: String,
    /// Unit of the value.
    pub unit: String,
    /// The value.
    pub value: Option<f64>,
}

/// Principal stretches of a state, beside what the material allows.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct StretchRange {
    /// Smallest principal stretch of a quadrature point [1].
    pub smallest: f64,
    /// Rest centre of the tetrahedron of the smallest [m].
    #[serde(default)]
    pub smallest_at: [f64; 3],
    /// Largest principal stretch of a quadrature point [1].
    pub largest: f64,
    /// Rest centre of the tetrahedron of the largest [m].
    pub largest_at: [f64; 3],
    /// Rest volume of the tetrahedra with a quadrature point whose smallest or largest stretch is beyond what their
    /// material was fitted to, as a part of the body [1].
    pub volume_beyond: f64,
    /// Stretch at break over the largest stretch, if it is known: the body tears below 1 [1].
    pub margin: Option<f64>,
    /// Smallest and largest principal stretch that the material was fitted to, if they are known; of several materials,
    /// those that all were fitted to [1].
    pub fitted: Option<[f64; 2]>,
    /// Uniaxial stretch at which the material tears, if it is known [1].
    pub at_break: Option<f64>,
    /// Each material, beside its tests.
    #[serde(default)]
    pub materials: Vec<MaterialRange>,
}

/// Principal stretches of one material, beside those of its tests.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MaterialRange {
    /// The body or volume, where there are several materials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Smallest and largest principal stretch that it was fitted to, if they are known [1].
    pub tested: Option<[f64; 2]>,
    /// Modes that it was fitted in: `tension`, `biaxial`, which is also compression along one axis, `planar`; none where
    /// they are not known.
    pub modes: Vec<String>,
    /// Smallest principal stretch of a quadrature point [1].
    pub smallest: f64,
    /// Rest centre of the tetrahedron of the smallest [m].
    pub smallest_at: [f64; 3],
    /// Largest principal stretch of a quadrature point [1].
    pub largest: f64,
    /// Rest centre of the tetrahedron of the largest [m].
    pub largest_at: [f64; 3],
    /// Rest volume of the tetrahedra with a quadrature point beyond what it was fitted to, as a part of its own [1].
    pub volume_beyond: f64,
    /// Rest volume of the tetrahedra that are strained by more than 20 % in a mode that it was not fitted in, by the mode
    /// that they are nearest to, as a part of its own [1].
    pub untested: BTreeMap<String, f64>,
}

/// By how much a state would change without locking.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Locking {
    /// Degree of the elements.
    pub degree: usize,
    /// The elements that they are compared with.
    #[serde(default)]
    pub compared_with: String,
    /// Largest bulk modulus of the laws, in shear moduli.
    pub bulk_over_shear: f64,
    /// 1 − |u| / |u + δ|: the part of the displacement that is missing, negative where it is too large;
    /// lengths are roots of mean squares over the rest volume, from the vertices.
    pub displacement: f64,
    /// |δ| / |u + δ|, whatever its direction.
    pub change: f64,
    /// 1 − q(u) / q(u + δ) of the probes, except those of contact.
    pub probes: BTreeMap<String, f64>,
    /// Time that it took [s].
    pub wall_s: f64,
}

/// What a probe changes by where numbers are off.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ErrorBars {
    /// Value of the probe.
    pub value: f64,
    /// Unit of the value and of all changes.
    pub unit: String,
    /// Root of the sum of squares of the bars that are not part of another.
    pub together: f64,
    /// One by one.
    pub bars: Vec<ErrorBar>,
}

/// What one number does to a probe.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ErrorBar {
    /// `modulus`, `creep`, `mullins`, `wall`, `pressure`, `density`, `membrane`, `friction`, or the
    /// path of a number.
    pub of: String,
    /// Tag of the wall, the chamber or the sheet, or volume, where it is of that alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Unit of the number.
    pub per: String,
    /// ∂q/∂p.
    pub derivative: f64,
    /// How far the number is off, downward and upward.
    pub off: [f64; 2],
    /// What the probe changes by at these, to first order.
    pub change: [f64; 2],
}
