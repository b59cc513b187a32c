//! `mold.json`: what was made, in millimetres, for the person who casts and for `fab verify`.

use std::path::{Component, Path};

use anyhow::Result;
use geometry::frame::{Frame, Turn};
use geometry::frustum::Frustum;
use geometry::overhang::{CUSTOMARY, Overhangs};
use geometry::{MM, Triple};
use mesh::io::IoError;
use mesh::measure::{area, bounds, enclosed_volume};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};
use nalgebra::Matrix3;
use program::write_json;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::collar::FittedTube;
use crate::body::groove::Groove;
use crate::body::layer::LaidIn;
use crate::body::source::Input;
use crate::body::thread::Thread;
use crate::body::weight::Weight;
use crate::config::method::Method;
use crate::config::{CastingConfig, Config};
use crate::mold::holding::Holding;
use crate::mold::{Feature, Mold, Piece, Purpose};

/// Name of the report in the folder of a mold.
pub const FILE: &str = "mold.json";

/// Name of the file with the body that is cast.
pub const CAST: &str = "reference/cast.stl";

/// Name of the file with the outside of the closed mold.
pub const OUTSIDE: &str = "reference/outside.stl";

/// The content of mold.json.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MoldReport {
    /// Program and version.
    pub program: String,
    /// Unit of every length in this file and in the STL files.
    pub units: String,
    /// The body.
    pub input: Input,
    /// From the design [m] to the mold [mm]: three rows of (s R | t).
    pub design_to_mold: [[f64; 4]; 3],
    /// Bounds of the closed mold.
    pub block: Bounds,
    /// File with the outside of the closed mold as a solid: parts, cast, channels and gaps fill it.
    pub outside: String,
    /// Volume of the box that the outside replaces, less the outside [mm³].
    pub plastic_saved: f64,
    /// Whether it is cast open: the top of the cast is at the top of the mold, without sprue.
    pub open: bool,
    /// Least thickness of the mold around the part [mm].
    pub wall: f64,
    /// How the chamber comes into the body.
    pub method: Method,
    /// Tags of the chambers, in the order of their cores.
    pub chambers: Vec<String>,
    /// Whether each core fits into its socket one way only.
    pub one_way: bool,
    /// How each core is held that stands on a stub.
    pub holds: Vec<Holding>,
    /// Printed parts; taken apart in reverse order.
    pub parts: Vec<Part>,
    /// What is cast.
    pub cast: Cast,
    /// The silicone, and how it is cast.
    pub casting: CastingConfig,
    /// Collars for tubes, which are cast and are not part of the design.
    pub collars: Vec<FittedTube>,
    /// Sheets that are laid in, from below.
    pub layers: Vec<LaidIn>,
    /// Threads that are wound on the casting.
    pub threads: Vec<Thread>,
    /// The groove for them, which is not part of the design.
    pub groove: Option<Groove>,
    /// Channels and gaps.
    pub features: Vec<Outline>,
    /// What a person should know.
    pub findings: Vec<Note>,
}

/// An axis-aligned box.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lowest corner [mm].
    pub min: Triple,
    /// Highest corner [mm].
    pub max: Triple,
}

/// A printed part.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The name.
    pub name: String,
    /// The file.
    pub file: String,
    /// What it does.
    pub role: Role,
    /// Rotation from the file, which has +z up on the printer, to the closed mold [1].
    pub to_mold: [Triple; 3],
    /// Direction in which it is demolded [1].
    pub demolding: Triple,
    /// Volume of the written surface [mm³].
    pub volume: f64,
    /// Area of the written surface [mm²].
    pub area: f64,
    /// Area on the printer's bed [mm²].
    pub bed: f64,
    /// Area that hangs over beyond what is printed without support [mm²].
    pub overhang: f64,
    /// Height as it is printed [mm].
    pub height: f64,
    /// Triangles of the written surface.
    pub triangles: usize,
    /// Handles of the solid before its coordinates were rounded.
    pub genus: i32,
}

impl Part {
    /// The rotation from its file to the closed mold.
    pub fn turn(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.to_mold[i][j])
    }
}

/// What a part does.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Shapes the outside.
    Shell,
    /// Shapes the chamber.
    Core,
}

/// What is cast.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cast {
    /// The file, in the closed mold.
    pub file: String,
    /// Volume of the body [mm³].
    pub volume: f64,
    /// Handles of the solid before its coordinates were rounded.
    pub genus: i32,
    /// What is cast already and lies in the mold [mL].
    pub inside_ml: f64,
    /// Silicone to fill the rest of the mold with its sprue and vents, without waste [mL].
    pub silicone_ml: f64,
    /// Area of the walls of its chambers [mm²].
    pub chamber_area: f64,
    /// What it weighs, if the density of its silicone is known.
    pub weight: Option<Weight>,
}

/// The outline of a channel or gap: a frustum.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Outline {
    /// What it is for.
    pub purpose: Purpose,
    /// Centre of the base [mm].
    pub base: Triple,
    /// From there to the centre of the top [mm].
    pub axis: Triple,
    /// Radius of the base [mm].
    pub base_radius: f64,
    /// Radius of the top [mm].
    pub top_radius: f64,
}

impl Outline {
    /// The frustum [mm].
    pub fn frustum(&self) -> Frustum {
        Frustum {
            base: Vec3::from(self.base),
            axis: Vec3::from(self.axis),
            base_radius: self.base_radius,
            top_radius: self.top_radius,
        }
    }

    /// The frustum as it was cut [mm].
    pub fn exact(&self) -> Solid {
        self.frustum().solid()
    }
}

/// A finding.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// The kind.
    pub rule: String,
    /// In words, with numbers.
    pub message: String,
    /// How many times.
    pub count: usize,
}

