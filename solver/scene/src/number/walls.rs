//! Walls that stand off along their normals: another rest shape from one.
//!
//! X_s = X + 𝓔 Σ d_k n_k(X)
//!
//! d_k      how far the walls with a tag, or all, are off, outward [m]
//! n_k(X)   moves of their vertices per distance, [`shifts`]; rigid parts stay
//! 𝓔        extension into the interior

use std::collections::BTreeMap;

use crate::model::Scene;
use crate::term::{Place, RoomNumber, rigid};
use anyhow::{Result, anyhow, ensure};
use mechanics::body::Body;
use mechanics::energy::Slot;
use mesh::Vec3;
use mesh::offset::{add_shifts_vjp, shifts};

use super::{Kind, Number, Owners};
use mechanics::extension::Extension;

pub(super) const WALL: Kind = Kind {
    word: "wall",
    paths: "wall.TAG or wall",
    meaning: "how far the whole boundary, or the part with a tag, stands outward along its normal; rigid parts stay where they are",
    numbers,
    derivative: |swept, number| {
        swept.by_walls.as_ref().map_or(0.0, |(walls, by)| walls.along(number.owner(), by))
    },
};

fn numbers<'a>(_: &str, Owners { body, .. }: Owners<'a>) -> Vec<RoomNumber<'a>> {
    let names = [String::new()].into_iter().chain(body.used_tags().cloned()).enumerate();
    let slot = || Slot::new("", "m");
    names
        .map(|(table, name)| RoomNumber { table, name, slot: slot(), place: Place::Wall })
        .collect()
}

/// Moves a wall of a scene outward [m].
pub(super) fn set(scene: &mut Scene, walls: Option<&Walls>, wall: usize, by: f64) -> Result<()> {
    let moves = walls.map(|walls| walls.moves_of(wall)).unwrap_or_default();
    scene.body.mesh.vertices.iter_mut().zip(moves).for_each(|(x, d)| *x += by * d);
    let findings = mesh::check::check_tets(&scene.body.mesh);
    ensure!(findings.is_empty(), "walls moved by {by:e} m turn an element over");
    Ok(())
}

/// The walls of a body, or of several bodies. Rigid parts stay: derivatives by their shape are not known.
pub struct Walls {
    extension: Extension,
    /// X of the body [m].
    rest: Vec<Vec3>,
    rigid: BTreeMap<usize, String>,
    /// Facets tag by tag, the first those of the whole boundary.
    facets: Vec<(Option<String>, Vec<[usize; 3]>)>,
}

impl Walls {
    /// The walls of the body of a scene.
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::on(scene, &scene.body)
    }

    /// The walls of the body of a scene on another mesh, or with another shape.
    pub fn on(scene: &Scene, body: &Body) -> Result<Self> {
        let extension = Extension::new(body)
            .map_err(|_| anyhow!("to move walls: an element of the mesh is too flat"))?;
        let mut facets = vec![(None, body.boundary().to_vec())];
        for tag in body.used_tags() {
            facets.push((Some(tag.clone()), body.facets(tag)?));
        }
        let (rest, rigid) =
            (body.mesh.vertices.clone(), rigid::vertices(&scene.config.rigid, body)?);
        Ok(Self { extension, rest, rigid, facets })
    }

    /// Where numbers are walls, those of the bodies of a scene.
    pub fn of<'a>(
        numbers: impl IntoIterator<Item = &'a Number>,
        scene: &Scene,
    ) -> Result<Option<Self>> {
        let any = numbers.into_iter().any(|number| number.is_wall());
        any.then(|| Self::new(scene)).transpose()
    }

    /// n of a wall at a shape.
    fn shifts(&self, wall: usize, x: &[Vec3]) -> impl Iterator<Item = (usize, Vec3)> {
        shifts(x, &self.facets[wall].1)
            .into_iter()
            .filter(move |(v, _)| !self.rigid.contains_key(v))
    }

    /// The derivative by moves of surface vertices, from that by all rest vertices.
    pub(super) fn vjp(&self, by_rest: &[f64]) -> Vec<Vec3> {
        let mut bar: Vec<Vec3> = by_rest.chunks_exact(3).map(Vec3::from_column_slice).collect();
        self.extension.vjp(&mut bar);
        bar
    }

    /// The derivative by the distance of a wall, from that by moves of surface vertices.
    fn along(&self, wall: usize, by: &[Vec3]) -> f64 {
        self.shifts(wall, &self.rest).map(|(v, d)| by[v].dot(&d)).sum()
    }

    fn moves_of(&self, wall: usize) -> Vec<Vec3> {
        self.way(&self.rest, &[(wall, 1.0)])
    }

    /// X_s − X.
    fn way(&self, x: &[Vec3], off: &[(usize, f64)]) -> Vec<Vec3> {
        let mut moves = vec![Vec3::zeros(); x.len()];
        for (wall, distance) in off {
            self.shifts(*wall, x).for_each(|(v, d)| moves[v] += *distance * d);
        }
        self.extension.apply(&mut moves);
        moves
    }

    /// The moves of all vertices per distance of the part with a tag, where there is one.
    pub fn moves(&self, tag: &str) -> Option<Vec<Vec3>> {
        let wall = self.facets.iter().position(|(own, _)| own.as_deref() == Some(tag))?;
        Some(self.moves_of(wall))
    }

    /// The walls that are off, each by its tag or all of them, with their distances [m].
    fn off(&self, off: &[(Option<&str>, f64)]) -> Vec<(usize, f64)> {
        let wall = |tag| self.facets.iter().position(|(own, _)| own.as_deref() == tag);
        off.iter().filter_map(|(tag, distance)| Some((wall(*tag)?, *distance))).collect()
    }

    /// X_s of a shape of the body, with the walls with tags, or all, so far off [m].
    pub fn moved(&self, x: &[Vec3], off: &[(Option<&str>, f64)]) -> Vec<Vec3> {
        x.iter().zip(self.way(x, &self.off(off))).map(|(x, d)| x + d).collect()
    }

    /// Adds to the cotangent of X_s, three components per vertex, what makes it that of X.
    pub fn add_vjp(&self, x: &[Vec3], off: &[(Option<&str>, f64)], bar: &mut [f64]) {
        let mut moves_bar = self.vjp(bar);
        self.rigid.keys().for_each(|&v| moves_bar[v] = Vec3::zeros());
        let mut by_x = vec![Vec3::zeros(); x.len()];
        for (wall, distance) in self.off(off) {
            let scaled: Vec<Vec3> = moves_bar.iter().map(|bar| distance * bar).collect();
            add_shifts_vjp(x, &self.facets[wall].1, &scaled, &mut by_x);
        }
        for (bar, by) in bar.chunks_exact_mut(3).zip(by_x) {
            (0..3).for_each(|k| bar[k] += by[k]);
        }
    }
}
