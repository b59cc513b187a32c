//! External programs: where they are, how they are run, what comes back.

pub mod ftetwild;
pub mod gmsh;
pub mod job;
pub mod layers;
pub mod python;
pub mod script;

use std::time::Duration;

use anyhow::Result;
use mesh::{SurfaceMesh, TetMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mesher::layers::Layers;
use python::Package;

/// What is asked of a tetrahedral mesher; everything that decides its result.
#[derive(Clone, Debug, Serialize)]
pub struct Options {
    /// Wanted edge length [m].
    pub edge_length: f64,
    /// Where it should be smaller.
    pub refine: Vec<Refinement>,
    /// How far the boundary of the result may be from the input [m].
    pub envelope: f64,
    /// Energy (AMIPS, 3 for a regular tetrahedron) below which elements are good enough [1].
    pub stop_energy: f64,
    /// Most optimisation passes.
    pub max_iterations: u32,
    /// Whether elements are merged afterwards where their quality allows it.
    pub coarsen: bool,
    /// Most threads, 0 for all.
    pub threads: usize,
    /// What decides the order in which fTetWild inserts triangles.
    pub seed: u32,
}

/// A ball with shorter edges; from its surface on the edge length grows by half the
/// distance, up to the general one.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// Centre [m].
    pub center: [f64; 3],
    /// Radius [m].
    pub radius: f64,
    /// Wanted edge length inside [m].
    pub edge_length: f64,
}

/// A program that fills a closed surface with tetrahedra.
pub trait TetMesher: Sync {
    /// Name in configurations.
    fn name(&self) -> &'static str;
    /// Whether the triangles of the surface become facets as they are, whatever edges are wanted.
    fn keeps_triangles(&self) -> bool {
        false
    }
    /// Python packages that carry it, of which the first that is installed is used.
    fn packages(&self) -> &'static [&'static str];
    /// Script that drives it; part of what decides the result.
    fn script(&self) -> &'static str;
    /// Meshes a closed surface whose shells are oriented by nesting; of `layers` the triangles
    /// become facets of tetrahedra. Positive volumes are up to the caller.
    fn mesh(
        &self,
        package: &Package,
        surface: &SurfaceMesh,
        layers: &Layers,
        options: &Options,
        timeout: Duration,
    ) -> Result<TetMesh>;
}

/// The tetrahedral meshers, by name.
pub const MESHERS: &[&dyn TetMesher] = &[&ftetwild::FTetWild, &gmsh::Gmsh];
