//! The mold has the surface of the CAD, and that of the tetrahedra as far as those have that of the CAD. The triangles of
//! `model.stl` stand for the faces of the CAD: how far they are from those, as `model.json` says, is added.

use std::path::Path;

use mesh::bvh::SurfaceBvh;
use mesh::io::{read_surface, read_text};
use mesh::{SurfaceMesh, Vec3, measure};
use serde::Deserialize;

use super::closed_mold::ClosedMold;
use super::origins::boundary_of;
use super::{Line, Status, deviation};
use crate::body::source::CastPart;
use crate::config::Casts;
use crate::files::report::MoldReport;

/// Largest distance of the CAD from the mold: half of what filament printers resolve [mm].
const CAD: f64 = 0.05;

/// How much more than at those points a distance may be between them [1]. It is no bound: it was raised from 1.05
/// when a sound body was refused that needs 1.065.
const BETWEEN: f64 = 1.2;

/// Points of a surface at which distances are measured, besides its vertices.
const SAMPLES: usize = 20_000;

/// The checks of a mold whose cavity has the surface `cavity` [mm], besides that with what was to be cast.
pub fn checks(mold: &ClosedMold, cavity: &SurfaceMesh) -> Vec<Line> {
    let ClosedMold { report, origins, .. } = mold;
    let name = "surface: mold to CAD";
    let Some(model) = &origins.model else {
        let (found, needed) =
            ("not compared, no CAD is named", "the CAD surface; fab mold --model names it");
        return vec![Line::new(name, false, found.into(), needed).or_warning()];
    };
    let compare = || {
        origins.require_unchanged(&report.input)?;
        let (model, chord) = read_model(model)?;
        let pair = MoldAndCad { mold, cavity, model, chord };
        let mut lines = Vec::new();
        // The CAD has neither what was designed nor a groove.
        if origins.modelled.is_none() && report.groove.is_none() {
            if report.input.surface == Casts::Mesh {
                lines.extend(pair.to_cad(name));
            } else if pair.chord > 0.0 {
                // what is cast has the triangles of the model, and is compared with them
                lines.extend(pair.to_cad("surface: mold to faces of CAD"));
            }
        }
        if report.input.surface != Casts::Mesh {
            lines.push(pair.to_design()?);
        }
        Ok(lines)
    };
    let unreadable = |error: String| {
        vec![Line::new(name, false, error, "the model; give its place with --model, --from")]
    };
    compare().unwrap_or_else(unreadable)
}

/// A mold and the CAD surface that its body was meshed from.
struct MoldAndCad<'a> {
    mold: &'a ClosedMold,
    /// Surface of its cavity [mm].
    cavity: &'a SurfaceMesh,
    /// The CAD surface [m].
    model: SurfaceMesh,
    /// How far its triangles are from the faces of the CAD, where that is known [m].
    chord: f64,
}

/// What is read of the report beside a model.
#[derive(Deserialize)]
struct Modelled {
    triangles: usize,
    chord_error: Option<f64>,
}

/// A CAD surface, and how far it is from its faces, as the report of `cad2fem` beside it says [m].
fn read_model(path: &Path) -> Result<(SurfaceMesh, f64), String> {
    let model = read_surface(path).map_err(|e| e.to_string())?;
    let report = read_text(&path.with_extension("json")).ok();
    let report = report.and_then(|text| serde_json::from_str::<Modelled>(&text).ok());
    let own = report.filter(|report| report.triangles == model.triangles.len());
    Ok((model, own.and_then(|report| report.chord_error).unwrap_or(0.0)))
}

impl MoldAndCad<'_> {
    /// The largest distance of the CAD from the mold.
    fn to_cad(&self, name: &str) -> Option<Line> {
        let Self { mold, cavity, model, .. } = self;
        let report = &mold.report;
        let vertices = model.vertices.iter().copied().chain(measure::spread(model, SAMPLES));
        let points = SurfaceMesh { vertices: vertices.collect(), triangles: Vec::new() };
        let placed = deviation::placed(&points, report);
        let bvh = SurfaceBvh::new(cavity);
        let cast = placed.vertices.iter().filter(|p| is_cast(p, report));
        let off = cast.map(|p| bvh.closest(p).distance).reduce(f64::max)?;
        let (chord, limit) = (self.chord * report.scale(), CAD + 2.0 * mold.rounding);
        let mut line = Line::at_most(name, off + chord, limit, "mm");
        if chord > 0.0 {
            line.needed += &format!(", {chord:.4} mm of it between model.stl and the CAD");
        }
        // The mold has the triangles that were asked for.
        if off <= limit && line.status == Status::Fail {
            line.status = Status::Warn;
            line.needed += ": cad2fem import with a smaller --chord, a smaller simplify of the model, or finer triangles of the script";
        }
        // The boundary of the tetrahedra was asked for.
        if report.input.surface == Casts::Mesh && line.status == Status::Fail {
            line.status = Status::Warn;
            line.needed += "; without surface = \"mesh\" the CAD is cast";
        }
        Some(line)
    }

    /// The largest distance of the mold from the design, which is off the CAD by the envelope of the mesher.
    fn to_design(&self) -> Result<Line, String> {
        let Self { mold, cavity, model, .. } = self;
        let ClosedMold { report, origins, .. } = mold;
        let modelled = boundary_of(origins.modelled.as_ref().unwrap_or(&origins.design))?;
        let film = deviation::SURFACE + 2.0 * mold.rounding;
        // The whole design, as the part that is cast may be cut off: where a plane grazes a wall, sections of the two differ by far more than the walls.
        let design = origins.whole(report, Casts::Mesh)?;
        let (there, at) =
            deviation::deviation(cavity, &design, film, |p| is_off_section(p, report, film));
        let limit = BETWEEN * apart(&modelled, model) * report.scale() + film;
        let mut line = Line::at_most("surface: mold to design", there, limit, "mm").placed(&at);
        line.needed += ", as the mesh is off the CAD";
        Ok(line)
    }
}

/// The largest distance between two surfaces, either way.
fn apart(a: &SurfaceMesh, b: &SurfaceMesh) -> f64 {
    measure::hausdorff(a, b, SAMPLES).max(measure::hausdorff(b, a, SAMPLES))
}

/// Whether a point is on the side that is cast of the plane at which the casting ends, `beyond` it [mm].
fn is_off_section(p: &Vec3, report: &MoldReport, beyond: f64) -> bool {
    match report.input.part {
        CastPart::Above(height) => p.z - height > beyond,
        CastPart::Below(height) => height - p.z > beyond,
        _ => true,
    }
}

/// Whether the mold casts the body at a point, away from its cut and from collars [mm].
fn is_cast(p: &Vec3, report: &MoldReport) -> bool {
    let beyond = is_off_section(p, report, CAD);
    let beside = report.collars.iter().all(|tube| {
        let [base, axis] = [tube.base, tube.axis].map(Vec3::from);
        let along = (p - base).dot(&axis) / axis.norm();
        let across = (p - base - axis.normalize() * along).norm();
        along > axis.norm() + CAD || across > tube.radius + CAD
    });
    beyond && beside
}
