//! Clocks that jump: what tells the age of files is wrong.

use std::fs::{File, FileTimes};
use std::path::Path;
use std::time::{Duration, SystemTime};

use mechanics::math::random::Random;

use crate::child::Running;
use crate::job::Sound;
use crate::trial::{Tally, moment};
use crate::{any, part};

/// A century, more than any run takes.
const FAR: Duration = Duration::from_secs(100 * 365 * 86_400);

/// After a kill all files are from the past, from the future, from one moment, or each from another: the
/// same command ends with the same bits.
pub fn jumps(sound: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = (sound.job.workdir)();
    let mut running = Running::start(sound.job.command(&dir));
    if running.runs_for(moment(sound, random)) {
        running.signal("KILL");
        tally.interruptions += 1;
    }
    running.end()?;
    let now = SystemTime::now();
    let (how, time): (_, fn(SystemTime, f64) -> SystemTime) = match any(random, 4) {
        0 => ("from 1970", |_, _| SystemTime::UNIX_EPOCH),
        1 => ("from the future", |now, _| now + FAR),
        2 => ("from now", |now, _| now),
        _ => ("each from another time", |now, u| now - FAR.mul_f64(0.5) + FAR.mul_f64(u)),
    };
    date(&dir.path("."), &mut || time(now, part(random))).map_err(|e| e.to_string())?;
    sound.ends_the_same(&dir).map_err(|what| format!("files {how}: {what}"))
}

/// Gives all files in a folder and below another time.
fn date(folder: &Path, time: &mut impl FnMut() -> SystemTime) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten() {
        if entry.path().is_dir() {
            date(&entry.path(), time)?;
        } else {
            let times = FileTimes::new().set_modified(time()).set_accessed(time());
            File::options().write(true).open(entry.path())?.set_times(times)?;
        }
    }
    Ok(())
}
