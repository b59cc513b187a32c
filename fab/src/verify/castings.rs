//! The castings of silicone make up the body, whose walls are thick enough.

use std::path::Path;

use geometry::MM;
use mesh::SurfaceMesh;
use mesh::measure::enclosed_volume;

use super::origins::Origins;
use super::{Against, Line, fit, walls};
use crate::body::source::CastPart;
use crate::body::walls::THICKNESS_ROUNDING;
use crate::files::report::MoldReport;
use crate::plan::report::{Entry, PlanReport};

/// Thickness of what may be missing where castings are glued: 6 µm are left out between a chamber
/// and its sheet, and its flat wall is uneven by 2 µm [mm].
const GLUE: f64 = 1e-2;

/// All checks of a plan that divides the body; a casting of the whole is compared with the
/// design itself.
pub fn checks(folder: &Path, plan: &PlanReport, against: &Against) -> Vec<Line> {
    let read = |entry: &Entry| MoldReport::read(&folder.join(&entry.folder)).ok();
    let reports: Vec<MoldReport> = plan.molds.iter().filter_map(read).collect();
    let Some(first) = reports.first() else { return Vec::new() };
    if reports.len() == 1 && first.input.part == CastPart::Whole {
        return Vec::new();
    }
    let origins = Origins::new(folder, &plan.input, against);
    // In the millimetres of each mold, larger by what the silicone shrinks.
    let designs: Result<Vec<SurfaceMesh>, String> =
        reports.iter().map(|report| origins.whole(report, report.input.surface)).collect();
    let designs = match designs {
        Ok(designs) => designs,
        Err(error) => return vec![Line::new("castings: design", false, error, "the design")],
    };
    let design = &designs[0];
    let volume = volume(&reports, &designs);
    let least = (first.casting.least_wall - THICKNESS_ROUNDING) * MM;
    let (cast, beside) = ((design, first.input.surface), origins.beside(first));
    vec![volume, walls::wall_line_with("castings: thinnest wall", cast, beside, least)]
}

/// No two castings are the same, and their volumes add up to that of the design, which is given as it
/// lies in each mold.
fn volume(reports: &[MoldReport], designs: &[SurfaceMesh]) -> Line {
    let name = "castings: volume";
    let piece = |report: &MoldReport| (report.design_to_mold, report.input.part.clone());
    let again = |(i, report): (usize, &MoldReport)| {
        reports[..i].iter().any(|other| piece(other) == piece(report))
    };
    if reports.iter().enumerate().any(again) {
        return Line::new(name, false, "one piece twice".into(), "every piece once");
    }
    let whole = enclosed_volume(&designs[0]);
    let sections = reports.iter().zip(designs).map(|(report, design)| fit::section(design, report));
    let glued = sections.fold(0.0, f64::max);
    let sum: f64 = reports.iter().map(|report| report.cast.volume).sum();
    Line::at_most(name, (sum - whole).abs(), GLUE * glued, "mm³ off the design")
}
