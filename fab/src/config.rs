//! `mold.toml`: how a body is to be molded.
//!
//! Lengths are metres and directions are those of the design; every key has a
//! default, an unknown key is an error that lists the valid ones.

pub mod fitting;
mod parting;
mod pour;

use std::path::Path;

use anyhow::{Result, ensure};
use library::{Chemistry, printers, silicones};
use mesh::Vec3;
use program::{parse_toml, read_checked};
use serde::{Deserialize, Deserializer, Serialize};

use crate::method::Method;
pub use fitting::Fitting;
pub use parting::{Auto, HeightField, Parting, Plane};
pub use pour::{Sprue, Vents};

/// Gap around a part that slides into another, from a filament printer: 0.2 to 0.4 mm
/// are usual [m].
const CLEARANCE: f64 = 2e-4;

/// Everything `fab mold` can be told.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Tag of the wall of the air cavity.
    pub cavity: String,
    /// How the cavity comes into the body. `"auto"`: what the measures allow.
    #[serde(deserialize_with = "method_or_auto")]
    pub method: Option<Method>,
    /// What decides between methods and partings.
    pub limits: Limits,
    /// Part of its lengths by which the silicone shrinks when it cures: the mold is larger by
    /// 1/(1 − s). Unset: that of the silicone that is named, if it cures with tin [1].
    pub shrinkage: Option<f64>,
    /// Whether pieces carry their names.
    pub labels: bool,
    /// Direction that points up while casting; the inlet must face down. Unset: away from the inlet [1].
    pub up: Option<[f64; 3]>,
    /// Least thickness of the mold around the part [m].
    pub wall: f64,
    /// Outside of the mold.
    pub outside: OutsideShape,
    /// Where the shells separate.
    pub parting: Parting,
    /// Where halves are glued.
    pub gluing: Gluing,
    /// Rim on which the shells are bolted to each other.
    pub flange: Flange,
    /// Cones that register one piece on another.
    pub keys: Keys,
    /// Funnel through which the silicone enters.
    pub sprue: Sprue,
    /// Channels through which the air leaves.
    pub vents: Vents,
    /// Stub that holds the core at its inlet.
    pub core: Core,
    /// The tube that is put into the inlet. Unset: what fits the inlet as it is modelled.
    pub fitting: Option<Fitting>,
    /// What is cast, and what the mold is printed on.
    pub casting: Casting,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            cavity: "cavity".into(),
            method: None,
            limits: Limits::default(),
            shrinkage: None,
            labels: true,
            up: None,
            wall: 5e-3,
            outside: OutsideShape::Hull,
            parting: Parting::Auto(Auto::default()),
            gluing: Gluing::default(),
            flange: Flange::default(),
            keys: Keys::default(),
            sprue: Sprue::default(),
            vents: Vents::default(),
            core: Core::default(),
            fitting: None,
            casting: Casting::default(),
        }
    }
}

fn method_or_auto<'de, D: Deserializer<'de>>(input: D) -> Result<Option<Method>, D::Error> {
    let name = String::deserialize(input)?;
    let found = Method::ALL.into_iter().find(|method| method.name() == name);
    if found.is_some() || name == "auto" {
        return Ok(found);
    }
    let names = Method::ALL.map(|method| format!("{:?}", method.name())).join(", ");
    Err(serde::de::Error::custom(format!("method is {name:?}, must be \"auto\" or one of {names}")))
}

/// Limits on measures. All are judgements from practice, not measurements.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Largest girth of a rigid core over that of its inlet: how far the inlet must stretch [1].
    pub girth: f64,
    /// Largest depth of an undercut over the width of the silicone that must give way [1].
    pub peel: f64,
    /// Least part of the cavity's outline that must lie flat on a plane for an open-top mold [1].
    pub flat: f64,
    /// Largest motion of the far end of a core that is not pointed out [m].
    pub sag: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { girth: 2.5, peel: 0.5, flat: 0.8, sag: 5e-4 }
    }
}

/// What the outside of the mold looks like.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum OutsideShape {
    /// Planes around the part in 26 directions, with flanges.
    Hull,
    /// A box.
    Box,
}

/// Where halves are glued.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gluing {
    /// Normal of the plane. Unset: searched [1].
    pub normal: Option<[f64; 3]>,
    /// Position of the plane along its normal, in the design's coordinates. Unset: searched [m].
    pub offset: Option<f64>,
}

/// The rim on which shells are bolted.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Flange {
    /// Thickness on each side of the parting [m].
    pub thickness: f64,
    /// Radius of the bolt holes: 1.7 mm for M3 [m].
    pub bolt: f64,
    /// Radius of the half-round slots for a screwdriver [m].
    pub pry: f64,
}

impl Default for Flange {
    fn default() -> Self {
        Self { thickness: 6e-3, bolt: 1.7e-3, pry: 2e-3 }
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
    /// Gap between a key and its seat. Unset: the printer's [m].
    pub clearance: Option<f64>,
}

impl Default for Keys {
    fn default() -> Self {
        Self { radius: 3e-3, height: 3e-3, clearance: None }
    }
}

/// The core print: a stub below the inlet, in a socket of the piece below.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Core {
    /// Length of the stub, and thickness of the mold below the part [m].
    pub length: f64,
    /// Gap between stub and socket. Unset: the printer's [m].
    pub clearance: Option<f64>,
    /// Width of the shoulder around the socket on which the core rests [m].
    pub shoulder: f64,
    /// Whether a pin holds the far end, too.
    pub support: Support,
    /// Radius of that pin [m].
    pub pin: f64,
    /// Radius of the bore for water in a soluble core [m].
    pub drain: f64,
    /// Least thickness of a soluble core around its bore [m].
    pub skin: f64,
}

