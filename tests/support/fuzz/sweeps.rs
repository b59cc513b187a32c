//! Sweeps made by structure-aware mutations, in one process of Python: `sweeps.py` beside this file.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;

use crate::skip::skip;
use crate::workdir::{Workdir, repository};

/// Reads so many sweeps, each of which is a short error or a sweep; what went wrong with the first that is neither.
pub fn campaign(cases: usize, seed: usize) -> Option<String> {
    let python = repository().join(".venv-sweep/bin/python");
    if !python.is_file() {
        skip("the Python packages of sweeps are missing: run `make .venv-sweep/installed`");
        return None;
    }
    let dir = Workdir::new();
    for file in ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml"] {
        let beam = repository().join("pipelines/beam").join(file);
        fs::copy(beam, dir.path(file)).expect("a body of ours");
    }
    dir.write("loop.toml", "include = \"../x/../loop.toml\"\n");
    dir.write("deep.toml", &format!("a = {}", "[".repeat(5000)));
    let made = Command::new("mkfifo").arg(dir.path("fifo")).status();
    assert!(made.is_ok_and(|status| status.success()), "a pipe");
    // the programs have to be there and are not run
    fs::create_dir(dir.path("bin")).expect("writable");
    for name in ["cad2fem", "tagger", "solver"] {
        dir.write(&format!("bin/{name}"), "#!/bin/false\n");
        let mode = fs::Permissions::from_mode(0o755);
        fs::set_permissions(dir.path("bin").join(name), mode).expect("ours");
    }
    let mut fuzz = Command::new(python);
    fuzz.arg(repository().join("tests/support/fuzz/sweeps.py"));
    fuzz.arg(repository().join("pipelines/sweep")).arg(dir.path(""));
    fuzz.args([cases, seed].map(|n| n.to_string())).env("PUFFER_BIN", dir.path("bin"));
    let output = fuzz.output().expect("Python starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (!output.status.success()).then_some(said)
}
