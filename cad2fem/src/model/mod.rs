//! A closed surface whose triangles carry the name of a region, made of CAD by [`cad`], and its files:
//! `model.stl`, `patches/<region>.stl`, of surfaces inside the body as well, `volumes/<volume>.stl`
//! and the report `model.json`, written last.

pub mod cad;
pub mod record;
pub mod solids;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use implicit::Thin;
use mesh::check::findings;
use mesh::faces::Face;
use mesh::io::{read_surface, remove_output, remove_output_folder, write_surface};
use mesh::measure::{area, bounds, enclosed_volume};
use mesh::topology::{boundary_loops, components};
use mesh::{SurfaceMesh, check};
use program::Unusable;
use serde::Serialize;

use crate::mesher::gmsh::Faces;
use crate::model::record::Record;
use crate::report::Input;

/// The report, written last.
const STAMP: &str = "model.json";

/// A closed surface [m] in named regions.
#[derive(Default)]
pub struct LabelledSurface {
    /// The surface [m].
    pub surface: SurfaceMesh,
    /// Region names.
    pub names: Vec<String>,
    /// For each triangle its region.
    pub region: Vec<Option<usize>>,
    /// Surfaces inside the body by their names [m].
    pub inside: Vec<(String, SurfaceMesh)>,
    /// Boundaries of parts of the body by their names [m].
    pub volumes: Vec<(String, SurfaceMesh)>,
    /// Where an implicit body is thinner than its finest cell.
    pub thin: Vec<Thin>,
    /// What was read and changed, of a body that others made.
    pub import: Option<Record>,
    /// What CAD says about its faces.
    pub facts: Facts,
}

/// What CAD says about the faces of regions, by their names.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// What the faces of a region are: `plane`, `cylinder`, …
    pub kinds: BTreeMap<String, String>,
    /// Regions that meet without an edge, as a fillet and its neighbours do.
    pub tangent: Vec<[String; 2]>,
    /// Largest distance of the triangles from the faces [m]; none where it is not known.
    pub chord_error: Option<f64>,
}

impl Facts {
    /// The kinds and the tangent pairs of the faces of a file, under the names that `renamed` gives them.
    pub fn of(faces: &Faces, renamed: impl Fn(&str) -> String) -> Self {
        let kinds = faces.names.iter().zip(&faces.kinds).filter(|(_, kind)| !kind.is_empty());
        let pair = |pair: &[usize; 2]| pair.map(|i| renamed(&faces.names[i]));
        Self {
            kinds: kinds.map(|(name, kind)| (renamed(name), kind.clone())).collect(),
            tangent: faces.tangent.iter().map(pair).collect(),
            chord_error: faces.chord_error,
        }
    }

    /// Adds those of another file.
    pub fn extend(&mut self, more: Self) {
        self.kinds.extend(more.kinds);
        self.tangent.extend(more.tangent);
        self.chord_error = self.chord_error.into_iter().chain(more.chord_error).reduce(f64::max);
    }
}

/// Content of `model.json`.
#[derive(Debug, Serialize)]
pub struct Report {
    program: String,
    input: Input,
    vertices: usize,
    triangles: usize,
    /// [m²]
    area: f64,
    /// [m³]
    volume: f64,
    /// Corners of the bounding box [m].
    bounds: [[f64; 3]; 2],
    regions: Vec<RegionReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    inside: Vec<RegionReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    volumes: Vec<VolumeReport>,
    /// What no region took.
    unassigned: PatchReport,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    thin: Vec<Thin>,
    #[serde(skip_serializing_if = "Option::is_none")]
    import: Option<Record>,
    /// Regions that meet without an edge, where CAD says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    tangent: Option<Vec<[String; 2]>>,
    /// Largest distance of the triangles from the faces of CAD [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    chord_error: Option<f64>,
    wall_s: f64,
}

#[derive(Debug, Serialize)]
struct RegionReport {
    name: String,
    /// What its faces are, such as `plane`, where CAD says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<String>,
    #[serde(flatten)]
    patch: PatchReport,
}

#[derive(Debug, Serialize)]
struct VolumeReport {
    name: String,
    triangles: usize,
    /// [m³]
    volume: f64,
}

#[derive(Debug, Serialize)]
struct PatchReport {
    triangles: usize,
    /// [m²]
    area: f64,
    components: usize,
    /// Closed loops of its rim.
    loops: usize,
    /// Middle of its area [m].
    middle: [f64; 3],
}

impl PatchReport {
    fn of(patch: &SurfaceMesh) -> Self {
        Self {
            triangles: patch.triangles.len(),
            area: area(patch),
            components: components(&patch.triangles).len(),
            loops: boundary_loops(&patch.triangles).len(),
            middle: Face::of(patch, 0..patch.triangles.len()).middle.into(),
        }
    }
}

impl LabelledSurface {
    /// Triangles of a region, or those without, as an open surface.
    fn patch(&self, region: Option<usize>) -> SurfaceMesh {
        let chosen: Vec<usize> =
            (0..self.region.len()).filter(|&t| self.region[t] == region).collect();
        self.surface.part(&chosen)
    }

