//! Threads on a body: their pieces in facets, and what is refused of them there.

use anyhow::{Context, Result};
use mechanics::body::Body;
use mechanics::energy::{self, Axis, Helix, LayError, Piece, Winding};
use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};
use program::{KeyPath, misfit};

use super::{Climb, WindingConfig};
use crate::term::Ground;
use crate::term::profile::Along;

/// A thread on a body.
pub(super) fn thread(winding: &WindingConfig, ground: &Ground) -> Result<Winding> {
    let Ground { body, space, .. } = ground;
    let WindingConfig { stiffness, pretension, slack, .. } = winding;
    let (pieces, helix) = Support::new(winding, body)?.lay(winding)?;
    let numbers = [stiffness.values()[0], *pretension, *slack];
    let thread = Winding::new(space, &pieces, numbers).with_helix(helix);
    Ok(match winding.stiffness_profile()? {
        None => thread,
        Some(profile) => thread.with_stiffness(&profile, &body.mesh.vertices),
    })
}

/// The point of a line that is farthest from its tag, by its place, and that distance [m]; none where all points are
/// nearer than half the mean edge of the tag's facets, as those on a curved surface are.
pub(super) fn farthest_point(winding: &WindingConfig, body: &Body) -> Option<(usize, f64)> {
    let support = Support::new(winding, body).ok()?;
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
        let Some(Climb { key, along: number, axis, .. }) = winding.climb()? else {
            return Ok(None);
        };
        let (facets, x, key) = (&self.facets, self.vertices, winding.title().key(key));
        let climb = match winding.angle {
            None => energy::Lead::Pitch(along(number, &key, axis, 1.0)?),
            Some(_) => energy::Lead::Angle(
                along(number, &key, axis, 1.0_f64.to_radians())?,
                axis.mean_distance(facets, x),
            ),
        };
        let heights = winding.heights(axis.heights(facets, x))?;
        let helix = Helix::new(axis, climb, heights, winding.phase.to_radians());
        winding.check_turns(helix.turns())?;
        Ok(Some(helix))
    }

    /// The pieces of a thread on the triangles, and the helix that it is.
    fn lay(&self, winding: &WindingConfig) -> Result<(Vec<Piece>, Option<Helix>)> {
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
            return Ok((energy::polyline(facets, x, &points).map_err(cannot)?, None));
        };
        let mut pieces = energy::helix(facets, x, &one).map_err(cannot)?;
        if winding.double {
            pieces.extend(energy::helix(facets, x, &one.opposite()).map_err(cannot)?);
        }
        Ok((pieces, Some(one)))
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
