//! `cad2fem.toml`: how a closed surface is filled with tetrahedra.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use program::schema::one_of_these;
use program::{Change, Keys, Settings};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

use crate::mesher::{MESHERS, Options, Refinement, TetMesher};

/// Most threads of a mesher.
const MOST_THREADS: usize = 1024;

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
    /// `ftetwild` or `gmsh`.
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
    one_of_these(MESHERS.iter().map(|mesher| mesher.name()))
}

impl Default for Tetmesh {
    fn default() -> Self {
        Self {
            mesher: "ftetwild".into(),
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
    ///
    /// # Errors
    /// If the file cannot be read or has an unknown key, or there is no file to change.
    pub fn read(path: Option<&Path>, changes: &[Change]) -> Result<Self> {
        let Some(path) = path else {
            ensure!(changes.is_empty(), "--set changes a key of a file: name it with --config");
            return Ok(Self::default());
        };
        Settings::read(path, changes, Keys::default())?.parse()
    }
}

impl Tetmesh {
    /// The mesher.
    ///
    /// # Errors
    /// If the name is unknown.
    pub fn tet_mesher(&self) -> Result<&'static dyn TetMesher> {
        MESHERS.iter().find(|m| m.name() == self.mesher).copied().with_context(|| {
            let known: Vec<&str> = MESHERS.iter().map(|m| m.name()).collect();
            format!("unknown mesher {:?}; expected one of {}", self.mesher, known.join(", "))
        })
    }

    /// The settings in metres for an input of the given diagonal [m].
    ///
    /// # Errors
    /// If a value makes no sense or a length is given twice.
    pub fn options(&self, diagonal: f64) -> Result<Options> {
        let length =
            |name, absolute, relative, default| length(name, absolute, relative, default, diagonal);
        ensure!(
            self.stop_energy > 3.0 && self.stop_energy.is_finite(),
            "stop_energy must exceed 3, the energy of a regular tetrahedron, found {}",
            self.stop_energy
        );
        ensure!(
            self.threads <= MOST_THREADS,
            "threads = {}: expected 0 for all, or up to {MOST_THREADS}",
            self.threads
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
    fn an_unknown_mesher_lists_the_known_ones() {
        let settings = Tetmesh { mesher: "netgen".into(), ..Tetmesh::default() };
        let message = settings.tet_mesher().err().unwrap().to_string();
        assert!(message.contains("ftetwild, gmsh"), "{message}");
    }
}
