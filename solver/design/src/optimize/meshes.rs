//! The meshes of a cascade: the scene's, and those that levels have in its place.
//!
//! A level moves the surface of its own mesh. At its end the meshes of later levels follow it, so that a
//! design goes from a coarse mesh to a fine one.

use std::path::PathBuf;

use anyhow::{Context, Result};
use mechanics::body::Body;
use scene::config::{DesignConfig, LevelConfig};

use crate::variables::{carry, check_same_body};

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
