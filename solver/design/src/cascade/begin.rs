//! How a level begins: the shape that the one before ended with, on its mesh and on those of later levels; the first one
//! with the body as modelled, or with another start beside it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use anyhow::{Result, bail};
use mechanics::body::{Body, Part};
use mechanics::math::linear::norm;
use mechanics::math::random::Random;
use scene::config::LevelConfig;

use super::Cascade;
use crate::meshes::{mesh_file, remesh, tidied};
use crate::{Checkpoint, Evaluation, Level, Rejected};

/// Rounds of motion and meshing in which a start gets to where its constraints are kept.
const ROUNDS: usize = 8;
/// How often such a motion is halved until it gives a valid shape.
const HALVINGS: i32 = 5;
/// Largest motion of the surface, over its mean edge [1].
const SPREAD: f64 = 1.0;
/// Largest motion of a variable of the loads, over the mean edge of the surface [1].
const LOADS: f64 = 2.0;
/// How often a motion is halved until the shape is valid.
const SPREAD_HALVINGS: usize = 8;

impl Cascade<'_> {
    /// The mesh that a level began with, or that its iteration `meshed_at` made; of a later level's mesh
    /// with its index.
    fn mesh_path(&self, at: &Checkpoint, later: Option<usize>, part: &Part) -> PathBuf {
        let mut what = match at.meshed_at {
            0 => format!("level-{}", at.level + 1),
            iteration => format!("remeshed-{}-{iteration}", at.level + 1),
        };
        if let Some(index) = later {
            what += &format!("-mesh-{index}");
        }
        self.folder.join(mesh_file(&what, part.name.as_deref()))
    }

    /// The body that a level began with, or, with its index, the mesh of a later level at that time.
    pub(super) fn body_of(&self, checkpoint: &Checkpoint, later: Option<usize>) -> Result<Body> {
        let part = |part: &Part| {
            let path = self.mesh_path(checkpoint, later, part);
            let file = mesh::io::read_tets(&path)?;
            Ok((part.name.clone(), file.mesh, file.tags))
        };
        let bodies = self.scene.body.parts.iter().map(part).collect::<Result<_>>()?;
        Ok(Body::join(bodies).cut_by(&self.scene.config.cuts())?)
    }

    /// The checkpoint before the first solve, from the body as modelled or another start.
    pub(super) fn begin(&self) -> Result<Checkpoint> {
        let mut start = Checkpoint::new(self.inputs.clone());
        let modelled = &self.scene.body;
        if self.start == 1 && self.meshes.others().next().is_none() {
            return self.begin_mesh(&self.kept(modelled)?, None, start);
        }
        if self.start == 1 {
            return self.begin_mesh(modelled, self.meshes.others(), start);
        }
        let (moved, tidied, loads) = self.spread_start(self.start)?;
        start.loads = loads;
        let follow = |(index, body): (usize, &Body)| {
            Ok((index, self.meshes.follow(index, body.clone(), modelled, &moved)?))
        };
        let others = self.meshes.others().map(follow).collect::<Result<Vec<_>>>()?;
        self.begin_mesh(&tidied, others.iter().map(|(index, body)| (*index, body)), start)
    }

    /// A body moved to where its constraints are kept, by the variables of the first level; its interior is re-meshed on the
    /// way, so that elements do not get flat. As it is where there is no such way: the level says why.
    fn kept(&self, body: &Body) -> Result<Body> {
        let mut body = body.clone();
        if !self.design.constraint.iter().any(|kept| kept.is_of_shape()) {
            return Ok(body);
        }
        let settings = &self.design.levels()[0];
        let scene = self.scene.with_fidelity(settings)?;
        for _ in 0..ROUNDS {
            let level = Level::new(&scene, &self.objectives, body.clone(), self.design, settings)?;
            let zero = level.map.start(&[]);
            let Ok(there) = level.restored(&zero) else { return Ok(body) };
            let motion = level.map.vertex_motion(&zero, &there);
            if motion == 0.0 {
                return Ok(body);
            }
            let at = |part: f64| -> Vec<f64> { there.iter().map(|d| part * d).collect() };
            let mut parts = (0..HALVINGS).map(|k| 0.5_f64.powi(k));
            let valid = |part: &f64| {
                level.free_fraction(&zero, &at(*part)) >= 1.0
                    && level.check_flat(&at(*part)).is_ok()
            };
            let Some(part) = parts.find(valid) else { return Ok(body) };
            body.mesh.vertices = level.map.shape(&at(part));
            body = tidied(&body, level.map.moving())?;
            let moved = 1e3 * part * motion;
            log::info!(
                "the start is moved by up to {moved:.3} mm, to where its constraints are kept"
            );
        }
        Ok(body)
    }

    /// Puts the mesh of a level, those of later ones and the checkpoint before its first solve on disk.
    pub(super) fn begin_mesh<'b>(
        &self,
        body: &Body,
        later: impl IntoIterator<Item = (usize, &'b Body)>,
        mut checkpoint: Checkpoint,
    ) -> Result<Checkpoint> {
        let later = later.into_iter().map(|(index, body)| (Some(index), body));
        for (index, body) in std::iter::once((None, body)).chain(later) {
            for (part, (_, mesh, tags)) in body.parts.iter().zip(body.separate()) {
                let path = self.mesh_path(&checkpoint, index, part);
                mesh::io::write_tets(&path, &mesh, &tags)?;
                checkpoint.add_file(&path)?;
            }
        }
        checkpoint.write(&self.folder)?;
        Ok(checkpoint)
    }

    /// The checkpoint before the first solve of the level `next`, the one after or the same on a new mesh,
    /// with its meshes on disk.
    pub(super) fn begin_level(
        &self,
        next: usize,
        level: &Level,
        at: &Evaluation,
        checkpoint: Checkpoint,
    ) -> Result<Checkpoint> {
        let levels = self.design.levels();
        let settings = &levels[next];
        let (index, shape) = (self.meshes.of(settings), level.shape(at));
        let mut meshes = self.meshes_from(next, level, shape, &checkpoint)?;
        let body = meshes.remove(&index).expect("that of the level is among them");
        let ended = &levels[checkpoint.level];
        // a level without iterations tells what the same mesh does at another fidelity
        let same = settings.iterations == 0 && index == self.meshes.of(ended);
        let body = if same { body } else { self.improved(&body, ended)? };
        let degree = settings.degree.unwrap_or(self.scene.config.degree);
        let loads = level.map.loads(&checkpoint.theta);
        let mut next = match checkpoint.flat {
            true => checkpoint.on_new_mesh(loads),
            false => checkpoint.next_level(loads),
        };
        next.write_start(&self.folder, &level.carry(at, &body, degree))?;
        self.begin_mesh(&body, meshes.iter().map(|(index, body)| (*index, body)), next)
    }

    /// The evaluation next to the runs that were carried over to a level; none without any.
    pub(super) fn solve_near(
        &self,
        level: &Level,
        theta: &[f64],
        checkpoint: &Checkpoint,
    ) -> Result<Option<Evaluation>> {
        if checkpoint.start.is_empty() {
            return Ok(None);
        }
        let states = checkpoint.read_start(&self.folder)?;
        let near = level.carried(theta, &checkpoint.start, states)?;
        let outcome = level.evaluate(theta, &near);
        if let Err(why) = &outcome {
            log::debug!("no equilibrium next to the last level's ({why}); starting from rest");
        }
        Ok(outcome.ok())
    }

    /// A body improved where the level that has ended moved its surface.
    fn improved(&self, body: &Body, ended: &LevelConfig) -> Result<Body> {
        let Some(shape) = &self.design.shape else { return Ok(body.clone()) };
        let moved = shape.on.all().iter().filter(|on| shape.moves(ended, on).is_some());
        let facets: Vec<_> = moved.map(|on| body.facets(on)).collect::<Result<_, _>>()?;
        remesh(body, &facets.concat(), shape.surface_tolerance)
    }

    /// The meshes of all levels from `next` on, by index, with the shape at the end of a level.
    fn meshes_from(
        &self,
        next: usize,
        level: &Level,
        shape: Body,
        checkpoint: &Checkpoint,
    ) -> Result<BTreeMap<usize, Body>> {
        let levels = self.design.levels();
        let own = self.meshes.of(&levels[checkpoint.level]);
        let wanted: BTreeSet<usize> = levels[next..].iter().map(|l| self.meshes.of(l)).collect();
        let moved = |index: usize| match index == own {
            true => Ok((index, shape.clone())),
            false => {
                let body = self.body_of(checkpoint, Some(index))?;
                Ok((index, self.meshes.follow(index, body, &level.body, &shape)?))
            }
        };
        wanted.into_iter().map(moved).collect()
    }

    /// The body, as it is and with its interior re-meshed, and the loads of the start with this number, the second or a later
    /// one: all handles of the first level that has some, and the loads, are changed at random, as far as shapes are valid
    /// and keep the constraints.
    fn spread_start(&self, number: usize) -> Result<(Body, Body, Vec<f64>)> {
        let levels = self.design.levels();
        let settings = levels.iter().find(|level| level.handles.is_some()).unwrap_or(&levels[0]);
        let settings = LevelConfig { mesh: None, body: None, ..settings.clone() };
        let scene = self.scene.with_fidelity(&settings)?;
        let body = scene.body.clone();
        let level = Level::new(&scene, &self.objectives, body, self.design, &settings)?;
        let mut random = Random::new(number as u64);
        let (shapes, count) = (level.map.shape_variables(), level.variables());
        let direction = random.numbers(count);
        let loads = level.map.mean_edge * LOADS / norm(&direction[shapes..]).max(1.0);
        let zero = vec![0.0; count];
        let mut only_shape = direction.clone();
        only_shape[shapes..].fill(0.0);
        let edge = level.map.mean_edge;
        // at a small amplitude the motion is proportional to it
        let unit = 1e-3 * edge / norm(&direction).max(1.0);
        let small: Vec<f64> = only_shape.iter().map(|d| unit * d).collect();
        let per_unit = level.map.motion(&zero, &small) / unit;
        let mut amplitude = if shapes == 0 { 0.0 } else { SPREAD * edge / per_unit };
        let mut why = String::new();
        for _ in 0..SPREAD_HALVINGS {
            let mut theta: Vec<f64> = only_shape.iter().map(|d| amplitude * d).collect();
            let of_loads = theta[shapes..].iter_mut().zip(&direction[shapes..]);
            of_loads.for_each(|(own, d)| *own = loads * d);
            if let Some((low, high)) = level.map.bounds(&zero) {
                let each = theta.iter_mut().enumerate();
                each.for_each(|(i, own)| *own = own.clamp(low[i], high[i]));
            }
            match tried(&level, &theta) {
                Ok(theta) => {
                    let mut body = scene.body.clone();
                    body.mesh.vertices = level.map.shape(&theta);
                    let tidied = tidied(&body, level.map.moving())?;
                    return Ok((body, tidied, level.map.loads(&theta)));
                }
                Err(rejected) => (why, amplitude) = (rejected.why, 0.5 * amplitude),
            }
        }
        bail!("start {number}: no shape next to the body as modelled is valid: {why}")
    }
}

/// The variables next to these that keep the constraints, if they give a valid shape.
fn tried(level: &Level, theta: &[f64]) -> Result<Vec<f64>, Rejected> {
    let zero = vec![0.0; theta.len()];
    let theta = level.restored(theta)?;
    if level.free_fraction(&zero, &theta) < 1.0 {
        return Err(Rejected::new("the surface would pass through itself"));
    }
    level.admit(&level.map.shape(&theta))?;
    Ok(theta)
}