/// Whether a core is held at a second place.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Support {
    /// By a pin if its neck bends more than `limits.sag`.
    Auto,
    /// By a pin.
    Pin,
    /// By its stub alone.
    Stub,
}

impl Default for Core {
    fn default() -> Self {
        Self {
            length: 8e-3,
            clearance: None,
            shoulder: 1e-4,
            support: Support::Auto,
            pin: 1e-3,
            drain: 6e-4,
            skin: 8e-4,
        }
    }
}

/// What is cast, and what the mold is printed on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Casting {
    /// A silicone of `silicones.toml` of the crate `library`. Unset: volumes only.
    pub silicone: Option<String>,
    /// A printer of `printers.toml` of the crate `library`. Unset: no build volume is checked.
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
            silicones().find(key).map_err(|message| name("silicone", message))?;
        }
        if let Some(key) = &self.printer {
            printers().find(key).map_err(|message| name("printer", message))?;
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
        read_checked(path, Self::parse)
    }

    /// Reads and checks the text of a file.
    ///
    /// # Errors
    /// As for [`Config::read`].
    pub fn parse(text: &str) -> Result<Self> {
        let config: Self = parse_toml(text)?;
        config.check()?;
        Ok(config)
    }

    /// Part of its lengths by which the silicone shrinks [1]. Platinum silicones shrink by
    /// less than a printer resolves.
    #[must_use]
    pub fn shrinkage(&self) -> f64 {
        let of_silicone = || {
            let silicone = silicones().find(self.casting.silicone.as_deref()?).ok()?;
            let facts =
                silicone.casting.as_ref().filter(|facts| facts.chemistry == Chemistry::Tin)?;
            facts.shrinkage.map(|percent| percent / 100.0)
        };
        self.shrinkage.or_else(of_silicone).unwrap_or(0.0)
    }

    /// Density of the silicone that is named, if it is known [kg/m³].
    #[must_use]
    pub fn density(&self) -> Option<f64> {
        silicones().find(self.casting.silicone.as_deref()?).ok()?.density
    }

    /// Gap around keys [m].
    #[must_use]
    pub fn key_clearance(&self) -> f64 {
        self.keys.clearance.unwrap_or_else(|| self.printer_clearance())
    }

    /// Gap around stubs of cores [m].
    #[must_use]
    pub fn stub_clearance(&self) -> f64 {
        self.core.clearance.unwrap_or_else(|| self.printer_clearance())
    }

    /// Gap around a part that slides into another: that of the printer, if one is named [m].
    fn printer_clearance(&self) -> f64 {
        let named = self.casting.printer.as_deref().and_then(|key| printers().find(key).ok());
        named.map_or(CLEARANCE, |printer| printer.clearance * 1e-3)
    }

    fn check(&self) -> Result<()> {
        self.casting.check().map_err(anyhow::Error::msg)?;
        self.sprue.check().map_err(anyhow::Error::msg)?;
        self.fitting.as_ref().map_or(Ok(()), Fitting::check).map_err(anyhow::Error::msg)?;
        let Limits { girth, peel, flat, sag } = self.limits;
        let mut lengths = vec![
            ("wall", self.wall),
            ("keys.radius", self.keys.radius),
            ("keys.height", self.keys.height),
            ("keys.clearance", self.key_clearance()),
            ("flange.thickness", self.flange.thickness),
            ("flange.bolt", self.flange.bolt),
            ("flange.pry", self.flange.pry),
            ("sprue.radius", self.sprue.radius),
            ("sprue.top_radius", self.sprue.top_radius),
            ("vents.radius", self.vents.radius),
            ("vents.persistence", self.vents.persistence),
            ("core.length", self.core.length),
            ("core.clearance", self.stub_clearance()),
            ("core.shoulder", self.core.shoulder),
            ("core.pin", self.core.pin),
            ("core.drain", self.core.drain),
            ("core.skin", self.core.skin),
            ("limits.sag", sag),
        ];
        let mut directions = vec![("up", self.up), ("gluing.normal", self.gluing.normal)];
        for (key, limit) in [("girth", girth), ("peel", peel), ("flat", flat)] {
            ensure!(
                limit > 0.0 && limit.is_finite(),
                "limits.{key} is {limit}, must be a ratio above 0"
            );
        }
        let shrinkage = self.shrinkage();
        ensure!(
            (0.0..0.2).contains(&shrinkage),
            "shrinkage is {shrinkage}, must be at least 0 and below 0.2: a part of lengths, not percent"
        );
        ensure!(
            self.keys.height + self.key_clearance() < self.flange.thickness,
            "flange.thickness is {}, must exceed keys.height and clearance, {}: the keys would pierce it",
            self.flange.thickness,
            self.keys.height + self.key_clearance()
        );
        match &self.parting {
            Parting::Auto(auto) => directions.push(("parting.pull", auto.pull)),
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
            ("[sprue]\nhead = 20", "sprue.head is 20"),
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
