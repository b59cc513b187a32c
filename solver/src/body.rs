//! A tetrahedral body whose boundary has named parts.

use anyhow::{Result, bail, ensure};
use mesh::{Tags, TetMesh};

/// A body with named parts of its boundary.
#[derive(Clone)]
pub struct Body {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// Names of boundary facets.
    pub tags: Tags,
    /// Boundary facets oriented out of the solid.
    boundary: Vec<[usize; 3]>,
}

impl Body {
    /// A tagged mesh; its boundary is extracted once.
    #[must_use]
    pub fn new(mesh: TetMesh, tags: Tags) -> Self {
        let boundary = mesh::topology::boundary(&mesh).facets;
        Self { mesh, tags, boundary }
    }

    /// All boundary facets, oriented out of the solid.
    #[must_use]
    pub fn boundary(&self) -> &[[usize; 3]] {
        &self.boundary
    }

    /// Names of the tags that have facets; a Gmsh file may name groups that have none.
    pub fn used_tags(&self) -> impl Iterator<Item = &String> {
        self.tags.names.iter().filter(|name| self.facets(name).is_ok())
    }

    /// The boundary facets of a tag, oriented out of the solid.
    ///
    /// # Errors
    /// When the body has no such tag or the tag has no boundary facet.
    pub fn facets(&self, name: &str) -> Result<Vec<[usize; 3]>> {
        let Some(id) = self.tags.id(name) else {
            bail!("unknown tag \"{name}\"; the mesh has: {}", self.tags.names.join(", "));
        };
        let facets: Vec<_> =
            self.boundary.iter().copied().filter(|&f| self.tags.get(f) == Some(id)).collect();
        ensure!(!facets.is_empty(), "tag \"{name}\" has no facet on the boundary of the mesh");
        Ok(facets)
    }
}
