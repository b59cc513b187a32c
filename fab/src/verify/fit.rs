//! The parts fit each other, and the mold cavity between them is the designed body.

use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, measure};
use program::sha256_file;

use super::closed_mold::{Body, ClosedMold};
use super::deviation::{SURFACE, deviation};
use super::{Line, Status, cad};
use crate::body::source::CastPart;
use crate::config::Casts;
use crate::files::report::MoldReport;
use crate::mold::Purpose;

/// Error of the balance as a part of the outside's volume: in a mold of 500 mL half a cubic
/// millimetre, a crumb.
const BALANCE: f64 = 1e-6;

/// Points per surface at which that distance is measured, besides its vertices: one per mm²
/// of a hand-sized body.
const SAMPLES: usize = 20_000;

/// All checks of fit.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let mut lines = vec![block(mold)];
    lines.extend(overlaps(mold));
    // Channels and gaps, where the body does not reach into them.
    let voids = mold.cavity.intersection(&mold.channels).difference(&mold.cast.solid);
    lines.push(balance(mold, &voids));
    lines.push(leaks(mold, &voids));
    lines.extend(surface(mold, &voids));
    lines
}

/// The shells together reach as far as the outside of the mold.
fn block(mold: &ClosedMold) -> Line {
    let (min, max) = mold.bounds;
    let (low, high) = mold.outside.solid.bounds();
    let off = (min - low).amax().max((max - high).amax());
    Line::at_most("outside: size", off, 2.0 * mold.rounding, "mm off")
}

/// No two bodies share a volume.
fn overlaps(mold: &ClosedMold) -> Vec<Line> {
    let bodies: Vec<&Body> = mold.parts().chain([&mold.cast]).collect();
    let mut lines = Vec::new();
    for (i, a) in bodies.iter().enumerate() {
        for b in &bodies[i + 1..] {
            let shared = a.solid.intersection(&b.solid).volume();
            let limit = mold.volume_rounding(a.area + b.area);
            let name = format!("overlap: {} and {}", a.name, b.name);
            lines.push(Line::at_most(name, shared, limit, "mm³"));
        }
    }
    lines
}

/// Outside − parts − voids = cast, in volumes of the written surfaces.
fn balance(mold: &ClosedMold, voids: &Solid) -> Line {
    let parts: f64 = mold.parts().map(|body| body.volume).sum();
    let rest = mold.outside.volume - parts - voids.volume();
    let limit = BALANCE * mold.outside.volume;
    let name = "balance: outside-parts-voids-cast";
    Line::at_most(name, (rest - mold.cast.volume).abs(), limit, "mm³")
}

/// Nothing but the cast, channels and gaps is empty.
fn leaks(mold: &ClosedMold, voids: &Solid) -> Line {
    let other = mold.cavity.difference(&mold.cast.solid).difference(voids);
    let limit = mold.volume_rounding(mold.cavity.area());
    Line::at_most("leaks: empty elsewhere", other.volume(), limit, "mm³")
}

/// The mold cavity has the surface of the design.
fn surface(mold: &ClosedMold, voids: &Solid) -> Vec<Line> {
    let hash = match sha256_file(&mold.origins.design) {
        Ok(hash) => hash,
        Err(error) => {
            let needed = "the design; give its place with --design";
            return vec![Line::new("design: readable", false, error.to_string(), needed)];
        }
    };
    let same = hash == mold.report.input.sha256;
    let found = format!("sha256 {}", &hash[..12]);
    let molded = mold.report.input.sha256.get(..12).unwrap_or_default();
    let mut lines =
        vec![Line::new("design: unchanged", same, found, &format!("{molded} as molded"))];
    if !same {
        return lines;
    }
    match designed(mold) {
        Ok(design) => lines.extend(distances(mold, voids, &design)),
        Err(error) => lines.push(Line::new("design: readable", false, error, "a valid body")),
    }
    lines
}

/// What is to be cast, in the mold's millimetres.
fn designed(mold: &ClosedMold) -> Result<SurfaceMesh, String> {
    let input = &mold.report.input;
    let whole = mold.origins.whole(&mold.report, input.surface)?;
    let cut = |up: f64, height: f64| {
        let solid = Solid::from_surface(&whole).map_err(|e| e.to_string())?;
        Ok(solid.trim_by_plane(&(Vec3::z() * up), up * height).to_surface())
    };
    match input.part {
        CastPart::Above(height) => cut(1.0, height),
        CastPart::Below(height) => cut(-1.0, height),
        CastPart::Whole => Ok(whole),
    }
}

/// Area of the section of a design, in the mold's millimetres, at which a casting ends [mm²].
pub fn section(design: &SurfaceMesh, report: &MoldReport) -> f64 {
    let (CastPart::Above(height) | CastPart::Below(height)) = report.input.part else { return 0.0 };
    let Ok(whole) = Solid::from_surface(design) else { return 0.0 };
    let (above, below) = whole.split_by_plane(&Vec3::z(), height);
    // The section is added on both sides.
    (above.area() + below.area() - whole.area()) / 2.0
}

/// What is to be cast, in words.
fn wanted(mold: &ClosedMold) -> &'static str {
    match (mold.report.input.surface, &mold.origins.modelled) {
        (Casts::Mesh, _) => "design",
        (Casts::Model, None) => "CAD",
        (Casts::Model, Some(_)) => "CAD and design",
    }
}

/// Distances between the largest piece of the mold cavity and what is to be cast, both ways.
fn distances(mold: &ClosedMold, voids: &Solid, design: &SurfaceMesh) -> Vec<Line> {
    let mut bodies = mold.cavity.difference(voids).decompose();
    plug(mold, design, &mut bodies);
    let Some(body) = bodies.first() else {
        return vec![Line::new("surface", false, "no cavity left".into(), "the designed body")];
    };
    let left = body.to_surface();
    let limit = SURFACE + 2.0 * mold.rounding;
    let (there, at) = deviation(&left, design, limit, |_| true);
    let back = measure::hausdorff(design, &left, SAMPLES);
    let left_area = body.area() + mold.cavity.area();
    let off = (body.volume() - measure::enclosed_volume(design)).abs();
    let wanted = wanted(mold);
    let rounding = mold.volume_rounding(left_area);
    let mut lines = vec![
        Line::at_most(format!("surface: mold to {wanted}"), there, limit, "mm").placed(&at),
        Line::at_most(format!("surface: {wanted} to mold"), back, limit, "mm"),
        Line::at_most(format!("volume: mold and {wanted}"), off, rounding, "mm³"),
        crumbs(mold, &bodies[1..]),
    ];
    lines.extend(cad::checks(mold, &left));
    lines
}

/// Fills the holes that pins leave in the largest body, as is done after casting.
fn plug(mold: &ClosedMold, design: &SurfaceMesh, bodies: &mut [Solid]) {
    let (Some(body), Ok(design)) = (bodies.first_mut(), Solid::from_surface(design)) else {
        return;
    };
    for pin in mold.report.outlines(Purpose::Pin) {
        *body = body.union(&pin.exact().intersection(&design));
    }
}

/// Other pieces of the mold cavity are films of rounding between touching faces.
fn crumbs(mold: &ClosedMold, others: &[Solid]) -> Line {
    let volume: f64 = others.iter().map(Solid::volume).sum();
    let limit = mold.volume_rounding(mold.cavity.area());
    let mut line = Line::at_most("cavity: other bodies", volume, limit, "mm³");
    if line.status == Status::Ok {
        line.found = format!("{} in {} films", line.found, others.len());
    }
    line
}
