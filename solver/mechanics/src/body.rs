//! Tetrahedral bodies whose boundary has named parts.

use std::collections::BTreeSet;
use std::ops::Range;

use mesh::topology::TET_FACETS;
use mesh::{Tags, TetMesh, Volumes, facet_key};

use crate::symmetry::{self, NoPlane, Parallel, Plane};

/// A tag that names no facets.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TagError {
    /// The mesh has no tags.
    #[error("unknown tag \"{tag}\"; the mesh has no tags: tag it first")]
    Untagged {
        /// The tag.
        tag: String,
    },
    /// The mesh has others.
    #[error("unknown tag \"{tag}\"; the mesh has: {}", known.join(", "))]
    Unknown {
        /// The tag.
        tag: String,
        /// Bodies and tags that there are.
        known: Vec<String>,
    },
    /// It has no facet on the boundary.
    #[error("tag \"{tag}\" has no facet on the boundary of the mesh")]
    NotOnBoundary {
        /// The tag.
        tag: String,
    },
    /// It has facets that are none of the mesh.
    #[error(
        "tag \"{tag}\": {lost} of its {count} facets are no facets of a tetrahedron; expected a mesh \
         that keeps the surface inside the body"
    )]
    Lost {
        /// The tag.
        tag: String,
        /// Facets that are none of the mesh.
        lost: usize,
        /// All its facets.
        count: usize,
    },
}

/// Tags in which a body is not cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// One of them has no facets.
    #[error("{}", symmetry::title(tags))]
    Tag {
        /// Tags of the cut.
        tags: Vec<String>,
        /// Which, and why.
        source: TagError,
    },
    /// Their facets are in no plane of symmetry.
    #[error("{}", symmetry::title(tags))]
    Plane {
        /// Tags of the cut.
        tags: Vec<String>,
        /// Why.
        source: NoPlane,
    },
    /// Two planes are parallel.
    #[error(transparent)]
    Parallel(#[from] Parallel),
}

/// One or several bodies in one mesh, with named parts of their boundary.
#[derive(Clone)]
pub struct Body {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// Names of boundary facets.
    pub tags: Tags,
    /// The bodies, in the order of their tetrahedra and vertices.
    pub parts: Vec<Part>,
    /// Planes of symmetry in which it is cut.
    pub planes: Vec<Plane>,
    /// Facets with one tetrahedron, oriented out of the solid.
    skin: Vec<[usize; 3]>,
    /// Facets of the skin that are in no plane of symmetry.
    boundary: Vec<[usize; 3]>,
}

/// One of several bodies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What scenes call it; nothing if it is the only one.
    pub name: Option<String>,
    /// The tetrahedra.
    pub tets: Range<usize>,
    /// The vertices.
    pub vertices: Range<usize>,
}

impl Body {
    /// One body; its boundary is extracted once.
    pub fn new(mesh: TetMesh, tags: Tags) -> Self {
        let part = Part { name: None, tets: 0..mesh.tets.len(), vertices: 0..mesh.vertices.len() };
        Self::with_parts(mesh, tags, vec![part])
    }

    /// The bodies one by one, with their own tags; the name is none if there is only
    /// one.
    pub fn separate(&self) -> Vec<(Option<String>, TetMesh, Tags)> {
        self.parts.iter().map(|part| self.one(part)).collect()
    }

    fn one(&self, part: &Part) -> (Option<String>, TetMesh, Tags) {
        let Some(name) = &part.name else {
            return (None, self.mesh.clone(), self.tags.clone());
        };
        let (vertex, prefix) = (part.vertices.start, format!("{name}."));
        let vertices = self.mesh.vertices[part.vertices.clone()].to_vec();
        let tets = self.mesh.tets[part.tets.clone()].iter().map(|t| t.map(|v| v - vertex));
        let mut tags = Tags::default();
        let mut ids = std::collections::BTreeMap::new();
        // ids count from one
        for (id, tag) in (1..).zip(&self.tags.names) {
            if let Some(own) = tag.strip_prefix(&prefix) {
                tags.names.push(own.to_owned());
                ids.insert(id, u32::try_from(tags.names.len()).expect("fewer than 2^32 tags"));
            }
        }
        for (facet, id) in &self.tags.facets {
            if let (true, Some(own)) = (part.vertices.contains(&facet[0]), ids.get(id)) {
                tags.set(facet.map(|v| v - vertex), *own);
            }
        }
        for (volume, tets) in self.volumes(part) {
            if let Some(own) = volume.strip_prefix(&prefix) {
                tags.volumes.of.extend(tets.map(|_| tags.volumes.names.len()));
                tags.volumes.names.push(own.to_owned());
            }
        }
        (Some(name.clone()), TetMesh { vertices, tets: tets.collect() }, tags)
    }

