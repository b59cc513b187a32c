//! `cad2fem picture`: any surface, mesh or result → a shaded PNG.

mod load;
mod options;

use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use log::info;
use mesh::Vec3;

use load::{Loaded, Paint};
use options::{Component, Cut, Pair};
use render::annotate::Key;
use render::camera::Projection;
use render::color::{self, Map, Rgb, Scale};
use render::cut::{Plane, cut};
use render::panel::Look;
use render::raster::Lines;
use render::shape::Shape;
use render::sheet::{Panel, Sheet, draw_sheet, floor};
use render::view::View;

/// Draws .stl, .obj, .ply, .msh (colours per tag) and .vtu files, one panel each
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Surfaces, volume meshes or results
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// PNG file to write
    #[arg(short, long)]
    output: PathBuf,
    /// Where to look from: iso, front, back, left, right, top, bottom, under, or
    /// azimuth,elevation in degrees
    #[arg(long, default_value = "iso", allow_hyphen_values = true)]
    view: View,
    /// Width and height in pixels
    #[arg(long, default_value = "1600x900")]
    size: Pair<'x', usize>,
    /// Parallel lines stay parallel
    #[arg(long)]
    orthographic: bool,
    /// Plane that cuts everything: x=V, y=V or z=V removes the side of the camera;
    /// nx,ny,nz,V removes n·x > V for the unit normal n
    #[arg(long, allow_hyphen_values = true)]
    cut: Option<Cut>,
    /// Colour by a field of a .vtu: NAME is a scalar or the length of a vector,
    /// NAME.x, NAME.y, NAME.z or NAME.0 to NAME.8 a component
    #[arg(long)]
    color: Option<Component>,
    /// Values at the ends of the colour scale [default: those of all files]
    #[arg(long, allow_hyphen_values = true)]
    range: Option<Pair<',', f64>>,
    /// Colours of the scale
    #[arg(long, value_enum, default_value_t = Map::Viridis)]
    map: Map,
    /// Point field of a .vtu that moves its points; none keeps them
    /// [default: displacement, where there is one]
    #[arg(long)]
    deform: Option<String>,
    /// Factor on the deformation
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true)]
    magnify: f64,
    /// Draw the edges of the mesh
    #[arg(long)]
    edges: bool,
    /// Leave out the lines at sharp edges
    #[arg(long)]
    smooth: bool,
    /// Leave out shadows on the ground
    #[arg(long)]
    no_ground: bool,
    /// All files in one panel, one colour each
    #[arg(long)]
    together: bool,
    /// Move files apart from their common centre, relative to their distance
    #[arg(long, default_value_t = 0.0, requires = "together")]
    spread: f64,
    /// Stand all files on the ground in a row, from left to right
    #[arg(long, requires = "together", conflicts_with = "spread")]
    row: bool,
    /// Written above everything
    #[arg(long, default_value = "")]
    title: String,
    /// One per file, separated by commas; names in the legend with --together
    #[arg(long, value_delimiter = ',')]
    captions: Vec<String>,
}

/// Largest width or height [px].
const LARGEST: usize = 16_384;

/// Runs `cad2fem picture`.
///
/// # Errors
/// If a file cannot be read or written, a field is missing, or nothing is left to draw.
pub fn run(args: &Args) -> Result<()> {
    let Pair(width, height) = args.size;
    let fits = |s: usize| (64..=LARGEST).contains(&s);
    ensure!(fits(width) && fits(height), "--size {width}x{height}: each must be 64 to {LARGEST}");
    ensure!(args.magnify.is_finite(), "--magnify {} is not a number", args.magnify);
    ensure!(
        args.captions.is_empty() || args.captions.len() == args.files.len(),
        "--captions: {} captions for {} files",
        args.captions.len(),
        args.files.len()
    );
    let mut loaded = load_all(args)?;
    if args.spread != 0.0 {
        spread(&mut loaded, args.spread);
    }
    if args.row {
        line_up(&mut loaded, &args.view.frame()[0]);
    }
    let panels = panels(args, &loaded);
    ensure!(
        panels.iter().flat_map(|p| &p.pieces).any(|p| !p.facets.is_empty()),
        "nothing is left to draw: {}",
        if args.cut.is_some() {
            "the cut removes everything"
        } else {
            "the files have no triangles"
        }
    );
    let sheet = sheet(args, &loaded, &panels)?;
    draw_sheet(&sheet, &panels).write_png(&args.output)?;
    info!("{}: {width} x {height} pixels", args.output.display());
    Ok(())
}

fn load_all(args: &Args) -> Result<Vec<Loaded>> {
    let loaded = args
        .files
        .iter()
        .enumerate()
        .map(|(i, path)| {
            let color = if args.together { color::palette(i) } else { color::material() };
            let paint = Paint {
                color,
                field: args.color.as_ref(),
                deform: args.deform.as_deref(),
                magnify: args.magnify,
                tags: !args.together,
            };
            load::load(path, &paint)
        })
        .collect::<Result<Vec<_>>>()?;
    if let Some(field) = &args.color {
        ensure!(loaded.iter().any(|l| l.unit.is_some()), "--color {field}: no file is a .vtu");
    }
    Ok(loaded)
}