impl MoldReport {
    /// The report of a mold whose parts are still to be added.
    pub fn new(mold: &Mold, input: Input, config: &Config, cast: &SurfaceMesh) -> Self {
        let volume = enclosed_volume(cast);
        let (low, high) = mold.outside.bounds();
        let outside = mold.outside.difference(&mold.cast);
        let channels: f64 = mold
            .features
            .iter()
            .filter(|f| matches!(f.purpose, Purpose::Sprue | Purpose::Vent))
            .map(|f| f.frustum.solid().intersection(&outside).volume() * MM.powi(3))
            .sum();
        let chamber_area = mold.chamber_area * MM.powi(2);
        // Cured, it has shrunk to the size of the design.
        let cured = 1.0 / mold.frame.scale;
        let plugs = mold.holds.iter().map(|hold| hold.plugs).sum::<f64>();
        let density = config.density();
        let weight = density.map(|density| {
            let volume = volume + plugs;
            Weight::new(volume * cured.powi(3), chamber_area * cured.powi(2), density)
        });
        Self {
            program: format!("fab {}", env!("CARGO_PKG_VERSION")),
            units: "mm".into(),
            design_to_mold: in_millimetres(&mold.frame),
            input,
            block: Bounds { min: millimetres(&low), max: millimetres(&high) },
            outside: OUTSIDE.into(),
            open: mold.open,
            plastic_saved: mold.saved() * MM.powi(3),
            wall: config.wall * MM,
            method: mold.method,
            chambers: mold.chambers.clone(),
            one_way: mold.one_way,
            holds: mold.holds.clone(),
            parts: Vec::new(),
            cast: Cast {
                file: CAST.into(),
                volume,
                genus: handles(&mold.cast),
                inside_ml: 0.0,
                silicone_ml: (volume + channels) / 1e3,
                chamber_area,
                weight,
            },
            casting: config.casting.clone(),
            collars: Vec::new(),
            layers: Vec::new(),
            threads: Vec::new(),
            groove: None,
            features: mold.features.iter().map(outline).collect(),
            findings: mold
                .findings
                .iter()
                .map(|f| Note { rule: f.rule.into(), message: f.message.clone(), count: f.count })
                .collect(),
        }
    }

    /// Adds a part written as `surface` after `turn`.
    pub fn add_part(&mut self, piece: &Piece, role: Role, turn: Turn, surface: &SurfaceMesh) {
        let below = Overhangs::new(surface, self.steepest(), |_| false);
        let (low, high) = bounds(&surface.vertices);
        self.parts.push(Part {
            name: piece.name.clone(),
            file: format!("{}.stl", piece.name),
            role,
            to_mold: rows(&turn.inverse().0),
            demolding: piece.demolding.into(),
            volume: enclosed_volume(surface),
            area: area(surface),
            bed: below.bed,
            overhang: below.hanging,
            height: high.z - low.z,
            triangles: surface.triangles.len(),
            genus: handles(&piece.solid),
        });
    }

    /// The steepest overhang that the named printer prints without support, from the
    /// vertical [degrees].
    fn steepest(&self) -> f64 {
        self.casting.printer().map_or(CUSTOMARY, |printer| printer.overhang)
    }

    /// Reads the report of the mold in `folder`.
    pub fn read(folder: &Path) -> Result<Self, IoError> {
        let path = folder.join(FILE);
        let text = mesh::io::read_own_text(&path)?;
        let report: Self =
            serde_json::from_str(&text).map_err(|e| IoError::content(&path, e.to_string()))?;
        let plain =
            |file: &&str| Path::new(file).components().all(|c| matches!(c, Component::Normal(_)));
        if let Some(file) = report.files().find(|file| !plain(file)) {
            let message = format!("lists {file:?}; files must lie in its own folder");
            return Err(IoError::content(&path, message));
        }
        Ok(report)
    }

    /// Millimetres of the mold per metre of the design [mm/m].
    pub fn scale(&self) -> f64 {
        let m = Matrix3::from_fn(|i, j| self.design_to_mold[i][j]);
        m.determinant().abs().cbrt()
    }

    /// Channels and gaps of a kind.
    pub fn outlines(&self, purpose: Purpose) -> impl Iterator<Item = &Outline> {
        self.features.iter().filter(move |outline| outline.purpose == purpose)
    }

    /// Writes the report into `folder`.
    pub fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(FILE), self)
    }

    /// Files other than the report, relative to its folder: those of the parts, the cast
    /// and the outside.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let references = [self.cast.file.as_str(), self.outside.as_str()];
        self.parts.iter().map(|p| p.file.as_str()).chain(references)
    }
}

/// Handles of the largest body: Booleans can leave films beside it, without volume, that
/// rounding removes.
fn handles(solid: &Solid) -> i32 {
    solid.decompose().first().map_or(0, Solid::genus)
}

fn outline(feature: &Feature) -> Outline {
    Outline {
        purpose: feature.purpose,
        base: millimetres(&feature.frustum.base),
        axis: millimetres(&feature.frustum.axis),
        base_radius: feature.frustum.base_radius * MM,
        top_radius: feature.frustum.top_radius * MM,
    }
}

/// The map of a frame from metres to millimetres.
fn in_millimetres(frame: &Frame) -> [[f64; 4]; 3] {
    let shift = -(frame.rotation * frame.origin) * frame.scale * MM;
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match j {
            0..3 => frame.rotation[(i, j)] * frame.scale * MM,
            _ => shift[i],
        })
    })
}

fn rows(m: &Matrix3<f64>) -> [Triple; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)] + 0.0))
}

fn millimetres(p: &Vec3) -> Triple {
    (p * MM).map(|x| x + 0.0).into()
}
