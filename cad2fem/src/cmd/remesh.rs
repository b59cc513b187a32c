//! `cad2fem remesh`: better tetrahedra inside, the surface untouched or changed within a tolerance.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use mesh::check::check_tets;
use mesh::improve::{ImproveReport, improve_tagged, improve_with_surface, usual_tolerance};
use mesh::io::{MshFile, read_tets, write_tets};
use mesh::topology::boundary;

use mesh::check::findings;

/// Boundary vertices and facets, those inside with a tag or between volumes, and tags stay as they are, bit
/// for bit, but for the parts of the surface that --surface names
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tetrahedral mesh (.msh)
    mesh: PathBuf,
    /// Mesh to write (.msh)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Passes over the mesh
    #[arg(long, value_name = "N", default_value_t = 10)]
    passes: usize,
    /// Tag whose facets may change where tetrahedra at them are poor; again for each. Its rim stays
    #[arg(long, value_name = "TAG")]
    surface: Vec<String>,
    /// How far from where it is that surface may be afterwards [m]; a twentieth of its mean edge if
    /// not given
    #[arg(long, value_name = "M", requires = "surface")]
    tolerance: Option<f64>,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let mut file = read_tets(&args.mesh)?;
    let found = check_tets(&file.mesh);
    if !found.is_empty() {
        bail!("{}: not a valid mesh:{}", args.mesh.display(), findings(&found));
    }
    let report = match args.surface.is_empty() {
        true => improve_tagged(&mut file.mesh, &mut file.tags, args.passes),
        false => with_surface(&mut file, args)?,
    };
    log::info!("before  {}", report.before);
    log::info!("after   {}", report.after);
    log::info!("{} moves, {} flips", report.moved, report.flips);
    write_tets(&args.output, &file.mesh, &file.tags)
        .with_context(|| format!("improving {}", args.mesh.display()))
}

/// Improves the mesh and the surface of the tags that are named.
fn with_surface(file: &mut MshFile, args: &Args) -> Result<ImproveReport> {
    let skin = boundary(&file.mesh).facets;
    let mut ids = Vec::new();
    for name in &args.surface {
        let id = file.tags.id(name).with_context(|| {
            format!(
                "{}: no tag `{name}`; the mesh has: {}",
                args.mesh.display(),
                file.tags.names.join(", ")
            )
        })?;
        ids.push(id);
    }
    let named = |f: &[usize; 3]| file.tags.get(*f).is_some_and(|id| ids.contains(&id));
    let moving: Vec<[usize; 3]> = skin.into_iter().filter(named).collect();
    ensure!(!moving.is_empty(), "{}: no facet has the tag", args.mesh.display());
    let usual = || usual_tolerance(&file.mesh.vertices, &moving);
    let tolerance = args.tolerance.unwrap_or_else(usual);
    ensure!(tolerance > 0.0, "--tolerance {tolerance} m must be positive");
    let (mesh, tags) = (&mut file.mesh, &mut file.tags);
    let (interior, surface) = improve_with_surface(mesh, tags, &moving, tolerance, args.passes);
    log::info!(
        "surface: {} edges exchanged, {} contracted, {} split, {} vertices moved; at most {:.4} mm from \
         where it was, {:.4} mm allowed",
        surface.flips,
        surface.collapses,
        surface.splits,
        surface.moved,
        1e3 * surface.distance,
        1e3 * tolerance
    );
    Ok(interior)
}