/// Moves every shape away from the centre of all.
fn spread(loaded: &mut [Loaded], factor: f64) {
    let centers: Vec<Vec3> = loaded.iter().map(|l| center(&l.shape)).collect();
    let mean = centers.iter().sum::<Vec3>() / centers.len() as f64;
    for (file, c) in loaded.iter_mut().zip(centers) {
        file.shape.translate(&(factor * (c - mean)));
    }
}

fn center(shape: &Shape) -> Vec3 {
    let points: Vec<Vec3> = shape.facets.iter().flat_map(|f| f.points).collect();
    let (min, max) = mesh::measure::bounds(&points);
    0.5 * (min + max)
}

/// Puts shapes on z = 0 one after the other along the horizontal direction
/// `right`, with a fifth of their mean width between them.
fn line_up(loaded: &mut [Loaded], right: &Vec3) {
    let span = |shape: &Shape, axis: &Vec3| {
        let along = shape.facets.iter().flat_map(|f| f.points).map(|p| axis.dot(&p));
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    let spans: Vec<(f64, f64)> = loaded.iter().map(|l| span(&l.shape, right)).collect();
    let gap = 0.2 * spans.iter().map(|(a, b)| b - a).sum::<f64>() / spans.len() as f64;
    let mut next = 0.0;
    for (file, (left, end)) in loaded.iter_mut().zip(spans) {
        let c = center(&file.shape);
        let level = Vec3::new(c.x, c.y, span(&file.shape, &Vec3::z()).0);
        let across = level - right.dot(&level) * right;
        file.shape.translate(&((next - left) * right - across));
        next += end - left + gap;
    }
}

fn panels(args: &Args, loaded: &[Loaded]) -> Vec<Panel> {
    let toward = args.view.frame()[2];
    let plane: Option<Plane> = args.cut.as_ref().map(|c| c.plane(&toward));
    let pieces = loaded.iter().map(|l| cut(&l.shape, plane));
    if args.together {
        return vec![Panel { pieces: pieces.collect(), caption: String::new() }];
    }
    let captions = args.captions.iter().cloned().chain(std::iter::repeat(String::new()));
    pieces.zip(captions).map(|(p, caption)| Panel { pieces: vec![p], caption }).collect()
}

fn sheet(args: &Args, loaded: &[Loaded], panels: &[Panel]) -> Result<Sheet> {
    let scale = scale(args, panels)?;
    let projection =
        if args.orthographic { Projection::Orthographic } else { Projection::Perspective };
    let lines = Lines { edges: args.edges, features: !args.smooth };
    let ground = if args.no_ground { None } else { floor(panels) };
    Ok(Sheet {
        size: [args.size.0, args.size.1],
        title: args.title.clone(),
        view: args.view,
        projection,
        look: Look { scale, lines, ground },
        key: key(args, loaded, scale),
    })
}

/// The range of values that are drawn, unless the user gives one.
fn scale(args: &Args, panels: &[Panel]) -> Result<Option<Scale>> {
    let Some(field) = &args.color else { return Ok(None) };
    if let Some(Pair(min, max)) = args.range {
        ensure!(min < max, "--range {min},{max}: the first must be smaller");
        return Ok(Some(Scale { min, max, map: args.map }));
    }
    let facets = panels.iter().flat_map(|p| &p.pieces).flat_map(|p| &p.facets);
    let values = facets.flat_map(|f| f.values).filter(|v| v.is_finite());
    let range = values.map(|v| (v, v)).reduce(|(a, b), (v, _)| (a.min(v), b.max(v)));
    let Some((mut min, mut max)) = range else {
        bail!("--color {field}: no finite value is left to draw");
    };
    if args.map == Map::Diverging {
        (min, max) = (-min.abs().max(max.abs()), min.abs().max(max.abs()));
    }
    Ok(Some(Scale { min, max, map: args.map }))
}

fn key(args: &Args, loaded: &[Loaded], scale: Option<Scale>) -> Key {
    if let (Some(field), Some(scale)) = (&args.color, scale) {
        let unit = loaded.iter().find_map(|l| l.unit.clone()).unwrap_or_default();
        return Key::Scale { name: field.to_string(), unit, scale };
    }
    let mut names: Vec<(String, Rgb)> = Vec::new();
    if args.together {
        names.extend(args.captions.iter().enumerate().map(|(i, c)| (c.clone(), color::palette(i))));
    } else {
        for entry in loaded.iter().flat_map(|l| &l.names) {
            if !names.contains(entry) {
                names.push(entry.clone());
            }
        }
    }
    if names.is_empty() { Key::None } else { Key::Names(names) }
}
