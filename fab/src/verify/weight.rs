//! What the casting weighs, from its written surface.

use library::silicones;
use mesh::SurfaceMesh;
use mesh::bvh::SurfaceBvh;
use mesh::measure::triangle_area;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::body::weight::Weight;
use crate::geometry::MM;

/// Largest difference, as a part, of what mold.json says and what is measured: less than a scale that shows
/// 0.1 g sees of a hand-sized body.
const OFF: f64 = 1e-3;

/// Facets of the cast within this distance of a core are walls of a chamber [mm].
const TOUCHES: f64 = 1e-2;

/// The casting weighs what mold.json says, if its silicone has a density.
pub fn check(mold: &ClosedMold) -> Option<Line> {
    let said = mold.report.cast.weight?;
    let name = "cast: mass";
    let key = mold.report.casting.silicone.as_deref();
    let silicone = key.and_then(|key| silicones().find(key).ok());
    let Some((silicone, density)) = silicone.and_then(|s| Some((s, s.density?))) else {
        let needed = "a silicone whose density is known: make the mold again";
        return Some(Line::new(name, false, format!("{:.2} g of {key:?}", said.mass), needed));
    };
    let cured = MM / mold.report.scale();
    let plugs: f64 = mold.report.holds.iter().map(|hold| hold.plugs).sum();
    let volume = mold.cast.volume + plugs;
    // Of an open chamber the core is one with its plate, whose area says nothing.
    let walls = match mold.cores.is_empty() {
        true => mold.report.cast.chamber_area,
        false => walls(mold),
    };
    let found = Weight::new(volume * cured.powi(3), walls * cured.powi(2), density);
    let alike = |a: f64, b: f64, off: f64| (a - b).abs() <= off * b;
    let same =
        alike(said.mass, found.mass, OFF) && alike(said.per_tenth, found.per_tenth, 10.0 * OFF);
    let words = |weight: &Weight| {
        format!("{:.2} g, {:.3} g per 0.1 mm of wall", weight.mass, weight.per_tenth)
    };
    let needed = format!("{} by mold.json, of {}", words(&said), silicone.name);
    Some(Line::new(name, same, words(&found), &needed))
}

/// Area of the cast that touches cores [mm²].
fn walls(mold: &ClosedMold) -> f64 {
    let cast = mold.cast.solid.to_surface();
    let cores: Vec<SurfaceMesh> = mold.cores.iter().map(|core| core.solid.to_surface()).collect();
    let cores: Vec<SurfaceBvh> = cores.iter().map(SurfaceBvh::new).collect();
    let touches = |t: &usize| {
        let centre = cast.centroid(*t);
        cores.iter().any(|core| core.closest(&centre).distance <= TOUCHES)
    };
    let area = |t: usize| {
        let [a, b, c] = cast.corners(t);
        triangle_area(a, b, c)
    };
    (0..cast.triangles.len()).filter(touches).map(area).sum()
}
