//! `cad2fem picture`: any surface, mesh or result → a shaded PNG.

pub mod load;
pub mod looks;
mod options;

use std::path::PathBuf;

use anyhow::{Result, ensure};
use log::info;
use mesh::Vec3;
use page::reported::Model;

use load::Loaded;
use looks::{Looks, values};
use options::Pair;
use render::Facet;
use render::annotate::Key;
use render::color::{self, Rgb, Scale};
use render::cut::cut;
use render::shape::Shape;
use render::sheet::{Panel, Sheet, draw_sheet, floor};

/// Names beyond which labels alone tell what is what, as nobody would read the legend.
const LEGEND: usize = 30;

/// Draws .stl, .obj, .ply, .msh (colours per tag) and .vtu files, one panel each, or a folder of
/// `cad2fem model` or `import`: its faces in their colours, with numbers or names and a legend
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Surfaces, volume meshes or results; or the folder of a model, whose patches are drawn as by
    /// --together --label
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// PNG file to write
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    looks: Looks,
    /// All files in one panel, one colour each
    #[arg(long)]
    together: bool,
    /// Move files apart from their common centre, relative to their distance; the walls of chambers out to the side
    #[arg(long, default_value_t = 0.0)]
    spread: f64,
    /// One per file, separated by commas; names in the legend with --together
    /// [default with --label: names of the files]
    #[arg(long, value_delimiter = ',')]
    captions: Vec<String>,
    /// Write its caption on each file, or the number where captions are one word with numbers
    #[arg(long)]
    label: bool,
}

/// Runs `cad2fem picture`.
pub fn run(args: &Args) -> Result<()> {
    args.looks.check()?;
    let args = &of_model(args)?;
    ensure!(
        args.together || (args.spread == 0.0 && !args.label),
        "--spread and --label are for --together, or for the folder of a model"
    );
    ensure!(
        args.captions.is_empty() || args.captions.len() == args.files.len(),
        "--captions: {} captions for {} files",
        args.captions.len(),
        args.files.len()
    );
    let mut loaded = load_all(args)?;
    if args.spread != 0.0 {
        spread(&mut loaded, args.spread, &args.looks.view.frame());
    }
    let panels = panels(args, &loaded);
    ensure!(
        panels.iter().flat_map(|p| &p.pieces).any(|p| !p.facets.is_empty()),
        "nothing is left to draw: {}",
        if args.looks.cut.is_some() {
            "the cut removes everything"
        } else {
            "the files have no triangles"
        }
    );
    let sheet = sheet(args, &loaded, &panels)?;
    draw_sheet(&sheet, &panels).write_png(&args.output)?;
    let Pair(width, height) = args.looks.size;
    info!("{}: {width} x {height} pixels", args.output.display());
    Ok(())
}

/// The arguments with the patches of a folder in its place, each with its label.
fn of_model(args: &Args) -> Result<Args> {
    let folder = args.files.iter().find(|file| file.is_dir());
    let Some(folder) = folder else { return Ok(args.clone()) };
    let shown = folder.display();
    ensure!(
        args.files.len() == 1,
        "{shown}: a folder is drawn alone, {} are given",
        args.files.len()
    );
    let model = Model::read(folder)?;
    let regions = model.regions.iter().chain(&model.inside);
    let files = regions.map(|region| folder.join("patches").join(format!("{}.stl", region.name)));
    let files = files.collect();
    Ok(Args { files, together: true, label: true, ..args.clone() })
}

fn load_all(args: &Args) -> Result<Vec<Loaded>> {
    let loaded = args
        .files
        .iter()
        .enumerate()
        .map(|(i, path)| {
            let color = if args.together { color::palette(i) } else { color::material() };
            load::load(path, &args.looks.paint(color, !args.together))
        })
        .collect::<Result<Vec<_>>>()?;
    if let Some(field) = &args.looks.color {
        ensure!(loaded.iter().any(|l| l.unit.is_some()), "--color {field}: no file is a .vtu");
    }
    Ok(loaded)
}

/// Part of the flux through a surface about its middle, over the largest that there can be, below which it is the wall of
/// a void. A flat face has 0, a sphere 1, and the wall of a chamber with four cells −0.2.
const VOID: f64 = -0.1;

