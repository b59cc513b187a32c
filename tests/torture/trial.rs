//! What programs must survive.

use std::process::Command;
use std::time::Duration;

use mechanics::math::random::Random;
use tests::workdir::Workdir;

use crate::child::{self, Running};
use crate::job::Sound;
use crate::{any, cad, clock, mesher, part};

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
    ("limits", limits),
    ("kills again", kills),
    ("read-only disk", read_only),
    ("bad meshers", mesher::bad),
    ("damaged CAD", cad::damaged),
    ("clocks", clock::jumps),
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
    let mut bytes = std::fs::read(&path).map_err(|e| e.to_string())?;
    let at = any(random, bytes.len());
    let how = match any(random, 6) {
        0 => {
            bytes.truncate(at);
            "cut off"
        }
        1 => {
            bytes.clear();
            "empty"
        }
        2 if !bytes.is_empty() => {
            bytes[at] ^= 1 << any(random, 8);
            "with a bit turned"
        }
        3 => {
            let end = bytes.len().min(at + 512);
            bytes[at..end].fill(0);
            "with a block of zeros"
        }
        4 => {
            bytes.extend_from_slice(b"0\n");
            "with two bytes more"
        }
        5 if !bytes.is_empty() => {
            bytes.swap(at, 0);
            "with two bytes exchanged"
        }
        _ => "as it was",
    };
    std::fs::write(&path, bytes).map_err(|e| e.to_string())?;
    let context = |what: String| format!("{name} {how} at byte {at}: {what}");
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

/// Little memory, few files, a small stack: an error, or the result.
fn limits(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let u = part(random);
    let limit = match any(random, 3) {
        // the system needs a fourth to load the program's libraries
        0 => format!("ulimit -n {}", 4 + (20.0 * u) as usize),
        1 => format!("ulimit -s {}", 200 + (8e3 * u) as usize),
        // below this the system cannot load the program [KiB]
        _ => format!("ulimit -v {}", 50_000 + (1e6 * u * u) as usize),
    };
    let end = child::run(sound.job.after(&dir, &limit))?;
    let context = |what: String| format!("{limit}: {what}");
    end.expect(&[0, 1, 2]).map_err(context)?;
    tally.interruptions += usize::from(end.code != Some(0));
    sound.ends_the_same(&dir).map_err(context)
}

/// A disk that cannot be written to.
fn read_only(sound: &Sound, _: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let here = "mount --bind . . && cd \"$PWD\" && mount -o remount,ro,bind .";
    let mut probe = Command::new("unshare");
    probe.args(["-rm", "bash", "-c", here]).current_dir(dir.path("."));
    if !child::run(probe)?.said.is_empty() {
        eprintln!("no read-only disk: this machine lets nobody mount one");
        return Ok(());
    }
    let own = sound.job.command(&dir);
    let mut command = Command::new("unshare");
    command.args(["-rm", "bash", "-c", &format!("{here} && exec \"$0\" \"$@\"")]);
    command.arg(own.get_program()).args(own.get_args()).current_dir(dir.path("."));
    let end = child::run(command)?;
    end.expect(&[2])?;
    if !end.said.to_lowercase().contains("read-only") {
        return Err(format!("does not say that the disk is read-only: {}", end.said));
    }
    tally.interruptions += 1;
    sound.ends_the_same(&dir)
}

/// No file that was not finished.
fn no_litter(dir: &Workdir) -> Result<(), String> {
    match dir.files("out").into_iter().find(|name| name.starts_with(".incomplete")) {
        Some(name) => Err(format!("out/{name} is left behind")),
        None => Ok(()),
    }
}
