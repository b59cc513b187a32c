//! Meshes of a cascade: on disk before they are used, and elements made better.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::Result;
use mesh::improve::{SurfaceReport, improve_tagged, improve_with_surface, usual_tolerance};

use super::cascade::{Cascade, MEMORY};
use super::checkpoint::Checkpoint;
use super::{Evaluation, Lbfgs, Level};
use crate::body::{Body, Part};
use crate::config::LevelConfig;
use crate::scene::Scene;

/// Passes of the interior re-meshing.
const REMESH_PASSES: usize = 10;

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
        Body::join(bodies).cut_by(&self.scene.config.cuts())
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
        (level, at): (&Level, &Evaluation),
        checkpoint: Checkpoint,
    ) -> Result<Checkpoint> {
        let settings = &self.design.levels()[next];
        let (index, shape) = (self.meshes.of(settings), level.shape(at));
        let mut meshes = self.meshes_from(next, (level, shape), &checkpoint)?;
        let body = meshes.remove(&index).expect("that of the level is among them");
        // a level without iterations tells what the same shape does at another fidelity
        let body = match settings.iterations {
            0 => body,
            _ => self.remeshed(&body, &self.design.levels()[checkpoint.level])?,
        };
        let degree = settings.degree.unwrap_or(self.scene.config.degree);
        let start = (level.carry(at, &body, degree), level.map().loads(&checkpoint.theta));
        let next = match checkpoint.flat {
            true => checkpoint.on_new_mesh(start, Lbfgs::new(MEMORY)),
            false => checkpoint.next_level(start, Lbfgs::new(MEMORY)),
        };
        self.begin_mesh(&body, meshes.iter().map(|(index, body)| (*index, body)), next)
    }

    /// A body improved where the level that has ended moved its surface.
    fn remeshed(&self, body: &Body, ended: &LevelConfig) -> Result<Body> {
        let Some(shape) = &self.design.shape else { return Ok(body.clone()) };
        let moved = shape.on.all().iter().filter(|on| ended.moves(on).is_some());
        let facets: Vec<_> = moved.map(|on| body.facets(on)).collect::<Result<_>>()?;
        remesh(body, &facets.concat(), shape.surface_tolerance)
    }

    /// The meshes of all levels from `next` on, by index, with the shape at the end of a level.
    fn meshes_from(
        &self,
        next: usize,
        (level, shape): (&Level, Body),
        checkpoint: &Checkpoint,
    ) -> Result<BTreeMap<usize, Body>> {
        let levels = self.design.levels();
        let own = self.meshes.of(&levels[checkpoint.level]);
        let wanted: BTreeSet<usize> = levels[next..].iter().map(|l| self.meshes.of(l)).collect();
        let moved = |index: usize| match index == own {
            true => Ok((index, shape.clone())),
            false => {
                let body = self.body_of(checkpoint, Some(index))?;
                Ok((index, self.meshes.follow(index, body, (&level.body, &shape))?))
            }
        };
        wanted.into_iter().map(moved).collect()
    }
}

/// Writes a mesh file for each body of a scene, placed as the scene reads them.
///
/// # Errors
/// When one cannot be written.
pub fn write_bodies(folder: &Path, what: &str, scene: &Scene, body: &Body) -> Result<()> {
    for (part, (name, mut mesh, tags)) in scene.parts.iter().zip(body.separate()) {
        let shift = mesh::Vec3::from(part.config.translate);
        mesh.vertices.iter_mut().for_each(|v| *v -= shift);
        mesh::io::write_tets(&folder.join(mesh_file(what, name.as_deref())), &mesh, &tags)?;
    }
    Ok(())
}

/// Name of a mesh file, of one body of several if it has a name.
#[must_use]
pub fn mesh_file(what: &str, body: Option<&str>) -> String {
    body.map_or_else(|| format!("{what}.msh"), |name| format!("{what}.{name}.msh"))
}

/// Improves the bodies that have facets `moving`: their interior, and those facets within a
/// `tolerance` [m] of where they are, [`usual_tolerance`] by default. Tags keep their
/// rims; facets inside with tags, and those between volumes, stay as they are.
fn remesh(body: &Body, moving: &[[usize; 3]], tolerance: Option<f64>) -> Result<Body> {
    let tolerance = tolerance.unwrap_or_else(|| usual_tolerance(&body.mesh.vertices, moving));
    let mut bodies = body.separate();
    for (part, (_, mesh, tags)) in body.parts.iter().zip(&mut bodies) {
        let own = moving.iter().filter(|facet| part.vertices.contains(&facet[0]));
        let own: Vec<_> = own.map(|f| f.map(|v| v - part.vertices.start)).collect();
        if own.is_empty() {
            continue;
        }
        let (interior, surface) = match tolerance {
            0.0 => (improve_tagged(mesh, tags, REMESH_PASSES), SurfaceReport::default()),
            _ => improve_with_surface(mesh, tags, &own, tolerance, REMESH_PASSES),
        };
        log::info!(
            "re-meshed the interior: radius ratio min {:.3} -> {:.3}, first percentile {:.3} -> \
             {:.3}",
            interior.before.radius_ratio_min,
            interior.after.radius_ratio_min,
            interior.before.radius_ratio_p1,
            interior.after.radius_ratio_p1
        );
        if surface.changed() {
            log::info!(
                "re-meshed the surface: {} edges exchanged, {} contracted, {} split, {} vertices \
                 moved; at most {:.3} mm from where it was",
                surface.flips,
                surface.collapses,
                surface.splits,
                surface.moved,
                1e3 * surface.distance
            );
        }
    }
    Body::join(bodies).cut_by(&body.cuts())
}
