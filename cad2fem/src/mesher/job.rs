//! A script of ours that runs an external program.
//!
//! It runs in a fresh temporary folder, with its settings in `settings.json` and
//! arrays in `.npy` files. What the external program prints goes to a log there, of
//! which an error shows the end.

use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use mesh::io::npy;
use mesh::{SurfaceMesh, Vec3};
use program::{Spinner, Unusable};
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

/// A script about to run in a temporary folder of its own.
pub struct Job {
    folder: TempDir,
    title: &'static str,
}

impl Job {
    /// A folder for a job with the name `title`.
    ///
    /// # Errors
    /// If the folder cannot be made.
    pub fn new(title: &'static str) -> Result<Self> {
        let folder = tempfile::Builder::new()
            .prefix("cad2fem-")
            .tempdir()
            .context("cannot create a temporary folder")?;
        Ok(Self { folder, title })
    }

    /// A file of the job.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `script` with `settings`; gives up after `timeout`.
    ///
    /// # Errors
    /// If the script does not start, fails, or does not end in time.
    pub fn run(
        &self,
        python: &Python,
        script: &str,
        settings: &serde_json::Value,
        timeout: Duration,
    ) -> Result<()> {
        let write = |name: &str, text: &str| {
            std::fs::write(self.file(name), text).with_context(|| format!("cannot write {name}"))
        };
        write("driver.py", &format!("{PRELUDE}{script}"))?;
        write("settings.json", &settings.to_string())?;
        let log = |name: &str| std::fs::File::create(self.file(name)).context("cannot write logs");
        let start = Instant::now();
        let mut child = Command::new(&python.path)
            .args(["-I", "driver.py"]) // no modules from here or the environment
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(log("stdout.log")?)
            .stderr(log("stderr.log")?)
            .spawn()
            .with_context(|| format!("cannot run {}", python.path.display()))?;
        match self.wait(&mut child, start, timeout)? {
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
        child: &mut Child,
        start: Instant,
        timeout: Duration,
    ) -> Result<Option<ExitStatus>> {
        let spinner = Spinner::new(self.title);
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            if start.elapsed() > timeout {
                child.kill()?;
                child.wait()?;
                return Ok(None);
            }
            spinner.show(start.elapsed());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn failure(&self, status: ExitStatus, after: Duration) -> anyhow::Error {
        let stderr = std::fs::read_to_string(self.file("stderr.log")).unwrap_or_default();
        if status.code() == Some(EXPLAINED) {
            return anyhow::anyhow!("{}", stderr.lines().last().unwrap_or_default().to_owned());
        }
        let stdout = std::fs::read_to_string(self.file("stdout.log")).unwrap_or_default();
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
    ///
    /// # Errors
    /// If the files cannot be written.
    pub fn put_surface(&self, surface: &SurfaceMesh) -> Result<()> {
        let points: Vec<f64> = surface.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        npy::write_f64(&self.file("vertices.npy"), &points, &[points.len() / 3, 3])?;
        // Indices are below 2⁵³, so that doubles hold them exactly.
        let corners: Vec<f64> = surface.triangles.iter().flatten().map(|&v| v as f64).collect();
        npy::write_f64(&self.file("triangles.npy"), &corners, &[corners.len() / 3, 3])?;
        Ok(())
    }

    /// Points that the script left in `name`.
    ///
    /// # Errors
    /// If the file is missing or is not an array of points.
    pub fn points(&self, name: &str) -> Result<Vec<Vec3>> {
        let rows = self.rows::<3>(name)?;
        Ok(rows.into_iter().map(Vec3::from).collect())
    }

    /// Rows of vertex numbers that the script left in `name`.
    ///
    /// # Errors
    /// If the file is missing or is not an array of rows of `N` indices.
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
