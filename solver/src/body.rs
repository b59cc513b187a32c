//! Tetrahedral bodies whose boundary has named parts.

use std::ops::Range;

use anyhow::{Result, bail, ensure};
use mesh::{Tags, TetMesh};

/// One or several bodies in one mesh, with named parts of their boundary.
#[derive(Clone)]
pub struct Body {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// Names of boundary facets.
    pub tags: Tags,
    /// The bodies, in the order of their tetrahedra and vertices.
    pub parts: Vec<Part>,
    /// Boundary facets oriented out of the solid.
    boundary: Vec<[usize; 3]>,
}

/// One of several bodies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What scenes call it; nothing if it is the only one.
    pub name: Option<String>,
    /// Its tetrahedra.
    pub tets: Range<usize>,
    /// Its vertices.
    pub vertices: Range<usize>,
}

impl Body {
    /// One body; its boundary is extracted once.
    #[must_use]
    pub fn new(mesh: TetMesh, tags: Tags) -> Self {
        let part = Part { name: None, tets: 0..mesh.tets.len(), vertices: 0..mesh.vertices.len() };
        Self::with_parts(mesh, tags, vec![part])
    }

    /// Several bodies, whose tags are called `name.tag` from now on.
    #[must_use]
    pub fn of_several(bodies: Vec<(String, TetMesh, Tags)>) -> Self {
        let mut mesh = TetMesh { vertices: Vec::new(), tets: Vec::new() };
        let (mut tags, mut parts) = (Tags::default(), Vec::new());
        for (name, one, own) in bodies {
            let (vertex, tet) = (mesh.vertices.len(), mesh.tets.len());
            let before = u32::try_from(tags.names.len()).expect("fewer than 2^32 tags");
            mesh.vertices.extend(one.vertices);
            mesh.tets.extend(one.tets.iter().map(|t| t.map(|v| v + vertex)));
            tags.names.extend(own.names.iter().map(|tag| format!("{name}.{tag}")));
            for (facet, id) in own.facets {
                tags.set(facet.map(|v| v + vertex), id + before);
            }
            let (vertices, tets) = (vertex..mesh.vertices.len(), tet..mesh.tets.len());
            parts.push(Part { name: Some(name), tets, vertices });
        }
        Self::with_parts(mesh, tags, parts)
    }

    fn with_parts(mesh: TetMesh, tags: Tags, parts: Vec<Part>) -> Self {
        let boundary = mesh::topology::boundary(&mesh).facets;
        Self { mesh, tags, parts, boundary }
    }

    /// All boundary facets, oriented out of the solid.
    #[must_use]
    pub fn boundary(&self) -> &[[usize; 3]] {
        &self.boundary
    }

    /// The body that a vertex belongs to.
    #[must_use]
    pub fn part_of(&self, vertex: usize) -> usize {
        self.parts.partition_point(|part| part.vertices.end <= vertex)
    }

    /// Names of the tags that have facets; a Gmsh file may name groups that have none.
    pub fn used_tags(&self) -> impl Iterator<Item = &String> {
        self.tags.names.iter().filter(|name| self.facets(name).is_ok())
    }

    /// The boundary facets of a tag, or of a whole body by its name, oriented out
    /// of the solid.
    ///
    /// # Errors
    /// When there is no such tag or the tag has no boundary facet.
    pub fn facets(&self, name: &str) -> Result<Vec<[usize; 3]>> {
        if let Some(part) = self.parts.iter().find(|p| p.name.as_deref() == Some(name)) {
            let own = |f: &[usize; 3]| part.vertices.contains(&f[0]);
            return Ok(self.boundary.iter().copied().filter(own).collect());
        }
        let Some(id) = self.tags.id(name) else {
            let bodies = self.parts.iter().filter_map(|part| part.name.clone());
            let all: Vec<String> = bodies.chain(self.tags.names.iter().cloned()).collect();
            bail!("unknown tag \"{name}\"; the mesh has: {}", all.join(", "));
        };
        let facets: Vec<_> =
            self.boundary.iter().copied().filter(|&f| self.tags.get(f) == Some(id)).collect();
        ensure!(!facets.is_empty(), "tag \"{name}\" has no facet on the boundary of the mesh");
        Ok(facets)
    }
}
