//! A body, read from its files.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use mesh::io::{MshFile, read_surface, read_tets};
use mesh::{SurfaceMesh, topology};

use super::boundary::{Boundary, chambers_of};
use super::carried::{Carried, Walls, carry};
use super::joined::{join, places};
use super::labels;
use crate::config::{Casts, Chambers};

/// Folder beside a model with its regions.
const PATCHES: &str = "patches";

/// What can be done where the surface of a model cannot be cast.
const INSTEAD: &str = "surface = \"mesh\" in mold.toml casts the boundary of the tetrahedra";

/// The files of a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyFiles<'a> {
    /// The tetrahedra.
    pub mesh: &'a Path,
    /// The surface that they were made from.
    pub model: Option<&'a Path>,
    /// The mesh as modelled, if the body was designed since.
    pub modelled: Option<&'a Path>,
}

/// A body and its mesh.
pub struct Body {
    /// The closed surfaces of the body and its chambers.
    pub boundary: Boundary,
    /// The tetrahedra with the tags of their facets.
    pub file: MshFile,
}

impl BodyFiles<'_> {
    /// The body with the surface that is cast: that which is asked for, else that of the model, if there is one,
    /// carried with the design. Where that is not valid, chambers that were designed are those of the design, and so
    /// is all of it if the outside moved.
    pub fn read(&self, chambers: &Chambers, asked: Option<Casts>) -> Result<Body> {
        let of_mesh = || self.mesh.display().to_string();
        let file = read_tets(self.mesh)?;
        let boundary = Boundary::new(&file, chambers).with_context(of_mesh)?;
        let Some(path) = self.model else {
            if let Some(asked @ (Casts::Model | Casts::Carried)) = asked {
                let name = asked.name();
                bail!(
                    "surface = {name:?} in mold.toml: name the surface that was meshed with --model"
                );
            }
            return Ok(Body { boundary, file });
        };
        let modelled = self.modelled.map(read_tets).transpose()?;
        let sources = Sources { path, model: read_surface(path)?, file: &file, modelled };
        let boundary = sources.boundary(boundary, chambers, asked).with_context(of_mesh)?;
        Ok(Body { boundary, file })
    }
}

/// What is read of a body that has a model.
struct Sources<'a> {
    path: &'a Path,
    model: SurfaceMesh,
    file: &'a MshFile,
    modelled: Option<MshFile>,
}

/// The boundary of a mesh as modelled.
struct Skin<'a> {
    file: &'a MshFile,
    facets: Vec<[usize; 3]>,
    surface: SurfaceMesh,
    /// For each facet the chamber whose wall it is, if any.
    chamber: Vec<Option<usize>>,
}

impl Sources<'_> {
    /// The body with the surface that is cast.
    fn boundary(
        self,
        boundary: Boundary,
        chambers: &Chambers,
        asked: Option<Casts>,
    ) -> Result<Boundary> {
        let skin = Skin::new(self.modelled.as_ref().unwrap_or(self.file), chambers)?;
        Boundary::require_near(&skin.surface, &self.model)?;
        let Some(modelled) = &self.modelled else {
            if asked == Some(Casts::Mesh) {
                return Ok(Boundary { beside: Some(self.model), ..boundary });
            }
            let of = self.labels(&skin, &skin.chamber)?;
            return boundary.on(&self.model, &of, chambers).with_context(|| self.said());
        };
        if matches!(asked, None | Some(Casts::Carried)) {
            match self.carried(&skin, &boundary, chambers) {
                Ok(carried) => return Ok(carried),
                Err(error) if asked.is_some() => return Err(error.context(self.said())),
                Err(error) => log::warn!(
                    "{}: it cannot be carried with the design: {error:#}: what moved is cast as the \
                     tetrahedra have it",
                    self.path.display()
                ),
            }
        }
        if asked == Some(Casts::Mesh) {
            return Ok(boundary);
        }
        if self.outside_moved(modelled, chambers)? {
            let error = "the design moved the outside, so that the model has not its shape";
            ensure!(asked.is_none(), "{error}: {INSTEAD}");
            log::warn!("{error}: the boundary of the tetrahedra is cast");
            return Ok(boundary);
        }
        let of = self.labels(&skin, &skin.chamber)?;
        let modelled = Boundary::new(modelled, chambers)?;
        let cores = modelled.cores.clone();
        let outside = modelled.on(&self.model, &of, chambers).with_context(|| self.said())?;
        join(boundary, outside, &cores).with_context(|| self.said())
    }

    fn said(&self) -> String {
        format!("{}: this surface is cast; {INSTEAD}", self.path.display())
    }

    /// For each triangle of the model the answer of the facets there.
    fn labels(&self, skin: &Skin, answers: &[Option<usize>]) -> Result<Vec<Option<usize>>> {
        Ok(labels::of_model(&self.model, &patches(self.path)?, &skin.surface, answers))
    }

    /// The body with the surface of the model, carried as the design moved the mesh.
    fn carried(&self, skin: &Skin, design: &Boundary, chambers: &Chambers) -> Result<Boundary> {
        let Skin { file, facets, .. } = skin;
        let tags: Vec<Option<usize>> =
            facets.iter().map(|facet| file.tags.get(*facet).map(|id| id as usize)).collect();
        let walls = Walls { modelled: &file.mesh, design: &self.file.mesh, facets, tags: &tags };
        let Carried { surface, origin } = carry(&self.model, &self.labels(skin, &tags)?, &walls)?;
        let of = self.labels(skin, &skin.chamber)?;
        let chamber: Vec<Option<usize>> = origin.into_iter().map(|t| of[t]).collect();
        let carried = design.clone().on(&surface, &chamber, chambers)?;
        // Walls of a designed body are others than those of its model.
        Ok(Boundary { casts: Casts::Carried, beside: None, ..carried })
    }

    /// Whether the outside of the design has other vertices than that of the mesh as modelled.
    fn outside_moved(&self, modelled: &MshFile, chambers: &Chambers) -> Result<bool> {
        let outside = |file: &MshFile| -> Result<BTreeSet<[u64; 3]>> {
            let facets = topology::boundary(&file.mesh).facets;
            let of = chambers_of(&file.mesh, &facets, &file.tags, chambers)?;
            let own = facets.iter().zip(of).filter(|(_, of)| of.is_none());
            Ok(places(own.flat_map(|(t, _)| t.map(|v| &file.mesh.vertices[v]))))
        };
        Ok(outside(modelled)? != outside(self.file)?)
    }
}

impl<'a> Skin<'a> {
    fn new(file: &'a MshFile, chambers: &Chambers) -> Result<Self> {
        let skin = topology::boundary(&file.mesh);
        let surface = skin.surface(&file.mesh).0;
        let chamber = chambers_of(&file.mesh, &skin.facets, &file.tags, chambers)?;
        Ok(Self { file, facets: skin.facets, surface, chamber })
    }
}

/// The regions of a model: the surfaces in the folder beside it, if there is one.
fn patches(model: &Path) -> Result<Vec<SurfaceMesh>> {
    let folder = model.with_file_name(PATCHES);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|end| end == "stl"));
    files.sort();
    files.iter().map(|path| Ok(read_surface(path)?)).collect()
}
