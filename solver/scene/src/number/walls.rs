//! Walls that stand off along their normals.

use std::collections::BTreeMap;

use crate::model::Scene;
use anyhow::{Result, anyhow, ensure};
use mesh::Vec3;
use mesh::offset::shifts;

use super::{Number, Row, Setting, any, nothing_added};
use mechanics::extension::Extension;

pub(super) const WALL: Row = Row {
    path: "wall.TAG or wall",
    meaning: "how far the whole boundary, or the part with a tag, stands outward along its normal; rigid parts stay where they are",
    list: |scene| {
        let tags = scene.body.used_tags().enumerate();
        let tags = tags.map(|(i, tag)| (tag.clone(), "m", [i + 1, 0]));
        [(String::new(), "m", [0, 0])].into_iter().chain(tags).collect()
    },
    value: nothing_added,
    set: Setting::By(|scene, walls, [wall, _], value| {
        let moves = walls.map(|walls| walls.moves_of(wall)).unwrap_or_default();
        scene.body.mesh.vertices.iter_mut().zip(moves).for_each(|(x, d)| *x += value * d);
        let findings = mesh::check::check_tets(&scene.body.mesh);
        ensure!(findings.is_empty(), "walls moved by {value:e} m turn an element over");
        Ok(())
    }),
    check: any,
    derivative: |swept, [wall, _]| {
        swept.by_walls.as_ref().map_or(0.0, |(walls, by)| walls.along(wall, by))
    },
    scale: None,
};

/// Moves of the rest vertices per distance: of the whole boundary, then tag by tag.
pub struct Walls {
    extension: Extension,
    vertices: usize,
    /// Tag by tag, the first of the whole boundary.
    shifts: Vec<(Option<String>, BTreeMap<usize, Vec3>)>,
}

impl Walls {
    /// Moves of the walls of a body, or of several bodies. Rigid parts stay: derivatives by their shape are not known.
    pub fn new(scene: &Scene) -> Result<Self> {
        let body = &scene.body;
        let (x, rigid) = (&body.mesh.vertices, scene.rigid_vertices(body)?);
        let shifts = |facets: &[[usize; 3]]| {
            let mut all = shifts(x, facets);
            all.retain(|v, _| !rigid.contains_key(v));
            all
        };
        let extension = Extension::new(body)
            .map_err(|_| anyhow!("to move walls: an element of the mesh is too flat"))?;
        let mut walls = vec![(None, shifts(body.boundary()))];
        for tag in body.used_tags() {
            walls.push((Some(tag.clone()), shifts(&body.facets(tag)?)));
        }
        Ok(Self { extension, vertices: x.len(), shifts: walls })
    }

    /// Where numbers are walls, those of the bodies of a scene.
    pub fn of<'a>(
        numbers: impl IntoIterator<Item = &'a Number>,
        scene: &Scene,
    ) -> Result<Option<Self>> {
        let any = numbers.into_iter().any(|number| number.is_wall());
        any.then(|| Self::new(scene)).transpose()
    }

    /// The derivative by moves of surface vertices, from that by all rest vertices.
    pub(super) fn vjp(&self, by_rest: &[f64]) -> Vec<Vec3> {
        let mut bar: Vec<Vec3> = by_rest.chunks_exact(3).map(Vec3::from_column_slice).collect();
        self.extension.vjp(&mut bar);
        bar
    }

    /// The derivative by the distance of a wall, from that by moves of surface vertices.
    fn along(&self, wall: usize, by: &[Vec3]) -> f64 {
        self.shifts[wall].1.iter().map(|(&v, d)| by[v].dot(d)).sum()
    }

    fn moves_of(&self, wall: usize) -> Vec<Vec3> {
        let mut moves = vec![Vec3::zeros(); self.vertices];
        self.shifts[wall].1.iter().for_each(|(&v, d)| moves[v] = *d);
        self.extension.apply(&mut moves);
        moves
    }

    /// The moves of all vertices per distance of the part with a tag, where there is one.
    pub fn moves(&self, tag: &str) -> Option<Vec<Vec3>> {
        let wall = self.shifts.iter().position(|(own, _)| own.as_deref() == Some(tag))?;
        Some(self.moves_of(wall))
    }
}
