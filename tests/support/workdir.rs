//! A temporary folder in which tests run the programs as a user would.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use mechanics::body::Body;
use mesh::io::write_tets;
use serde_json::Value;
use tempfile::TempDir;

pub use crate::judges::python;
use crate::reported;

/// A folder that vanishes with the test, and the programs to run in it.
pub struct Workdir {
    folder: TempDir,
}

/// What a program said and how it ended.
#[derive(Debug)]
pub struct Run {
    /// Exit code; none when a signal ended the program.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// The top folder of the repository.
pub fn repository() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().expect("the package lies in the repository").to_path_buf()
}

/// A program of the workspace, from the profile that this test was built with.
pub fn program(name: &str) -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(build_programs).join(name)
}

/// Brings the programs up to date and returns their folder, `target/<profile>`.
///
/// Cargo neither builds the programs of other packages for `cargo test -p tests` nor reports
/// where they are. It holds its lock while it compiles, not while it runs tests, so that a
/// test may call it; several test programs at once wait for each other. Where nothing has
/// changed, the call takes a fraction of a second.
fn build_programs() -> PathBuf {
    let test = std::env::current_exe().expect("a test is a file");
    let folder = test.parent().and_then(Path::parent).expect("target/<profile>/deps/<test>");
    let target = folder.parent().expect("target/<profile>");
    let profile = match folder.file_name().and_then(|name| name.to_str()) {
        Some("debug") => "dev",
        Some(name) => name,
        None => panic!("{} is not a folder of cargo's", folder.display()),
    };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build.args(["build", "--quiet", "--locked", "--workspace", "--bins", "--profile", profile]);
    build.arg("--target-dir").arg(target).current_dir(repository());
    let status = build.status().unwrap_or_else(|e| panic!("{build:?}: {e}"));
    assert!(status.success(), "{build:?}: {status}");
    folder.to_path_buf()
}

/// `make`, without the flags of a make that runs these tests, which it would hand down.
pub fn make() -> Command {
    let mut make = Command::new("make");
    for flags in ["MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES"] {
        make.env_remove(flags);
    }
    make
}

impl Workdir {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A folder with a body in `body.msh`.
    pub fn with(body: &Body) -> Self {
        let dir = Self::new();
        dir.put("body.msh", body);
        dir
    }

    /// Writes the mesh of a body.
    pub fn put(&self, name: &str, body: &Body) {
        write_tets(&self.path(name), &body.mesh, &body.tags).expect("a sound body");
    }

    /// Copies the Python package as it is in the sources: neither its compiled module nor the programs are in it.
    pub fn put_python(&self) -> PathBuf {
        let (from, to) = (repository().join("solver/python/softpuffer"), self.path("softpuffer"));
        for folder in ["", "studio", "studio/page"] {
            std::fs::create_dir(to.join(folder)).expect("the folder is writable");
            for file in from.join(folder).read_dir().expect("a folder").flatten() {
                if file.file_type().is_ok_and(|kind| kind.is_file()) {
                    let copy = to.join(folder).join(file.file_name());
                    std::fs::copy(file.path(), copy).expect("the folder is writable");
                }
            }
        }
        to
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("the folder is writable");
    }

    /// Reads a text file.
    pub fn text(&self, name: &str) -> String {
        let path = self.path(name);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// Reads a JSON file.
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Reads a file with a value of JSON in each line.
    pub fn lines(&self, name: &str) -> Vec<Value> {
        let line = |line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{name}: {e}"));
        self.text(name).lines().map(line).collect()
    }

    /// The value of a probe at the end of a run in a subfolder.
    pub fn probe(&self, folder: &str, name: &str) -> f64 {
        reported::number(&self.json(&format!("{folder}/report.json"))["probes"][name]["value"])
    }

    /// Names of the files in a subfolder, sorted; empty if there is no such folder.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let Ok(entries) = std::fs::read_dir(self.path(folder)) else { return Vec::new() };
        let name = |entry: std::fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
        let mut names: Vec<String> = entries.flatten().map(name).collect();
        names.sort();
        names
    }

