//! The parts can be printed on the named printer.

use geometry::frame::moved;
use geometry::overhang::{Overhangs, needs_supports};
use library::Printer;
use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, measure};

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};
use crate::files::report::Part;

/// Facets this near to the body shape it: twice what the surfaces may be apart, for
/// centroids of facets across a fold [mm].
const AT_BODY: f64 = 0.01;

/// Difference of two sums of the same areas, for another order.
const SUMS: f64 = 1e-9;

/// All checks of printing; parts are turned back from the closed mold.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let Some(printer) = mold.report.casting.printer() else {
        let needed = "casting.printer in mold.toml, for build volume and overhangs";
        return vec![Line::new("printer", false, "none named".into(), needed).or_warning()];
    };
    let body = SurfaceBvh::new(&mold.cast.solid.to_surface());
    let mut lines = Vec::new();
    for (part, Body { surface, .. }) in mold.report.parts.iter().zip(mold.parts()) {
        let from_mold = part.turn().transpose();
        let printed = moved(surface, |p| from_mold * p);
        lines.push(fits(printer, &part.name, &printed));
        let at_body = |t: usize| body.closest(&surface.centroid(t)).distance <= AT_BODY;
        let below = Overhangs::new(&printed, printer.overhang, at_body);
        lines.push(overhangs(printer, part, &below));
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

/// Area that hangs over more steeply than is printed without support. The settings switch supports on; they leave scars
/// where they touch what shapes the silicone. Settings and sheet rely on the area in the report.
fn overhangs(printer: &Printer, part: &Part, below: &Overhangs) -> Line {
    let Overhangs { bed, hanging, shaping } = *below;
    let found = format!("{hanging:.0} mm², {shaping:.0} mm² of it at the silicone");
    let needed =
        format!("supports beyond {}°, as in its .ini, none at the silicone", printer.overhang);
    let reported = |area: f64, reported: f64| (area - reported).abs() <= SUMS * area;
    let holds = reported(hanging, part.overhang) && reported(bed, part.bed);
    let mut line = Line::new(format!("{}: overhang", part.name), holds, found, &needed);
    if !holds {
        line.needed =
            format!("{:.3} mm², {:.3} mm² on the bed, as reported", part.overhang, part.bed);
    } else if needs_supports(shaping) {
        line.status = Status::Warn;
        line.needed += ": smooth what they leave there";
    }
    line
}
