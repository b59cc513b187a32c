//! `mold.toml`: how a body is to be molded.
//!
//! Lengths are metres and directions are those of the design. A key is one row of one file: its type, default, range
//! and meaning ([`program::table`]). An unknown key is an error that lists the valid ones.

pub mod method;

mod casting;
mod core;
pub mod fitting;
mod groove;
mod parting;
mod tables;

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use library::Chemistry;
use program::table;
use program::table::{Range, Table, direction, nested};
use program::{Change, KeyPath, Keys, Misfit, Names, Settings, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use casting::CastingConfig;
pub use core::{CoreConfig, STUB_FLAT, Support};
pub use fitting::FittingConfig;
pub use groove::GrooveConfig;
use method::Method;
pub use parting::{AutoParting, HeightFieldConfig, PartingConfig, PlaneParting};
pub use tables::{FlangeConfig, GluingConfig, KeysConfig, LimitsConfig, SprueConfig, VentsConfig};

/// Gap around a part that slides into another, from a filament printer: 0.2 to 0.4 mm
/// are usual [m].
const CLEARANCE: f64 = 2e-4;

/// A length of a mold.
const LENGTH: Range = Range::above(0.0).below(1.0).unit("m");

/// What the outside of the mold looks like.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutsideShape {
    /// Planes around the part in 26 directions, with flanges.
    Hull,
    /// A box.
    Box,
}

/// Which surface of a body is cast.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Casts {
    /// The surface of the model; chambers that a design moved are those of its tetrahedra.
    Model,
    /// The boundary of its tetrahedra.
    #[default]
    Mesh,
}

impl Casts {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Model => Self::Mesh,
            Self::Mesh => Self::Model,
        }
    }
}

table! {
    /// Everything that can be asked of `fab mold`.
    #[derive(Clone, Debug)]
    pub struct Config {
        /// Tag of the wall of the air chamber; of several chambers a list, in the order in which cores
        /// are numbered; `[]` for a body without one.
        chamber: Names = Names::One("cavity".into()), different;
        /// How the chamber comes into the body: one of the methods above.
        method: Option<Method> = None => "what is measured decides";
        /// Tags of sheets inside the body, such as paper, that are laid in while it is cast: in a
        /// casting that is open on top, and level there.
        layers: Vec<String> = Vec::new() => "none";
        /// Report of `solver simulate`, from the folder of this file: its threads are wound on the casting, as
        /// `cast.html` then says.
        wound: Option<PathBuf> = None => "none";
        /// Mesh of what is cast already and lies in the mold, from the folder of this file: the silicone around it, such
        /// as a skin over a wound core, is what is left to pour.
        around: Option<PathBuf> = None => "none";
        /// Which surface is cast: `"model"`, that of the model which `--model` names, with designed chambers as the
        /// tetrahedra have them; or `"mesh"`, the boundary of the tetrahedra, which is off the model by up to the
        /// mesher's envelope.
        surface: Option<Casts> = None => "that of the model, if there is one";
        /// What decides between methods and partings.
        limits: LimitsConfig = LimitsConfig::default(), nested;
        /// Part of its lengths by which the silicone shrinks when it cures: the mold is larger by
        /// 1/(1 − s) [1].
        shrinkage: Option<f64> = None => "that of a `casting.silicone` that cures with tin, else 0";
        /// Whether pieces carry their names on their flanges.
        labels: bool = true;
        /// Direction that points up while casting; the inlets must face down [1].
        up: Option<[f64; 3]> = None => "away from the inlet", direction;
        /// Least thickness of the mold around the part [m].
        wall: f64 = 5e-3, LENGTH;
        /// Outside of the mold: `"hull"`, planes in 26 directions, or `"box"`.
        outside: OutsideShape = OutsideShape::Hull;
        /// Where the shells separate.
        parting: PartingConfig = PartingConfig::Auto(AutoParting::default()), nested;
        /// Where halves are glued.
        gluing: GluingConfig = GluingConfig::default(), nested;
        /// Rim on which the shells are bolted to each other.
        flange: FlangeConfig = FlangeConfig::default(), nested;
        /// Cones that register one piece on another.
        keys: KeysConfig = KeysConfig::default(), nested;
        /// Channel through which the silicone enters.
        sprue: SprueConfig = SprueConfig::default(), nested;
        /// Channels through which the air leaves.
        vents: VentsConfig = VentsConfig::default(), nested;
        /// Stub that holds the core at its inlet.
        core: CoreConfig = CoreConfig::default(), nested;
        /// The tube that is put into the inlet. Unset: what fits the inlet as it is modelled.
        fitting: Option<FittingConfig> = None, FittingConfig::check;
        /// The groove for the thread of `wound`. Unset: none.
        groove: Option<GrooveConfig> = None, nested;
        /// What is cast, and what the mold is printed on.
        casting: CastingConfig = CastingConfig::default(), nested;
    }
}

