//! The whole of an obstacle of a part of a symmetric body.

use anyhow::{Result, ensure};
use mechanics::symmetry::{AXES, Plane};
use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};
use program::{KeyPath, misfit};

use super::ObstacleConfig;
use crate::term::Ground;
use crate::term::values::Values;

/// How far an obstacle may be off its mirror image, in its diagonals [1].
const OFF_PLANE: f64 = 1e-6;

/// How an obstacle was completed in a plane: what is on the other side from the obstacle in the
/// file moves as its mirror image.
#[derive(Clone, Copy)]
pub(super) struct MirroredObstacle {
    axis: usize,
    level: f64,
    /// Side of the obstacle in the file: 1 above the level, −1 below.
    side: f64,
}

impl MirroredObstacle {
    /// Mirrors the motion of a place if it is on the other side [m].
    pub fn turn(&self, place: Vec3, motion: &mut Vec3) {
        if self.side * (place[self.axis] - self.level) < 0.0 {
            motion[self.axis] = -motion[self.axis];
        }
    }
}

/// The whole of an obstacle: with its mirror image in each plane of symmetry on one side of
/// which it lies. An obstacle that is on both sides must be its own image.
pub(super) fn complete(
    mut surface: SurfaceMesh,
    config: &ObstacleConfig,
    ground: &Ground,
) -> Result<(SurfaceMesh, Vec<MirroredObstacle>)> {
    let mut mirrored = Vec::new();
    for plane in &ground.body.planes {
        let near = OFF_PLANE * mesh::measure::diagonal(&surface.vertices);
        let heights = surface.vertices.iter().map(|x| x[plane.axis] - plane.level);
        let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        if low >= -near || high <= near {
            mirrored.push(MirroredObstacle {
                axis: plane.axis,
                level: plane.level,
                side: if high > near { 1.0 } else { -1.0 },
            });
            mirror_surface(&mut surface, plane, near);
        } else {
            check_own_image(&surface, config, plane, (near, &ground.around.values))?;
        }
    }
    Ok((surface, mirrored))
}

fn check_own_image(
    surface: &SurfaceMesh,
    config: &ObstacleConfig,
    plane: &Plane,
    (near, values): (f64, &Values),
) -> Result<()> {
    let bvh = SurfaceBvh::new(surface);
    let off = |x: &Vec3| bvh.closest(&plane.mirror(*x)).distance;
    let worst = surface.vertices.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
    if let Some(x) = worst {
        ensure!(
            off(x) <= near,
            misfit!(
                KeyPath::list("obstacle").named(&config.name),
                ": it is on both sides of the plane of symmetry {}, but not its own mirror image: that \
                 of ({:.5}, {:.5}, {:.5}) m is {:.3e} m off it; expected {near:.1e} m at most: cut the \
                 obstacle at the plane, or make it symmetric",
                plane.equation(),
                x.x,
                x.y,
                x.z,
                off(x)
            )
        );
    }
    let motion = values.field(&config.displacement);
    for t in values.moments().into_iter().rev() {
        let across = motion.at(Vec3::zeros(), t)[plane.axis];
        ensure!(
            across == 0.0,
            misfit!(
                KeyPath::list("obstacle").named(&config.name),
                ": it is on both sides of the plane of symmetry {} and moves by {across:.3e} m along {} \
                 at t = {t}; expected 0: cut the obstacle at the plane",
                plane.equation(),
                AXES[plane.axis]
            )
        );
    }
    Ok(())
}

/// Adds the mirror image of a surface; vertices in the plane are shared.
fn mirror_surface(surface: &mut SurfaceMesh, plane: &Plane, near: f64) {
    let own = surface.vertices.len();
    let mut image: Vec<usize> = (0..own).collect();
    for (v, image) in image.iter_mut().enumerate() {
        let x = surface.vertices[v];
        if plane.height(&x).abs() > near {
            *image = surface.vertices.len();
            surface.vertices.push(plane.mirror(x));
        }
    }
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.triangles[t].map(|v| image[v]);
        surface.triangles.push([b, a, c]);
    }
}
