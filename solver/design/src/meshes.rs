//! The meshes of a cascade: the scene's, those that levels have in its place, and the same with better elements.
//!
//! A level moves the surface of its own mesh. At its end the meshes of later levels follow it, so that a
//! design goes from a coarse mesh to a fine one.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use mechanics::body::Body;
use mesh::improve::{SurfaceReport, improve_tagged, improve_with_surface, usual_tolerance};
use scene::Scene;
use scene::config::{DesignConfig, LevelConfig};

use variables::{carry, check_same_body};

/// Passes of the interior re-meshing.
const REMESH_PASSES: usize = 10;

/// The meshes that levels have in place of the scene's.
pub struct Meshes {
    others: Vec<Other>,
}

struct Other {
    path: PathBuf,
    /// Name of the body that the file is of, in a scene with several.
    of: Option<String>,
    /// All bodies of the scene as modelled, that one on this mesh.
    body: Body,
}

impl Other {
    fn is_of(&self, level: &LevelConfig) -> bool {
        level.mesh.as_ref() == Some(&self.path) && level.body == self.of
    }
}

impl Meshes {
    /// The meshes of a design, with `read` for the bodies of a scene on the mesh of a level.
    pub fn new(
        scene: &Body,
        design: &DesignConfig,
        read: impl Fn(&LevelConfig) -> Result<Body>,
    ) -> Result<Self> {
        let mut others: Vec<Other> = Vec::new();
        let moving = design.shape.as_ref().map_or(&[][..], |shape| shape.on.all());
        for level in design.levels() {
            let Some(path) = level.mesh.clone() else { continue };
            if others.iter().any(|other| other.is_of(&level)) {
                continue;
            }
            let body = read(&level)?;
            check_same_body(scene, &body, moving).with_context(|| path.display().to_string())?;
            others.push(Other { path, of: level.body, body });
        }
        Ok(Self { others })
    }

    /// Index of the mesh of a level: 0 is the scene's.
    pub fn of(&self, level: &LevelConfig) -> usize {
        self.others.iter().position(|other| other.is_of(level)).map_or(0, |i| i + 1)
    }

    /// All bodies on each mesh but the scene's, as modelled, by its index.
    pub fn others(&self) -> impl Iterator<Item = (usize, &Body)> {
        self.others.iter().enumerate().map(|(i, other)| (i + 1, &other.body))
    }

    /// Bodies on the mesh with this index, moved as the surface is from `before` to `after`, which have the
    /// same boundary facets.
    pub fn follow(
        &self,
        index: usize,
        mut body: Body,
        before: &Body,
        after: &Body,
    ) -> Result<Body> {
        let name = match index.checked_sub(1) {
            None => "the mesh of the scene".to_owned(),
            Some(i) => self.others[i].path.display().to_string(),
        };
        let carried = carry(before, &after.mesh, &body).with_context(|| name.clone())?;
        log::debug!(
            "{name} follows by up to {:.3} mm; surfaces at most {:.4} mm apart",
            1e3 * carried.motion,
            1e3 * carried.apart
        );
        body.mesh.vertices = carried.vertices;
        // planes of symmetry belong to the vertices as they were
        Ok(Body::join(body.separate()).cut_by(&body.cuts())?)
    }
}

/// Improves the bodies that have facets `moving`: their interior, and those facets within a
/// `tolerance` [m] of where they are, [`usual_tolerance`] by default. Tags keep their
/// rims; facets inside with tags, and those between volumes, stay as they are.
pub(super) fn remesh(body: &Body, moving: &[[usize; 3]], tolerance: Option<f64>) -> Result<Body> {
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
    Ok(Body::join(bodies).cut_by(&body.cuts())?)
}

/// A body with better elements inside, and its surface as it is.
pub(super) fn tidied(body: &Body, moving: &[[usize; 3]]) -> Result<Body> {
    remesh(body, moving, Some(0.0)).context("its interior could not be re-meshed")
}

/// Writes a mesh file for each body of a scene, placed as the scene reads them.
pub fn write_bodies(folder: &Path, what: &str, scene: &Scene, body: &Body) -> Result<()> {
    for (part, (name, mut mesh, tags)) in scene.parts.iter().zip(body.separate()) {
        let shift = mesh::Vec3::from(part.config.translate);
        mesh.vertices.iter_mut().for_each(|v| *v -= shift);
        mesh::io::write_tets(&folder.join(mesh_file(what, name.as_deref())), &mesh, &tags)?;
    }
    Ok(())
}

/// Name of a mesh file, of one body of several if it has a name.
pub fn mesh_file(what: &str, body: Option<&str>) -> String {
    body.map_or_else(|| format!("{what}.msh"), |name| format!("{what}.{name}.msh"))
}

#[cfg(test)]
mod tests {
    use mechanics::testing::cube;
    use mesh::Tags;
    use mesh::topology::boundary;

    use super::*;

    /// The unit cube with n cells per side: its floor is a plane of symmetry.
    fn half(n: usize) -> Body {
        let mesh = cube(n, 0.1);
        let mut tags = Tags::new(vec!["cut".to_owned(), "wall".to_owned()]);
        for facet in boundary(&mesh).facets {
            let low = facet.iter().all(|&v| mesh.vertices[v].z == 0.0);
            tags.set(facet, tags.id(if low { "cut" } else { "wall" }).expect("named above"));
        }
        Body::new(mesh, tags).cut_by(&[vec!["cut".to_owned()]]).expect("flat")
    }

    #[test]
    fn a_mesh_follows_in_its_plane_of_symmetry() {
        let (before, other) = (half(2), half(3));
        let mut after = before.clone();
        after.mesh.vertices.iter_mut().for_each(|x| x.y *= 1.0 + x.z);
        let meshes = Meshes { others: Vec::new() };
        let found = meshes.follow(0, other, &before, &after).expect("the same body");
        assert_eq!(found.planes.len(), 1);
        let top = found.mesh.vertices.iter().map(|x| x.y).fold(0.0, f64::max);
        assert!((top - 2.0).abs() < 1e-12, "{top}");
        assert_eq!(found.mesh.vertices.iter().map(|x| x.z).fold(0.0, f64::min), 0.0);
    }
}
