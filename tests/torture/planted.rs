//! Links and pipes in place of the files of a finished run, as a folder that others sent may hold them.

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use mechanics::math::random::Random;
use tests::workdir::Workdir;

use crate::any;
use crate::child;
use crate::job::{Job, Sound};
use crate::trial::Tally;

/// Whoever follows a link ends here.
const VICTIM: &str = "precious";

/// What is put in place of a file, by its name.
type Plant = fn(&Path, &Path) -> std::io::Result<()>;

const PLANTS: &[(&str, Plant)] = &[
    ("a link to a file", |place, top| symlink(top.join("victim/file"), place)),
    ("a link to a folder", |place, top| symlink(top.join("victim"), place)),
    ("a link to nothing", |place, top| symlink(top.join("victim/new"), place)),
    ("a link to a device", |place, _| symlink("/dev/full", place)),
    ("a pipe", |place, _| Command::new("mkfifo").arg(place).status().map(drop)),
];

/// One file of a finished run.
pub fn one(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let places = places(&finished(sound.job)?);
    let place = &places[any(random, places.len())];
    let plant = any(random, PLANTS.len());
    tally.interruptions += usize::from(planted(sound.job, place, plant)? != 0);
    Ok(())
}

/// Each file and folder of a finished run with each plant; how many runs were refused.
pub fn each(job: &Job) -> Result<usize, String> {
    let places = places(&finished(job)?);
    let mut refused = 0;
    for place in &places {
        for plant in 0..PLANTS.len() {
            refused += usize::from(planted(job, place, plant)? != 0);
        }
    }
    eprintln!("{}: {} places, {} plants, {refused} refused", job.name, places.len(), PLANTS.len());
    Ok(refused)
}

fn finished(job: &Job) -> Result<Workdir, String> {
    let dir = (job.workdir)();
    child::run(job.command(&dir))?.expect(&[0])?;
    Ok(dir)
}

/// What lies below `out`, and the file that is locked, relative to it.
fn places(dir: &Workdir) -> Vec<PathBuf> {
    let top = dir.path("out");
    let mut found = vec![PathBuf::from(".lock")];
    let mut folders = vec![top.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            folders.extend(path.is_dir().then(|| path.clone()));
            found.push(path.strip_prefix(&top).unwrap_or(&path).to_owned());
        }
    }
    found.sort();
    found
}

/// The exit code of a run that finds it there. What the link leads to stays as it was.
fn planted(job: &Job, place: &Path, plant: usize) -> Result<i32, String> {
    let dir = finished(job)?;
    let (what, put) = PLANTS[plant];
    let context = |said: String| format!("{} in place of {}: {said}", what, place.display());
    std::fs::create_dir(dir.path("victim")).map_err(|e| e.to_string())?;
    dir.write("victim/file", VICTIM);
    let path = dir.path("out").join(place);
    let _not_there_yet =
        if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
    put(&path, &dir.path("")).map_err(|e| context(e.to_string()))?;
    let end = child::run(job.command(&dir)).map_err(context)?;
    end.expect(&[0, 2]).map_err(context)?;
    if dir.files("victim") != ["file"] || dir.text("victim/file") != VICTIM {
        return Err(context("what it leads to is changed".into()));
    }
    let named = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if end.code == Some(2) && !end.said.contains(&named) {
        return Err(context(format!("refused without its name: {}", end.said)));
    }
    Ok(end.code.unwrap_or_default())
}
