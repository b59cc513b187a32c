//! Walls are thick enough: of the mold, and of the silicone at rest and inflated, as
//! [`mesh::walls`] measures them.

use std::path::Path;

use geometry::MM;
use library::Printer;
use mesh::bvh::SurfaceBvh;
use mesh::io::vtu::read_vtu;
use mesh::{SurfaceMesh, TetMesh, Vec3, topology};
use program::InputFile;
use reports::OneOrList;
use serde::Deserialize;

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};
use crate::body::source::{CastPart, Input};
use crate::body::walls::{Wall, thinnest};
use crate::config::{CastingConfig, Casts};
use crate::mold::Purpose;

/// Walls thinner than this part of the least at rest are pointed out when inflated: a
/// judgement. Rubber that is stretched twice in both directions has a quarter.
const INFLATED: f64 = 0.25;

/// Checks of the walls as they are cast.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let surface = mold.cast.solid.to_surface();
    let least = mold.report.casting.least_wall * MM - 2.0 * mold.rounding;
    let (input, origins) = (&mold.report.input, &mold.origins);
    let beside = match input.part {
        CastPart::Whole => origins.beside(&mold.report),
        _ => None,
    };
    // Between grooves that cross silicone ends in edges; what is left below a groove is measured beside it.
    let plain = mold.report.groove.as_ref().map(|_| origins.plain(&mold.report, input.surface));
    let plain = plain.and_then(Result::ok);
    let cast = (plain.as_ref().unwrap_or(&surface), input.surface);
    let mut silicone = wall_line_with("silicone: thinnest wall", cast, beside, least);
    if mold.report.input.part != CastPart::Whole && silicone.status == Status::Fail {
        silicone.status = Status::Ok;
        silicone.needed = "any: what the plan cuts in two has a sharp edge, no wall".into();
    }
    let mut lines = vec![mold_walls(mold, &surface), silicone];
    lines.extend(cores(mold));
    lines
}

/// Cores with their bores filled: what is left around a bore is `core.skin`.
fn cores(mold: &ClosedMold) -> Vec<Line> {
    let Some(least) = mold.report.casting.least_core else { return Vec::new() };
    let least = least * MM - 2.0 * mold.rounding;
    let bores: Vec<_> = mold.report.outlines(Purpose::Drain).map(|bore| bore.exact()).collect();
    let one = |core: &Body| {
        let filled = bores.iter().fold(core.solid.clone(), |core, bore| core.union(bore));
        let body = filled.decompose().into_iter().max_by(|a, b| a.volume().total_cmp(&b.volume()));
        let surface = body.unwrap_or(filled).to_surface();
        wall_line(&format!("{}: thinnest", core.name), &surface, least)
    };
    mold.cores.iter().map(one).collect()
}

/// Least distance of the body and of the keys' seats from the outside, and of the seats
/// from the body.
fn mold_walls(mold: &ClosedMold, cast: &SurfaceMesh) -> Line {
    let bvh = SurfaceBvh::new(cast);
    let mut outside = mold.outside.solid.to_surface();
    if mold.report.open {
        // The top of an open mold is no wall.
        let sky = mold.bounds.1.z - mold.rounding;
        let vertices = &outside.vertices;
        outside.triangles.retain(|t| t.iter().any(|&v| vertices[v].z < sky));
    }
    let outside = SurfaceBvh::new(&outside);
    let body = cast.vertices.iter().map(|p| outside.closest(p).distance);
    let body = body.fold(f64::INFINITY, f64::min);
    let keys = mold.report.outlines(Purpose::Key);
    let keys = keys.flat_map(|key| key.exact().to_surface().vertices);
    let beside = keys.map(|p| bvh.closest(&p).distance).fold(f64::INFINITY, f64::min);
    let printed = mold.report.casting.printer().map_or(0.0, Printer::least_wall);
    let least = mold.report.wall.max(printed) - 2.0 * mold.rounding;
    let mut line = Line::at_least("wall: least", body.min(beside), least, "mm");
    if printed > mold.report.wall {
        line.needed += ", two lines of the printer";
    }
    line
}

/// A wall of the least thickness, or a thinner one, with its place in the surface's coordinates.
pub fn wall_line(name: &str, surface: &SurfaceMesh, least: f64) -> Line {
    wall_line_with(name, (surface, Casts::Mesh), None, least)
}

/// A wall as in [`wall_line`], measured on the other one of model and mesh, too, if there is one:
/// the surface or why it cannot be read.
pub fn wall_line_with(
    name: &str,
    cast: (&SurfaceMesh, Casts),
    other: Option<Result<SurfaceMesh, String>>,
    least: f64,
) -> Line {
    let other = match other.transpose() {
        Ok(other) => other,
        Err(error) => {
            return Line::new(name, false, error, "the model; give its place with --model");
        }
    };
    match thinnest(cast, other.as_ref()) {
        Some(Wall { thickness, at, on }) => {
            let mut line = Line::at_least(name, thickness, least, "mm");
            let on = if other.is_some() { format!(" of the {on}") } else { String::new() };
            line.found += &format!("{on} at ({:.1}, {:.1}, {:.1})", at.x, at.y, at.z);
            line
        }
        None => Line::new(name, false, "no wall".into(), "a body with two sides"),
    }
}

