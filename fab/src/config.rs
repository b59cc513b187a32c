//! `mold.toml`: how a body is to be molded.
//!
//! Lengths are metres and directions are those of the design; every key has a
//! default, an unknown key is an error that lists the valid ones.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use mesh::Vec3;
use serde::{Deserialize, Serialize};

use crate::{printer, silicone};

/// Everything `fab mold` can be told.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Tag of the wall of the air cavity.
    pub cavity: String,
    /// Direction that points up while casting; the inlet must face down. Unset: away from the inlet [1].
    pub up: Option<[f64; 3]>,
    /// Least thickness of the mold around the part [m].
    pub wall: f64,
    /// Where the shells separate.
    pub parting: Parting,
    /// Cones that register one piece on another.
    pub keys: Keys,
    /// Funnel through which the silicone enters.
    pub sprue: Sprue,
    /// Channels through which the air leaves.
    pub vents: Vents,
    /// Stub that holds the core at its inlet.
    pub core: Core,
    /// What is cast, and what the mold is printed on.
    pub casting: Casting,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            cavity: "cavity".into(),
            up: None,
            wall: 5e-3,
            parting: Parting::HeightField(HeightField::default()),
            keys: Keys::default(),
            sprue: Sprue::default(),
            vents: Vents::default(),
            core: Core::default(),
            casting: Casting::default(),
        }
    }
}

/// The surface between the two shells.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Parting {
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

/// Conical registration keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Keys {
    /// Radius at the foot of a key [m].
    pub radius: f64,
    /// Height of a key [m].
    pub height: f64,
    /// Gap between a key and its seat [m].
    pub clearance: f64,
}

impl Default for Keys {
    fn default() -> Self {
        Self { radius: 3e-3, height: 3e-3, clearance: 2e-4 }
    }
}

/// The conical sprue.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sprue {
    /// A point of the design above or below which the sprue enters. Unset: the highest point [m].
    pub at: Option<[f64; 3]>,
    /// Radius at the part [m].
    pub radius: f64,
    /// Radius at the top of the mold [m].
    pub top_radius: f64,
}

impl Default for Sprue {
    fn default() -> Self {
        Self { at: None, radius: 3e-3, top_radius: 5.4e-3 }
    }
}

/// Vents at the local maxima of height.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vents {
    /// Radius of a vent [m].
    pub radius: f64,
    /// A maximum is vented if one has to descend at least this far to reach a higher one [m].
    pub persistence: f64,
}

impl Default for Vents {
    fn default() -> Self {
        Self { radius: 8e-4, persistence: 1e-3 }
    }
}

/// The core print: a stub below the inlet, in a socket of the piece below.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Core {
    /// Length of the stub, and thickness of the mold below the part [m].
    pub length: f64,
    /// Gap between stub and socket [m].
    pub clearance: f64,
    /// Width of the shoulder around the socket on which the core rests [m].
    pub shoulder: f64,
}

impl Default for Core {
    fn default() -> Self {
        Self { length: 8e-3, clearance: 2e-4, shoulder: 1e-4 }
    }
}

/// What is cast, and what the mold is printed on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Casting {
    /// A silicone of `solver/silicones.toml`. Unset: volumes only.
    pub silicone: Option<String>,
    /// A printer of `printers.toml`. Unset: no build volume is checked.
    pub printer: Option<String>,
    /// Silicone that stays in the cup, as a share of what fills the mold [1].
    pub waste: f64,
    /// Least thickness of the silicone at rest [m].
    pub least_wall: f64,
    /// Gauge pressure of the leak test [Pa]. Unset: that at which the body works.
    pub leak_test: Option<f64>,
}

impl Default for Casting {
    fn default() -> Self {
        Self { silicone: None, printer: None, waste: 0.2, least_wall: 1e-3, leak_test: None }
    }
}

