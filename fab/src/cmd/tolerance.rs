//! `fab tolerance`: how far print tolerance spreads the response of a body.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use library::printers;
use mesh::io::{read_tets, write_atomic, write_tets};
use mesh::measure;
use program::{Changes, FolderLock, beside};

use crate::tolerance::offset::offset;
use crate::tolerance::run::Solver;
use crate::tolerance::{FILE, Response, Study};

/// Arguments of `fab tolerance`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tagged tetrahedral mesh of the design (.msh) [m]
    pub mesh: PathBuf,
    /// Scene for `solver simulate`
    #[arg(long)]
    pub scene: PathBuf,
    /// Other values of the scene
    #[command(flatten)]
    pub changes: Changes,
    /// Body of the scene that the mesh replaces, if the scene has several
    #[arg(long)]
    pub body: Option<String>,
    /// How far a wall may be off [m]
    #[arg(long, required_unless_present = "printer", conflicts_with = "printer")]
    pub tolerance: Option<f64>,
    /// Printer whose tolerance is studied
    #[arg(long)]
    pub printer: Option<String>,
    /// The program `solver`; without it, the one beside this program
    #[arg(long)]
    pub solver: Option<PathBuf>,
    /// Folder for meshes, results and tolerance.json
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Prints one line per response on standard output.
pub fn run(args: &Args) -> Result<()> {
    let tolerance = match (args.tolerance, &args.printer) {
        (Some(tolerance), _) => tolerance,
        (None, Some(key)) => printers().find(key).map_err(anyhow::Error::msg)?.tolerance * 1e-3,
        (None, None) => unreachable!("clap requires one of the two"),
    };
    ensure!(
        tolerance > 0.0 && tolerance < 0.01,
        "--tolerance is {tolerance}, must be above 0 and below 0.01 (lengths are metres)"
    );
    let program = args.solver.clone().unwrap_or_else(|| beside("solver"));
    let (scene, body) = (args.scene.clone(), args.body.clone());
    let solver = Solver { program, scene, body, changes: args.changes.set.clone() };
    let msh = read_tets(&args.mesh)?;
    let _lock = FolderLock::new(&args.output)?;
    let mut volumes = [0.0; 3];
    let (mut runs, mut cuts) = (Vec::new(), Vec::new());
    for (i, (name, shift)) in
        [("nominal", 0.0), ("thin", -tolerance), ("thick", tolerance)].into_iter().enumerate()
    {
        let moved = match shift {
            0.0 => msh.mesh.clone(),
            _ => {
                offset(&msh.mesh, shift, &cuts).with_context(|| args.mesh.display().to_string())?
            }
        };
        volumes[i] = measure::volume(&moved);
        let folder = args.output.join(name);
        let path = folder.join("body.msh");
        write_tets(&path, &moved, &msh.tags)?;
        log::info!("{name}: {:.2} mL of silicone", volumes[i] * 1e6);
        let run = solver.run(&path, &folder).context(name)?;
        runs.push(run.responses);
        cuts = run.cuts;
    }
    let study = study(tolerance, volumes, &runs)?;
    write_atomic(&args.output.join(FILE), |out| {
        serde_json::to_writer_pretty(&mut *out, &study)?;
        out.write_all(b"\n")
    })?;
    print(&study)
}

fn study(
    tolerance: f64,
    volumes: [f64; 3],
    runs: &[Vec<(String, &'static str, f64)>],
) -> Result<Study> {
    let [nominal, thin, thick] = runs else { unreachable!("three runs") };
    let mut responses = Vec::new();
    for ((a, b), c) in nominal.iter().zip(thin).zip(thick) {
        ensure!(a.0 == b.0 && a.0 == c.0, "runs report different numbers: {} and {}", a.0, b.0);
        responses.push(Response::new(a.0.clone(), a.1, [a.2, b.2, c.2]));
    }
    let program = format!("fab {}", env!("CARGO_PKG_VERSION"));
    Ok(Study { program, tolerance, volumes, responses })
}

fn print(study: &Study) -> Result<()> {
    let mut out = program::stdout();
    writeln!(
        out,
        "{:<36}  {:>12}  {:>12}  {:>12}  {:>8}",
        format!("walls ± {:.3} mm", study.tolerance * 1e3),
        "nominal",
        "thin",
        "thick",
        "spread"
    )?;
    for Response { name, unit, nominal, thin, thick, spread } in &study.responses {
        let spread = spread.map_or("-".into(), |s| format!("{s:.1} %"));
        writeln!(
            out,
            "{:<36}  {nominal:>12.4e}  {thin:>12.4e}  {thick:>12.4e}  {spread:>8}",
            format!("{name} [{unit}]")
        )?;
    }
    Ok(())
}