/// What is read of the report of `solver simulate`.
#[derive(Deserialize)]
struct Simulated {
    usable: bool,
    inputs: Inputs,
    #[serde(default)]
    steps: Vec<LoadStep>,
    stretch_range: Option<Stretch>,
}

/// A load step of it.
#[derive(Deserialize)]
struct LoadStep {
    smallest_volume_ratio: Option<f64>,
}

/// What was simulated.
#[derive(Deserialize)]
struct Inputs {
    mesh: OneOrList<InputFile>,
}

/// Principal stretches of all elements.
#[derive(Deserialize)]
struct Stretch {
    largest: f64,
}

/// Checks of the walls under the load of a simulation: the folder that `solver simulate`
/// wrote for the body that `design` names, cast as `casting` says.
pub fn inflated(design: &Input, casting: &CastingConfig, folder: &Path) -> Vec<Line> {
    let name = "inflated: result";
    let report = mesh::io::read_text(&folder.join("report.json"))
        .map_err(|e| e.to_string())
        .and_then(|text| serde_json::from_str::<Simulated>(&text).map_err(|e| e.to_string()));
    let grid = read_vtu(&folder.join("result.vtu")).map_err(|e| e.to_string());
    let (report, grid) = match (report, grid) {
        (Ok(report), Ok(grid)) => (report, grid.at_most_quadratic()),
        (Err(error), _) | (_, Err(error)) => {
            return vec![Line::new(name, false, error, "the folder of `solver simulate`")];
        }
    };
    let found = format!("usable: {}", report.usable);
    let mut lines = vec![Line::new(name, report.usable, found, "a result that may be used")];
    let body = same_body(design, &report.inputs.mesh);
    let other = body.status == Status::Fail;
    lines.push(body);
    if other {
        return lines;
    }
    let field = grid.point_fields.iter().find(|f| f.name == "displacement" && f.components == 3);
    let Some(field) = field.filter(|_| grid.cell_type.corners() == 4) else {
        let found = "no displacement of tetrahedra".into();
        lines.push(Line::new("inflated: fields", false, found, "point field displacement"));
        return lines;
    };
    let moved = field.values.chunks_exact(3).zip(&grid.points);
    let vertices = moved.map(|(u, p)| (p + Vec3::new(u[0], u[1], u[2])) * MM).collect();
    let cells = grid.cells.chunks_exact(grid.cell_type.nodes());
    let tets = TetMesh { vertices, tets: cells.map(|c| [c[0], c[1], c[2], c[3]]).collect() };
    let surface = topology::boundary(&tets).surface(&tets).0;
    let least = INFLATED * casting.least_wall * MM;
    lines.push(wall_line("inflated: thinnest wall", &surface, least));
    lines.extend(report.stretch_range.map(|range| stretch(casting, range.largest)));
    lines.extend(report.steps.last().and_then(|step| step.smallest_volume_ratio).map(elements));
    lines
}

/// What was simulated is what is molded.
fn same_body(design: &Input, simulated: &OneOrList<InputFile>) -> Line {
    let meshes = simulated.all();
    let same = meshes.iter().any(|mesh| mesh.sha256 == design.sha256);
    let named = |path: &Path, sha256: &str| {
        format!("{}, sha256 {}", path.display(), sha256.get(..12).unwrap_or(sha256))
    };
    let found: Vec<String> = meshes.iter().map(|mesh| named(&mesh.path, &mesh.sha256)).collect();
    let needed = named(&design.path, &design.sha256);
    Line::new("inflated: body", same, found.join("; "), &format!("the run of {needed}"))
}

/// No element is turned inside out, which a scene may tolerate: walls and stretches are not to be
/// trusted there.
fn elements(ratio: f64) -> Line {
    let found = format!("smallest volume ratio {ratio:.2e}");
    let needed = "more than 0: none inside out";
    Line::new("inflated: elements", ratio > 0.0, found, needed).or_warning()
}

/// The silicone is not stretched beyond what tears it.
fn stretch(casting: &CastingConfig, largest: f64) -> Line {
    let name = "inflated: largest stretch";
    match casting.elongation() {
        Some(elongation) => Line::at_most(name, largest, 1.0 + elongation / 100.0, ""),
        None => {
            let needed = "less than at break; name a silicone whose elongation is known";
            Line::new(name, false, format!("{largest:.2}"), needed).or_warning()
        }
    }
}
