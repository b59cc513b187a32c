//! Families of fibres on a body, and what is refused of them there.

use std::ops::Range;

use anyhow::{Result, bail, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Direction, Directions, Fibres, Profile};
use mechanics::material::fibre::Fibre;
use mechanics::symmetry::Plane;
use mesh::Vec3;
use program::{misfit, unknown};

use super::FibreConfig;
use super::directions::directions_of;
use crate::term::{Ground, PARALLEL, image};

/// Vertices at which it is tested whether fibres are symmetric, at most.
const TESTED: usize = 200;
/// The families of fibres of a body.
pub(super) fn families(all: &[FibreConfig], ground: &Ground) -> Result<Vec<Fibres>> {
    let Ground { body, space, .. } = ground;
    let one = |fibre: &FibreConfig| {
        let elements = elements_of(fibre, ground)?;
        let directions = directions_of(fibre, ground, elements.clone())?;
        check_defined(fibre, &directions, body, (space, elements.clone()))?;
        let family = Fibres::new(fibre.law(), directions, elements).named(&fibre.name);
        Ok(family.with_stiffness(fibre.stiffness()?))
    };
    let fibres = all.iter().map(one).collect::<Result<Vec<_>>>()?;
    for plane in &body.planes {
        check_mirrored(all, &fibres, plane, body)?;
    }
    Ok(fibres)
}

/// The elements that a family is in, which follow each other.
fn elements_of(fibre: &FibreConfig, ground: &Ground) -> Result<Range<usize>> {
    let Some(on) = &fibre.on else { return Ok(0..ground.body.mesh.tets.len()) };
    let mut own = ground.laws.iter().filter(|law| law.is_of(Some(on)));
    let Some(first) = own.next() else {
        let names = || ground.laws.iter().map(|law| law.name.as_str());
        let listed = names().collect::<Vec<_>>().join(", ");
        let has = format!("there are: {listed}; a volume needs a [[material]] of its own");
        let what = unknown("unknown body or volume", on, names(), ';', &has);
        bail!(misfit!(fibre.title().key("on"), ": {what}"));
    };
    let last = own.next_back().unwrap_or(first);
    Ok(first.elements(ground.body).start..last.elements(ground.body).end)
}

/// Whether the mirror images of all fibres in a plane are fibres.
fn check_mirrored(
    all: &[FibreConfig],
    fibres: &[Fibres],
    plane: &Plane,
    body: &Body,
) -> Result<()> {
    for (fibre, own) in all.iter().zip(fibres) {
        let tets = &body.mesh.tets[own.elements()];
        let step = tets.len().div_ceil(TESTED).max(1);
        let places = tets.iter().step_by(step).map(|t| body.mesh.vertices[t[0]]);
        let places: Vec<Vec3> = places.collect();
        ensure!(
            fibres.iter().any(|other| mirrors(own, other, plane, &places)),
            misfit!(
                fibre.title(),
                ": its mirror image in {} is no family of the scene, so the body is not symmetric; expected \
                 another [[fibre]] with the same numbers and the opposite angle, along an axis at the mirror \
                 images of the heights, or the whole body (solver mirror)",
                plane.equation()
            )
        );
    }
    Ok(())
}

/// Refuses a formula that is undefined in some elements, or at one of their vertices.
fn check_defined(
    fibre: &FibreConfig,
    directions: &Directions,
    body: &Body,
    (space, elements): (&FunctionSpace, Range<usize>),
) -> Result<()> {
    let vertices = &body.mesh.vertices;
    let on_axis = match directions {
        Directions::Formula(direction) => {
            direction.axis().and_then(|axis| axis.point_inside(space, vertices, elements.clone()))
        }
        Directions::Twisting(angle) => {
            let mut turned = elements.clone().filter(|&e| is_turned(angle, space.tets()[e], body));
            turned.find_map(|e| angle.axis().point_inside(space, vertices, e..e + 1))
        }
        Directions::Elements(_) => None,
    };
    if let Some(place) = on_axis {
        bail!(misfit!(
            fibre.title().key("around"),
            ": the axis passes through the material at ({:.6}, {:.6}, {:.6}) m, where fibres have no \
             direction; expected an axis in a hole or outside, or a volume without it",
            place.x,
            place.y,
            place.z
        ));
    }
    let mut corners = body.mesh.tets[elements].iter().flatten();
    ensure!(
        corners.all(|&v| {
            let formula = directions.formula(vertices[v]);
            formula.is_none_or(|direction| direction.at(vertices[v]).norm_squared() < 2.0)
        }),
        misfit!(
            fibre.title().key("around"),
            ": fibres have no direction at some vertex; expected an axis near the body"
        )
    );
    Ok(())
}

/// Whether the angle to an axis is not 0 all over an element.
fn is_turned(angle: &Profile, tet: [usize; 4], body: &Body) -> bool {
    let heights = tet.map(|v| angle.height(body.mesh.vertices[v]));
    let low = heights.into_iter().fold(f64::INFINITY, f64::min);
    let high = heights.into_iter().fold(-f64::INFINITY, f64::max);
    angle.bounds([low, high]) != [0.0; 2]
}

/// Whether a family is at all of some places the mirror image of another one. Directions of elements are those of
/// their mirror images, too.
fn mirrors(own: &Fibres, other: &Fibres, plane: &Plane, places: &[Vec3]) -> bool {
    let same = |x: Vec3| {
        let (here, there) = (own.law_at(x), other.law_at(image(plane, x)));
        let equal = (here.k1 - there.k1).abs() <= PARALLEL * here.k1;
        let lead = match (own.directions.formula(x), other.directions.formula(image(plane, x))) {
            (Some(one), Some(two)) => is_image(&one, &two, plane, x),
            (None, None) => own.directions == other.directions,
            _ => false,
        };
        equal && lead && Fibre { k1: here.k1, ..there } == here
    };
    other.elements() == own.elements() && places.iter().all(|&x| same(x))
}

/// Whether fibres at the mirror image of a point lead along the mirror image of others.
fn is_image(own: &Direction, other: &Direction, plane: &Plane, x: Vec3) -> bool {
    let mut along = own.at(x);
    along[plane.axis] = -along[plane.axis];
    along.cross(&other.at(image(plane, x))).norm() < PARALLEL
}
