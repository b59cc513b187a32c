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

use anyhow::{Context as _, Result, bail};
use mesh::faces::Face;
use mesh::{SurfaceMesh, Vec3, io};
use program::{KeyPath, Picked, Recognized};

use crate::facets::Facets;
pub use cuboid::{Cuboid, ordered};
pub use patch::nearest_patches;
pub use plane::Plane;
pub use point::Point;

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

/// The rule that a table asks for.
pub enum Selection<'a> {
    /// Facets on open surfaces, by the names of their files.
    Patch(&'a [String]),
    /// What is inside a closed surface.
    Volume(&'a Path),
    /// What is on or beyond a plane.
    Plane(&'a Plane),
    /// What is inside a box.
    Box(&'a Cuboid),
    /// A connected component.
    Component(usize),
    /// Facets around a point.
    Point(&'a Point),
}

impl<'a> Selection<'a> {
    /// The only one of those that a table has, by their keys.
    pub fn only<const N: usize>(given: [(&str, Option<Self>); N]) -> Result<Self> {
        let given = given.into_iter();
        let mut given = given.filter_map(|(key, selection)| Some((key, selection?)));
        match (given.next(), given.next()) {
            (Some((_, one)), None) => Ok(one),
            (None, _) => bail!(
                "no selector; one of `patch`, `volume`, `plane`, `box`, `component`, `point` is needed, for a [[volume]] one \
                 of `volume`, `plane`, `box`"
            ),
            (Some((one, _)), Some((other, _))) => {
                let what = format!("both `{one}` and `{other}`: there is exactly one selector");
                bail!(KeyPath::word(other).told(what))
            }
        }
    }

    /// Makes the selector.
    pub fn build(self, sources: &mut Sources) -> Result<Box<dyn Selector + 'a>> {
        Ok(match self {
            Self::Patch(names) => Box::new(patch::Patch::new(names, sources)?),
            Self::Volume(file) => Box::new(volume::Volume::new(&sources.folder.join(file))?),
            Self::Plane(plane) => Box::new(plane.clone()),
            Self::Box(cuboid) => Box::new(cuboid.clone()),
            Self::Component(index) => Box::new(component::Component(index)),
            Self::Point(point) => Box::new(point.clone()),
        })
    }
}

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
        self.recognized = Recognized::new(picked, now);
        Ok(())
    }

    /// The file of a selection; of a face that was picked, the one that is like it.
    pub fn file(&self, name: &str) -> Result<PathBuf> {
        Ok(self.folder.join(self.recognized.file(name)?))
    }
}

/// Axis-aligned bounds of the centroids, for messages.
fn extent(facets: &Facets) -> String {
    let (min, max) = mesh::measure::bounds(&facets.centroids);
    format!("the boundary's centroids span {} to {} m", place(&min), place(&max))
}

/// A point, for messages [m].
pub fn place(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}