    /// Writes the folder. `model.json` disappears first and comes back last, so that
    /// it stands for a complete folder.
    pub fn write(&self, folder: &Path, input: Input, start: Instant) -> Result<Report> {
        remove_stamp(folder)?;
        let model = folder.join("model.stl");
        write_surface(&model, &self.surface)?;
        self.require_sound(&model)?;
        let patches = folder.join("patches");
        remove_output_folder(&patches)?;
        let write = |name: &str, patch: &SurfaceMesh| -> Result<RegionReport> {
            write_surface(&patches.join(format!("{name}.stl")), patch)?;
            let kind = self.facts.kinds.get(name).cloned();
            Ok(RegionReport { name: name.to_owned(), kind, patch: PatchReport::of(patch) })
        };
        let regions = self.regions()?;
        let regions =
            regions.iter().map(|(name, patch)| write(name, patch)).collect::<Result<_>>()?;
        let inside =
            self.inside.iter().map(|(name, patch)| write(name, patch)).collect::<Result<_>>()?;
        let volumes = self.write_volumes(&folder.join("volumes"))?;
        let (min, max) = bounds(&self.surface.vertices);
        let report = Report {
            program: crate::PROGRAM.into(),
            input,
            vertices: self.surface.vertices.len(),
            triangles: self.surface.triangles.len(),
            area: area(&self.surface),
            volume: enclosed_volume(&self.surface),
            bounds: [min.into(), max.into()],
            regions,
            inside,
            volumes,
            unassigned: PatchReport::of(&self.patch(None)),
            thin: self.thin.clone(),
            import: self.import.clone(),
            tangent: self.tangent(),
            chord_error: self.facts.chord_error,
            wall_s: start.elapsed().as_secs_f64(),
        };
        program::write_json(&folder.join(STAMP), &report)?;
        Ok(report)
    }

    /// Regions of this surface that meet without an edge; none where nothing is known of its faces.
    fn tangent(&self) -> Option<Vec<[String; 2]>> {
        let here = |pair: &&[String; 2]| pair.iter().all(|name| self.names.contains(name));
        let known = self.names.iter().any(|name| self.facts.kinds.contains_key(name));
        known.then(|| self.facts.tangent.iter().filter(here).cloned().collect())
    }

    /// Checks what a reader of the file will see: STL rounds to 32 bits.
    fn require_sound(&self, model: &Path) -> Result<()> {
        let found = check::check_surface(&read_surface(model)?);
        if found.is_empty() {
            return Ok(());
        }
        remove_output(model)?;
        Err(Unusable(format!("the surface is not usable:{}", findings(&found))).into())
    }

    fn write_volumes(&self, folder: &Path) -> Result<Vec<VolumeReport>> {
        remove_output_folder(folder)?;
        let one = |(name, surface): &(String, SurfaceMesh)| {
            write_surface(&folder.join(format!("{name}.stl")), surface)?;
            let (triangles, volume) = (surface.triangles.len(), enclosed_volume(surface));
            Ok(VolumeReport { name: name.clone(), triangles, volume })
        };
        self.volumes.iter().map(one).collect()
    }

    /// The triangles of each region, of which none may be empty.
    fn regions(&self) -> Result<Vec<(&str, SurfaceMesh)>> {
        let mut regions = Vec::with_capacity(self.names.len());
        for (index, name) in self.names.iter().enumerate() {
            let patch = self.patch(Some(index));
            if patch.triangles.is_empty() {
                let message = format!("region {name:?} is empty: its conditions take no triangle");
                return Err(Unusable(message).into());
            }
            regions.push((name.as_str(), patch));
        }
        Ok(regions)
    }
}

impl Report {
    /// Logs counts, areas and volumes.
    pub fn log(&self) {
        log::info!(
            "{} triangles, area {:.2} cm2, volume {:.3} cm3",
            self.triangles,
            self.area * 1e4,
            self.volume * 1e6
        );
        if let Some(error) = self.chord_error {
            log::info!("  up to {:.4} mm from the faces that they stand for", error * 1e3);
        }
        for RegionReport { name, patch, .. } in &self.regions {
            log::info!(
                "  {name:<12} {:>6} triangles  {:>8.2} cm2  middle at {:.1}, {:.1}, {:.1} mm  {} \
                 component(s), {} rim loop(s)",
                patch.triangles,
                patch.area * 1e4,
                1e3 * patch.middle[0],
                1e3 * patch.middle[1],
                1e3 * patch.middle[2],
                patch.components,
                patch.loops
            );
        }
        for RegionReport { name, patch, .. } in &self.inside {
            log::info!(
                "  {name:<12} {:>6} triangles  {:>8.2} cm2  inside: cad2fem tetmesh --inside \
                 patches/{name}.stl",
                patch.triangles,
                patch.area * 1e4
            );
        }
        for VolumeReport { name, triangles, volume } in &self.volumes {
            log::info!("  volume {name:<12} {triangles:>6} triangles  {:>8.3} cm3", volume * 1e6);
        }
        if self.unassigned.triangles > 0 {
            log::warn!(
                "{} triangles, {:.2} cm2, belong to no region; a region with `rest = true`, or one \
                 more physical surface, takes them",
                self.unassigned.triangles,
                self.unassigned.area * 1e4
            );
        }
    }
}

/// Removes the report that stands for a complete folder.
pub fn remove_stamp(folder: &Path) -> Result<()> {
    remove_output(&folder.join(STAMP))?;
    Ok(())
}
