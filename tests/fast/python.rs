//! The Python package on a small body: `tests/python/package.py`, with the module as it was compiled.

use std::path::PathBuf;
use std::process::Command;

use tests::reported::check_simulation;
use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

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

/// The Python of the checkout; none where a package is missing in it.
fn python_with(needs: &str) -> Option<PathBuf> {
    let python = repository().join(".venv/bin/python");
    let import = Command::new(&python).args(["-c", &format!("import {needs}")]).output();
    if !import.is_ok_and(|done| done.status.success()) {
        skip(&format!("the Python package {needs} is not installed"));
        return None;
    }
    Some(python)
}

/// The folder in which some classes of tests in a file passed; none where a package of Python is missing.
fn passed(file: &str, classes: &[&str], needs: &str) -> Option<Workdir> {
    let python = python_with(needs)?;
    let dir = package();
    let tests = repository().join("tests/python").join(file);
    let mut command = Command::new(python);
    command.arg("-B").arg(tests).args(classes).current_dir(dir.path(""));
    command.env("PYTHONPATH", dir.path("")).env("PUFFER_SAVED", dir.path("saved"));
    command.env("PUFFER_BIN", program("fab").parent().unwrap());
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    Some(dir)
}

/// What it saves is what the program makes of the same scene.
#[test]
fn the_python_package_works_on_a_small_body() {
    let classes = ["Bodies", "Scenes", "Runs", "Starts", "Scenarios", "Programs", "Keys", "Book"];
    let Some(dir) = passed("package.py", &classes, "autograd") else { return };
    for name in ["still", "moving", "path"] {
        dir.solver(&format!("simulate saved/{name}/sim.toml -o {name}")).assert_good();
        let [saved, made] = [format!("saved/{name}"), name.to_owned()]
            .map(|of| dir.json(&format!("{of}/report.json")));
        check_simulation(&saved);
        for key in [
            "steps",
            "probes",
            "chambers",
            "energy_balance",
            "tags",
            "error_bars",
            "status",
            "usable",
            "stability",
            "stretch_range",
            "limit",
            "config",
        ] {
            assert_eq!(saved[key], made[key], "{name}: {key}");
        }
        assert_eq!(saved["locking"]["change"], made["locking"]["change"], "{name}");
        for key in ["factor_entries", "dofs", "newton_iterations"] {
            assert!(saved[key].as_u64().unwrap() > 0 && saved[key] == made[key], "{name}: {key}");
        }
    }
}

#[test]
fn runs_are_judged_kept_and_ended() {
    let _ = passed("runs.py", &[], "autograd");
}

#[test]
fn pytorch_differentiates_a_simulation() {
    let _ = passed("frameworks.py", &["Torch"], "torch");
}

#[test]
fn jax_differentiates_a_simulation() {
    let _ = passed("frameworks.py", &["Jax"], "jax");
}

#[test]
fn scipy_designs_with_gradients() {
    let _ = passed("package.py", &["SciPy"], "scipy");
}

#[test]
fn bodies_come_from_meshio() {
    let _ = passed("package.py", &["Meshio"], "meshio");
}

#[test]
fn pyvista_shows_bodies_and_runs() {
    let _ = passed("package.py", &["PyVista"], "pyvista");
}

#[test]
fn type_checkers_pass_the_book_and_find_what_is_wrong() {
    let Some(python) = python_with("mypy") else { return };
    let dir = package();
    let mut command = Command::new(python);
    command.arg("-B").arg(repository().join("tests/python/typed.py")).current_dir(dir.path(""));
    let done = command.output().unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    said.lines().filter_map(|line| line.strip_prefix("SKIPPED ")).for_each(skip);
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
}

/// Those notebooks that need NumPy and autograd alone; `slow/notebooks.rs` runs all of them.
#[test]
fn small_notebooks_of_the_book_run() {
    let Some(python) = python_with("autograd") else { return };
    let dir = package();
    let mut command = Command::new(python);
    command.arg("-B").arg(repository().join("tests/python/notebooks.py"));
    command.args(["measured-angle", "own-loss", "reading-results"]).current_dir(dir.path(""));
    let done = command.env("PYTHONPATH", dir.path("")).output().unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
    assert!(!said.contains("SKIPPED"), "{said}");
}
