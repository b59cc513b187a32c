//! `cad2fem pick`: a body → a page on which a person clicks faces and gets `tags.toml`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use clap::Parser as _;
use mesh::io::extension;
use page::pick::given::{Given, Tag};
use page::pick::{Source, Summary};
use program::units::Unit;

use super::{import, model};

/// A page on which you name the faces of a body by clicking; it downloads tags.toml, which tagger
/// reads. It is one file without a server or a network
///
/// Example: cad2fem pick hand.step -o pick.html; then open pick.html in a browser.
///
/// The page has faces of CAD, regions of an implicit model, or the parts of an STL between sharp
/// edges. It proposes closed chambers and flat sides. A click takes a face, all tangent faces, or all
/// connected ones; with Shift, or where a drag paints, faces are painted.
///
/// With --tags it begins with the tags of a file. Tags of faces are shown and can be changed. All else
/// that the file holds, such as a tag by a box, is named, and kept in what the page downloads; comments
/// are not.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder that `cad2fem model` or `cad2fem import` wrote, or a file that is modelled first: .step,
    /// .brep, .iges, .stl, .obj, .ply, .3mf, .geo or .toml
    body: PathBuf,
    /// Page to write (.html)
    #[arg(short, long)]
    output: PathBuf,
    /// File of tags with which the page begins, such as one that it downloaded
    #[arg(long, value_name = "TAGS.toml")]
    tags: Option<PathBuf>,
    /// Folder for the model of a file, whose patches tags.toml names [default: model beside the page]
    #[arg(long, value_name = "DIR")]
    model: Option<PathBuf>,
    /// Title of the page [default: the name of the body's file]
    #[arg(long)]
    title: Option<String>,
    /// Unit of a file that states none
    #[arg(long)]
    unit: Option<Unit>,
    /// What is taken away from a file: other files, or solids of the CAD file by their names or
    /// numbers
    #[arg(long, value_name = "FILE|SOLID", num_args = 1..)]
    subtract: Vec<String>,
    /// Several solids of a CAD file that touch or cross are one body
    #[arg(long)]
    unite: bool,
    /// Faces of an STL, OBJ, PLY or 3MF end at edges sharper than this [deg] [default: 40]
    #[arg(long, value_name = "DEG")]
    split: Option<f64>,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let kind = extension(&args.output);
    ensure!(
        kind == "html" || kind == "htm",
        "{}: the page is HTML, say -o pick.html; it is opened in a browser, and downloads tags.toml",
        args.output.display()
    );
    let folder = if args.body.is_dir() { given(args)? } else { modelled(args)? };
    let source =
        Source { folder: &folder, tags: args.tags.as_deref(), title: args.title.as_deref() };
    let Summary { faces, chambers, given, bytes } = page::pick::write(&source, &args.output)?;
    if let (Some(given), Some(path)) = (given, &args.tags) {
        tell(&given, path);
    }
    log::info!(
        "{}: {faces} faces, closed chambers: {chambers}; {:.1} MB, {:.1} s; open it in a browser",
        args.output.display(),
        bytes as f64 * 1e-6,
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Says which tags the page begins with, and what it only keeps.
fn tell(given: &Given, path: &Path) {
    let (shown, kept): (Vec<&Tag>, Vec<&Tag>) =
        given.list.iter().partition(|tag| tag.kept.is_none());
    let names =
        |tags: &[&Tag]| tags.iter().map(|tag| tag.name.as_str()).collect::<Vec<_>>().join(", ");
    let path = path.display();
    log::info!("{path}: tags on the page: {}", names(&shown));
    if !kept.is_empty() {
        log::warn!("{path}: {} cannot be shown, but is kept: not made of faces", names(&kept));
    }
    for remark in &given.remarks {
        log::warn!("{path}: {remark}");
    }
}

/// The folder of a body that was modelled before.
fn given(args: &Args) -> Result<PathBuf> {
    let with = |is: bool, option: &'static str| is.then_some(option);
    let options = [
        with(args.model.is_some(), "--model"),
        with(args.unit.is_some(), "--unit"),
        with(!args.subtract.is_empty(), "--subtract"),
        with(args.unite, "--unite"),
        with(args.split.is_some(), "--split"),
    ];
    if let Some(option) = options.into_iter().flatten().next() {
        bail!("{}: {option} is for a file; this folder has its faces", args.body.display());
    }
    Ok(args.body.clone())
}

/// Models a file, as `make body` does: scripts and implicit models as they are, all else is imported.
fn modelled(args: &Args) -> Result<PathBuf> {
    let beside = || args.output.parent().unwrap_or(Path::new("")).join("model");
    let folder = args.model.clone().unwrap_or_else(beside);
    let kind = extension(&args.body);
    let own = matches!(kind.as_str(), "toml" | "geo");
    let triangles = matches!(kind.as_str(), "stl" | "obj" | "ply" | "3mf");
    ensure!(
        args.split.is_none() || triangles,
        "{}: --split is for a file of triangles; this one has faces or regions",
        args.body.display()
    );
    let mut words: Vec<OsString> = vec!["cad2fem".into(), args.body.clone().into()];
    let mut option = |name: &str, value: OsString| words.extend([name.into(), value]);
    option("--output", folder.clone().into());
    if let Some(unit) = args.unit {
        option("--unit", unit.symbol().into());
    }
    if triangles {
        option("--split", args.split.unwrap_or(40.0).to_string().into());
    }
    for what in &args.subtract {
        option("--subtract", what.into());
    }
    if args.unite {
        words.push("--unite".into());
    }
    log::info!("{} -> {}", args.body.display(), folder.display());
    let done = if own {
        model::run(&Alone::<model::Args>::try_parse_from(words)?.args)
    } else {
        let (body, page) = (args.body.display(), args.output.display());
        let command = format!("cad2fem pick {body} -o {page}");
        import::run_as(&Alone::<import::Args>::try_parse_from(words)?.args, &command)
    };
    done.with_context(|| format!("{}: no page is written", args.output.display()))?;
    Ok(folder)
}

/// The arguments of another verb by themselves.
#[derive(clap::Parser)]
struct Alone<A: clap::Args> {
    #[command(flatten)]
    args: A,
}
