//! The Python that runs the external programs.

use std::path::PathBuf;
use std::process::{Command, Output};

use anyhow::{Context, Result, bail, ensure};

use crate::installation;

/// Environment variable that names the Python to use.
pub const PYTHON_VARIABLE: &str = "PUFFER_PYTHON";

/// Path of the Python of a checkout.
const PYTHON: &str = if cfg!(windows) { ".venv/Scripts/python.exe" } else { ".venv/bin/python" };

/// Defines `load`, which loads a package.
const LOAD: &str = include_str!("load.py");

/// A Python interpreter.
pub struct Python {
    pub(crate) path: PathBuf,
}

/// A package that a Python has.
pub struct Package<'a> {
    /// Which Python.
    pub python: &'a Python,
    /// What pip and Python call it.
    pub name: &'static str,
    /// The version that is installed.
    pub version: String,
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

    /// The first of some packages that is installed.
    pub fn first_of(&self, names: &'static [&'static str]) -> Result<Package<'_>> {
        let line = "import importlib.metadata as m, sys
for name in sys.argv[1:]:
    try: print(name, m.version(name)); break
    except m.PackageNotFoundError: pass";
        let output = self.ask(line, names)?;
        let found = String::from_utf8_lossy(&output.stdout);
        let (found, version) = found.trim().split_once(' ').unwrap_or_default();
        let name = names.iter().find(|name| **name == found).with_context(|| {
            format!(
                "{} has no package {}; pip install softpuffer, in a checkout `make setup`, or set \
                 {PYTHON_VARIABLE} to a Python that has it",
                self.path.display(),
                names.join(" or ")
            )
        })?;
        Ok(Package { python: self, name, version: version.to_owned() })
    }

    /// Runs a script, with nothing from the working directory.
    fn ask(&self, script: &str, arguments: &[&str]) -> Result<Output> {
        let output = Command::new(&self.path).args(["-I", "-c", script]).args(arguments).output();
        output.with_context(|| format!("cannot run {}", self.path.display()))
    }
}

impl Package<'_> {
    /// Loads it: libraries of the system that it needs may be missing.
    pub fn load(&self) -> Result<()> {
        let output = self.python.ask(&format!("{LOAD}load(sys.argv[1])"), &[self.name])?;
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim_end().lines().last().unwrap_or("it says nothing");
        ensure!(output.status.success(), "cannot be loaded: {last}");
        Ok(())
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
