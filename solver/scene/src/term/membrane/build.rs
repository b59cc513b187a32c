//! Sheets on a body, and what is refused of them there.

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::energy::{Direction, Membrane};
use mechanics::material::sheet::Strain;
use mechanics::symmetry::Plane;
use mesh::Vec3;
use program::misfit;

use super::MembraneConfig;
use crate::term::{Ground, PARALLEL, image};

/// Part of the direction of a warp that lies in its sheet, at least [1].
const LEAST_PART: f64 = 0.1;

/// The sheet of a table, beside all of them.
pub(super) fn sheet(
    config: &MembraneConfig,
    all: &[MembraneConfig],
    ground: &Ground,
) -> Result<Membrane> {
    let Ground { body, space, .. } = ground;
    let facets = body.tagged(&config.on).with_context(|| config.title())?;
    for plane in &body.planes {
        let inside = facets.iter().filter(|&&facet| plane.has_facet(facet)).count();
        ensure!(
            inside == 0,
            misfit!(
                config.title(),
                ": {inside} of its {} facets lie in the plane of symmetry {}, where the whole body \
                 goes on: there is no surface to bond a sheet to; expected a tag without them, or \
                 the whole body (solver mirror)",
                facets.len(),
                plane.equation()
            )
        );
    }
    let law = config.specification()?.build(config.tension);
    let sheet = Membrane::new(space, &facets, config.thickness, law);
    let Some(direction) = config.leads()? else { return Ok(sheet) };
    check_warp(config, &direction, &facets, body)?;
    for plane in &body.planes {
        check_mirrored((config, &direction), all, (plane, &facets[..]), body)?;
    }
    Ok(sheet.along(direction))
}

/// Refuses a sheet whose mirror image in a plane is none of the sheets on its tag.
fn check_mirrored(
    (own, direction): (&MembraneConfig, &Direction),
    all: &[MembraneConfig],
    (plane, facets): (&Plane, &[[usize; 3]]),
    body: &Body,
) -> Result<()> {
    let stiffness = own.specification()?.build(false).tangent(&Strain::zeros());
    let balanced = stiffness[(0, 0)] == stiffness[(1, 1)];
    let mut found = false;
    for other in all {
        let Some(lead) = other.leads()?.filter(|_| own.has_numbers_of(other)) else { continue };
        let image = |facet: &[usize; 3]| {
            let corners = facet.map(|v| body.mesh.vertices[v]);
            is_image(direction, &lead, balanced, (plane, corners))
        };
        found |= facets.iter().all(image);
    }
    ensure!(
        found,
        misfit!(
            own.title(),
            ": its mirror image in {} is no sheet of the scene, so the body is not symmetric; expected a warp along \
             the plane or across it, another [[membrane]] on the tag with the same numbers and the opposite angle, \
             or the whole body (solver mirror)",
            plane.equation()
        )
    );
    Ok(())
}

impl MembraneConfig {
    /// Whether another sheet has the same numbers, on the same tag.
    fn has_numbers_of(&self, other: &Self) -> bool {
        let numbers = |sheet: &Self| {
            let law = sheet.specification().map(|own| (own.law.key, own.values)).ok();
            (sheet.on.clone(), sheet.tension, sheet.thickness, law)
        };
        numbers(self) == numbers(other)
    }
}

/// Whether a warp is the mirror image of another at a facet with these corners; where warp and weft are as stiff, the warp
/// of one or the weft of the other.
fn is_image(
    own: &Direction,
    other: &Direction,
    balanced: bool,
    (plane, x): (&Plane, [Vec3; 3]),
) -> bool {
    let normal = (x[1] - x[0]).cross(&(x[2] - x[0])).normalize();
    let centre = x.iter().sum::<Vec3>() / 3.0;
    let inside = |along: Vec3| (along - normal.dot(&along) * normal).normalize();
    // the image of the other is compared here, in the plane of this facet
    let mut there = other.at(image(plane, centre));
    there[plane.axis] = -there[plane.axis];
    let (here, there) = (inside(own.at(centre)), inside(there));
    here.cross(&there).norm() < PARALLEL || balanced && here.dot(&there).abs() < PARALLEL
}

/// Refuses a warp that is nearly across its sheet somewhere.
fn check_warp(
    membrane: &MembraneConfig,
    direction: &Direction,
    facets: &[[usize; 3]],
    body: &Body,
) -> Result<()> {
    for facet in facets {
        let [a, b, c] = facet.map(|v| body.mesh.vertices[v]);
        let centre = (a + b + c) / 3.0;
        let normal = (b - a).cross(&(c - a)).normalize();
        // where it is undefined, on an axis, none of it counts
        let part = |x: Vec3| direction.at(x).cross(&normal).norm();
        let parts = [a, b, c, centre].map(part).into_iter();
        let least = parts.map(|p| if p.is_nan() { 0.0 } else { p }).fold(f64::INFINITY, f64::min);
        ensure!(
            least >= LEAST_PART,
            misfit!(
                membrane.title(),
                ": the warp is across the sheet at ({:.6}, {:.6}, {:.6}) m, where {:.1} % of its direction lie in \
                 the sheet; expected {:.0} % or more, so another direction, or a tag without these facets",
                centre.x,
                centre.y,
                centre.z,
                100.0 * least,
                100.0 * LEAST_PART
            )
        );
    }
    Ok(())
}