impl Casting {
    /// Whether the names are known and the numbers can be.
    ///
    /// # Errors
    /// The key, what it is, and what it may be.
    pub fn check(&self) -> Result<(), String> {
        let name = |key: &str, message| format!("casting.{key}: {message}");
        if let Some(key) = &self.silicone {
            silicone::find(key).map_err(|message| name("silicone", message))?;
        }
        if let Some(key) = &self.printer {
            printer::find(key).map_err(|message| name("printer", message))?;
        }
        if !(0.0..=10.0).contains(&self.waste) {
            return Err(format!("casting.waste is {}, must lie between 0 and 10", self.waste));
        }
        if !(self.least_wall > 0.0 && self.least_wall < 1.0) {
            let least = self.least_wall;
            return Err(format!("casting.least_wall is {least}, must be above 0 and below 1 m"));
        }
        match self.leak_test {
            Some(pressure) if !(pressure > 0.0 && pressure <= 1e6) => Err(format!(
                "casting.leak_test is {pressure} Pa, must be above 0 and at most 1e6 Pa"
            )),
            _ => Ok(()),
        }
    }
}

impl Config {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read, is not TOML, has an unknown key or a value out of range.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text).with_context(|| path.display().to_string())
    }

    /// Reads and checks the text of a file.
    ///
    /// # Errors
    /// As for [`Config::read`].
    pub fn parse(text: &str) -> Result<Self> {
        let config: Self = toml::from_str(text)?;
        config.check()?;
        Ok(config)
    }

    fn check(&self) -> Result<()> {
        self.casting.check().map_err(anyhow::Error::msg)?;
        let mut lengths = vec![
            ("wall", self.wall),
            ("keys.radius", self.keys.radius),
            ("keys.height", self.keys.height),
            ("keys.clearance", self.keys.clearance),
            ("sprue.radius", self.sprue.radius),
            ("sprue.top_radius", self.sprue.top_radius),
            ("vents.radius", self.vents.radius),
            ("vents.persistence", self.vents.persistence),
            ("core.length", self.core.length),
            ("core.clearance", self.core.clearance),
            ("core.shoulder", self.core.shoulder),
        ];
        let mut directions = vec![("up", self.up)];
        match &self.parting {
            Parting::Plane(plane) => directions.push(("parting.pull", plane.pull)),
            Parting::HeightField(field) => {
                directions.push(("parting.pull", field.pull));
                lengths.push(("parting.cell", field.cell));
                lengths.push(("parting.smoothing", field.smoothing));
                ensure!(
                    field.smoothing <= 50.0 * field.cell,
                    "parting.smoothing is {}, must be at most 50 cells of {} m",
                    field.smoothing,
                    field.cell
                );
                ensure!(
                    (1.0..=89.0).contains(&field.max_slope),
                    "parting.max_slope is {}, must lie between 1 and 89 degrees",
                    field.max_slope
                );
            }
        }
        for (key, length) in lengths {
            ensure!(
                length > 0.0 && length < 1.0,
                "{key} is {length}, must be above 0 and below 1 (lengths are metres)"
            );
        }
        for (key, direction) in directions {
            let Some(d) = direction else { continue };
            let norm = Vec3::from(d).norm();
            ensure!(
                norm.is_finite() && norm > 1e-9,
                "{key} is {d:?}, must be a direction with a length above 0"
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn defaults_are_valid() {
        Config::parse("").unwrap();
        Config::parse("[parting]\nkind = \"plane\"").unwrap();
    }

    #[test]
    fn unknown_keys_are_named_with_the_valid_ones() {
        for text in ["wal = 1", "[parting]\nkind = \"plane\"\ncell = 1", "[keys]\nsize = 1"] {
            let message = format!("{:#}", Config::parse(text).unwrap_err());
            assert!(message.contains("unknown field"), "{message}");
            assert!(message.contains("expected"), "{message}");
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for (text, key) in [
            ("wall = 5", "wall is 5"),
            ("[vents]\nradius = -1e-3", "vents.radius is -0.001"),
            ("up = [0, 0, 0]", "up is"),
            ("[parting]\nkind = \"height-field\"\nmax_slope = 90", "parting.max_slope is 90"),
            ("[parting]\nkind = \"height-field\"\ncell = 1e-6", "parting.smoothing is 0.0016"),
            ("[sprue]\nradius = nan", "sprue.radius is NaN"),
            ("[casting]\nsilicone = \"rubber\"", "known are dragon-skin-10-medium"),
            ("[casting]\nprinter = \"pen\"", "known are bambu-p1s"),
            ("[casting]\nwaste = -1", "casting.waste is -1"),
            ("[casting]\nleak_test = 0", "casting.leak_test is 0 Pa"),
        ] {
            let message = format!("{:#}", Config::parse(text).unwrap_err());
            assert!(message.contains(key), "{message}");
        }
    }
}
