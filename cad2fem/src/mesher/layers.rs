//! Surfaces inside a body whose triangles become facets of its tetrahedra: where a sheet lies,
//! or where one material ends and another begins.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use mesh::check::{findings, run};
use mesh::topology::TET_FACETS;
use mesh::{SurfaceMesh, TetMesh, Vec3, facet_key, place_key, triangle_key};
use program::units::Unit;

use crate::report::read_in;

/// Surfaces inside a body, open or closed, without the triangles that are on its boundary.
#[derive(Default)]
pub struct Layers {
    surfaces: Vec<SurfaceMesh>,
}

impl Layers {
    /// Reads the files, in metres or the unit that is said.
    pub fn read(files: &[PathBuf], unit: Option<Unit>, boundary: &SurfaceMesh) -> Result<Self> {
        let mut known: BTreeSet<_> =
            (0..boundary.triangles.len()).map(|t| triangle_key(&boundary.corners(t))).collect();
        let mut surfaces = Vec::new();
        for file in files {
            let surface = read_in(file, unit)?;
            surfaces.extend(new_triangles(&surface, file, &mut known)?);
        }
        Ok(Self { surfaces })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
    }

    /// The triangles of a closed surface, then those inside, whose number is the second; vertices
    /// at the same place are one.
    pub fn beside(&self, boundary: &SurfaceMesh) -> (SurfaceMesh, usize) {
        let mut all = boundary.clone();
        if self.is_empty() {
            return (all, 0);
        }
        self.surfaces.iter().for_each(|surface| append(&mut all, surface));
        let inside = all.triangles.len() - boundary.triangles.len();
        (all, inside)
    }
}

/// Adds the triangles of a surface to others; vertices at the same place become one.
pub fn append(all: &mut SurfaceMesh, surface: &SurfaceMesh) {
    let mut places: HashMap<[u64; 3], usize> =
        all.vertices.iter().map(place_key).zip(0..).collect();
    let mut vertex = |v: usize| {
        let p = surface.vertices[v];
        *places.entry(place_key(&p)).or_insert_with(|| {
            all.vertices.push(p);
            all.vertices.len() - 1
        })
    };
    let triangles: Vec<_> = surface.triangles.iter().map(|t| t.map(&mut vertex)).collect();
    all.triangles.extend(triangles);
}

/// The facets of a mesh that are triangles of the surfaces, if all of these are facets; a mesher
/// that keeps to an envelope has others.
pub fn exact_facets(layers: &Layers, mesh: &TetMesh) -> Option<BTreeSet<[usize; 3]>> {
    let vertex: HashMap<[u64; 3], usize> = mesh.vertices.iter().map(place_key).zip(0..).collect();
    let facets_of = |tet: &[usize; 4]| TET_FACETS.map(|facet| facet_key(facet.map(|c| tet[c])));
    let known: BTreeSet<[usize; 3]> = mesh.tets.iter().flat_map(facets_of).collect();
    let triangles =
        layers.surfaces.iter().flat_map(|s| (0..s.triangles.len()).map(|t| s.corners(t)));
    let facet = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(|p| vertex.get(&place_key(&p)).copied());
        Some(facet_key([a?, b?, c?])).filter(|facet| known.contains(facet))
    };
    triangles.map(facet).collect()
}

/// Checks that all triangles meet in common vertices and edges only, as a mesher needs that keeps
/// them.
pub fn require_conforming(all: &SurfaceMesh) -> Result<()> {
    let found = run(all, &["intersecting"]);
    ensure!(
        found.is_empty(),
        "surfaces inside cross each other or the boundary:{}\n  gmsh keeps all triangles, so that \
         these have to meet in vertices and edges: make one CAD model of them by BooleanFragments, \
         or use mesher = \"ftetwild\"",
        findings(&found)
    );
    Ok(())
}

/// The triangles that are not known yet, if there are any.
fn new_triangles(
    surface: &SurfaceMesh,
    file: &Path,
    known: &mut BTreeSet<[[u64; 3]; 3]>,
) -> Result<Option<SurfaceMesh>> {
    let found = run(surface, &["degenerate"]);
    ensure!(found.is_empty(), "{}: it is not usable:{}", file.display(), findings(&found));
    let triangles: Vec<usize> = (0..surface.triangles.len())
        .filter(|&t| known.insert(triangle_key(&surface.corners(t))))
        .collect();
    log::info!(
        "{}: {} of {} triangles inside, the others are on the boundary or in other surfaces",
        file.display(),
        triangles.len(),
        surface.triangles.len()
    );
    Ok((!triangles.is_empty()).then(|| surface.part(&triangles)))
}
