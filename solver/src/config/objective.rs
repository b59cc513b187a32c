//! `[[objective]]`: what a design is wanted to do.

mod check;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::objective::{Density, DistanceKind, KINDS, Kind, Measure, SmoothnessForm, TimeIntegral};
use crate::schedule::Field;

/// A name, or several.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "needed is a name in quotes, or a list of names")]
pub enum Names {
    /// One name.
    One(String),
    /// A list of names.
    Several(Vec<String>),
}

impl Names {
    /// All names.
    #[must_use]
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// What of the forces of contact counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForceForm {
    /// The component of their sum along a direction.
    Along,
    /// The square of their sum.
    #[default]
    Squared,
    /// The sum of their squares over nodes.
    SumOfSquares,
}

/// A weighted term of the objective. Each has a `name`, a `weight` in the inverse of
/// the unit of its value, and what it is summed `over` in time. With the measure
/// "rest", areas and volumes are of the rest shape.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // name, weight and over, of every kind, are documented above
pub enum ObjectiveConfig {
    /// Squared distance of deformed tags to a target surface [m⁴].
    Target {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should reach the target.
        on: Names,
        /// Target surface, a file in metres.
        target: PathBuf,
        /// What of the distance is interpolated.
        #[serde(default)]
        distance: DistanceKind,
        /// Lattice spacing of the interpolated distance [m].
        #[serde(default = "super::a_millimetre")]
        spacing: f64,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Squared difference to a wanted displacement [m⁴].
    Displacement {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should be displaced.
        on: Names,
        /// What is wanted, also in time [m].
        displacement: Field,
        /// The axes that count, such as "xz".
        #[serde(default = "super::all_axes")]
        components: String,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Squared difference to a wanted position [m⁴].
    Position {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should be there.
        on: Names,
        /// What is wanted, also in time [m].
        position: Field,
        /// The axes that count, such as "xz".
        #[serde(default = "super::all_axes")]
        components: String,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Force of contact and friction on tags or bodies [N; N²]; needs [contact].
    ContactForce {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags or bodies on which the force acts.
        on: Names,
        /// What of it.
        #[serde(default)]
        form: ForceForm,
        /// Of the form "along"; of any length [1].
        direction: Option<[f64; 3]>,
    },
    /// Squared forces of a barrier wider than that of contact [m⁴]; needs
    /// [contact].
    ContactProxy {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Two or more tags or bodies, apart from each other.
        on: Names,
        /// The barrier.
        #[serde(default)]
        density: Density,
        /// Distance from which on they feel each other [m].
        activation: f64,
    },
    /// Penalty on walls thinner than `minimum` + `activation` [m⁴].
    WallThickness {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags on one side of the wall.
        on: Names,
        /// Tags on the other side; without them, each two tags of `on` are the
        /// sides of a wall.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        against: Vec<String>,
        /// The barrier; the log one is infinite at `minimum`.
        #[serde(default)]
        density: Density,
        /// Thinnest admissible wall, of the log barrier [m].
        minimum: Option<f64>,
        /// The penalty starts this far above the minimum [m].
        activation: f64,
        /// Walls of which shape.
        #[serde(default)]
        measure: Measure,
    },
    /// Laplacian of the rest surface of tags [1; m²].
    Smoothness {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags to smooth.
        on: Names,
        /// How it is normalised.
        #[serde(default)]
        form: SmoothnessForm,
    },
    /// Barrier between parts of the rest surface that are not adjacent [m⁴].
    Clearance {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Distance below which the barrier acts [m].
        activation: f64,
    },
    /// Volume of bodies or of a chamber [m³], or the squared difference to a wanted
    /// one [m⁶].
    Volume {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A tag, for the chamber behind it; a body; nothing for all bodies.
        on: Option<String>,
        /// The wanted volume [m³].
        volume: Option<f64>,
        /// Of which shape.
        #[serde(default)]
        measure: Measure,
    },
    /// ∫ |P|^q over bodies [Pa^q m³].
    Stress {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A body; nothing for all.
        on: Option<String>,
        /// q, 2 or more [1].
        #[serde(default = "two")]
        power: f64,
    },
    /// Penalty on principal stretches beyond limits [m³].
    StrainLimit {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A body; nothing for all.
        on: Option<String>,
        /// Largest stretch that costs nothing [1].
        largest: f64,
        /// Smallest stretch that costs nothing [1].
        #[serde(default)]
        smallest: f64,
    },
}

fn two() -> f64 {
    2.0
}

impl ObjectiveConfig {
    fn common(&self) -> (&str, f64, &TimeIntegral) {
        match self {
            Self::Target { name, weight, over, .. }
            | Self::Displacement { name, weight, over, .. }
            | Self::Position { name, weight, over, .. }
            | Self::ContactForce { name, weight, over, .. }
            | Self::ContactProxy { name, weight, over, .. }
            | Self::WallThickness { name, weight, over, .. }
            | Self::Smoothness { name, weight, over, .. }
            | Self::Clearance { name, weight, over, .. }
            | Self::Volume { name, weight, over, .. }
            | Self::Stress { name, weight, over, .. }
            | Self::StrainLimit { name, weight, over, .. } => (name, *weight, over),
        }
    }

    /// The user's name for the term.
    #[must_use]
    pub fn name(&self) -> &str {
        self.common().0
    }

    /// Factor of the term, in the inverse of its unit.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.common().1
    }

    /// What it is summed over.
    #[must_use]
    pub fn over(&self) -> &TimeIntegral {
        self.common().2
    }

    /// Its row of the table.
    #[must_use]
    pub fn kind(&self) -> &'static Kind {
        &KINDS[match self {
            Self::Target { .. } => 0,
            Self::Displacement { .. } => 1,
            Self::Position { .. } => 2,
            Self::ContactForce { .. } => 3,
            Self::ContactProxy { .. } => 4,
            Self::WallThickness { .. } => 5,
            Self::Smoothness { .. } => 6,
            Self::Clearance { .. } => 7,
            Self::Volume { .. } => 8,
            Self::Stress { .. } => 9,
            Self::StrainLimit { .. } => 10,
        }]
    }
}

/// Which of x, y, z are named.
#[must_use]
pub fn axes(components: &str) -> [bool; 3] {
    ['x', 'y', 'z'].map(|axis| components.contains(axis))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