    /// `solver` with arguments separated by blanks, to be run in the folder.
    pub fn command(&self, arguments: &str) -> Command {
        self.command_of("solver", arguments)
    }

    /// A program of the workspace with arguments separated by blanks, to be run in the folder.
    pub fn command_of(&self, name: &str, arguments: &str) -> Command {
        let mut command = Command::new(program(name));
        command.args(arguments.split_whitespace()).current_dir(self.folder.path());
        command
    }

    /// Runs a program of the workspace with arguments separated by blanks.
    pub fn run(&self, name: &str, arguments: &str) -> Run {
        self.command_of(name, arguments).output().expect("the program starts").into()
    }

    /// Runs `solver` with arguments separated by blanks.
    pub fn solver(&self, arguments: &str) -> Run {
        let run = self.run("solver", arguments);
        // where a run is refused, other files of that name may have been there before
        if matches!(run.code, Some(0 | 1)) {
            self.check_reports(arguments);
        }
        run
    }

    /// Runs `solver` to a good end: the report in the folder that it writes.
    pub fn report(&self, arguments: &str) -> Value {
        self.solver(arguments).assert_good();
        let folder = output(arguments).expect("a folder of results");
        self.json(&format!("{folder}/report.json"))
    }

    /// Asserts that the report of a simulation, or the report and the history of an optimisation, have what their
    /// schemas say.
    fn check_reports(&self, arguments: &str) {
        let mut words = arguments.split_whitespace();
        let verb = words.find(|word| ["simulate", "optimize"].contains(word));
        let (Some(verb), Some(folder)) = (verb, output(arguments)) else { return };
        let read = |name| std::fs::read_to_string(self.path(folder).join(name)).unwrap_or_default();
        let report: Option<Value> = serde_json::from_str(&read("report.json")).ok();
        match (verb, report) {
            ("simulate", Some(report)) => reported::check_simulation(&report),
            ("optimize", report) => {
                report.iter().for_each(reported::check_optimization);
                let lines = read("history.jsonl");
                let lines = lines.lines().filter_map(|line| serde_json::from_str(line).ok());
                lines.for_each(|line: Value| reported::check_iteration(&line));
            }
            _ => {}
        }
    }

    /// Runs `solver` with a limit on the size of files [KiB], which stands for a
    /// full disk: a write beyond it fails in the middle.
    pub fn solver_on_small_disk(&self, limit: usize, arguments: &str) -> Run {
        let mut command = Command::new("bash");
        // without the trap the signal would end the program before it sees the error
        let script = format!("trap '' XFSZ; ulimit -f {limit}; exec \"$0\" \"$@\"");
        command.args(["-c", &script]).arg(program("solver"));
        command.args(arguments.split_whitespace()).current_dir(self.folder.path());
        command.output().expect("bash starts").into()
    }
}

/// What stands after `-o`.
fn output(arguments: &str) -> Option<&str> {
    arguments.split_whitespace().skip_while(|word| *word != "-o").nth(1)
}

impl Default for Workdir {
    fn default() -> Self {
        Self::new()
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self {
            code: output.status.code(),
            stdout: text(&output.stdout),
            stderr: text(&output.stderr),
        }
    }
}

impl Run {
    /// Asserts that the program ended well.
    pub fn assert_good(&self) {
        assert_eq!(self.code, Some(0), "{}\n{}", self.stdout, self.stderr);
    }

    /// Asserts that the program ended well and that its messages have all of `words`.
    pub fn assert_says(&self, words: &[&str]) {
        self.assert_good();
        for word in words {
            assert!(self.stderr.contains(word), "does not say {word:?}:\n{}", self.stderr);
        }
    }

    /// Asserts that the program ended with an exit code and a message that has
    /// all of `words`, without a panic.
    pub fn assert_refused(&self, code: i32, words: &[&str]) {
        assert!(!self.stderr.contains("panicked"), "a panic:\n{}", self.stderr);
        assert_eq!(self.code, Some(code), "{}\n{}", self.stdout, self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "does not say {word:?}:\n{}", self.stderr);
        }
    }
}
