//! How the mold stands: which way is up, which way the shells are pulled.

use anyhow::{Result, anyhow, ensure};
use geometry::frame::{Frame, Pull, moved};
use mesh::measure::bounds;
use mesh::{SurfaceMesh, Vec3};

use crate::body::boundary::{Boundary, Inlet};
use crate::body::orientation::Orientation;
use crate::config::Config;

/// An inlet faces down, and `up` is a coordinate axis, within this angle's
/// cosine (5°): a mesher leaves the rim of a narrow inlet uneven.
const DOWN: f64 = 0.9962;

/// The direction `up` that the configuration asks for, or away from the first inlet; z for a
/// closed chamber.
pub fn up(boundary: &Boundary, config: &Config) -> Vec3 {
    config.up.map_or_else(|| away_from_inlet(boundary), Vec3::from).normalize()
}

/// `up`, if all inlets face down.
pub fn require_inlets_down(boundary: &Boundary, up: Vec3) -> Result<Vec3> {
    for inlet in boundary.cores.iter().flat_map(|core| &core.inlets) {
        let cosine = -inlet.normal.dot(&up);
        let [x, y, z] = inlet.centre.into();
        ensure!(
            cosine >= DOWN,
            "the inlet at ({x:.5}, {y:.5}, {z:.5}) m faces {:.1}° away from straight down, at most 5° are allowed: set `up` \
             opposite to the inlet; inlets that face different ways cannot be molded",
            cosine.clamp(-1.0, 1.0).acos().to_degrees()
        );
    }
    Ok(up)
}

/// The mold's frame for an orientation. The filled part stands on z = 0, or is cut there.
pub fn frame(
    filled: &SurfaceMesh,
    orientation: &Orientation,
    shrinkage: f64,
) -> Result<(Frame, Pull)> {
    let askew = |cosine: f64| {
        anyhow!(
            "parting.pull makes an angle of {:.2}° with up; it must be along up (upper and lower shell) or across it (left \
             and right shell on a base)",
            cosine.acos().to_degrees()
        )
    };
    let (mut frame, pull) = Frame::new(orientation.up, orientation.pull).map_err(askew)?;
    let (low, high) = bounds(&placed(filled, &frame).vertices);
    let middle = (low + high) / 2.0;
    let bottom = orientation.portion.cut().unwrap_or(low.z);
    frame.origin = frame.rotation.transpose() * Vec3::new(middle.x, middle.y, bottom);
    frame.scale = 1.0 / (1.0 - shrinkage);
    Ok((frame, pull))
}

/// A surface of the design in the mold's frame.
pub fn placed(surface: &SurfaceMesh, frame: &Frame) -> SurfaceMesh {
    moved(surface, |p| frame.point(p))
}

/// Opposite to the first inlet, or the coordinate axis that is nearly so.
fn away_from_inlet(boundary: &Boundary) -> Vec3 {
    let mut inlets = boundary.cores.iter().flat_map(|core| &core.inlets);
    let Some(inlet) = inlets.next() else { return Vec3::z() };
    near_axis(-inlet.normal)
}

/// A unit vector, or the coordinate axis that is nearly it.
fn near_axis(v: Vec3) -> Vec3 {
    let mut axis = Vec3::zeros();
    let k = v.iamax();
    axis[k] = v[k].signum();
    if axis.dot(&v) >= DOWN { axis } else { v }
}

/// The direction into the body along which an inlet runs: `up` if it faces down.
pub fn inward(inlet: &Inlet, up: Vec3) -> Vec3 {
    if -inlet.normal.dot(&up) >= DOWN { up } else { near_axis(-inlet.normal) }
}
