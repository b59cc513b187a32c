//! `cad2fem film`: a run, step by step → an animated GIF.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use gif::{Encoder, Frame, Repeat};
use log::info;
use mesh::Vec3;
use mesh::io::{read_text, write_atomic};
use page::reported::Scene;
use render::annotate::Key;
use render::color;
use render::cut::cut;
use render::image::Image;
use render::sheet::{Panel, Sheet, draw_sheet};
use serde::Deserialize;

use super::picture::load;
use super::picture::looks::{Looks, values};

/// Draws all steps of a run with one camera and one colour scale
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of `solver simulate` with its step_*.vtu, or files, one per frame
    #[arg(required = true)]
    run: Vec<PathBuf>,
    /// GIF file to write
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    looks: Looks,
    /// Frames per second, 1 to 50
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=50))]
    fps: u16,
    /// Most frames; of more steps some are left out, evenly
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u16).range(2..=5000))]
    frames: u16,
}

/// How carefully the 256 colours of a frame are chosen: 1 most, 30 least.
const HASTE: i32 = 10;
/// How long the last frame stays [s].
const HOLD: f64 = 1.0;

/// A file and what is written below it.
struct Step {
    path: PathBuf,
    caption: String,
}

/// Runs `cad2fem film`.
pub fn run(args: &Args) -> Result<()> {
    args.looks.check()?;
    ensure!(
        args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("gif")),
        "{}: films are written as GIF; the name of the output has to end with .gif",
        args.output.display()
    );
    let [width, height] = [args.looks.size.0, args.looks.size.1].map(u16::try_from);
    let (width, height) = (width?, height?);
    let steps = thinned(steps(&args.run)?, args.frames.into());
    let sheet = sheet(&args.looks, &steps)?;
    write_atomic(&args.output, |out| {
        let mut film = Encoder::new(out, width, height, &[]).map_err(std::io::Error::other)?;
        film.set_repeat(Repeat::Infinite).map_err(std::io::Error::other)?;
        for (i, step) in steps.iter().enumerate() {
            let (panel, _) = panel(&args.looks, step).map_err(std::io::Error::other)?;
            let image = draw_sheet(&sheet, &[panel]);
            let mut frame = Frame::from_rgb_speed(width, height, &bytes(&image), HASTE);
            let seconds = if i + 1 == steps.len() { HOLD } else { 1.0 / f64::from(args.fps) };
            // a GIF counts hundredths of a second
            frame.delay = (100.0 * seconds).round() as u16;
            film.write_frame(&frame).map_err(std::io::Error::other)?;
        }
        Ok(())
    })?;
    info!("{}: {} frames of {width} x {height} pixels", args.output.display(), steps.len());
    Ok(())
}

/// The steps of a run's folder, or files as they are given.
fn steps(given: &[PathBuf]) -> Result<Vec<Step>> {
    if let Some(path) = given.iter().find(|path| !path.exists()) {
        bail!("{}: no such file or folder", path.display());
    }
    let steps = match given {
        [folder] if folder.is_dir() => of_folder(folder)?,
        files => {
            let step = |path: &PathBuf| Step { path: path.clone(), caption: String::new() };
            files.iter().map(step).collect()
        }
    };
    ensure!(
        steps.len() > 1,
        "{}: {} steps, a film needs 2 at least: simulate in more steps, as with --set \
         solver.largest_load_step=0.1, and without --final-only",
        given[0].display(),
        steps.len()
    );
    Ok(steps)
}

/// What is read of the report of a simulation.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Report {
    config: Scene,
    steps: Vec<State>,
}

#[derive(Deserialize)]
struct State {
    t: Option<f64>,
    load: Option<f64>,
}

fn of_folder(folder: &Path) -> Result<Vec<Step>> {
    let report = folder.join("report.json");
    let text = read_text(&report)?;
    let Report { config, steps } =
        serde_json::from_str(&text).with_context(|| report.display().to_string())?;
    let step = |(i, state): (usize, &State)| Step {
        path: folder.join(format!("step_{i:03}.vtu")),
        caption: match (config.time.is_some(), state.t, state.load) {
            (true, Some(t), _) => format!("{t:.3} s"),
            (false, _, Some(load)) => format!("{:.0} % of the load", 100.0 * load),
            _ => String::new(),
        },
    };
    Ok(steps.iter().enumerate().map(step).filter(|step| step.path.is_file()).collect())
}

/// At most so many, evenly chosen, the last of them always.
fn thinned(steps: Vec<Step>, most: usize) -> Vec<Step> {
    let count = steps.len();
    if count <= most {
        return steps;
    }
    let kept: Vec<usize> = (0..most).map(|i| i * (count - 1) / (most - 1)).collect();
    steps
        .into_iter()
        .enumerate()
        .filter(|(i, _)| kept.binary_search(i).is_ok())
        .map(|s| s.1)
        .collect()
}

/// A step to be drawn, and the unit of its field.
fn panel(looks: &Looks, step: &Step) -> Result<(Panel, load::Loaded)> {
    let loaded = load::load(&step.path, &looks.paint(color::material(), false))?;
    let pieces = vec![cut(&loaded.shape, looks.plane())];
    Ok((Panel { pieces, caption: step.caption.clone(), labels: Vec::new() }, loaded))
}

/// One camera, scale and ground for all steps, of which one at a time is in memory.
fn sheet(looks: &Looks, steps: &[Step]) -> Result<Sheet> {
    let mut range: Option<(f64, f64)> = None;
    let mut shown: Option<(Vec3, Vec3)> = None;
    let mut last = None;
    for step in steps {
        let (panel, loaded) = panel(looks, step)?;
        let (low, high) = (f64::min, f64::max);
        range = merged(range, values(std::slice::from_ref(&panel)), |a, b| {
            (low(a.0, b.0), high(a.1, b.1))
        });
        shown = merged(shown, render::bounds(&panel.pieces), |a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        last = Some(loaded);
    }
    ensure!(shown.is_some(), "nothing is left to draw: the cut removes everything");
    let scale = looks.scale(range)?;
    let key = last.and_then(|loaded| looks.key(&[loaded], scale)).unwrap_or(Key::None);
    let ground = shown.map(|(min, _)| min.z);
    Ok(Sheet { shown, ..looks.sheet(scale, ground, key) })
}

fn merged<T>(a: Option<T>, b: Option<T>, merge: impl Fn(T, T) -> T) -> Option<T> {
    match (a, b) {
        (Some(a), Some(b)) => Some(merge(a, b)),
        (a, b) => a.or(b),
    }
}

fn bytes(image: &Image) -> Vec<u8> {
    image.pixels.iter().flatten().map(|v| (255.0 * v).round() as u8).collect()
}
