//! `[parting]`: where the shells separate.

use serde::Deserialize;

/// Settings of a parting that is chosen by what is measured.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Auto {
    /// Direction in which the shells separate. Unset: where least is hidden [1].
    pub pull: Option<[f64; 3]>,
}

/// The surface between the two shells.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Parting {
    /// Chosen by what is measured.
    Auto(Auto),
    /// A plane across the pull direction.
    Plane(Plane),
    /// A height over the plane across the pull direction.
    HeightField(HeightField),
}

/// Settings of a planar parting surface.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Direction in which the shells separate, along or across `up`. Unset: across `up`, where the part is thinnest [1].
    pub pull: Option<[f64; 3]>,
    /// Position of the plane along `pull`, in the design's coordinates. Unset: the middle of the part [m].
    pub offset: Option<f64>,
}

/// Settings of a height-field parting surface.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeightField {
    /// Direction in which the shells separate, along or across `up`. Unset: `up` [1].
    pub pull: Option<[f64; 3]>,
    /// Spacing of the columns [m].
    pub cell: f64,
    /// Standard deviation of the Gaussian that smooths the heights [m].
    pub smoothing: f64,
    /// Steepest slope along a row of columns [degrees].
    pub max_slope: f64,
}

impl Default for HeightField {
    fn default() -> Self {
        Self { pull: None, cell: 8e-4, smoothing: 1.6e-3, max_slope: 80.0 }
    }
}
