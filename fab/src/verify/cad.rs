//! The mold has the surface of the CAD where the design did not move it, that of the CAD carried along where it did, and
//! that of the tetrahedra as far as those have that of the CAD. The triangles of `model.stl` stand for the faces of the
//! CAD: how far they are from those, as `model.json` says, is added.
//!
//! Where a carried surface is looked for, it is found the other way round than the mold was made: from the vertices of
//! the mesh, where the motion is known, to the CAD.

use std::collections::BTreeSet;
use std::path::Path;

use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::io::{MshFile, read_surface, read_tets, read_text};
use mesh::{SurfaceMesh, TetMesh, Vec3, measure, place_key, topology};
use serde::Deserialize;

use super::closed_mold::ClosedMold;
use super::motion::Motion;
use super::origins::{Origins, boundary_of};
use super::{Line, Status, deviation};
use crate::body::boundary::chambers_of;
use crate::body::source::CastPart;
use crate::config::Casts;
use crate::files::report::MoldReport;

/// Largest distance of the CAD from the mold where nothing moved: half of what filament printers resolve [mm].
const CAD: f64 = 0.05;

/// How much more than at those points a distance may be between them [1]. It is no bound: it was raised from 1.05
/// when a sound body was refused that needs 1.065.
const BETWEEN: f64 = 1.2;

/// Part of how far the motion bends within a facet by which a carried surface may be farther off: its edges are a
/// quarter as long [1].
const BENT: f64 = 0.25;

/// Points of a surface at which distances are measured, besides its vertices.
const SAMPLES: usize = 20_000;

