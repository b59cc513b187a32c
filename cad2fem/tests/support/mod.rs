//! A scratch folder in which the program runs.

#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "../../../tests/support/skip.rs"]
mod skip;

/// A folder that disappears with the test; runs use caches of their own.
pub struct Workdir {
    folder: tempfile::TempDir,
    /// The Python that runs use.
    python: Option<String>,
}

/// A finished run.
pub struct Run {
    code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Workdir {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), python: None }
    }

    /// One whose runs use the Python with the meshers; none if that lacks one of the `packages`, and the test is counted
    /// as skipped.
    pub fn with(packages: &[&str]) -> Option<Self> {
        packages.iter().try_fold(Self::new(), |dir, package| dir.with_python(package))
    }

    /// This folder with runs that use the Python of the meshers; none if that lacks the package, and the test is counted as
    /// skipped.
    pub fn with_python(self, package: &str) -> Option<Self> {
        Some(Self { python: Some(python_with(package)?), ..self })
    }

    /// One whose runs use a Python with numpy and pytetwild alone, installed by the hashes of the checkout; none if pip
    /// cannot get it, and the test is counted as skipped.
    pub fn with_pytetwild() -> Option<Self> {
        let dir = Self::with(&["numpy"])?;
        let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("../requirements.txt");
        let mut python = Command::new(dir.python.as_ref()?);
        let made = python.args(["-c", PYTETWILD]).arg(list).current_dir(dir.folder.path()).output();
        let made = made.unwrap();
        if !made.status.success() {
            let said = String::from_utf8_lossy(&made.stderr);
            skip::skip(&format!("pip cannot install pytetwild: {}", said.trim_end()));
            return None;
        }
        let python = dir.path("env/bin/python").display().to_string();
        Some(Self { python: Some(python), ..dir })
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// A file of JSON.
    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }

    /// A shell script to run in place of a real program.
    pub fn program(&self, name: &str, script: &str) -> String {
        let path = self.path(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        path.display().to_string()
    }

    /// Runs the program with arguments separated by blanks.
    pub fn run(&self, arguments: &str) -> Run {
        self.run_words(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs the program with arguments in which blanks may stand.
    pub fn run_words(&self, arguments: &[&str]) -> Run {
        self.finish(Command::new(env!("CARGO_BIN_EXE_cad2fem")).args(arguments))
    }

    /// Runs a script of Python in the folder.
    pub fn script(&self, script: &str) {
        let mut python = Command::new(self.python.as_ref().unwrap());
        let made = python.args(["-c", script]).current_dir(self.folder.path()).output().unwrap();
        assert!(made.status.success(), "{made:?}");
    }

    pub fn run_with(&self, variable: &str, value: &str, arguments: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cad2fem"));
        self.finish(command.args(arguments.split_whitespace()).env(variable, value))
    }

    /// Runs a shell script in which `$0` is the program.
    pub fn run_in_shell(&self, script: &str) -> Run {
        let program = env!("CARGO_BIN_EXE_cad2fem");
        self.finish(Command::new("sh").args(["-c", script, program]))
    }

    fn finish(&self, command: &mut Command) -> Run {
        let command = command.current_dir(self.folder.path());
        command.envs(self.python.iter().map(|python| ("PUFFER_PYTHON", python)));
        let output = command.env("PUFFER_CACHE", self.path("cache")).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

impl Run {
    #[track_caller]
    pub fn succeeds(&self) {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
    }

    #[track_caller]
    pub fn says(&self, part: &str) {
        self.succeeds();
        assert!(self.stderr.contains(part), "{part:?} is not in:\n{}", self.stderr);
    }

    #[track_caller]
    pub fn fails(&self, code: i32, part: &str) {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        assert!(self.stderr.contains(part), "{part:?} is not in:\n{}", self.stderr);
    }
}

/// Makes an environment with numpy, that of the Python which runs this, and pytetwild. Its line in a list of packages has a
/// marker, of the systems that need it.
const PYTETWILD: &str = r#"
import os, pathlib, subprocess, sys, sysconfig, venv
venv.create("env", symlinks=True)
[packages] = pathlib.Path("env").glob("lib/python3*/site-packages")
for path in pathlib.Path(sysconfig.get_path("platlib")).glob("numpy*"):
    os.symlink(path, packages / path.name)
lines = open(sys.argv[1]).read().replace("\\\n", "").splitlines()
[words] = [line.split() for line in lines if line.startswith("pytetwild==")]
open("list.txt", "w").write(" ".join([words[0]] + [word for word in words if word.startswith("--hash")]))
options = ["--quiet", "--no-deps", "--require-hashes", "--only-binary", ":all:", "--target", packages]
sys.exit(subprocess.run([sys.executable, "-m", "pip", "install", *options, "-r", "list.txt"]).returncode)
"#;

/// The Python with the meshers; none if it lacks `package`, which is said. `ftetwild` is either of its packages.
fn python_with(package: &str) -> Option<String> {
    let named = std::env::var("PUFFER_PYTHON").ok();
    let venv = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    let python = named.unwrap_or_else(|| venv.display().to_string());
    let either = "from importlib.util import find_spec as f; assert f('wildmeshing') or f('pytetwild'), 'none is there'";
    let import = format!("import {package}");
    let script = if package == "ftetwild" { either } else { &import };
    let output = Command::new(&python).args(["-c", script]).output();
    let reason = match output {
        Err(error) => format!("{python} does not run ({error}); run `make setup`"),
        Ok(output) if output.status.success() => return Some(python),
        Ok(output) => String::from_utf8_lossy(&output.stderr).lines().last()?.to_owned(),
    };
    skip::skip(&format!("Python's {package} is not usable: {reason}"));
    None
}

/// A file of a pipeline.
pub fn scene(name: &str, file: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.join("pipelines").join(name).join(file).display().to_string()
}