    /// The bodies of [`Self::separate`] in one.
    pub fn join(mut bodies: Vec<(Option<String>, TetMesh, Tags)>) -> Self {
        if bodies.len() == 1 && bodies[0].0.is_none() {
            let (_, mesh, tags) = bodies.remove(0);
            return Self::new(mesh, tags);
        }
        let named = |(name, mesh, tags): (Option<String>, TetMesh, Tags)| {
            (name.unwrap_or_default(), mesh, tags)
        };
        Self::of_several(bodies.into_iter().map(named).collect())
    }

    /// Several bodies, whose tags are called `name.tag` from now on.
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
            let Volumes { mut names, mut of } = own.volumes;
            if names.is_empty() {
                (names, of) = (vec![name.clone()], vec![0; mesh.tets.len() - tet]);
            } else {
                names.iter_mut().for_each(|volume| *volume = format!("{name}.{volume}"));
            }
            let before = tags.volumes.names.len();
            tags.volumes.names.extend(names);
            tags.volumes.of.extend(of.into_iter().map(|volume| volume + before));
            let (vertices, tets) = (vertex..mesh.vertices.len(), tet..mesh.tets.len());
            parts.push(Part { name: Some(name), tets, vertices });
        }
        Self::with_parts(mesh, tags, parts)
    }

    fn with_parts(mesh: TetMesh, tags: Tags, parts: Vec<Part>) -> Self {
        let skin = mesh::topology::boundary(&mesh).facets;
        Self { mesh, tags, parts, planes: Vec::new(), boundary: skin.clone(), skin }
    }

    /// The body as a part of a symmetric one, cut in the planes of some tags, one list for
    /// each plane. Vertices of the cuts are moved into their planes.
    pub fn cut_by(mut self, cuts: &[Vec<String>]) -> Result<Self, CutError> {
        for tags in cuts {
            let mut facets = Vec::new();
            for tag in tags {
                let found = self.facets(tag);
                facets
                    .extend(found.map_err(|source| CutError::Tag { tags: tags.clone(), source })?);
            }
            let plane = Plane::find(&self.mesh, &self.skin, tags, &facets)
                .map_err(|source| CutError::Plane { tags: tags.clone(), source })?;
            for &v in plane.vertices() {
                self.mesh.vertices[v][plane.axis] = plane.level;
            }
            self.boundary.retain(|&facet| !plane.has_facet(facet));
            self.planes.push(plane);
        }
        symmetry::check_orthogonal(&self.planes)?;
        Ok(self)
    }

    /// Tags of the cut in each plane of symmetry, as [`Self::cut_by`] takes them.
    pub fn cuts(&self) -> Vec<Vec<String>> {
        self.planes.iter().map(|plane| plane.tags.clone()).collect()
    }

    /// All boundary facets, oriented out of the solid; of a part of a symmetric body those
    /// of the whole, without the cuts.
    pub fn boundary(&self) -> &[[usize; 3]] {
        &self.boundary
    }

    /// The volumes of one of several bodies, or of the only one, as far as they have names: one
    /// after the other in the order of tetrahedra.
    fn volumes(&self, part: &Part) -> Vec<(&str, Range<usize>)> {
        let Volumes { names, of } = &self.tags.volumes;
        let own = of.get(part.tets.clone()).unwrap_or_default();
        let mut start = part.tets.start;
        let one = |run: &[usize]| {
            start += run.len();
            (names[run[0]].as_str(), start - run.len()..start)
        };
        own.chunk_by(|a, b| a == b).map(one).collect()
    }

    /// The tetrahedra of a volume of a body, by its place among all; none where there is no volume
    /// of this name.
    pub fn volume(&self, part: usize, name: &str) -> Range<usize> {
        let part = &self.parts[part];
        let full =
            part.name.as_ref().map_or_else(|| name.to_owned(), |body| format!("{body}.{name}"));
        let mut all = self.volumes(part).into_iter();
        all.find(|(volume, _)| *volume == full).map_or(0..0, |(_, tets)| tets)
    }

    /// The body that a vertex belongs to.
    pub fn part_of(&self, vertex: usize) -> usize {
        self.parts.partition_point(|part| part.vertices.end <= vertex)
    }

    /// Names of the tags that have facets; a Gmsh file may name groups that have none.
    pub fn used_tags(&self) -> impl Iterator<Item = &String> {
        self.tags.names.iter().filter(|name| self.facets(name).is_ok())
    }

    /// The facets of a tag, on the boundary of the mesh or inside it, or of the boundary of a
    /// whole body by its name.
    pub fn tagged(&self, name: &str) -> Result<Vec<[usize; 3]>, TagError> {
        let on_boundary = self.facets(name);
        let facets = self.tags.id(name).map(|id| self.tags.facets_of(id)).unwrap_or_default();
        if facets.len() <= on_boundary.as_ref().map_or(0, Vec::len) {
            return on_boundary;
        }
        let of_tet = |tet: &[usize; 4]| TET_FACETS.map(|facet| facet_key(facet.map(|c| tet[c])));
        let all: BTreeSet<[usize; 3]> = self.mesh.tets.iter().flat_map(of_tet).collect();
        let lost = facets.iter().filter(|facet| !all.contains(*facet)).count();
        if lost > 0 {
            return Err(TagError::Lost { tag: name.to_owned(), lost, count: facets.len() });
        }
        Ok(facets)
    }

    /// The boundary facets of a tag, or of a whole body by its name, oriented out
    /// of the solid.
    pub fn facets(&self, name: &str) -> Result<Vec<[usize; 3]>, TagError> {
        if let Some(part) = self.parts.iter().find(|p| p.name.as_deref() == Some(name)) {
            let own = |f: &[usize; 3]| part.vertices.contains(&f[0]);
            return Ok(self.boundary.iter().copied().filter(own).collect());
        }
        let tag = name.to_owned();
        let Some(id) = self.tags.id(name) else {
            let bodies = self.parts.iter().filter_map(|part| part.name.clone());
            let known: Vec<String> = bodies.chain(self.tags.names.iter().cloned()).collect();
            return Err(if known.is_empty() {
                TagError::Untagged { tag }
            } else {
                TagError::Unknown { tag, known }
            });
        };
        let facets: Vec<_> =
            self.skin.iter().copied().filter(|&f| self.tags.get(f) == Some(id)).collect();
        if facets.is_empty() {
            return Err(TagError::NotOnBoundary { tag });
        }
        Ok(facets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cube;

    #[test]
    fn bodies_are_the_same_when_they_are_taken_apart_and_joined() {
        let one = |n: usize, tag: &str| {
            let mesh = cube(n, 0.1);
            let mut tags = Tags::new(vec![tag.to_owned(), "rest".to_owned()]);
            for (i, facet) in mesh::topology::boundary(&mesh).facets.into_iter().enumerate() {
                tags.set(facet, 1 + u32::from(i % 3 == 0));
            }
            (tag.to_owned(), mesh, tags)
        };
        let body = Body::of_several(vec![one(2, "left"), one(1, "right")]);
        let again = Body::join(body.separate());
        assert_eq!(again.mesh, body.mesh);
        assert_eq!(again.parts, body.parts);
        assert_eq!(body.separate()[1].2.names, ["right", "rest"]);
        assert_eq!((again.tags.names, again.tags.facets), (body.tags.names, body.tags.facets));
    }
}
