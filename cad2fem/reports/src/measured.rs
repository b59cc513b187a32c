//! What is measured on a state.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Measures of one tag.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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

/// Thickness, law and measures of a sheet.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Membrane {
    /// Tag that it is bonded to.
    pub on: String,
    /// Law of its material.
    pub kind: String,
    /// Whether it bears tension only.
    pub tension_only: bool,
    /// Thickness [m].
    pub thickness: f64,
    /// Rest area [m²].
    pub area: f64,
    /// Stored energy [J].
    pub energy: f64,
    /// Smallest and largest principal stretch [1].
    pub stretch: [f64; 2],
    /// Largest principal force per width, pulled back to the rest sheet [N/m].
    pub tension: f64,
    /// Share of the area in tension along both principal directions [1].
    pub taut: f64,
    /// Share that is compressed across its largest strain [1].
    pub wrinkled: f64,
    /// Share where nothing is stretched [1].
    pub slack: f64,
}

/// Measures of a family of fibres.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Fibre {
    /// Name of the family.
    pub name: String,
    /// Rest volume that it is in [m³].
    pub volume: f64,
    /// Stored energy [J].
    pub energy: f64,
    /// Smallest and largest stretch along the fibres [1].
    pub stretch: [f64; 2],
    /// Largest force of the fibres per rest area across them [Pa].
    pub stress: f64,
    /// Share of the volume in which they are in tension [1].
    pub taut: f64,
}

/// Measures of a thread.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Winding {
    /// Name of the winding.
    pub name: String,
    /// Tag that it is wound on.
    pub on: String,
    /// Length of the thread at rest [m].
    pub length: f64,
    /// Turns of a helix, those of both threads where there are two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turns: Option<f64>,
    /// Segments, each in one facet.
    pub segments: usize,
    /// Stored energy [J].
    pub energy: f64,
    /// Smallest and largest force along it [N], each over as much of it as its segments are long on average.
    pub force: [f64; 2],
    /// Mean force along it [N].
    pub mean_force: f64,
    /// Mean force of a helix along its axis, across sections of the body in the middle third of its height [N].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial_force: Option<f64>,
    /// Mean axial force of all elastic parts there: bodies, sheets, fibres and all threads [N].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub section_force: Option<f64>,
    /// The thread's share of it [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_share: Option<f64>,
    /// Force at which it breaks over the largest force, if it is known: it breaks below 1 [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// Share of the length that is in tension [1].
    pub taut: f64,
}

/// Value of a probe.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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
#[schemars(deny_unknown_fields)]
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
