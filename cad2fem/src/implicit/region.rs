//! Which region a triangle belongs to.

use mesh::{SurfaceMesh, Vec3};

use super::model::{Cut, Model, Region};
use super::{Cuboid, Fields};

/// What the conditions of a region look at.
struct Site {
    centroid: Vec3,
    /// On the wall of the cavity, on no cut.
    cavity: bool,
    /// Index of the cut whose face it is on.
    cut: Option<usize>,
    /// Index of the nearest body, on the outside.
    body: Option<usize>,
}

/// For each triangle of a model's surface [unit of the file] the first region that
/// takes it, as an index into [`Model::region_names`]; `None` if no region does.
#[must_use]
pub fn assign(model: &Model, fields: &Fields, surface: &SurfaceMesh) -> Vec<Option<usize>> {
    let names = model.region_names();
    (0..surface.triangles.len())
        .map(|t| {
            let site = Site::of(model, fields, surface, t);
            let region = model.region.iter().find(|r| r.takes(model, &site))?;
            names.iter().position(|n| *n == region.name)
        })
        .collect()
}

impl Site {
    fn of(model: &Model, fields: &Fields, surface: &SurfaceMesh, t: usize) -> Self {
        let centroid = surface.centroid(t);
        let cut = model.cut.iter().position(|c| c.holds(&surface.corners(t), model.grid * 1e-6));
        let (to_solid, to_cavity) = (fields.solid.at(&centroid), fields.cavity.at(&centroid));
        let cavity = cut.is_none() && to_cavity.abs() < to_solid.abs();
        let outside = cut.is_none() && !cavity;
        let body = outside.then(|| fields.solid.nearest(&centroid)).flatten();
        Self { centroid, cavity, cut, body }
    }
}

impl Cut {
    /// Whether all corners lie on the plane.
    fn holds(&self, corners: &[Vec3; 3], tolerance: f64) -> bool {
        let normal = Vec3::from(self.normal).normalize();
        corners.iter().all(|p| (normal.dot(p) - self.offset).abs() <= tolerance)
    }
}

impl Region {
    fn takes(&self, model: &Model, site: &Site) -> bool {
        let on_cut = |name: &String| site.cut.is_some_and(|c| model.cut[c].name == *name);
        let near_one =
            |names: &Vec<String>| site.body.is_some_and(|b| names.contains(&model.solid[b].name));
        self.cut.as_ref().is_none_or(on_cut)
            && (!self.cavity || site.cavity)
            && self.primitives.as_ref().is_none_or(near_one)
            && self.within.is_none_or(|w| w.contains(&site.centroid))
    }
}

impl Cuboid {
    fn contains(&self, p: &Vec3) -> bool {
        (0..3).all(|k| self.min[k] <= p[k] && p[k] <= self.max[k])
    }
}
