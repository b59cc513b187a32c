//! The Python that runs the external programs.

use std::path::PathBuf;
use std::process::{Command, Output};

use anyhow::{Context, Result, bail, ensure};

use crate::installation;

/// Environment variable that names the Python to use.
pub const PYTHON_VARIABLE: &str = "PUFFER_PYTHON";

/// Path of the Python of a checkout.
const PYTHON: &str = ".venv/bin/python";

/// A Python interpreter.
pub struct Python {
    pub(crate) path: PathBuf,
}

impl Python {
    /// The interpreter named by [`PYTHON_VARIABLE`]; where that is unset or empty, the one whose package this
    /// program lies in, else `.venv/bin/python` of the checkout that the program was built in; says which.
    pub fn find() -> Result<Self> {
        let named = std::env::var_os(PYTHON_VARIABLE).filter(|name| !name.is_empty());
        let path = match named.map(PathBuf::from) {
            Some(path) if path.is_file() => path,
            Some(path) => bail!("{PYTHON_VARIABLE} is {}, which is not a file", path.display()),
            None => installation::python().map_or_else(of_checkout, Ok)?,
        };
        log::info!("Python of the meshers: {}", path.display());
        Ok(Self { path })
    }

    /// Where it is.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Loads a package: libraries of the system that it needs may be missing.
    pub fn import(&self, package: &str) -> Result<()> {
        let output = self.ask("import importlib as m; m.import_module(package)", package)?;
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim_end().lines().last().unwrap_or("it says nothing");
        ensure!(output.status.success(), "cannot be loaded: {last}");
        Ok(())
    }

    /// The installed version of a package.
    pub fn version_of(&self, package: &str) -> Result<String> {
        let output =
            self.ask("import importlib.metadata as m; print(m.version(package))", package)?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
        }
        bail!(
            "{} has no package {package}; pip install softpuffer, in a checkout `make setup`, or set \
             {PYTHON_VARIABLE} to a Python that has it",
            self.path.display()
        )
    }

    /// Runs a line about a package, with nothing from the working directory.
    fn ask(&self, line: &str, package: &str) -> Result<Output> {
        let script = format!("import sys; package = sys.argv[1]; {line}");
        let output = Command::new(&self.path).args(["-I", "-c", &script, package]).output();
        output.with_context(|| format!("cannot run {}", self.path.display()))
    }
}

fn of_checkout() -> Result<PathBuf> {
    let remedy = || {
        format!(
            "no Python with the meshers: {PYTHON_VARIABLE} is not set, and the program lies neither in \
             the package of a Python nor in a checkout of its own with a .venv; use that of `pip install softpuffer` \
             or of `make setup`, or set {PYTHON_VARIABLE}"
        )
    };
    let python = installation::checkout().map(|folder| folder.join(PYTHON));
    python.filter(|python| python.is_file()).with_context(remedy)
}
