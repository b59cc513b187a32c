//! The plane in which a body is cut in two, so that each half can be demolded.
//!
//! Each half is cast over a plate that carries its half of the core, cut face down.
//! Undercuts of the filled body block the cup, and undercuts of the core hold silicone
//! below the core.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use geometry::undercut::{PartingHeight, View};
use geometry::{extent, gap};
use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::solid::Solid;

use super::pull::plane;
use crate::body::boundary::{Boundary, Inlet};
use crate::config::GluingConfig;

/// Planes that leave up to this much more of an area in undercuts than the best count as
/// equally good: the one along whose normal the body is thinnest is taken [1].
const AS_GOOD: f64 = 5e-3;

/// A body counts as thin along a normal up to this many times its least thickness.
const AS_THIN: f64 = 1.1;

/// A wall is flat where it keeps to a plane this closely [m].
const WALL_FLATNESS: f64 = 2e-6;

/// The chamber is cut this far inside its flat wall, the sheet begins as far outside of
/// it: what is missing between is much thinner than the glue [m].
const ASIDE: f64 = 3e-6;

/// Cosine of the angle up to which facets count as parallel to a plane (2°).
const PARALLEL: f64 = 0.9994;

/// Sine of the angle up to which an inlet slides along the mold outside of it (half a degree).
const SLIDING: f64 = 9e-3;

/// Part of the area of the cores that may be blocked by the mold: facets at inlets.
pub const CAUGHT: f64 = 1e-3;

/// A core is carried by a plate if it reaches at least this far beyond the cut on both sides [m].
const CARRIED: f64 = 1e-3;

/// Flat walls that are considered, largest first.
const WALLS: usize = 8;

/// A plane that cuts the body.
#[derive(Clone, Debug)]
pub struct Cut {
    /// The unit normal [1].
    pub normal: Vec3,
    /// The position along the normal [m].
    pub offset: f64,
    /// Part of the area of the outside that is in undercuts [1].
    pub outside: f64,
    /// Cores that it does not cut, which no plate carries.
    pub missed: usize,
    /// Part of the area of the cores that is in undercuts [1].
    pub core: f64,
    /// Part of the area of the cores from which the straight line to the plane leaves the
    /// body: the mold around it stands there, as in the hole of a ring [1].
    pub caught: f64,
    /// Largest depth over width of the undercuts of the cores [1].
    pub core_ratio: f64,
    /// Area that is glued [m²].
    pub glued: f64,
    /// Thickness of the body along the normal [m].
    pub thickness: f64,
}

impl Cut {
    /// In words, with numbers.
    pub fn describe(&self) -> String {
        format!(
            "{} hides {:.2} % of the outside and {:.2} % of the core, and glues {:.0} mm²",
            plane(&self.normal, self.offset),
            100.0 * self.outside,
            100.0 * self.core,
            self.glued * 1e6
        )
    }
}

/// The plane through the middle of the chamber that leaves least in undercuts, or the one asked for.
/// If that does not free the cores, by an undercut of at most `peel` over its width, the plane
/// that leaves least of those that do.
pub fn best(boundary: &Boundary, gluing: &GluingConfig, normals: &[Vec3], peel: f64) -> Cut {
    let asked = gluing.normal.map(|n| vec![Vec3::from(n).normalize()]);
    let normals = asked.unwrap_or_else(|| normals.to_vec());
    let mut cuts: Vec<Cut> = normals
        .iter()
        .map(|normal| {
            let all = || boundary.cast.vertices.iter().map(|p| p.dot(normal));
            let middle = || gap::clear(all(), middle(boundary, normal));
            let offset = gluing.offset.unwrap_or_else(middle);
            let carried =
                |[low, high]: [f64; 2]| low + CARRIED <= offset && offset <= high - CARRIED;
            let missed = extents(boundary, normal).into_iter().filter(|e| !carried(*e)).count();
            Cut { missed, ..measured(boundary, *normal, offset) }
        })
        .collect();
    let hidden = |cut: &Cut| cut.outside + cut.core + cut.caught + cut.missed as f64;
    let least = cuts.iter().map(hidden).fold(f64::INFINITY, f64::min);
    let good = || cuts.iter().filter(|cut| hidden(cut) <= least + AS_GOOD);
    let thinnest = good().map(|cut| cut.thickness).fold(f64::INFINITY, f64::min);
    let thin = good().find(|cut| cut.thickness <= AS_THIN * thinnest);
    let mut cut = thin.expect("there is a normal").clone();
    cut.core_ratio = ratio(boundary, &cut);
    if cut.missed == 0 && (cut.caught > CAUGHT || cut.core_ratio > peel) {
        cuts.sort_by(|a, b| hidden(a).total_cmp(&hidden(b)));
        let free = cuts.into_iter().filter(|cut| cut.missed == 0 && cut.caught <= CAUGHT);
        let mut measured = free.map(|cut| Cut { core_ratio: ratio(boundary, &cut), ..cut });
        cut = measured.find(|cut| cut.core_ratio <= peel).unwrap_or(cut);
    }
    cut.glued = glued(boundary, &cut);
    cut
}

