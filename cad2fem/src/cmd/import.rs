//! `cad2fem import`: meshes and CAD files of others → closed surface and patches.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use mesh::Vec3;
use mesh::io::remove_litter;
use nalgebra::{Matrix3, Rotation3};
use program::FolderLock;

use crate::import::repair::{Repair, parse_positive};
use crate::import::source::Reader;
use crate::import::{Request, import};
use crate::mesher::gmsh::CadOptions;
use crate::model::{Facts, LabelledSurface};
use crate::report::Input;
use crate::units::Unit;

/// Writes what `cad2fem model` writes: `DIR/model.stl`, `DIR/patches/<patch>.stl` and
/// `DIR/model.json`, in metres
///
/// Patches are the faces of a STEP, BREP or IGES file by name, by colour or by number; objects of a
/// 3MF file; `outer` and `cavity` of a mesh; with several files those of each with its name.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// .stl, .obj, .ply, .3mf, .step, .brep or .iges, or a tetrahedral .msh, whose boundary counts; of
    /// several the union
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Unit of files that state none; otherwise it is guessed by their size, and said
    #[arg(long)]
    unit: Option<Unit>,
    /// Files with what is taken away, such as chambers, or solids of the CAD file by their names or
    /// numbers
    #[arg(long, value_name = "FILE|SOLID", num_args = 1..)]
    subtract: Vec<String>,
    /// CAD: several solids that touch or cross are one body
    #[arg(long)]
    unite: bool,
    /// Factor of all lengths
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = parse_positive)]
    scale: f64,
    /// Turn about an axis through the origin, such as x=90 [deg]; several follow each other
    #[arg(long, value_name = "AXIS=DEG", value_parser = parse_turn)]
    turn: Vec<Matrix3<f64>>,
    /// Shift, after scale and turns [m]
    #[arg(long = "move", value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    shift: Option<Vec3>,
    /// Part patches at edges sharper than this [deg], such as 40
    #[arg(long, value_name = "DEG", value_parser = parse_positive)]
    split: Option<f64>,
    #[command(flatten)]
    repair: Repair,
    /// CAD: longest edge [m]
    #[arg(long, value_name = "M", value_parser = parse_positive)]
    edge_length: Option<f64>,
    /// CAD: how far triangles may be from the faces [m]
    #[arg(long, value_name = "M", default_value_t = 2e-5, value_parser = parse_positive)]
    chord: f64,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let files: Vec<String> = args.files.iter().map(|file| file.display().to_string()).collect();
    run_as(args, &format!("cad2fem import {} -o {}", files.join(" "), args.output.display()))
}

/// Runs the verb for another one, of which `command` is what the user would write again.
pub(super) fn run_as(args: &Args, command: &str) -> Result<()> {
    let start = Instant::now();
    let (files, solids): (Vec<_>, Vec<_>) =
        args.subtract.iter().cloned().partition(|text| Path::new(text).exists());
    if let (Some(solid), false) = (solids.first(), args.files.len() == 1) {
        bail!(
            "--subtract {solid}: there is no such file, and several files whose solid it could be"
        );
    }
    let mut request = Request {
        files: args.files.clone(),
        subtract: files.into_iter().map(PathBuf::from).collect(),
        reader: Reader {
            unit: args.unit,
            cad: CadOptions {
                unit: None,
                numbers: BTreeMap::new(),
                edge_length: args.edge_length,
                chord: Some(args.chord),
                trust: false,
                subtract: solids,
                timeout: Duration::from_secs(args.repair.timeout),
            },
            unite: args.unite,
            command: command.to_owned(),
            guessed: None,
            facts: Facts::default(),
        },
        repair: args.repair.clone(),
        scale: args.scale,
        turn: args.turn.iter().fold(Matrix3::identity(), |all, turn| turn * all),
        shift: args.shift.unwrap_or_default(),
        split: args.split,
    };
    let mut labelled = import(&mut request)?;
    remark_on_chord(args.chord * args.scale, &labelled);
    let _lock = FolderLock::new(&args.output)?;
    for file in labelled.import.iter_mut().flat_map(|record| &mut record.files) {
        file.input = file.input.seen_from(&args.output);
    }
    remove_litter(&args.output.join("patches"));
    let input = Input::of(&args.files[0])?;
    labelled.write(&args.output, input, start)?.log();
    Ok(())
}

/// Says so where triangles do not follow the faces of CAD as closely as was wanted [m].
fn remark_on_chord(wanted: f64, labelled: &LabelledSurface) {
    match labelled.facts.chord_error {
        Some(error) if error > wanted => log::warn!(
            "triangles are up to {:.4} mm from the faces of the CAD, --chord asks for {:.4} mm",
            error * 1e3,
            wanted * 1e3
        ),
        None if !labelled.facts.kinds.is_empty() => log::warn!(
            "how far triangles are from the faces of the CAD is not known: gmsh cannot measure it"
        ),
        _ => {}
    }
}

/// Reads `x=90`.
fn parse_turn(text: &str) -> Result<Matrix3<f64>> {
    let needed = "AXIS=DEG is needed, such as x=90";
    let (axis, angle) = text.split_once('=').context(needed)?;
    let axis = match axis {
        "x" => Vec3::x_axis(),
        "y" => Vec3::y_axis(),
        "z" => Vec3::z_axis(),
        _ => bail!("{axis:?} is not x, y or z"),
    };
    let angle: f64 = angle.parse().with_context(|| format!("{angle:?} is not a number"))?;
    ensure!(angle.is_finite(), "{angle} is not an angle");
    // quarters of a turn without rounding
    let rotation = Rotation3::from_axis_angle(&axis, angle.to_radians()).into_inner();
    Ok(if angle % 90.0 == 0.0 { rotation.map(f64::round) } else { rotation })
}

/// Reads `0.01,0,-0.02`.
fn parse_point(text: &str) -> Result<Vec3> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|x| x.is_finite()) => Ok(Vec3::new(x, y, z)),
        _ => bail!("three numbers with commas are needed, found {text:?}"),
    }
}
