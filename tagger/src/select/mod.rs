//! Selectors: rules that say which boundary facets belong to a tag, and which tetrahedra to a
//! volume.
//!
//! All of them test the centroid of a facet. Testing its three vertices loses
//! whole rims: the vertices of a rim lie on the side wall of an offset body.

mod component;
mod cuboid;
mod patch;
mod plane;
mod point;
mod volume;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use mesh::faces::Face;
use mesh::{SurfaceMesh, Vec3, io};
use program::{Picked, Recognized};
use schemars::{Schema, SchemaGenerator};
use serde::de::DeserializeOwned;

use crate::facets::Facets;
pub use patch::nearest_patches;

/// A rule that picks boundary facets.
pub trait Selector {
    /// Which facets are selected.
    fn select(&self, facets: &Facets, sources: &Sources) -> Result<Vec<bool>>;

    /// Area that the selection should have [m²], where the input knows it.
    fn expected_area(&self, _sources: &Sources) -> Option<f64> {
        None
    }

    /// Distance of a point from the surface of the selection, negative inside [m]; none where it
    /// selects facets only.
    fn signed_distance(&self, _point: &Vec3) -> Option<f64> {
        None
    }

    /// What may be wrong when nothing was selected.
    fn advice(&self, facets: &Facets, sources: &Sources) -> String;
}

/// A row of [`SELECTORS`].
pub struct Entry {
    /// Key in the tag file.
    pub key: &'static str,
    /// Form and meaning of its value.
    pub meaning: &'static str,
    /// Makes the selector from the value of the key.
    pub build: fn(&toml::Value, &mut Sources) -> Result<Box<dyn Selector>>,
    /// What the value may be.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
}

/// Every selector, in the order in which messages list them.
pub const SELECTORS: &[Entry] =
    &[patch::ENTRY, volume::ENTRY, plane::ENTRY, cuboid::ENTRY, component::ENTRY, point::ENTRY];

/// What selectors share: where files are, the open patches, and which of them
/// is nearest to each facet.
pub struct Sources {
    /// Folder that file names are relative to.
    pub folder: PathBuf,
    /// Selection distance ε [m].
    pub epsilon: f64,
    /// Open patches in order of declaration, with their files.
    pub patches: Vec<(PathBuf, SurfaceMesh)>,
    /// The whole model surface, which competes with the patches.
    pub surface: Option<SurfaceMesh>,
    /// Index into `patches` of the patch that each facet belongs to.
    pub nearest: Vec<Option<usize>>,
    /// Which faces are those that were picked.
    pub recognized: Recognized,
}

impl Sources {
    /// No patches yet.
    pub fn new(folder: &Path, epsilon: f64) -> Self {
        let folder = folder.to_path_buf();
        let recognized = Recognized::default();
        Self { folder, epsilon, patches: vec![], surface: None, nearest: vec![], recognized }
    }

    /// Looks for the faces that were picked among the patches in the folder.
    pub fn recognize(&mut self, picked: &BTreeMap<String, Picked>) -> Result<()> {
        let shown = || self.folder.display().to_string();
        let entries = std::fs::read_dir(&self.folder).with_context(shown)?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        files.retain(|path| io::extension(path) == "stl");
        files.sort();
        let patches: Vec<SurfaceMesh> =
            files.iter().map(|path| io::read_surface_in_metres(path)).collect::<Result<_, _>>()?;
        let names = files.iter().map(|path| path.file_name().unwrap_or_default());
        let names = names.map(|name| name.to_string_lossy().into_owned());
        let now = names.zip(Face::of_patches(&patches)).collect();
        self.recognized = Recognized::new(picked, now)?;
        Ok(())
    }

    /// The file of a selection; of a face that was picked, the one that is like it.
    pub fn file(&self, name: &str) -> Result<PathBuf> {
        Ok(self.folder.join(self.recognized.file(name)?))
    }
}

/// Reads the value of a selector's key.
fn parse<T: DeserializeOwned>(value: &toml::Value, entry: &Entry) -> Result<T> {
    value
        .clone()
        .try_into()
        .map_err(|e| anyhow!("`{}` must be {}: {}", entry.key, entry.meaning, e.message().trim()))
}

/// A file name in the tag file, from the folder of the selections.
fn path_of(value: &toml::Value, entry: &Entry, sources: &Sources) -> Result<PathBuf> {
    Ok(sources.folder.join(parse::<PathBuf>(value, entry)?))
}

/// Axis-aligned bounds of the centroids, for messages.
fn extent(facets: &Facets) -> String {
    let (min, max) = mesh::measure::bounds(&facets.centroids);
    format!("the boundary's centroids span {} to {} m", point(&min), point(&max))
}

/// A point, for messages [m].
pub fn point(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}
