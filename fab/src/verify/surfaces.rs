//! Every written surface is valid and in one piece.

use mesh::check::{self, CHECKS};
use mesh::{SurfaceMesh, topology};

use super::Line;
use super::closed_mold::Files;

/// Name of the body among the surfaces.
const CAST: &str = "cast";

/// The rules of [`mesh::check`], the number of pieces and the numbers of the report.
pub fn checks(files: &Files) -> Vec<Line> {
    let Files { report, parts, cast, outside } = files;
    let reported = report.parts.iter().map(|part| (part.name.as_str(), part.genus, part.volume));
    let reported = reported.chain([(CAST, report.cast.genus, report.cast.volume)]);
    let all: Vec<_> = reported.zip(parts.iter().chain([cast])).collect();
    let mut lines: Vec<Line> = Vec::new();
    let surfaces = all.iter().map(|((name, ..), surface)| (*name, *surface));
    lines.extend(surfaces.chain([("outside", outside)]).flat_map(|(name, s)| valid(name, s)));
    lines.extend(all.iter().map(|((name, genus, _), surface)| handles(name, surface, *genus)));
    lines
        .extend(all.iter().map(|((name, _, volume), surface)| as_reported(name, surface, *volume)));
    lines
}

fn valid(name: &str, surface: &SurfaceMesh) -> Vec<Line> {
    // The reader has already refused coordinates that are not finite.
    let mut lines: Vec<Line> = CHECKS
        .iter()
        .filter(|rule| rule.name != "finite")
        .map(|rule| {
            let findings = check::run(surface, &[rule.name]);
            let count: usize = findings.iter().map(|f| f.count).sum();
            let found = match findings.first() {
                // The rules speak of metres, the files are in millimetres.
                Some(finding) => finding.message.replace(" m³", " mm³"),
                None => format!("{count} offending"),
            };
            Line::new(format!("{name}: {}", rule.name), findings.is_empty(), found, rule.demands)
        })
        .collect();
    let pieces = topology::components(&surface.triangles).len();
    let (name, found) = (format!("{name}: pieces"), format!("{pieces} connected"));
    lines.push(Line::new(name, pieces == 1, found, "1 connected piece, no crumbs"));
    lines
}

/// Handles of a closed surface in one piece: V − E + F = 2 − 2 g, with E = 3 F / 2.
fn genus(surface: &SurfaceMesh) -> f64 {
    let [v, f] = [surface.vertices.len(), surface.triangles.len()].map(|n| n as f64);
    1.0 - (v - f / 2.0) / 2.0
}

/// No hole of the body was opened or closed when it was rounded. In a part it is only a warning:
/// rounding may remove a film thinner than a micrometre that closed a hole, and a hole through a
/// part that matters is found as a leak.
fn handles(name: &str, surface: &SurfaceMesh, reported: i32) -> Line {
    let found = genus(surface);
    let holds = found == f64::from(reported);
    let needed = format!("genus {reported}, as before rounding");
    let line = Line::new(format!("{name}: genus"), holds, format!("genus {found}"), &needed);
    if name == CAST { line } else { line.or_warning() }
}

/// The surface has the volume that was reported when it was written.
fn as_reported(name: &str, surface: &SurfaceMesh, reported: f64) -> Line {
    // Summed in the same order over the same triangles, but turned, which may
    // exchange the products in a determinant: rounding only.
    const VOLUME_ROUNDING: f64 = 1e-12;
    let volume = mesh::measure::enclosed_volume(surface);
    let holds = (volume - reported).abs() <= VOLUME_ROUNDING * reported;
    let needed = format!("{reported:.4} mm³ as reported");
    Line::new(format!("{name}: volume"), holds, format!("{volume:.4} mm³"), &needed)
}
