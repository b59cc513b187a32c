//! `cad2fem.toml`: how a closed surface is filled with tetrahedra.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mesh::SurfaceMesh;
use mesh::measure::{longest_edge, triangle_shape};
use program::schema::one_of_these;
use program::{Change, Keys, Settings};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

use crate::mesher::{MESHERS, Options, Refinement, TetMesher};

/// Stands for the mesher that suits a surface.
const AUTO: &str = "auto";

/// More triangles of a surface are not kept without being asked for: tetrahedra are about three times as many.
const MOST_KEPT: usize = 50_000;

/// A surface is not kept where more than one in a hundred of its triangles is flatter, 4√3 area over the sum of the
/// squared edges: of CAD none is below 0.28, of implicit models one in a hundred is below 0.04 to 0.1 [1].
const FLAT: f64 = 0.2;

/// How much longer than wanted the longest edge may be of those that are kept, and how much shorter [1].
const LONGER: f64 = 2.0;

/// Content of `cad2fem.toml`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Settings of `cad2fem tetmesh`.
    pub tetmesh: Tetmesh,
}

/// Settings of `cad2fem tetmesh`; lengths either absolute or relative to the
/// diagonal of the bounding box of the input.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tetmesh {
    /// `ftetwild`, `gmsh`, or `auto`: the first of them that makes a usable mesh. That is `gmsh`, which keeps the
    /// triangles of the surface, where these are well shaped, as long as is wanted within a factor of two, and not too
    /// many, as those of CAD are; else `ftetwild`.
    #[schemars(schema_with = "meshers")]
    pub mesher: String,
    /// Wanted edge length [m]; instead of `relative_edge_length`. `gmsh` keeps the triangles of the surface:
    /// inside alone edges are no longer.
    pub edge_length: Option<f64>,
    /// Wanted edge length, by default 0.05 [diagonal].
    pub relative_edge_length: Option<f64>,
    /// Surfaces inside the body whose triangles become facets of tetrahedra, as files beside the
    /// surface that is meshed, such as `patches/paper.stl`.
    pub inside: Vec<PathBuf>,
    /// Balls with shorter edges.
    pub refine: Vec<Refinement>,
    /// Envelope around the input in which the boundary stays [m]; instead of
    /// `relative_envelope`.
    pub envelope: Option<f64>,
    /// Envelope, by default 0.9e-3 [diagonal].
    pub relative_envelope: Option<f64>,
    /// AMIPS energy below which an element is good enough, 3 is regular [1].
    pub stop_energy: f64,
    /// Most optimisation passes of the mesher.
    pub max_iterations: u32,
    /// Whether the mesher merges elements afterwards; fewer but worse elements.
    pub coarsen: bool,
    /// Passes of our own improvement of the interior, boundary untouched.
    pub improve_passes: usize,
    /// Most threads, 0 for all.
    pub threads: usize,
}

fn meshers(_: &mut SchemaGenerator) -> Schema {
    one_of_these(std::iter::once(AUTO).chain(MESHERS.iter().map(|mesher| mesher.name())))
}

impl Default for Tetmesh {
    fn default() -> Self {
        Self {
            mesher: AUTO.into(),
            edge_length: None,
            relative_edge_length: None,
            inside: Vec::new(),
            refine: Vec::new(),
            envelope: None,
            relative_envelope: None,
            stop_energy: 10.0,
            max_iterations: 80,
            coarsen: false,
            improve_passes: 10,
            threads: 0,
        }
    }
}

impl Config {
    /// Reads a configuration, with changes from outside, or gives the defaults.
    pub fn read(path: Option<&Path>, changes: &[Change]) -> Result<Self> {
        let Some(path) = path else {
            ensure!(changes.is_empty(), "--set changes a key of a file: name it with --config");
            return Ok(Self::default());
        };
        Settings::read(path, changes, Keys::default())?.parse()
    }
}

