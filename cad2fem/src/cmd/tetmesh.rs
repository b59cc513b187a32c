//! `cad2fem tetmesh`: closed surface → tetrahedra.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use mesh::io::write_tets;
use mesh::measure::diagonal;
use mesh::topology::edge_facets;
use mesh::{SurfaceMesh, Tags};
use program::Changes;
use program::units::Unit;
use serde::Serialize;

use crate::mesher::layers::{Layers, append};
use crate::mesher::python::Python;
use crate::report::{Input, read_in};
use crate::tetmesh::cache::Cache;
use crate::tetmesh::config::{Config, Tetmesh};
use crate::tetmesh::{Outcome, Request, prepare, tetrahedralize};

/// Edges wanted, over the longest of a surface that stays, from which on a user expects a coarser mesh.
const COARSER: f64 = 1.25;

/// Settings come from --config, then from the flags; what neither says has a default.
/// Writes OUT and OUT with the extension .report.json
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Closed surface [m], or as --unit says; of several files, shells or faces that meet in common
    /// vertices, all together
    #[arg(required = true)]
    surfaces: Vec<PathBuf>,
    /// Unit of the surfaces, if not metres
    #[arg(long)]
    unit: Option<Unit>,
    /// Surface inside the body, open or closed, whose triangles become facets of tetrahedra; again
    /// for each
    #[arg(long = "inside", value_name = "FILE")]
    inside: Vec<PathBuf>,
    /// Mesh to write (.msh)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// cad2fem.toml
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// auto, ftetwild or gmsh
    #[arg(long)]
    mesher: Option<String>,
    /// Wanted edge length [m]; gmsh keeps the triangles of the surface, and bounds edges inside alone
    #[arg(long, value_name = "M")]
    edge_length: Option<f64>,
    /// Envelope around the input [m]
    #[arg(long, value_name = "M")]
    envelope: Option<f64>,
    /// Turn an inward-facing outer surface instead of refusing it
    #[arg(long)]
    orient: bool,
    /// Longest time the mesher may take [s]
    #[arg(long, value_name = "S", default_value_t = 1800)]
    timeout: u64,
    /// Neither use nor fill the cache of meshes
    #[arg(long)]
    no_cache: bool,
    #[command(flatten)]
    changes: Changes,
}

#[derive(Serialize)]
struct Report {
    program: &'static str,
    input: Vec<Input>,
    #[serde(flatten)]
    outcome: Outcome,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let settings = args.settings()?;
    let of_config = || args.config.as_ref().map_or("settings".into(), |p| p.display().to_string());
    let input = args.surfaces.iter().map(|file| Input::of(file)).collect::<Result<_>>()?;
    let read = args.surfaces.iter().map(|file| read_in(file, args.unit));
    let mut surface = joined(read.collect::<Result<_>>()?);
    let place = || {
        let all: Vec<String> =
            args.surfaces.iter().map(|file| file.display().to_string()).collect();
        all.join(", ")
    };
    prepare(&mut surface, args.orient).with_context(place)?;
    let options = settings.options(diagonal(&surface.vertices)).with_context(of_config)?;
    let request = Request {
        python: Python::find()?,
        meshers: settings.meshers(&surface, options.edge_length).with_context(of_config)?,
        options,
        improve_passes: settings.improve_passes,
        layers: Layers::read(&args.inside(&settings), args.unit, &surface)?,
        cache: if args.no_cache { None } else { Cache::open() },
        timeout: Duration::from_secs(args.timeout),
    };
    if settings.edge_length.or(settings.relative_edge_length).is_some() {
        warn_of_kept_triangles(&surface, &request);
    }
    let (mesh, outcome) = tetrahedralize(&surface, &request).with_context(place)?;
    outcome.log();
    write_tets(&args.output, &mesh, &Tags::default())?;
    let report = Report { program: crate::PROGRAM, input, outcome };
    program::write_json(&args.output.with_extension("report.json"), &report)
}

/// Says so where longer edges are wanted than the surface has, whose triangles the mesher keeps.
fn warn_of_kept_triangles(surface: &SurfaceMesh, request: &Request) {
    let (mesher, wanted) = (request.meshers[0], request.options.edge_length);
    let ends = |[a, b]: &[usize; 2]| (surface.vertices[*a] - surface.vertices[*b]).norm();
    let edge = edge_facets(&surface.triangles).keys().map(ends).fold(0.0, f64::max);
    if mesher.keeps_triangles() && wanted > COARSER * edge {
        log::warn!(
            "edges of {:.4} mm are wanted, but {} keeps the triangles of the surface, whose longest edge has \
             {:.4} mm: for a coarser mesh make a coarser surface (`cad2fem model` takes --edge-length, and --set for \
             a number of a script), or take mesher = \"ftetwild\"",
            wanted * 1e3,
            mesher.name(),
            edge * 1e3
        );
    }
}

/// Several surfaces as one, in which vertices at the same place are one.
fn joined(surfaces: Vec<SurfaceMesh>) -> SurfaceMesh {
    let add = |mut all: SurfaceMesh, surface: SurfaceMesh| {
        append(&mut all, &surface);
        all
    };
    surfaces.into_iter().reduce(add).unwrap_or_default()
}

impl Args {
    /// Surfaces inside: those of the settings lie beside the first surface.
    fn inside(&self, settings: &Tetmesh) -> Vec<PathBuf> {
        let folder = self.surfaces[0].parent().unwrap_or(Path::new(""));
        let of_settings = settings.inside.iter().map(|file| folder.join(file));
        of_settings.chain(self.inside.iter().cloned()).collect()
    }

    /// The configuration with the flags on top.
    fn settings(&self) -> Result<Tetmesh> {
        let mut settings = Config::read(self.config.as_deref(), &self.changes.set)?.tetmesh;
        if let Some(mesher) = &self.mesher {
            settings.mesher.clone_from(mesher);
        }
        if self.edge_length.is_some() {
            (settings.edge_length, settings.relative_edge_length) = (self.edge_length, None);
        }
        if self.envelope.is_some() {
            (settings.envelope, settings.relative_envelope) = (self.envelope, None);
        }
        Ok(settings)
    }
}
