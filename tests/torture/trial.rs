//! What programs must survive.

use std::time::Duration;

use mechanics::math::random::Random;
use tests::fuzz::mutate;
use tests::workdir::Workdir;

use crate::child::{self, Running};
use crate::job::Sound;
use crate::{any, cad, part};

/// Most kills in one folder.
const KILLS: usize = 12;

/// What a kind of trial came to.
#[derive(Clone, Default)]
pub struct Tally {
    pub cases: usize,
    /// Kills, signals and refusals: what did not end by itself.
    pub interruptions: usize,
    pub failures: Vec<String>,
}

type Trial = fn(&Sound, &mut Random, &mut Tally) -> Result<(), String>;

pub const TRIALS: &[(&str, Trial)] = &[
    ("kills", kills),
    ("signals", signals),
    ("full disk", full_disk),
    ("damaged files", damage),
    ("two writers", two_writers),
    ("damaged CAD", cad::damaged),
];

/// A moment of a run.
pub fn moment(sound: &Sound, random: &mut Random) -> Duration {
    sound.time.mul_f64(1.1 * part(random))
}

/// SIGKILL at random moments until it ends, or often enough.
fn kills(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    for _ in 0..KILLS {
        let mut running = Running::start(sound.job.command(&dir));
        if running.runs_for(moment(sound, random)) {
            running.signal("KILL");
        }
        let end = running.end()?;
        if end.signal.is_none() {
            end.expect(&[0])?;
            break;
        }
        tally.interruptions += 1;
    }
    sound.ends_the_same(&dir)
}

/// A signal that asks it to end: it does so in order, and leaves nothing half-written.
fn signals(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let (name, code) = if any(random, 2) == 0 { ("INT", 130) } else { ("TERM", 143) };
    let mut running = Running::start(sound.job.command(&dir));
    if running.runs_for(moment(sound, random)) {
        running.signal(name);
    }
    let end = running.end()?;
    // before it has begun to listen, the signal itself ends it
    if end.signal.is_none() {
        end.expect(&[0, code])?;
        no_litter(&dir)?;
    }
    tally.interruptions += usize::from(end.code != Some(0));
    sound.ends_the_same(&dir)
}

/// Files that may not grow further stand for a full disk.
fn full_disk(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let limit = any(random, sound.largest() / 1024 + 1);
    // without the trap the signal would end the program before it sees the error
    let end = child::run(sound.job.after(&dir, &format!("trap '' XFSZ; ulimit -f {limit}")))?;
    end.expect(&[0, 1, 2])?;
    no_litter(&dir)?;
    tally.interruptions += usize::from(end.code != Some(0));
    sound.ends_the_same(&dir)
}

/// One file of its own is altered between two runs: it is refused, or did not matter.
fn damage(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let mut running = Running::start(sound.job.command(&dir));
    if running.runs_for(moment(sound, random)) {
        running.signal("KILL");
    }
    running.end()?;
    let files = dir.files("out");
    if files.is_empty() {
        return sound.ends_the_same(&dir);
    }
    let name = files[any(random, files.len())].clone();
    let path = dir.path(&format!("out/{name}"));
    if path.is_dir() {
        return sound.ends_the_same(&dir);
    }
    let bytes = std::fs::read(&path).map_err(|e| e.to_string())?;
    std::fs::write(&path, mutate(&[bytes], random)).map_err(|e| e.to_string())?;
    let context = |what: String| format!("{name}: {what}");
    let end = child::run(sound.job.command(&dir))?;
    end.expect(&[0, 2]).map_err(context)?;
    if end.code == Some(0) {
        return sound.is_same(&dir).map_err(context);
    }
    tally.interruptions += 1;
    if !sound.job.continues {
        return Err(context(format!("refused: {}", end.said)));
    }
    let mut again = sound.job.command(&dir);
    again.arg("--restart");
    child::run(again)?.expect(&[0]).map_err(context)?;
    sound.is_same(&dir).map_err(context)
}

/// Two runs of one command at once: one works, the other works too or is refused.
fn two_writers(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let mut first = Running::start(sound.job.command(&dir));
    first.runs_for(moment(sound, random).mul_f64(0.5));
    let second = child::run(sound.job.command(&dir))?;
    let first = first.end()?;
    first.expect(&[0, 2])?;
    second.expect(&[0, 2])?;
    if first.code != Some(0) && second.code != Some(0) {
        return Err(format!("both are refused: {} and {}", first.said, second.said));
    }
    tally.interruptions += usize::from(first.code != second.code);
    sound.ends_the_same(&dir)
}

/// No file that was not finished.
fn no_litter(dir: &Workdir) -> Result<(), String> {
    match dir.files("out").into_iter().find(|name| name.starts_with(".incomplete")) {
        Some(name) => Err(format!("out/{name} is left behind")),
        None => Ok(()),
    }
}
