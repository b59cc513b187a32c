//! `[parting]`: where the shells separate.

use program::{KeyPath, Misfit, misfit};
use schemars::JsonSchema;
use serde::Deserialize;

use super::table::{Key, any, length, optional_direction, table};

/// The surface between the two shells.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
    AutoParting, "parting." {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", optional_direction;
    }
}

table! {
    /// Settings of a planar parting surface.
    PlaneParting, "parting." {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", optional_direction;
        /// Plane: its position along `pull`, in the design's coordinates [m].
        offset: Option<f64> = None => "where undercuts are least", any;
    }
}

table! {
    /// Settings of a height-field parting surface.
    HeightFieldConfig, "parting." {
        /// Direction in which the shells separate, along or across `up` [1].
        pull: Option<[f64; 3]> = None => "where undercuts are least", optional_direction;
        /// Height field: spacing of the columns [m].
        cell: f64 = 8e-4, length;
        /// Height field: standard deviation of the Gaussian that smooths the heights [m].
        smoothing: f64 = 1.6e-3, length;
        /// Height field: steepest slope along a row of columns [degrees].
        max_slope: f64 = 80.0, slope;
    }
}

fn slope(key: &str, degrees: &f64) -> Result<(), String> {
    match (1.0..=89.0).contains(degrees) {
        true => Ok(()),
        false => Err(format!("{key} is {degrees}, must lie between 1 and 89 degrees")),
    }
}

impl PartingConfig {
    /// The keys, in order.
    pub fn keys() -> impl Iterator<Item = &'static Key> {
        const KIND: Key = Key {
            name: "parting.kind",
            default: "\"auto\"",
            meaning: "Where the shells separate: `\"plane\"`, `\"height-field\"`, or `\"auto\"`, \
                      which chooses by what is measured; halves and sheets always choose by it.",
        };
        let tables = [AutoParting::KEYS, PlaneParting::KEYS, HeightFieldConfig::KEYS];
        std::iter::once(&KIND).chain(tables.into_iter().flatten())
    }

    /// Whether every value lies in its range.
    pub fn check(&self) -> Result<(), Misfit> {
        match self {
            Self::Auto(auto) => auto.check_ranges(),
            Self::Plane(plane) => plane.check_ranges(),
            Self::HeightField(field) => {
                field.check_ranges()?;
                let HeightFieldConfig { smoothing, cell, .. } = field;
                match *smoothing <= 50.0 * cell {
                    true => Ok(()),
                    false => Err(misfit!(
                        KeyPath::of("parting.smoothing"),
                        " is {smoothing}, must be at most 50 cells of {cell} m"
                    )),
                }
            }
        }
    }
}
