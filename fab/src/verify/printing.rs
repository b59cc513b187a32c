//! The parts can be printed on the named printer.

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, measure};

use super::set::{Files, Set};
use super::{Line, Status};
use crate::printer::{self, Printer};

/// Facets this near to the lowest point lie on the bed [mm].
const BED: f64 = 0.05;

/// Facets this near to the body shape it [mm].
const AT_BODY: f64 = 0.01;

/// All checks of printing; `parts` are in the closed mold and are turned back.
pub fn checks(set: &Set, parts: &[SurfaceMesh]) -> Vec<Line> {
    let Some(key) = &set.report.casting.printer else {
        let needed = "casting.printer in mold.toml, for build volume and overhangs";
        let mut line = Line::new("printer", true, "none named".into(), needed);
        line.status = Status::Warn;
        return vec![line];
    };
    let printer = match printer::find(key) {
        Ok(printer) => printer,
        Err(message) => return vec![Line::new("printer", false, message, "a known printer")],
    };
    let body = SurfaceBvh::new(&set.cast.solid.to_surface());
    let mut lines = Vec::new();
    for (part, surface) in set.report.parts.iter().zip(parts) {
        let to_mold = Files::turn(part);
        let vertices = surface.vertices.iter().map(|p| to_mold.transpose() * p).collect();
        let printed = SurfaceMesh { vertices, triangles: surface.triangles.clone() };
        lines.push(fits(printer, &part.name, &printed));
        let at_body = |t: usize| body.closest(&surface.centroid(t)).distance <= AT_BODY;
        lines.push(overhangs(printer, &part.name, &printed, at_body));
    }
    lines
}

fn fits(printer: &Printer, name: &str, printed: &SurfaceMesh) -> Line {
    let (low, high) = measure::bounds(&printed.vertices);
    let size: [f64; 3] = (high - low).into();
    let found = format!("{:.1} × {:.1} × {:.1} mm", size[0], size[1], size[2]);
    let needed = match printer.volume {
        Some([x, y, z]) => format!("within {x} × {y} × {z} mm of the {}", printer.name),
        None => format!("no limit known of {}", printer.name),
    };
    Line::new(format!("{name}: build volume"), printer.holds(size), found, &needed)
}

/// Area that hangs over more steeply than is printed without support: supports cost
/// time, and leave scars where they touch what shapes the silicone.
fn overhangs(
    printer: &Printer,
    name: &str,
    printed: &SurfaceMesh,
    at_body: impl Fn(usize) -> bool,
) -> Line {
    let bed = measure::bounds(&printed.vertices).0.z + BED;
    // A facet at the angle a from the vertical has a normal with z = −sin a.
    let limit = -printer.overhang.to_radians().sin() - 1e-6;
    let (mut all, mut shaping) = (0.0, 0.0);
    for t in 0..printed.triangles.len() {
        let [a, b, c] = printed.corners(t);
        let hangs = measure::triangle_normal(a, b, c).z < limit;
        if hangs && printed.centroid(t).z > bed {
            let area = measure::triangle_area(a, b, c);
            all += area;
            shaping += if at_body(t) { area } else { 0.0 };
        }
    }
    let found = format!("{all:.0} mm², {shaping:.0} mm² of it at the silicone");
    let needed = format!("0 mm² beyond {}°, or supports", printer.overhang);
    let mut line = Line::new(format!("{name}: overhang"), true, found, &needed);
    if all > 0.5 {
        line.status = Status::Warn;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::Vec3;
    use mesh::solid::Solid;

    #[test]
    fn ceilings_hang_and_slopes_do_not() {
        let printer = printer::find("prusa-mk4").expect("known");
        // A table: its top of 20 × 20 mm hangs over a foot of 4 × 4 mm.
        let foot = Solid::cube(&Vec3::new(-2.0, -2.0, 0.0), &Vec3::new(2.0, 2.0, 10.0));
        let top = Solid::cube(&Vec3::new(-10.0, -10.0, 10.0), &Vec3::new(10.0, 10.0, 12.0));
        let line = overhangs(printer, "table", &foot.union(&top).to_surface(), |_| false);
        assert_eq!(line.status, Status::Warn);
        assert!(line.found.starts_with("384 mm², 0 mm²"), "{line}");
        // A cone that widens by 40° and one by 50°.
        for (degrees, status) in [(40.0_f64, Status::Ok), (50.0, Status::Warn)] {
            let wide = 2.0 + 10.0 * degrees.to_radians().tan();
            let cone = Solid::cylinder(&Vec3::zeros(), &(Vec3::z() * 10.0), 2.0, wide, 96);
            let line = overhangs(printer, "cone", &cone.to_surface(), |_| true);
            assert_eq!(line.status, status, "{line}");
        }
    }

    #[test]
    fn parts_too_large_are_refused() {
        let printer = printer::find("prusa-mini").expect("known");
        let part = Solid::cube(&Vec3::zeros(), &Vec3::new(181.0, 20.0, 20.0)).to_surface();
        assert_eq!(fits(printer, "bar", &part).status, Status::Fail);
    }
}