/// From where to where each core reaches along a normal [m].
fn extents(boundary: &Boundary, normal: &Vec3) -> Vec<[f64; 2]> {
    boundary.cores.iter().map(|core| extent(&core.surface.vertices, normal)).collect()
}

/// The middle of what all cores have in common along a normal, or of all of them if they have nothing in
/// common; of the body if it has no chamber [m].
fn middle(boundary: &Boundary, normal: &Vec3) -> f64 {
    let mut all = extents(boundary, normal);
    if all.is_empty() {
        all.push(extent(&boundary.filled.vertices, normal));
    }
    let fold = |k: usize, pick: fn(f64, f64) -> f64| all.iter().map(|e| e[k]).reduce(pick);
    let [low, high] = [fold(0, f64::max), fold(1, f64::min)].map(|x| x.expect("there is one"));
    let common = low + 2.0 * CARRIED <= high || all.len() == 1;
    match common {
        true => (low + high) / 2.0,
        false => (fold(0, f64::min).unwrap_or(low) + fold(1, f64::max).unwrap_or(high)) / 2.0,
    }
}

/// A flat wall of the chamber: all of it lies on one side of the wall's plane.
#[derive(Clone, Debug)]
pub struct Flat {
    /// The plane that opens the chamber, which is on the side away from its normal.
    pub cut: Cut,
    /// Position of the plane that leaves it closed [m].
    pub beyond: f64,
    /// Area of the wall over the area of the chamber as seen along the normal [1].
    pub share: f64,
}

/// The flat wall that covers most of the chamber's outline, of several chambers one on which all of
/// them stand if there is any.
pub fn flattest(boundary: &Boundary) -> Option<Flat> {
    let flats = walls(boundary).into_iter().map(|normal| {
        let top = boundary.cores.iter().flat_map(|core| &core.surface.vertices);
        let [_, offset] = extent(top, &normal);
        let (mut wall, mut outline) = (0.0, 0.0);
        for core in &boundary.cores {
            outline += View::along(&core.surface, &normal).outline();
            let on_plane = |t: &usize| {
                let corners = core.surface.corners(*t);
                corners.iter().all(|p| offset - p.dot(&normal) <= WALL_FLATNESS)
            };
            let flat = (0..core.surface.triangles.len()).filter(on_plane);
            wall += flat.map(|t| core.surface.area(t)).sum::<f64>();
        }
        let reaches = |[_, high]: &[f64; 2]| offset - high <= WALL_FLATNESS;
        let missed = extents(boundary, &normal).iter().filter(|e| !reaches(e)).count();
        (normal, offset, wall / outline, missed)
    });
    let better = |a: f64, b: f64| a.total_cmp(&b);
    let (normal, offset, share, missed) =
        flats.max_by(|a, b| b.3.cmp(&a.3).then(better(a.2, b.2)))?;
    let mut cut = Cut { missed, ..measured(boundary, normal, offset - ASIDE) };
    cut.core_ratio = ratio(boundary, &cut);
    cut.glued = glued(boundary, &cut);
    Some(Flat { cut, beyond: offset + ASIDE, share })
}