/// The checks of a mold whose cavity has the surface `cavity` [mm], besides that with what was to be cast.
pub fn checks(mold: &ClosedMold, cavity: &SurfaceMesh, origins: &Origins) -> Vec<Line> {
    let report = &mold.report;
    if report.input.part == CastPart::Core {
        return Vec::new();
    }
    let name = "surface: mold to CAD";
    let Some(model) = &origins.model else {
        let needed = "the CAD surface; fab mold --model names it";
        let mut line = Line::new(name, true, "not compared, no CAD is named".into(), needed);
        line.status = Status::Warn;
        return vec![line];
    };
    let compare = || {
        origins.require_unchanged(&report.input)?;
        let (model, chord) = read_model(model)?;
        let groove = report.groove.as_ref().map(|groove| Region::new(&groove.solid().to_surface()));
        let pair = MoldAndCad { mold, cavity, origins, model, chord, groove };
        let mut lines = Vec::new();
        if report.input.surface == Casts::Mesh || origins.modelled.is_some() {
            lines.extend(pair.to_cad(name)?);
        } else if pair.chord > 0.0 {
            // what is cast has the triangles of the model, and is compared with them
            lines.extend(pair.to_cad("surface: mold to faces of CAD")?);
        }
        if report.input.surface == Casts::Carried {
            lines.extend(pair.to_carried()?);
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
    origins: &'a Origins,
    /// The CAD surface [m].
    model: SurfaceMesh,
    /// How far its triangles are from the faces of the CAD, where that is known [m].
    chord: f64,
    /// The groove for a thread, which the CAD does not have [mm].
    groove: Option<Region>,
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

/// What a surface encloses.
struct Region {
    bvh: SurfaceBvh,
    inside: WindingNumber,
}

impl Region {
    fn new(surface: &SurfaceMesh) -> Self {
        Self { bvh: SurfaceBvh::new(surface), inside: WindingNumber::new(surface) }
    }

    /// Whether a point is in it, or beside it.
    fn holds(&self, p: &Vec3) -> bool {
        self.inside.contains(p) || self.bvh.closest(p).distance <= CAD
    }
}

impl MoldAndCad<'_> {
    /// How much larger the mold is than the body, in millimetres for each metre.
    fn scale(&self) -> f64 {
        Vec3::from_fn(|i, _| self.mold.report.design_to_mold[0][i]).norm()
    }

    /// The largest distance of the CAD from the mold where the design did not move it.
    fn to_cad(&self, name: &str) -> Result<Option<Line>, String> {
        let Self { mold, cavity, origins, model, .. } = self;
        let report = &mold.report;
        let read = |path| read_tets(path).map_err(|e| e.to_string());
        let unmoved = match &origins.modelled {
            Some(path) => {
                Some(Unmoved::new(&read(path)?, &read(&origins.design)?.mesh, report, model)?)
            }
            None => None,
        };
        let points = model.vertices.iter().copied().chain(measure::spread(model, SAMPLES));
        let still = points.filter(|p| unmoved.as_ref().is_none_or(|unmoved| unmoved.holds(p)));
        let vertices = still.collect();
        let placed = deviation::placed(SurfaceMesh { vertices, triangles: Vec::new() }, report);
        let bvh = SurfaceBvh::new(cavity);
        let cast = placed.vertices.iter().filter(|p| self.is_cast(p));
        let off = cast.map(|p| bvh.closest(p).distance).reduce(f64::max);
        let Some(off) = off else { return Ok(None) };
        let (chord, limit) = (self.chord * self.scale(), CAD + 2.0 * mold.rounding);
        let mut line = Line::at_most(name, off + chord, limit, "mm");
        line.needed += if unmoved.is_some() { " where nothing moved" } else { "" };
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
        Ok(Some(line))
    }

    /// The largest distance of the CAD from the mold where vertices of the mesh moved: at its point nearest to each, as
    /// far from the design there as it was from the mesh as modelled.
    fn to_carried(&self) -> Result<Option<Line>, String> {
        let Self { mold, cavity, origins, .. } = self;
        let report = &mold.report;
        let Some(motion) = origins.modelled.as_ref().map(|path| Motion::new(path, origins)) else {
            return Ok(None);
        };
        let motion = motion?;
        let vertices = motion.carried(&self.model);
        let placed = deviation::placed(SurfaceMesh { vertices, triangles: Vec::new() }, report);
        let bvh = SurfaceBvh::new(cavity);
        let cast = placed.vertices.iter().filter(|p| self.is_cast(p));
        let off: Vec<(f64, &Vec3)> = cast.map(|p| (bvh.closest(p).distance, p)).collect();
        let farthest = off.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let line = farthest.map(|(distance, at)| {
            let name = "surface: mold to CAD that moved";
            let limit = CAD + BENT * motion.bends() * self.scale() + 2.0 * mold.rounding;
            let mut line = Line::at_most(name, *distance, limit, "mm");
            line.needed += &format!(" at {} vertices of the mesh", off.len());
            line.placed(at)
        });
        Ok(line)
    }

    /// Whether the mold casts the body at a point as it is in the CAD [mm].
    fn is_cast(&self, p: &Vec3) -> bool {
        is_cast(p, &self.mold.report) && self.groove.as_ref().is_none_or(|groove| !groove.holds(p))
    }

    /// The largest distance of the mold from the design, which is off the CAD by the envelope of the mesher, and whose
    /// facets are flat where the motion bends them.
    fn to_design(&self) -> Result<Line, String> {
        let Self { mold, cavity, origins, model, .. } = self;
        let report = &mold.report;
        let modelled = boundary_of(origins.modelled.as_ref().unwrap_or(&origins.design))?;
        let film = deviation::SURFACE + 2.0 * mold.rounding;
        // The whole design, as the part that is cast may be cut off: where a plane grazes a wall, sections of the two differ by far more than the walls.
        let design = origins.whole(report, Casts::Mesh)?;
        let (there, at) =
            deviation::deviation(cavity, &design, film, |p| is_off_section(p, report, film));
        let carried = origins.modelled.as_ref().filter(|_| report.input.surface == Casts::Carried);
        let bends = match carried {
            Some(path) => Motion::new(path, origins)?.bends(),
            None => 0.0,
        };
        let limit = (BETWEEN * apart(&modelled, model) + bends) * self.scale() + film;
        let mut line = Line::at_most("surface: mold to design", there, limit, "mm").placed(&at);
        line.needed += match bends > 0.0 {
            true => ", as the mesh is off the CAD and its facets are flat",
            false => ", as the mesh is off the CAD",
        };
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

/// Walls of a mesh that a design did not move: the outside, and those of chambers.
struct Unmoved {
    still: Option<SurfaceBvh>,
    moved: Option<SurfaceBvh>,
    /// How near to walls that moved others end with their rims [m].
    rim: f64,
}

impl Unmoved {
    fn new(
        modelled: &MshFile,
        design: &TetMesh,
        report: &MoldReport,
        model: &SurfaceMesh,
    ) -> Result<Self, String> {
        let mesh = &modelled.mesh;
        let facets = topology::boundary(mesh).facets;
        let of = chambers_of(mesh, &facets, &modelled.tags, &report.input.chamber);
        let of = of.map_err(|e| e.to_string())?;
        let places: BTreeSet<[u64; 3]> = design.vertices.iter().map(place_key).collect();
        let moves =
            |f: &[usize; 3]| f.iter().any(|&v| !places.contains(&place_key(&mesh.vertices[v])));
        let moved: BTreeSet<Option<usize>> =
            facets.iter().zip(&of).filter(|(f, _)| moves(f)).map(|(_, of)| *of).collect();
        let surface = |wanted: bool| {
            let own = facets.iter().zip(&of).filter(|(_, of)| moved.contains(of) == wanted);
            let triangles = own.map(|(f, _)| *f).collect();
            let surface = SurfaceMesh { vertices: mesh.vertices.clone(), triangles };
            (!surface.triangles.is_empty()).then(|| SurfaceBvh::new(&surface))
        };
        let all = topology::submesh(&mesh.vertices, &facets).0;
        Ok(Self { still: surface(false), moved: surface(true), rim: apart(&all, model) })
    }

    fn holds(&self, p: &Vec3) -> bool {
        let Some(moved) = &self.moved else { return true };
        let Some(still) = &self.still else { return false };
        let away = moved.closest(p).distance;
        away > 2.0 * self.rim && away > still.closest(p).distance
    }
}
