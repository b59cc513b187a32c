//! `cad2fem model`: implicit model or CAD file → closed surface and patches.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use implicit::{Fields, Model, ModelFile, assign, surface};
use mesh::io::remove_litter;
use program::units::Unit;
use program::{Change, FolderLock, Unusable};

use crate::mesher::gmsh::{CadOptions, Kind};
use crate::model::cad::{self, parse_number};
use crate::model::{LabelledSurface, remove_stamp};
use crate::report::{Input, remark_on_size};

/// Writes `DIR/model.stl`, `DIR/patches/<region>.stl`, of CAD `DIR/volumes/<volume>.stl`,
/// `DIR/model.json`, and the same in `DIR/<variant>/` for every variant; lengths in metres
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Model: .toml (implicit), .geo (gmsh script), .step, .brep or .iges
    file: PathBuf,
    /// Folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Implicit: keep ornaments (primitives with `fine = true`)
    #[arg(long)]
    fine: bool,
    /// .geo and .brep: unit of the numbers
    #[arg(long)]
    unit: Option<Unit>,
    /// .toml: another value for a key, as in cavity.slot.shape.box.size.2=5; .geo: for a number that
    /// the script declares with DefineConstant
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// STEP, .brep and .iges: a solid of the file, by name or number, that is taken out of the
    /// others, such as the air of a chamber; several follow each other
    #[arg(long, value_name = "SOLID", num_args = 1..)]
    subtract: Vec<String>,
    /// CAD: let the script, and `FILE.opt` beside the file, run programs, read and write files
    #[arg(long)]
    trust: bool,
    /// CAD: longest edge [m]
    #[arg(long, value_name = "M")]
    edge_length: Option<f64>,
    /// CAD: longest time gmsh may take [s]
    #[arg(long, value_name = "S", default_value_t = 600)]
    timeout: u64,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    match args.file.extension().and_then(|e| e.to_str()) {
        Some("toml") => implicit(args),
        _ => from_cad(args),
    }
}

fn implicit(args: &Args) -> Result<()> {
    if args.unit.is_some() || args.edge_length.is_some() || args.trust || !args.subtract.is_empty()
    {
        bail!(
            "--unit, --edge-length, --subtract and --trust are for CAD files; a .toml model states \
             its own"
        );
    }
    let changes: Vec<Change> = all(&args.set, |text| text.parse().map_err(|e| anyhow!("{e}")))?;
    let file = ModelFile::read(&args.file, &changes)?;
    let input = input(args)?;
    // The stamp of the model itself stands for the variants too: it comes last.
    remove_stamp(&args.output)?;
    for (name, variant) in &file.variants {
        log::info!("variant {name}");
        write(args, variant, &args.output.join(name), &input)
            .with_context(|| format!("variant {name:?}"))?;
    }
    log::info!("model");
    write(args, &file.model, &args.output, &input)
}

fn write(args: &Args, model: &Model, folder: &Path, input: &Input) -> Result<()> {
    let start = Instant::now();
    let fields = Fields::new(model, args.fine);
    let skin = surface(model, &fields).with_context(|| args.file.display().to_string())?;
    let region = assign(model, &fields, &skin);
    let labelled = LabelledSurface {
        surface: skin.surface,
        names: model.region_names(),
        region,
        thin: skin.thin,
        ..LabelledSurface::default()
    };
    finish(args, &labelled, folder, input.clone(), start)
}

fn from_cad(args: &Args) -> Result<()> {
    let start = Instant::now();
    let options = CadOptions {
        unit: args.unit,
        numbers: all(&args.set, parse_number)?,
        edge_length: args.edge_length,
        chord: None,
        trust: args.trust,
        subtract: args.subtract.clone(),
        timeout: Duration::from_secs(args.timeout),
    };
    let (labelled, solids) = cad::read(&args.file, &options)?;
    let (file, folder) = (args.file.display(), args.output.display());
    let command = format!("cad2fem model {file} -o {folder}");
    if let Some(complaint) = solids.complaint(&args.file, &command) {
        bail!(complaint);
    }
    solids.remark_on_chambers(&args.file);
    let done = finish(args, &labelled, &args.output, input(args)?, start);
    let is_shape = Kind::of(&args.file)? != Kind::Script;
    match done {
        Err(error) if is_shape && error.is::<Unusable>() => Err(error.context(format!(
            "the triangles do not follow the faces closely enough; `cad2fem import {file} -o {folder}` \
             follows curved faces, and repairs"
        ))),
        done => done,
    }
}

fn input(args: &Args) -> Result<Input> {
    Ok(Input { set: args.set.clone(), ..Input::of(&args.file)? })
}

/// What `read` makes of each `--set`.
fn all<T, C: FromIterator<T>>(set: &[String], read: impl Fn(&str) -> Result<T>) -> Result<C> {
    set.iter().map(|text| read(text).with_context(|| format!("--set {text}"))).collect()
}

fn finish(
    args: &Args,
    labelled: &LabelledSurface,
    folder: &Path,
    input: Input,
    start: Instant,
) -> Result<()> {
    remark_on_size(&args.file, &labelled.surface);
    let _lock = FolderLock::new(folder)?;
    remove_litter(&folder.join("patches"));
    let report =
        labelled.write(folder, input, start).with_context(|| args.file.display().to_string())?;
    report.log();
    Ok(())
}
