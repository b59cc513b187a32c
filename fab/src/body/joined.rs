//! A body whose chambers were designed: its outside on the model, its chambers as the design has them.
//!
//! filled part = that of the model,   cores = those of the design,   body = filled part − cores − beyond,
//!
//! where `beyond` is what the rims of the cores sweep along their normals: no film is left where a rim of the
//! tetrahedra and the face of the model in which it lies are apart by a rounding.

use std::collections::BTreeSet;

use mesh::solid::{Solid, SolidError};
use mesh::topology::boundary_edges;
use mesh::{SurfaceMesh, Vec3, place_key};

use super::boundary::{Boundary, CoreBoundary};
use crate::config::Casts;

/// How far a rim is swept [m].
const BEYOND: f64 = 1e-4;

/// The body `design` with the outside of `model`, of which nothing moved, and with those of its cores that are in
/// `design` as in `modelled`.
pub fn join(
    design: Boundary,
    model: Boundary,
    modelled: &[CoreBoundary],
) -> Result<Boundary, SolidError> {
    let cores: Vec<CoreBoundary> = design
        .cores
        .into_iter()
        .map(|core| {
            let moved = only(modelled, &core.chamber).is_none_or(|before| moved(before, &core));
            let of_model = only(&model.cores, &core.chamber).filter(|_| !moved);
            of_model.cloned().unwrap_or(core)
        })
        .collect();
    let mut cast = Solid::from_surface(&model.filled)?;
    for core in &cores {
        cast = cast.difference(&Solid::from_surface(&core.surface)?);
        for inlet in &core.inlets {
            let prism = swept(&inlet.cap, &(inlet.normal * BEYOND));
            cast = cast.difference(&Solid::from_surface(&prism)?);
        }
    }
    let cast = cast.to_surface();
    Ok(Boundary {
        filled: model.filled,
        cast,
        casts: Casts::Model,
        beside: None,
        plain: None,
        cores,
        air_paths: design.air_paths,
    })
}

/// The core of a chamber that has but one.
fn only<'a>(cores: &'a [CoreBoundary], chamber: &str) -> Option<&'a CoreBoundary> {
    let mut own = cores.iter().filter(|core| core.chamber == chamber);
    own.next().filter(|_| own.next().is_none())
}

/// Whether a core has other vertices than before.
fn moved(before: &CoreBoundary, core: &CoreBoundary) -> bool {
    places(&before.surface.vertices) != places(&core.surface.vertices)
}

/// Where points are, whatever their order.
pub(super) fn places<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> BTreeSet<[u64; 3]> {
    points.into_iter().map(place_key).collect()
}

/// What a surface sweeps.
fn swept(surface: &SurfaceMesh, by: &Vec3) -> SurfaceMesh {
    let triangles = &surface.triangles;
    let n = surface.vertices.len();
    let moved = surface.vertices.iter().map(|p| p + by);
    let vertices: Vec<Vec3> = surface.vertices.iter().copied().chain(moved).collect();
    let end = triangles.iter().map(|t| t.map(|v| v + n));
    let start = triangles.iter().map(|&[a, b, c]| [a, c, b]);
    let sides = boundary_edges(triangles).into_iter();
    let sides = sides.flat_map(|[a, b]| [[a, b, b + n], [a, b + n, a + n]]);
    SurfaceMesh { vertices, triangles: end.chain(start).chain(sides).collect() }
}