/// Normals of the largest flat walls of the chamber, without its inlets.
pub fn walls(boundary: &Boundary) -> Vec<Vec3> {
    // Normals that round to the same hundredths are one.
    let mut sums: BTreeMap<[i32; 3], Vec3> = BTreeMap::new();
    for core in &boundary.cores {
        for t in 0..core.surface.triangles.len() {
            let [a, b, c] = core.surface.corners(t);
            let normal = (b - a).cross(&(c - a));
            let key: [i32; 3] = normal.normalize().map(|x| (x * 100.0).round() as i32).into();
            *sums.entry(key).or_insert_with(Vec3::zeros) += normal;
        }
    }
    let mut walls: Vec<Vec3> = sums.into_values().collect();
    walls.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    walls.truncate(WALLS);
    let inlets: Vec<Vec3> =
        boundary.cores.iter().flat_map(|core| &core.inlets).map(|inlet| inlet.normal).collect();
    let is_inlet = |n: &Vec3| inlets.iter().any(|inlet| inlet.dot(n) > PARALLEL);
    walls.into_iter().map(|n| snapped(n.normalize())).filter(|n| !is_inlet(n)).collect()
}

/// A coordinate axis if the direction is one to rounding.
fn snapped(n: Vec3) -> Vec3 {
    let k = n.iamax();
    let mut axis = Vec3::zeros();
    axis[k] = n[k].signum();
    if (n - axis).norm() < 1e-6 { axis } else { n }
}

fn measured(boundary: &Boundary, normal: Vec3, offset: f64) -> Cut {
    let plane = PartingHeight::Plane(offset);
    let view = View::along(&boundary.filled, &normal);
    let [low, high] = view.extent();
    let core =
        boundary.cores.iter().map(|core| View::along(&core.surface, &normal).undercut(plane).share);
    Cut {
        normal,
        offset,
        outside: view.undercut(plane).share,
        missed: 0,
        core: core.fold(0.0, f64::max),
        caught: caught(boundary, &normal, offset),
        core_ratio: 0.0,
        glued: 0.0,
        thickness: high - low,
    }
}

/// Part of the cores' area from which the straight line to a plane leaves the body, with the
/// inlets that the mold blocks.
fn caught(boundary: &Boundary, normal: &Vec3, offset: f64) -> f64 {
    let bvh = SurfaceBvh::new(&boundary.filled);
    let (mut sum, mut total) = (0.0, 0.0);
    for core in &boundary.cores {
        for t in 0..core.surface.triangles.len() {
            let from = core.surface.centroid(t);
            let height = offset - from.dot(normal);
            let way = normal * height.signum();
            let leaves = |s: f64| s > WALL_FLATNESS && s < height.abs() - WALL_FLATNESS;
            let area = core.surface.area(t);
            total += area;
            if bvh.ray(&from, &way).iter().any(|hit| leaves(hit.0)) {
                sum += area;
            }
        }
        let inlets = core.inlets.iter().filter(|inlet| blocks(inlet, normal, offset));
        sum += inlets.map(|inlet| PI * inlet.radius.powi(2)).sum::<f64>();
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Whether the mold outside of an inlet holds the core when that leaves along a normal: it lies
/// between the inlet and the plane if the inlet faces the plane, or is cut by it obliquely.
fn blocks(inlet: &Inlet, normal: &Vec3, offset: f64) -> bool {
    let height = offset - inlet.centre.dot(normal);
    let facing = inlet.normal.dot(normal);
    match height.abs() < inlet.reach {
        true => facing.abs() > SLIDING,
        false => facing * height.signum() > SLIDING,
    }
}

/// Largest depth over width of the undercuts of the cores.
fn ratio(boundary: &Boundary, cut: &Cut) -> f64 {
    let plane = PartingHeight::Plane(cut.offset);
    let ratios = boundary.cores.iter().map(|core| {
        let view = View::along(&core.surface, &cut.normal);
        let undercut = view.undercut(plane);
        view.steepest(&undercut)
    });
    ratios.fold(0.0, f64::max)
}

/// Area that is glued [m²]: cutting in two adds the section twice to the area.
fn glued(boundary: &Boundary, cut: &Cut) -> f64 {
    let whole = Solid::from_surface(&boundary.cast).expect("the boundary was checked");
    let (beyond, before) = whole.split_by_plane(&cut.normal, cut.offset);
    (beyond.area() + before.area() - whole.area()) / 2.0
}
