//! What a report says of terms of the energy, a section for each list of tables in the scene.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mullins::Mullins;

/// The sections, each in the order of the scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Terms {
    /// Measures of each sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membranes: Option<Vec<Membrane>>,
    /// Measures of each family of fibres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fibres: Option<Vec<Fibre>>,
    /// Measures of each thread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub windings: Option<Vec<Winding>>,
    /// How far bodies are softened.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mullins: Option<Vec<Mullins>>,
}

/// Thickness, law and measures of a sheet.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
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
