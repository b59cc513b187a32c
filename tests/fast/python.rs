//! The Python package on a small body: `tests/python/package.py`, with the module as it was compiled.

use std::path::PathBuf;
use std::process::Command;

use tests::skip::skip;
use tests::workdir::{Workdir, repository};

/// A folder with the package, and in it the module as it is now.
fn package() -> Workdir {
    let dir = Workdir::new();
    // with the features of the whole workspace, in which everything else is compiled
    let cargo = ["build", "--release", "--locked", "--workspace", "--lib"];
    let built = Command::new(env!("CARGO")).args(cargo).current_dir(repository()).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let to = dir.path("softpuffer");
    std::fs::create_dir(&to).unwrap();
    for entry in repository().join("solver/python/softpuffer").read_dir().unwrap().flatten() {
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
    let module = compiled().join("lib_native.so");
    std::os::unix::fs::symlink(module, to.join("_native.abi3.so")).unwrap();
    dir
}

/// Where cargo leaves what it compiled.
fn compiled() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.ancestors().nth(2).unwrap().to_path_buf()
}

#[test]
fn the_python_package_works_on_a_small_body() {
    let python = repository().join(".venv/bin/python");
    if !python.exists() {
        return skip("no .venv: make setup");
    }
    let dir = package();
    let tests = repository().join("tests/python/package.py");
    let mut command = Command::new(python);
    command.args(["-B", "-W", "error"]).arg(tests).env("PYTHONPATH", dir.path(""));
    let done = command.current_dir(dir.path("")).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