/// Moves every shape away from the centre of all. Where walls of voids would still be hidden in others, they move on
/// beside these in the picture, whose vectors to the right and up begin the frame, and turn the side of their colour out.
fn spread(loaded: &mut [Loaded], factor: f64, [right, up, _]: &[Vec3; 3]) {
    let centers: Vec<Vec3> = loaded.iter().map(|l| center(&l.shape)).collect();
    let mean = centers.iter().sum::<Vec3>() / centers.len() as f64;
    for (file, c) in loaded.iter_mut().zip(centers) {
        file.shape.translate(&(factor * (c - mean)));
    }
    let (mut voids, others): (Vec<_>, Vec<_>) =
        loaded.iter_mut().map(|l| &mut l.shape).partition(|shape| is_void(shape));
    if voids.is_empty() || others.is_empty() {
        return;
    }
    let all = |shapes: &[&mut Shape], axis: &Vec3| {
        let spans = shapes.iter().map(|shape| span(shape, axis));
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default()
    };
    let beside = [right, up].map(|axis| {
        let ((low, high), end) = (all(&voids, axis), all(&others, axis).1);
        (end - low + BESIDE * (high - low), *axis)
    });
    let [(across, right), (along, up)] = beside;
    let by = if across <= along { across * right } else { along * up };
    for shape in &mut voids {
        shape.translate(&by);
        shape.facets.iter_mut().for_each(Facet::turn);
    }
}

/// Room between what was hidden and what hid it, over its own extent.
const BESIDE: f64 = 0.2;

/// Whether the normals of a surface point to its middle.
fn is_void(shape: &Shape) -> bool {
    let (middle, mut flux, mut most) = (center(shape), 0.0, 0.0);
    for [a, b, c] in shape.facets.iter().map(|f| f.points) {
        let (normal, arm) = ((b - a).cross(&(c - a)), (a + b + c) / 3.0 - middle);
        flux += arm.dot(&normal);
        most += arm.norm() * normal.norm();
    }
    flux < VOID * most
}

/// From where to where a shape reaches along an axis.
fn span(shape: &Shape, axis: &Vec3) -> (f64, f64) {
    let along = shape.facets.iter().flat_map(|f| f.points).map(|p| axis.dot(&p));
    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
}

fn center(shape: &Shape) -> Vec3 {
    let points: Vec<Vec3> = shape.facets.iter().flat_map(|f| f.points).collect();
    let (min, max) = mesh::measure::bounds(&points);
    0.5 * (min + max)
}

fn panels(args: &Args, loaded: &[Loaded]) -> Vec<Panel> {
    let pieces = loaded.iter().map(|l| cut(&l.shape, args.looks.plane()));
    if args.together {
        let labels = if args.label { labels(&names(args)) } else { Vec::new() };
        return vec![Panel { pieces: pieces.collect(), caption: String::new(), labels }];
    }
    let captions = args.captions.iter().cloned().chain(std::iter::repeat(String::new()));
    let panel = |(piece, caption)| Panel { pieces: vec![piece], caption, labels: Vec::new() };
    pieces.zip(captions).map(panel).collect()
}

fn sheet(args: &Args, loaded: &[Loaded], panels: &[Panel]) -> Result<Sheet> {
    let scale = args.looks.scale(values(panels))?;
    Ok(args.looks.sheet(scale, floor(panels), key(args, loaded, scale)))
}

fn key(args: &Args, loaded: &[Loaded], scale: Option<Scale>) -> Key {
    if let Some(key) = args.looks.key(loaded, scale) {
        return key;
    }
    let mut entries: Vec<(String, Rgb)> = Vec::new();
    if args.together && (args.label || !args.captions.is_empty()) {
        let captions = names(args).into_iter().enumerate();
        entries.extend(captions.map(|(i, c)| (c, color::palette(i))));
    } else {
        for entry in loaded.iter().flat_map(|l| &l.names) {
            if !entries.contains(entry) {
                entries.push(entry.clone());
            }
        }
    }
    let unread = args.label && entries.len() > LEGEND;
    if entries.is_empty() || unread { Key::None } else { Key::Names(entries) }
}

/// What files of one panel are called: their captions, or else their names.
fn names(args: &Args) -> Vec<String> {
    if !args.captions.is_empty() {
        return args.captions.clone();
    }
    let name = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    args.files.iter().map(name).collect()
}

/// Names as they are written on surfaces: of `face-1`, `face-2`, … the numbers.
fn labels(names: &[String]) -> Vec<String> {
    let split = |name: &str| {
        let word = name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        (word > 0 && word < name.len()).then_some(word)
    };
    let words: Option<Vec<&str>> = names.iter().map(|n| split(n).map(|at| &n[..at])).collect();
    match words.as_deref() {
        Some([first, rest @ ..]) if !rest.is_empty() && rest.iter().all(|word| word == first) => {
            names.iter().map(|name| name[first.len()..].to_owned()).collect()
        }
        _ => names.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::labels;

    #[test]
    fn faces_are_labelled_by_their_numbers_and_regions_by_their_names() {
        let of =
            |names: &[&str]| labels(&names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>());
        assert_eq!(of(&["face-1", "face-12"]), ["1", "12"]);
        for names in [&["face-1", "seat"][..], &["face-1", "side-2"], &["1", "2"], &["face-1"]] {
            assert_eq!(of(names), names);
        }
    }
}
