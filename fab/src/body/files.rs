//! A body, read from its files.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use mesh::io::{MshFile, read_surface, read_tets};
use mesh::{SurfaceMesh, topology};
use program::Names;

use super::boundary::{Boundary, chambers_of};
use super::joined::{join, places};
use super::labels;
use crate::config::Casts;

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
    /// The body with the surface that is cast: that which is asked for, else that of the model, if there is one. Chambers
    /// that were designed are those of the design, and so is all of it if the outside moved.
    pub fn read(&self, chambers: &Names, asked: Option<Casts>) -> Result<Body> {
        let of_mesh = || self.mesh.display().to_string();
        let file = read_tets(self.mesh)?;
        let boundary = Boundary::new(&file, chambers).with_context(of_mesh)?;
        let Some(path) = self.model else {
            ensure!(
                asked != Some(Casts::Model),
                "surface = \"model\" in mold.toml: name the surface that was meshed with --model"
            );
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

impl Sources<'_> {
    /// The body with the surface that is cast.
    fn boundary(
        self,
        boundary: Boundary,
        chambers: &Names,
        asked: Option<Casts>,
    ) -> Result<Boundary> {
        let file = self.modelled.as_ref().unwrap_or(self.file);
        let skin = topology::boundary(&file.mesh);
        let surface = skin.surface(&file.mesh).0;
        Boundary::require_near(&surface, &self.model)?;
        // For each triangle of the model the chamber whose wall it is, if any.
        let of = || -> Result<Vec<Option<usize>>> {
            let chamber = chambers_of(&file.mesh, &skin.facets, &file.tags, chambers)?;
            Ok(labels::of_model(&self.model, &patches(self.path)?, &surface, &chamber))
        };
        let Some(modelled) = &self.modelled else {
            if asked == Some(Casts::Mesh) {
                return Ok(Boundary { beside: Some(self.model), ..boundary });
            }
            return boundary.on(&self.model, &of()?, chambers).with_context(|| self.said());
        };
        if asked == Some(Casts::Mesh) {
            return Ok(boundary);
        }
        if self.outside_moved(modelled, chambers)? {
            let error = "the design moved the outside, so that the model has not its shape";
            ensure!(asked.is_none(), "{error}: {INSTEAD}");
            log::warn!("{error}: the boundary of the tetrahedra is cast");
            return Ok(boundary);
        }
        let modelled = Boundary::new(modelled, chambers)?;
        let cores = modelled.cores.clone();
        let outside = modelled.on(&self.model, &of()?, chambers).with_context(|| self.said())?;
        join(boundary, outside, &cores).with_context(|| self.said())
    }

    fn said(&self) -> String {
        format!("{}: this surface is cast; {INSTEAD}", self.path.display())
    }

    /// Whether the outside of the design has other vertices than that of the mesh as modelled.
    fn outside_moved(&self, modelled: &MshFile, chambers: &Names) -> Result<bool> {
        let outside = |file: &MshFile| -> Result<BTreeSet<[u64; 3]>> {
            let facets = topology::boundary(&file.mesh).facets;
            let of = chambers_of(&file.mesh, &facets, &file.tags, chambers)?;
            let own = facets.iter().zip(of).filter(|(_, of)| of.is_none());
            Ok(places(own.flat_map(|(t, _)| t.map(|v| &file.mesh.vertices[v]))))
        };
        Ok(outside(modelled)? != outside(self.file)?)
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