/// The rule of names of which none occurs twice.
fn different(key: &KeyPath, names: &Names) -> Result<(), Misfit> {
    let names = names.all();
    match (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        Some(i) => Err(misfit!(key.clone(), " names {:?} twice", names[i])),
        None => Ok(()),
    }
}

impl Config {
    /// Reads and checks a file with changes from outside, or gives the defaults.
    pub fn read(path: Option<&Path>, changes: &[Change]) -> Result<Self> {
        let Some(path) = path else {
            ensure!(changes.is_empty(), "--set changes a key of a file: name it with --config");
            return Self::parse("");
        };
        Settings::read(path, changes, Keys::default())?.checked(Self::of)
    }

    /// Reads and checks the text of a file.
    pub fn parse(text: &str) -> Result<Self> {
        Settings::of_text(text).checked(Self::of)
    }

    fn of(file: &Settings) -> Result<Self> {
        let config: Self = file.parse()?;
        config.check()?;
        Ok(config)
    }

    /// Part of its lengths by which the silicone shrinks [1]. Platinum silicones shrink by
    /// less than a printer resolves.
    pub fn shrinkage(&self) -> f64 {
        let of_silicone = || {
            let facts = self.casting.silicone()?.casting.as_ref()?;
            let percent = facts.shrinkage.filter(|_| facts.chemistry == Chemistry::Tin)?;
            Some(percent / 100.0)
        };
        self.shrinkage.or_else(of_silicone).unwrap_or(0.0)
    }

    /// Density of the silicone that is named, if it is known [kg/m³].
    pub fn density(&self) -> Option<f64> {
        self.casting.silicone()?.density
    }

    /// Gap around keys [m].
    pub fn key_clearance(&self) -> f64 {
        self.keys.clearance.unwrap_or_else(|| self.printer_clearance())
    }

    /// Gap around stubs of cores [m].
    pub fn stub_clearance(&self) -> f64 {
        self.core.clearance.unwrap_or_else(|| self.printer_clearance())
    }

    /// Gap around a part that slides into another: that of the printer, if one is named [m].
    fn printer_clearance(&self) -> f64 {
        self.casting.printer().map_or(CLEARANCE, |printer| printer.clearance * 1e-3)
    }

    fn check(&self) -> Result<()> {
        self.check_ranges(&KeyPath::default())?;
        ensure!(
            self.groove.is_none() || self.wound.is_some(),
            misfit!(
                KeyPath::table("groove"),
                " without wound: name the report of a scene whose [[winding]] lies in the groove"
            )
        );
        let shrinkage = self.shrinkage();
        ensure!(
            (0.0..0.2).contains(&shrinkage),
            misfit!(
                KeyPath::of("shrinkage"),
                " = {shrinkage}: must be at least 0 and below 0.2: a part of lengths, not percent"
            )
        );
        ensure!(
            self.keys.height + self.key_clearance() < self.flange.thickness,
            misfit!(
                KeyPath::table("flange").key("thickness"),
                " = {} m: must exceed keys.height and clearance, {}: the keys would pierce it",
                self.flange.thickness,
                self.keys.height + self.key_clearance()
            )
        );
        if let Some(printer) = self.casting.printer() {
            let least = 1e-3 * printer.least_wall();
            ensure!(
                self.wall >= least,
                misfit!(
                    KeyPath::of("wall"),
                    " = {} m, but two lines of casting.printer {:?} are {least:.1e} m wide: with less the mold \
                     leaks, or is not printed at all",
                    self.wall,
                    printer.name
                )
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
    fn a_wall_of_two_lines_of_the_printer_is_enough() {
        Config::parse("wall = 8e-4\n[casting]\nprinter = \"prusa-mk4\"").unwrap();
        Config::parse("wall = 1e-4\n[casting]\nprinter = \"resin\"").unwrap();
        Config::parse("wall = 1e-4").unwrap();
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for (text, key) in [
            ("wall = 5", "wall = 5 m"),
            ("[vents]\nradius = -1e-3", "[vents]: radius = -0.001 m"),
            ("up = [0, 0, 0]", "up = ["),
            ("[parting]\nkind = \"height-field\"\nmax_slope = 90", "[parting]: max_slope = 90°"),
            ("[parting]\nkind = \"height-field\"\ncell = 1e-6", "[parting]: smoothing = 0.0016"),
            ("[sprue]\nradius = nan", "[sprue]: radius = NaN m"),
            ("[casting]\nsilicone = \"rubber\"", "known are dragon-skin-10-medium"),
            ("[casting]\nprinter = \"pen\"", "known are bambu-p1s"),
            ("wall = 7e-4\n[casting]\nprinter = \"prusa-mk4\"", "wall = 0.0007 m, but two lines"),
            ("[casting]\nwaste = -1", "[casting]: waste = -1"),
            ("[casting]\nleak_test = 0", "[casting]: leak_test = 0 Pa"),
        ] {
            let message = format!("{:#}", Config::parse(text).unwrap_err());
            assert!(message.contains(key), "{message}");
        }
    }
}
