//! Which region a triangle belongs to.

use mesh::Vec3;

use super::model::{Model, Primitive, Region};
use super::{Cuboid, Fields, Part, Skin};

/// What the conditions of a region look at.
struct Triangle {
    centroid: Vec3,
    /// What it is a part of.
    part: Part,
    /// Index of the nearest body of the solid, on the outside, or of the cavity, on its wall.
    body: Option<usize>,
}

/// For each triangle of a model's surface the first region that takes it, as an index into
/// [`Model::region_names`]; `None` if no region does.
pub fn assign(model: &Model, fields: &Fields, skin: &Skin) -> Vec<Option<usize>> {
    let names = model.region_names();
    (0..skin.surface.triangles.len())
        .map(|t| {
            let triangle = Triangle::of(model, fields, skin, t);
            let region = model.region.iter().find(|r| r.takes(model, &triangle))?;
            names.iter().position(|n| *n == region.name)
        })
        .collect()
}

impl Triangle {
    fn of(model: &Model, fields: &Fields, skin: &Skin, t: usize) -> Self {
        let centroid = skin.surface.centroid(t) / model.unit.metres();
        let part = skin.part[t];
        let body = match part {
            Part::Outside => fields.solid.nearest(&centroid),
            Part::Cavity => fields.cavity.nearest(&centroid),
            Part::Cut(_) => None,
        };
        Self { centroid, part, body }
    }
}

impl Region {
    fn takes(&self, model: &Model, triangle: &Triangle) -> bool {
        let on_cut =
            |name: &String| matches!(triangle.part, Part::Cut(c) if model.cut[c].name == *name);
        let near_one = |names: &[String], bodies: &[Primitive]| {
            triangle.body.is_some_and(|b| names.contains(&bodies[b].name))
        };
        let on_primitive =
            |names: &Vec<String>| triangle.part == Part::Outside && near_one(names, &model.solid);
        let in_cavity = || {
            let names = self.cavity.names();
            triangle.part == Part::Cavity && (names.is_empty() || near_one(names, &model.cavity))
        };
        self.cut.as_ref().is_none_or(on_cut)
            && (!self.cavity.is_given() || in_cavity())
            && self.primitives.as_ref().is_none_or(on_primitive)
            && self.within.is_none_or(|w| w.contains(&triangle.centroid))
    }
}

impl Cuboid {
    fn contains(&self, p: &Vec3) -> bool {
        (0..3).all(|k| self.min[k] <= p[k] && p[k] <= self.max[k])
    }
}
