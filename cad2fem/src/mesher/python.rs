//! The Python that runs the external programs.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};

/// Environment variable that names the Python to use.
pub const PYTHON_VARIABLE: &str = "PUFFER_PYTHON";

/// A Python interpreter.
pub struct Python {
    pub(super) path: PathBuf,
}

impl Python {
    /// The interpreter named by [`PYTHON_VARIABLE`], else `.venv/bin/python` in the
    /// working directory, in the folder of the program, or above one of them.
    ///
    /// # Errors
    /// If there is none.
    pub fn find() -> Result<Self> {
        if let Some(path) = std::env::var_os(PYTHON_VARIABLE).map(PathBuf::from) {
            if path.is_file() {
                return Ok(Self { path });
            }
            bail!("{PYTHON_VARIABLE} is {}, which is not a file", path.display());
        }
        let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
        let places = starts.iter().flatten().flat_map(|start| start.ancestors());
        let mut candidates = places.map(|folder| folder.join(".venv/bin/python"));
        let path = candidates.find(|path| path.is_file()).with_context(|| {
            format!(
                "no Python with the meshers: {PYTHON_VARIABLE} is not set and there is no \
                 .venv/bin/python in or above the working directory or the program; \
                 run `make setup`"
            )
        })?;
        Ok(Self { path })
    }

    /// The installed version of a package.
    ///
    /// # Errors
    /// If Python does not run or the package is not installed.
    pub fn version_of(&self, package: &str) -> Result<String> {
        let script = "import importlib.metadata as m, sys; print(m.version(sys.argv[1]))";
        let output = Command::new(&self.path)
            .args(["-I", "-c", script, package]) // nothing from the working directory
            .output()
            .with_context(|| format!("cannot run {}", self.path.display()))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
        }
        bail!(
            "{} has no package {package}; run `make setup`, or set {PYTHON_VARIABLE} to a Python \
             that has it",
            self.path.display()
        )
    }
}
