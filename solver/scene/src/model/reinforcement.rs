//! The fibres and threads of a scene, on a body.

use std::ops::Range;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{
    self, Axis, Direction, Directions, Fibres, Helix, LayError, Piece, Profile, Winding,
};
use mechanics::material::fibre::Fibre;
use mechanics::symmetry::Plane;
use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};
use program::{KeyPath, misfit, unknown};

use super::{Scene, SceneLaw};
use crate::config::{Along, Climb, FibreConfig, WindingConfig};

/// Vertices at which it is tested whether fibres are symmetric, at most.
const TESTED: usize = 200;
/// Sine of the angle between fibres that are mirror images of each other, at most, and relative difference of their k₁.
pub(super) const PARALLEL: f64 = 1e-6;

impl Scene {
    /// The families of fibres of a body, in the order of the scene.
    pub(super) fn fibres(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Fibres>> {
        let one = |fibre: &FibreConfig| {
            let elements = self.elements_of(fibre, body)?;
            let directions = self.directions_of(fibre, body, elements.clone())?;
            check_defined(fibre, &directions, body, (space, elements.clone()))?;
            let family = Fibres::new(fibre.law(), directions, elements).named(&fibre.name);
            Ok(family.with_stiffness(fibre.stiffness()?))
        };
        let fibres = self.config.fibre.iter().map(one).collect::<Result<Vec<_>>>()?;
        for plane in &body.planes {
            self.check_mirrored(&fibres, plane, body)?;
        }
        Ok(fibres)
    }

    /// The elements that a family is in, which follow each other.
    fn elements_of(&self, fibre: &FibreConfig, body: &Body) -> Result<Range<usize>> {
        let Some(on) = &fibre.on else { return Ok(0..body.mesh.tets.len()) };
        let own = self.laws.iter().filter(|law| self.is_law_of(law, on));
        let own: Vec<Range<usize>> = own.map(|law| law.elements(body)).collect();
        let names: Vec<String> =
            self.laws.iter().map(|law: &SceneLaw| self.law_name(law)).collect();
        let (Some(first), Some(last)) = (own.first(), own.last()) else {
            let known = names.iter().map(String::as_str);
            let has = format!(
                "there are: {}; a volume needs a [[material]] of its own",
                names.join(", ")
            );
            let what = unknown("unknown body or volume", on, known, ';', &has);
            return Err(misfit!(fibre.title().key("on"), ": {what}").into());
        };
        Ok(first.start..last.end)
    }

    /// Whether the mirror images of all fibres in a plane are fibres.
    fn check_mirrored(&self, fibres: &[Fibres], plane: &Plane, body: &Body) -> Result<()> {
        for (fibre, own) in self.config.fibre.iter().zip(fibres) {
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

    /// The helix of a thread on the body; none of a line through points.
    pub fn helix(&self, winding: &WindingConfig) -> Result<Option<Helix>> {
        Support::new(winding, &self.body)?.helix(winding)
    }

    /// The point of a line that is farthest from its tag, by its place, and that distance [m]; none where all points are
    /// nearer than half the mean edge of the tag's facets, as those on a curved surface are.
    pub fn farthest_point(&self, winding: &WindingConfig) -> Option<(usize, f64)> {
        let support = Support::new(winding, &self.body).ok()?;
        let vertices = support.vertices.to_vec();
        let surface = SurfaceMesh { vertices, triangles: support.facets };
        let edges = (0..surface.triangles.len()).flat_map(|t| {
            let [a, b, c] = surface.corners(t);
            [(a - b).norm(), (b - c).norm(), (c - a).norm()]
        });
        let mean = edges.sum::<f64>() / (3 * surface.triangles.len()) as f64;
        let tree = SurfaceBvh::new(&surface);
        let distance = |point: &[f64; 3]| tree.closest(&(*point).into()).distance;
        let all = winding.points.iter().map(distance).enumerate();
        all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, distance)| *distance > 0.5 * mean)
    }

    /// The threads of a body, in the order of the scene.
    pub(super) fn windings(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Winding>> {
        let one = |winding: &WindingConfig| {
            let WindingConfig { stiffness, pretension, slack, .. } = winding;
            let pieces = Support::new(winding, body)?.lay(winding)?;
            let numbers = [stiffness.values()[0], *pretension, *slack];
            let thread = Winding::new(space, &pieces, numbers);
            Ok(match winding.stiffness_profile()? {
                None => thread,
                Some(profile) => thread.with_stiffness(&profile, &body.mesh.vertices),
            })
        };
        self.config.winding.iter().map(one).collect()
    }
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
        return Err(misfit!(
            fibre.title().key("around"),
            ": the axis passes through the material at ({:.6}, {:.6}, {:.6}) m, where fibres have no \
             direction; expected an axis in a hole or outside, or a volume without it",
            place.x,
            place.y,
            place.z
        )
        .into());
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

/// The mirror image of a point.
pub(super) fn image(plane: &Plane, x: Vec3) -> Vec3 {
    let mut place = x;
    place[plane.axis] = 2.0 * plane.level - x[plane.axis];
    place
}

/// Whether fibres at the mirror image of a point lead along the mirror image of others.
fn is_image(own: &Direction, other: &Direction, plane: &Plane, x: Vec3) -> bool {
    let mut along = own.at(x);
    along[plane.axis] = -along[plane.axis];
    along.cross(&other.at(image(plane, x))).norm() < PARALLEL
}

/// What a thread lies on.
struct Support<'a> {
    /// The facets of its tags.
    facets: Vec<[usize; 3]>,
    /// Vertices of the body at rest [m].
    vertices: &'a [Vec3],
}

impl<'a> Support<'a> {
    fn new(winding: &WindingConfig, body: &'a Body) -> Result<Self> {
        let all = winding.on.all().iter().map(|tag| body.tagged(tag));
        let all = all.collect::<Result<Vec<_>, _>>().with_context(|| winding.title())?;
        Ok(Self { facets: all.concat(), vertices: &body.mesh.vertices })
    }

    /// The helix of a thread; none of a line through points.
    fn helix(&self, winding: &WindingConfig) -> Result<Option<Helix>> {
        let (Some(climb), Some(around)) = (winding.climb()?, &winding.around) else {
            return Ok(None);
        };
        let (facets, x) = (&self.facets, self.vertices);
        let axis = around.line();
        let climb = match climb {
            Climb::Pitch(pitch) => {
                energy::Lead::Pitch(along(pitch, &winding.title().key("pitch"), axis, 1.0)?)
            }
            Climb::Angle(angle) => energy::Lead::Angle(
                along(angle, &winding.title().key("angle"), axis, 1.0_f64.to_radians())?,
                axis.mean_distance(facets, x),
            ),
        };
        let heights = winding.heights(axis.heights(facets, x))?;
        let helix = Helix::new(axis, climb, heights, winding.phase.to_radians());
        winding.check_turns(helix.turns())?;
        Ok(Some(helix))
    }

    /// The pieces of a thread on the triangles.
    fn lay(&self, winding: &WindingConfig) -> Result<Vec<Piece>> {
        let (facets, x, helix) = (&self.facets, self.vertices, self.helix(winding)?);
        let reach = helix.as_ref().map(|helix| reach(helix, facets, x));
        let cannot = |error: LayError| {
            misfit!(
                winding.title(),
                ": the thread cannot be laid on \"{}\": {error}{}\n  {}",
                winding.on.all().join("\" and \""),
                reach.as_deref().filter(|_| misses_or_leaves(&error)).unwrap_or_default(),
                advice(&error)
            )
        };
        let Some(one) = helix else {
            let points: Vec<Vec3> = winding.points.iter().map(|&point| point.into()).collect();
            return Ok(energy::polyline(facets, x, &points).map_err(cannot)?);
        };
        let mut pieces = energy::helix(facets, x, &one).map_err(cannot)?;
        if winding.double {
            pieces.extend(energy::helix(facets, x, &one.opposite()).map_err(cannot)?);
        }
        Ok(pieces)
    }
}

/// A number of a thread in other units, which may change along its axis.
fn along(number: &Along, key: &KeyPath, axis: Axis, factor: f64) -> Result<energy::Along> {
    Ok(match number {
        Along::Number(value) => energy::Along::Number(value * factor),
        Along::Profile(profile) => {
            energy::Along::Profile(profile.build(key, Some(axis))?.times(factor))
        }
    })
}

/// The heights of a helix beside those of its tag, in words.
fn reach(helix: &Helix, facets: &[[usize; 3]], x: &[Vec3]) -> String {
    let ([low, high], [start, end]) = (helix.axis.heights(facets, x), helix.heights);
    format!(
        "; along the axis from its point, the facets reach from {low:.6} to {high:.6} m and the thread from {start:.6} to \
         {end:.6} m"
    )
}

fn misses_or_leaves(error: &LayError) -> bool {
    matches!(error, LayError::Misses | LayError::Leaves { .. })
}

/// What may be done where a thread cannot be laid.
fn advice(error: &LayError) -> &'static str {
    match error {
        LayError::Misses => "expected an axis and heights of the tag, or points near it",
        LayError::Leaves { .. } => {
            "expected a tag all around the axis between start and end, or a shorter thread"
        }
        LayError::Layers { .. } => {
            "expected a tag with one layer around the axis, as the outer wall alone, or points that are closer"
        }
        LayError::AxisInside { .. } => "expected a tag around the axis, without end faces",
    }
}
