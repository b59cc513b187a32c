//! `[parting]`: where the shells separate.

use program::table;
use program::table::{Range, Table, direction};
use program::{KeyPath, Misfit, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::LENGTH;

/// The surface between the two shells.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum PartingConfig {
    /// Chosen by what is measured.
    Auto(AutoParting),
    /// A plane across the pull direction.
    Plane(PlaneParting),
    /// A height over the plane across the pull direction.
    HeightField(HeightFieldConfig),
}

impl PartingConfig {
    /// Whether nothing was asked for.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Auto(AutoParting { pull: None }))
    }
}

table! {
    /// Settings of a parting surface that is chosen by what is measured.
    #[derive(Clone, Debug)]
    pub struct AutoParting {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", direction;
    }
}

table! {
    /// Settings of a planar parting surface.
    #[derive(Clone, Debug)]
    pub struct PlaneParting {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", direction;
        /// Its position along `pull`, in the design's coordinates [m].
        offset: Option<f64> = None => "where undercuts are least";
    }
}

table! {
    /// Settings of a height-field parting surface.
    #[derive(Clone, Debug)]
    pub struct HeightFieldConfig {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", direction;
        /// Spacing of the columns [m].
        cell: f64 = 8e-4, LENGTH;
        /// Standard deviation of the Gaussian that smooths the heights [m].
        smoothing: f64 = 1.6e-3, LENGTH;
        /// Steepest slope along a row of columns [degrees].
        max_slope: f64 = 80.0, Range::between(1.0, 89.0).unit("°");
    }
}

impl Table for PartingConfig {
    fn check_ranges(&self, at: &KeyPath) -> Result<(), Misfit> {
        match self {
            Self::Auto(auto) => auto.check_ranges(at),
            Self::Plane(plane) => plane.check_ranges(at),
            Self::HeightField(field) => {
                field.check_ranges(at)?;
                let HeightFieldConfig { smoothing, cell, .. } = field;
                match *smoothing <= 50.0 * cell {
                    true => Ok(()),
                    false => Err(misfit!(
                        at.clone().key("smoothing"),
                        " = {smoothing} m: must be at most 50 cells of {cell} m"
                    )),
                }
            }
        }
    }
}
