//! The files of a mold, read back and put together.

use std::path::Path;

use mesh::io::read_surface;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, measure};

use super::Line;
use super::origins::Origins;
use crate::files::report::{MoldReport, Role};

/// By how much channels and gaps are taken wider than they were cut [mm].
const WIDER: f64 = 1e-3;

/// Surfaces of a mold in the closed mold's coordinates [mm].
pub struct Files {
    /// The report that `fab mold` wrote.
    pub report: MoldReport,
    /// One per part of the report.
    pub parts: Vec<SurfaceMesh>,
    /// The body that is cast.
    pub cast: SurfaceMesh,
    /// Outside of the closed mold.
    pub outside: SurfaceMesh,
}

/// A part as a solid.
pub struct Body {
    /// The name.
    pub name: String,
    /// The surface of its file, in the closed mold [mm].
    pub surface: SurfaceMesh,
    /// The shape in the closed mold [mm].
    pub solid: Solid,
    /// Volume [mm³].
    pub volume: f64,
    /// Area [mm²].
    pub area: f64,
    /// Direction in which it is demolded [1].
    pub demolding: Vec3,
}

/// A mold put together from its files [mm].
pub struct ClosedMold {
    /// The report that `fab mold` wrote.
    pub report: MoldReport,
    /// Where the files of the body are.
    pub origins: Origins,
    /// Shells, in the order of the report.
    pub shells: Vec<Body>,
    /// Cores.
    pub cores: Vec<Body>,
    /// The body that is cast.
    pub cast: Body,
    /// Lowest and highest corner of all shells.
    pub bounds: (Vec3, Vec3),
    /// Outside of the closed mold.
    pub outside: Body,
    /// Largest displacement of a vertex by the rounding of the files.
    pub rounding: f64,
    /// Outside − shells − cores.
    pub cavity: Solid,
    /// All channels and gaps.
    pub channels: Solid,
}

impl Files {
    /// The surfaces of a report's files in their order: parts as they are printed, then the
    /// cast and the outside.
    pub fn of(report: MoldReport, mut surfaces: Vec<SurfaceMesh>) -> Self {
        let outside = surfaces.pop().expect("a report lists the outside");
        let cast = surfaces.pop().expect("a report lists the cast");
        for (surface, part) in surfaces.iter_mut().zip(&report.parts) {
            let turn = part.turn();
            surface.vertices.iter_mut().for_each(|p| *p = turn * *p);
        }
        Self { report, parts: surfaces, cast, outside }
    }
}

/// Reads the files of a report; none of them if one is missing.
pub fn read(folder: &Path, report: MoldReport) -> (Vec<Line>, Option<Files>) {
    let mut lines = vec![only_listed(folder, &report)];
    let mut surfaces = Vec::new();
    for file in report.files() {
        match read_surface(&folder.join(file)) {
            Ok(surface) => surfaces.push(surface),
            Err(error) => {
                let (name, found) = (format!("{file}: readable"), error.to_string());
                lines.push(Line::new(name, false, found, "a complete STL file"));
            }
        }
    }
    if surfaces.len() < report.files().count() {
        return (lines, None);
    }
    (lines, Some(Files::of(report, surfaces)))
}

/// No STL file lies in the folder that the report does not list.
fn only_listed(folder: &Path, report: &MoldReport) -> Line {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut strangers: Vec<String> = names
        .filter(|name| name.ends_with(".stl") && !report.files().any(|file| file == name))
        .collect();
    strangers.sort();
    let found = match strangers.len() {
        0 => format!("{} listed, 0 others", report.files().count()),
        n => format!("{n} others: {}", strangers.join(", ")),
    };
    Line::new("files", strangers.is_empty(), found, "only the STL files in mold.json")
}

impl ClosedMold {
    /// Puts valid surfaces together.
    ///
    /// # Panics
    /// If a surface is not closed, oriented and manifold.
    pub fn new(files: Files, origins: Origins) -> Self {
        let Files { report, parts, cast, outside } = files;
        let points: Vec<Vec3> = parts.iter().flat_map(|s| s.vertices.iter().copied()).collect();
        let reach = points.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let rounding = 3.0_f64.sqrt() * reach * 2.0_f64.powi(-24);
        let (mut shells, mut cores) = (Vec::new(), Vec::new());
        for (surface, part) in parts.into_iter().zip(&report.parts) {
            let body = Body::new(&part.name, surface, Vec3::from(part.demolding));
            match part.role {
                Role::Shell => shells.push(body),
                Role::Core => cores.push(body),
            }
        }
        let of_shells = shells.iter().flat_map(|shell| &shell.surface.vertices).copied();
        let bounds = measure::bounds(&of_shells.collect::<Vec<_>>());
        let outside = Body::new("outside", outside, Vec3::zeros());
        let solids = shells.iter().chain(&cores);
        let whole = outside.solid.clone();
        let cavity = solids.fold(whole, |rest, body| rest.difference(&body.solid));
        let empty = Solid::cube(&Vec3::zeros(), &Vec3::zeros());
        // A little wider than they were cut, so that rounding leaves no film beside them.
        let wider = report.features.iter().map(|outline| outline.frustum().grown(WIDER).solid());
        let channels = wider.fold(empty, |all, outline| all.union(&outline));
        let cast = Body::new("cast", cast, Vec3::zeros());
        Self { report, origins, shells, cores, cast, bounds, outside, rounding, cavity, channels }
    }

    /// Largest change of a volume with this boundary area by rounding [mm³].
    pub fn volume_rounding(&self, area: f64) -> f64 {
        self.rounding * area
    }

    /// Shells and cores.
    pub fn parts(&self) -> impl Iterator<Item = &Body> {
        self.shells.iter().chain(&self.cores)
    }
}

impl Body {
    fn new(name: &str, surface: SurfaceMesh, demolding: Vec3) -> Self {
        let solid = Solid::from_surface(&surface).expect("the surface was checked");
        let (volume, area) = (measure::enclosed_volume(&surface), measure::area(&surface));
        Self { name: name.into(), surface, solid, volume, area, demolding }
    }
}