impl Tetmesh {
    /// The meshers that may be tried on a surface, in this order, when edges are to have a length [m].
    pub fn meshers(
        &self,
        surface: &SurfaceMesh,
        wanted: f64,
    ) -> Result<Vec<&'static dyn TetMesher>> {
        if self.mesher == AUTO {
            let mut all = MESHERS.to_vec();
            all.sort_by_key(|mesher| mesher.keeps_triangles() != worth_keeping(surface, wanted));
            return Ok(all);
        }
        let found = MESHERS.iter().find(|m| m.name() == self.mesher).copied();
        let found = found.with_context(|| {
            let known: Vec<&str> = MESHERS.iter().map(|m| m.name()).collect();
            format!(
                "unknown mesher {:?}; expected one of {AUTO}, {}",
                self.mesher,
                known.join(", ")
            )
        })?;
        Ok(vec![found])
    }

    /// The settings in metres for an input of the given diagonal [m].
    pub fn options(&self, diagonal: f64) -> Result<Options> {
        let length =
            |name, absolute, relative, default| length(name, absolute, relative, default, diagonal);
        ensure!(
            self.stop_energy > 3.0 && self.stop_energy.is_finite(),
            "stop_energy must exceed 3, the energy of a regular tetrahedron, found {}",
            self.stop_energy
        );
        for ball in &self.refine {
            ensure!(
                ball.radius > 0.0 && ball.edge_length > 0.0,
                "refine: radius and edge_length must be positive, found {} and {} m",
                ball.radius,
                ball.edge_length
            );
        }
        Ok(Options {
            refine: self.refine.clone(),
            edge_length: length("edge_length", self.edge_length, self.relative_edge_length, 0.05)?,
            envelope: length("envelope", self.envelope, self.relative_envelope, 0.9e-3)?,
            stop_energy: self.stop_energy,
            max_iterations: self.max_iterations,
            coarsen: self.coarsen,
            threads: self.threads,
            seed: 1,
        })
    }
}

/// Whether the triangles of a surface are such that tetrahedra on them are what is wanted.
fn worth_keeping(surface: &SurfaceMesh, wanted: f64) -> bool {
    if surface.triangles.len() > MOST_KEPT {
        return false;
    }
    let all = (0..surface.triangles.len()).map(|t| surface.corners(t));
    let flat = all.clone().filter(|&corners| triangle_shape(corners) < FLAT).count();
    let longest = all.clone().map(longest_edge).fold(0.0, f64::max);
    flat * 100 <= all.len() && longest <= LONGER * wanted && wanted <= LONGER * longest
}

fn length(
    name: &str,
    absolute: Option<f64>,
    relative: Option<f64>,
    default: f64,
    diagonal: f64,
) -> Result<f64> {
    let (key, value, unit) = match (absolute, relative) {
        (Some(_), Some(_)) => bail!("give {name} [m] or relative_{name} [diagonal], not both"),
        (Some(value), None) => (name.to_owned(), value, 1.0),
        (None, value) => (format!("relative_{name}"), value.unwrap_or(default), diagonal),
    };
    let meters = value * unit;
    ensure!(
        meters > 0.0 && meters < diagonal,
        "{key} = {value} is {meters:.3e} m; it must lie between 0 and the diagonal of the input, \
         {diagonal:.3e} m"
    );
    Ok(meters)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;
    use mesh::solid::Solid;

    #[test]
    fn lengths_are_absolute_or_relative_but_not_both() {
        let mut settings = Tetmesh { relative_edge_length: Some(0.1), ..Tetmesh::default() };
        assert_eq!(settings.options(2.0).unwrap().edge_length, 0.2);
        assert_eq!(settings.options(2.0).unwrap().envelope, 1.8e-3);
        settings.edge_length = Some(0.01);
        let message = settings.options(2.0).unwrap_err().to_string();
        assert!(message.contains("not both"), "{message}");
        settings.relative_edge_length = None;
        assert_eq!(settings.options(2.0).unwrap().edge_length, 0.01);
        settings.edge_length = Some(f64::NAN);
        assert!(settings.options(2.0).is_err());
    }

    #[test]
    fn triangles_that_are_well_shaped_and_fine_enough_are_kept() {
        let first = |surface: &SurfaceMesh, wanted: f64| {
            Tetmesh::default().meshers(surface, wanted).unwrap()[0].name()
        };
        let mut ball = Solid::sphere(&Vec3::zeros(), 1.0, 32).to_surface();
        assert_eq!(first(&ball, 0.2), "gmsh");
        assert_eq!(first(&ball, 0.05), "ftetwild", "too long");
        assert_eq!(first(&ball, 0.9), "ftetwild", "too short");
        ball.vertices.iter_mut().for_each(|p| p.z *= 0.1);
        ball.vertices.iter_mut().for_each(|p| p.x *= 10.0);
        assert_eq!(first(&ball, 5.0), "ftetwild", "too flat");
        let settings = Tetmesh { mesher: "gmsh".into(), ..Tetmesh::default() };
        let names: Vec<_> =
            settings.meshers(&ball, 5.0).unwrap().iter().map(|m| m.name()).collect();
        assert_eq!(names, ["gmsh"], "what is asked for is not exchanged");
    }
}
