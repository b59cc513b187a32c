//! What is shown of reports. A text is a text here, whatever it says, and what a report does not have is not shown.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use mesh::Vec3;
use mesh::io::read_text;
use program::InputFile;
use reports::{Designed, End, Inputs, OneOrList, Step};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// The report of a simulation.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Run {
    /// How it ended.
    pub status: String,
    /// Number of tetrahedra.
    pub tets: Option<usize>,
    /// Files that it was made from.
    pub inputs: Option<Inputs>,
    /// The scene.
    pub config: Scene,
    /// The state at rest, where forces balance there.
    pub rest: Option<Step>,
    /// Every load step or time step.
    pub steps: Vec<Step>,
    /// The state at the end.
    #[serde(flatten)]
    pub end: Option<End>,
}

/// The report of an optimisation.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Design {
    /// How it ended.
    pub status: Option<String>,
    /// The design at the end.
    #[serde(flatten)]
    pub designed: Option<Designed>,
}

/// A scene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Scene {
    /// Time steps, if there are any.
    pub time: Option<Value>,
    /// Bodies, where there are several.
    pub body: Vec<SceneBody>,
}

/// A body of several in a scene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct SceneBody {
    /// The name.
    pub name: Option<String>,
    /// Where it was moved to [m].
    pub translate: [f64; 3],
}

/// Where a result comes from, as all reports say it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Name and version of the program.
    pub program: Option<String>,
    /// Files of each kind that the solver was given.
    pub inputs: BTreeMap<String, OneOrList<InputFile>>,
    /// The file that another program was given, or files.
    pub input: Option<OneOrList<InputFile>>,
    /// Values that `--set` gave.
    pub set: Vec<String>,
    /// Time of the run [s].
    #[serde(alias = "wall_s_of_this_run")]
    pub wall_s: Option<f64>,
    /// Largest memory in use [MB].
    pub peak_rss_mb: Option<f64>,
}

impl Provenance {
    /// All files that the result was made from.
    pub fn files(&self) -> impl Iterator<Item = &InputFile> {
        self.inputs.values().chain(&self.input).flat_map(OneOrList::all)
    }
}

/// A plan of molds.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Plan {
    /// The method.
    pub method: String,
    /// Why, with numbers.
    pub reason: String,
    /// The body.
    pub input: Option<InputFile>,
    /// The thinnest wall of the body, if it was measured.
    pub wall: Option<ThinnestWall>,
    /// The molds.
    pub molds: Vec<Entry>,
    /// What to do with the castings, in order.
    #[serde(default)]
    pub steps: Vec<String>,
}

/// The thinnest wall of a body.
#[derive(Clone, Debug, Deserialize)]
pub struct ThinnestWall {
    /// How thick it is [mm].
    pub thickness: f64,
    /// Where it begins, in the design [mm].
    pub at: [f64; 3],
}

/// A mold of a plan.
#[derive(Clone, Debug, Deserialize)]
pub struct Entry {
    /// The folder, relative to that of the plan.
    pub folder: String,
}

/// The sheet for casting.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct CastSheet {
    /// The silicone, if one is named.
    pub silicone: Option<CastSilicone>,
    /// What can go wrong.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// What to do, in order.
    #[serde(default)]
    pub steps: Vec<String>,
}

/// A silicone to mix.
#[derive(Clone, Debug, Deserialize)]
pub struct CastSilicone {
    /// The name.
    pub name: String,
    /// How much [g].
    pub mass_g: f64,
}

/// A mold.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Mold {
    /// The method.
    pub method: String,
    /// The body.
    pub input: Option<InputFile>,
    /// From the design [m] to the mold [mm]: three rows of (s R | t).
    pub design_to_mold: Option<[[f64; 4]; 3]>,
    /// Printed parts.
    pub parts: Vec<MoldPart>,
}

/// A printed part.
#[derive(Clone, Debug, Deserialize)]
pub struct MoldPart {
    /// The name.
    pub name: String,
}

impl Mold {
    /// Where a place of the design [m] is in the mold [mm].
    pub fn in_mold(&self, place: &Vec3) -> Option<Vec3> {
        let row = |[x, y, z, shift]: [f64; 4]| Vec3::new(x, y, z).dot(place) + shift;
        Some(Vec3::from(self.design_to_mold?.map(row)))
    }
}

/// The report of a surface in regions, `model.json`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Model {
    /// The file that was modelled.
    pub input: Option<InputFile>,
    /// Regions of the surface.
    pub regions: Vec<Region>,
    /// Surfaces inside the body.
    pub inside: Vec<Region>,
    /// Regions that meet without an edge, where CAD says so.
    pub tangent: Option<Vec<[String; 2]>>,
    /// What it was imported from, if it was.
    pub import: Imported,
}

/// A region of a surface, or a surface inside the body.
#[derive(Clone, Debug, Deserialize)]
pub struct Region {
    /// The name of its file in `patches`, without extension.
    pub name: String,
    /// What its faces are, such as `plane`, where CAD says so.
    pub kind: Option<String>,
}

/// What a surface was imported from.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Imported {
    /// Angle at which faces of files of triangles end [deg], if they were parted.
    pub split: Option<f64>,
    /// The files.
    pub files: Vec<InputFile>,
}

impl Model {
    /// Reads the report in a folder that `cad2fem model` or `cad2fem import` wrote.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("model.json");
        ensure!(
            path.is_file(),
            "{}: there is no model.json; a folder is needed that `cad2fem model` or `cad2fem import` has written",
            folder.display()
        );
        let model: Self = read(&path)?;
        ensure!(!model.regions.is_empty(), "{}: model.json has no regions", folder.display());
        Ok(model)
    }
}

/// Reads a report.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = read_text(path)?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

impl Design {
    /// Reads the report in a folder, if it is there: an optimisation that still runs has none.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("report.json");
        if path.exists() { read(&path) } else { Ok(Self::default()) }
    }
}

/// Reads a file with one JSON value per line.
pub fn read_lines<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    let text = read_text(path)?;
    let parsed = |(i, line)| {
        serde_json::from_str(line).with_context(|| format!("{}: line {}", path.display(), i + 1))
    };
    text.lines().enumerate().map(parsed).collect()
}
