//! A script of ours that runs an external program.
//!
//! It runs in a fresh temporary folder, with its settings in `settings.json` and
//! arrays in `.npy` files. What the external program prints goes to a log there, of
//! which an error shows the end.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use mesh::io::{Unfinished, create_new, npy, read_own_text};
use mesh::{SurfaceMesh, Vec3};
use program::{Heartbeat, Process, Unusable, temporary_folder};
use tempfile::TempDir;

use super::python::Python;

/// Exit code by which a script says that its last line on stderr is for the user.
const EXPLAINED: i32 = 3;

/// Begins every script: the job ends when the program that started it does.
const PRELUDE: &str = "\
import ctypes, signal, sys
if sys.platform == 'linux':
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
";

/// What the names of the folders begin with.
const PREFIX: &str = "cad2fem-";

/// A script about to run in a temporary folder of its own.
pub struct Job {
    folder: TempDir,
    title: &'static str,
    _unfinished: Unfinished,
}

impl Job {
    /// A folder for a job with the name `title`.
    pub fn new(title: &'static str) -> Result<Self> {
        let make = || temporary_folder(PREFIX);
        let (folder, unfinished) =
            Unfinished::new(make, |folder: &TempDir| folder.path().to_owned())?;
        Ok(Self { folder, title, _unfinished: unfinished })
    }

    /// A file of the job.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Makes a file for the script.
    pub fn put(&self, name: &str, content: &[u8]) -> Result<()> {
        let write = create_new(&self.file(name))?.write_all(content);
        write.with_context(|| format!("cannot write {name}"))
    }

    /// Runs `script` with `settings`; gives up after `timeout`.
    pub fn run(
        &self,
        python: &Python,
        script: &str,
        settings: &serde_json::Value,
        timeout: Duration,
    ) -> Result<()> {
        self.put("driver.py", format!("{PRELUDE}{script}").as_bytes())?;
        self.put("settings.json", settings.to_string().as_bytes())?;
        let log = |name: &str| create_new(&self.file(name));
        let start = Instant::now();
        let mut command = Command::new(&python.path);
        command
            .args(["-I", "driver.py"]) // no modules from here or the environment
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(log("stdout.log")?)
            .stderr(log("stderr.log")?);
        let child = Process::spawn(&mut command)
            .with_context(|| format!("cannot run {}", python.path.display()))?;
        match self.wait(&child, start, timeout)? {
            Some(status) if status.success() => Ok(()),
            Some(status) => Err(self.failure(status, start.elapsed())),
            None => Err(Unusable(format!(
                "{} was stopped after {:.0} s; allow more with --timeout, or ask for larger \
                 elements or a wider envelope",
                self.title,
                timeout.as_secs_f64()
            ))
            .into()),
        }
    }

    /// Waits for the end, showing the time that has passed; `None` on a timeout.
    fn wait(
        &self,
        child: &Process,
        start: Instant,
        timeout: Duration,
    ) -> Result<Option<ExitStatus>> {
        let mut heartbeat = Heartbeat::start();
        let mut told = 0;
        loop {
            let ended = child.try_wait()?;
            told = self.tell_notes(told);
            if ended.is_some() {
                return Ok(ended);
            }
            if start.elapsed() > timeout {
                child.kill()?;
                return Ok(None);
            }
            heartbeat.say(|| format!("{}  {} s", self.title, start.elapsed().as_secs()));
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Passes on what the script wrote into `notes`, of which `told` lines are known; how many are known then.
    fn tell_notes(&self, told: usize) -> usize {
        let notes = read_own_text(&self.file("notes")).unwrap_or_default();
        let complete: Vec<&str> =
            notes.split_inclusive('\n').filter(|line| line.ends_with('\n')).collect();
        complete.iter().skip(told).for_each(|line| log::warn!("{}", line.trim_end()));
        complete.len().max(told)
    }

    fn failure(&self, status: ExitStatus, after: Duration) -> anyhow::Error {
        let stderr = read_own_text(&self.file("stderr.log")).unwrap_or_default();
        if status.code() == Some(EXPLAINED) {
            return anyhow::anyhow!("{}", stderr.lines().last().unwrap_or_default().to_owned());
        }
        let stdout = read_own_text(&self.file("stdout.log")).unwrap_or_default();
        let log = format!("{stdout}{stderr}");
        let lines: Vec<&str> = log.lines().collect();
        let end = lines[lines.len().saturating_sub(12)..].join("\n  ");
        Unusable(format!(
            "{} failed after {:.1} s ({status}); the end of its log:\n  {end}",
            self.title,
            after.as_secs_f64()
        ))
        .into()
    }

    /// Hands a surface to the script as `vertices.npy` and `triangles.npy`.
    pub fn put_surface(&self, surface: &SurfaceMesh) -> Result<()> {
        let points: Vec<f64> = surface.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        npy::write_f64(&self.file("vertices.npy"), &points, &[points.len() / 3, 3])?;
        // Indices are below 2⁵³, so that doubles hold them exactly.
        let corners: Vec<f64> = surface.triangles.iter().flatten().map(|&v| v as f64).collect();
        npy::write_f64(&self.file("triangles.npy"), &corners, &[corners.len() / 3, 3])?;
        Ok(())
    }

    /// Points that the script left in `name`.
    pub fn points(&self, name: &str) -> Result<Vec<Vec3>> {
        let rows = self.rows::<3>(name)?;
        Ok(rows.into_iter().map(Vec3::from).collect())
    }

    /// Rows of vertex numbers that the script left in `name`.
    pub fn indices<const N: usize>(&self, name: &str) -> Result<Vec<[usize; N]>> {
        Ok(self.rows::<N>(name)?.into_iter().map(|row| row.map(|x| x as usize)).collect())
    }

    fn rows<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        let (values, shape) = npy::read_f64(&self.file(name))
            .with_context(|| format!("{} left no usable result", self.title))?;
        if shape.len() != 2 || shape[1] != N {
            bail!("{} left {name} with the shape {shape:?}; rows of {N} are needed", self.title);
        }
        let (rows, _) = values.as_chunks::<N>();
        Ok(rows.to_vec())
    }
}
