//! The Python package on a small body: `tests/python/package.py`, with the module as it was compiled. And
//! `solver/python.md`: every piece of Python in it runs, and says what the reports say.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tests::chamber;
use tests::reported::check_simulation;
use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

use crate::sweep::{python, said};

/// A folder with the package, and in it the module as it is now.
fn package() -> Workdir {
    let dir = Workdir::new();
    // with the features of the whole workspace, in which everything else is compiled
    let cargo = ["build", "--release", "--locked", "--workspace", "--lib"];
    let built = Command::new(env!("CARGO")).args(cargo).current_dir(repository()).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let to = dir.put_python();
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

/// Values of a report that differ from run to run, or by where it lies: the package writes the mesh anew, in which bodies
/// are where they belong.
const OF_A_RUN: [&str; 8] = [
    "timings",
    "peak_rss_mb",
    "memory_estimate_mb",
    "inputs",
    "wall_s",
    "equilibrium_s",
    "mesh",
    "translate",
];

/// What the reports of program and package differ in, by JSON pointers.
fn differences(at: &str, made: Option<&Value>, saved: Option<&Value>, found: &mut Vec<String>) {
    match (made, saved) {
        (Some(Value::Object(made)), Some(Value::Object(saved))) => {
            let keys: BTreeSet<&String> = made.keys().chain(saved.keys()).collect();
            for key in keys.into_iter().filter(|key| !OF_A_RUN.contains(&&key[..])) {
                differences(&format!("{at}/{key}"), made.get(key), saved.get(key), found);
            }
        }
        (Some(Value::Array(made)), Some(Value::Array(saved))) if made.len() == saved.len() => {
            for (i, (made, saved)) in made.iter().zip(saved).enumerate() {
                differences(&format!("{at}/{i}"), Some(made), Some(saved), found);
            }
        }
        _ if made == saved => {}
        _ => found.push(format!("{at}: {made:?} of the program, {saved:?} of the package")),
    }
}

/// Scenes of `pipelines` whose meshes are made, of degree 1 and with two time steps.
#[test]
#[ignore = "it simulates all bodies twice, in minutes: make test-all"]
fn program_and_package_report_the_same_of_every_body() {
    let Some(python) = python_with("autograd") else { return };
    let dir = package();
    let mut compared = 0;
    for scene in scenes(&repository().join("pipelines")) {
        let mut changes = vec!["degree=1"];
        if std::fs::read_to_string(&scene).unwrap().contains("\n[time]") {
            changes.extend(["time.end=0.02", "time.steps=2"]);
        }
        let set = changes.iter().flat_map(|change| ["--set", change]);
        let mut simulate = Command::new(program("solver"));
        simulate.args(["-q", "simulate"]).arg(&scene).args(["--output", "made"]).args(set);
        let done = simulate.current_dir(dir.path("")).output().unwrap();
        // 2: refused, as its meshes are not made, or a time step is not one that it can make
        if done.status.code().is_none_or(|code| code >= 2) {
            let why = String::from_utf8_lossy(&done.stderr).into_owned();
            skip(&format!("{}: {}", scene.display(), why.lines().next().unwrap_or_default()));
            continue;
        }
        let mut package = Command::new(&python);
        package.arg("-B").arg(repository().join("tests/python/reports.py")).arg(&scene);
        package.arg("saved").args(&changes).env("PYTHONPATH", dir.path(""));
        let saved = package.current_dir(dir.path("")).output().unwrap();
        let made = dir.json("made/report.json");
        if made["status"] != "no-equilibrium" {
            assert!(saved.status.success(), "{}", String::from_utf8_lossy(&saved.stderr));
            let (mut found, saved) = (Vec::new(), dir.json("saved/report.json"));
            differences("", Some(&made), Some(&saved), &mut found);
            assert!(found.is_empty(), "{}:\n{}", scene.display(), found.join("\n"));
            compared += 1;
        }
        for folder in ["made", "saved"] {
            let _ = std::fs::remove_dir_all(dir.path(folder));
        }
    }
    assert!(compared > 0, "no body is made: make beam");
}

/// Files of scenes in a folder and those in it.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let is_scene = |path: &Path| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.starts_with("sim.") && name.ends_with(".toml")
    };
    let of = |path: PathBuf| match path.is_dir() {
        true => scenes(&path),
        false => Vec::from_iter(Some(path).filter(|path| is_scene(path))),
    };
    entries.into_iter().flat_map(of).collect()
}

#[test]
fn every_piece_of_python_runs() {
    let Some(python) = python() else { return };
    let page = fs::read_to_string(repository().join("solver/python.md")).unwrap();
    let pieces: Vec<&str> =
        page.split("```python\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(pieces.len(), 5);
    for piece in &pieces {
        assert!(piece.lines().count() <= 5, "more than five lines:\n{piece}");
    }
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o inflated").assert_good();
    dir.solver("optimize design.toml --set shape.level.0.iterations=1 --set shape.level.1.iterations=1 -o optimize").assert_good();
    // a sweep is too long for this test; it writes its table with pandas as well
    fs::create_dir(dir.path("sweep")).unwrap();
    let table = "import pandas; t = pandas.DataFrame({'status': ['ok', 'failed'], 'volume': [1.0, None]}); \
                 t.to_parquet('sweep/table.parquet')";
    let run = |code: &str| {
        let output = Command::new(&python).args(["-c", code]).current_dir(dir.path("")).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{code}\n{}", said(&output));
        said(&output)
    };
    run(table);
    let printed: Vec<String> = pieces.iter().map(|piece| run(piece)).collect();

    let report = dir.json("inflated/report.json");
    let number = |text: &str| text.trim().parse::<f64>().unwrap_or_else(|_| panic!("{text}"));
    let (volume, largest) = printed[0].trim().split_once(' ').unwrap();
    assert_eq!(Some(number(volume)), report["chambers"]["cavity"]["volume"].as_f64());
    let tags = report["tags"].as_object().unwrap();
    let on_tags =
        tags.values().filter_map(|tag| tag["max_displacement"].as_f64()).fold(0.0, f64::max);
    assert!(number(largest) >= on_tags && number(largest) < 1.5 * on_tags, "{largest} {on_tags}");
    let steps = report["steps"].as_array().unwrap().len();
    assert_eq!(printed[1].lines().count(), 1 + steps, "{}", printed[1]);
    let last = dir.lines("optimize/history.jsonl").pop().unwrap();
    let objective = number(printed[2].split_whitespace().last().unwrap());
    let expected = last["objective"].as_f64().unwrap();
    assert!((objective / expected - 1.0).abs() < 1e-5, "{objective} {expected}");
    assert!(printed[3].contains("displacement"), "{}", printed[3]);
    assert!(printed[4].contains("count") && printed[4].contains("1.0"), "{}", printed[4]);
}
