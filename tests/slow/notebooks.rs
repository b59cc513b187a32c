//! The notebooks of the book, in a kernel of Jupyter in a clean environment with the wheel and what they need.

use std::process::Command;

use tests::skip::skip;
use tests::workdir::repository;

use crate::run;
use crate::wheel::{Environment, wheel};

/// What the extra `notebook` of the package brings, as it was tried.
const PACKAGES: [&str; 5] = [
    "matplotlib==3.11.2",
    "scipy==1.17.1",
    "optuna==5.0.0",
    "ipykernel==7.4.0",
    "nbclient==0.11.0",
];

/// PUFFER_TORCH=yes installs PyTorch, too, which has gigabytes; the network is skipped without it.
#[test]
#[ignore = "builds the wheel and runs all notebooks, ten minutes: runs in make test-all"]
fn notebooks_run_in_a_kernel() {
    let (_dir, wheel) = wheel("wheel");
    let Some(environment) = Environment::new(&wheel) else {
        return skip("pip cannot install the meshers here");
    };
    let bin = environment.0.path("env/bin");
    let mut packages = PACKAGES.to_vec();
    packages.extend(std::env::var_os("PUFFER_TORCH").map(|_| "torch"));
    let installed =
        Command::new(bin.join("pip")).args(["install", "--quiet"]).args(packages).output();
    if !installed.unwrap().status.success() {
        return skip("pip cannot install what notebooks need here");
    }
    let mut command = Command::new(bin.join("python"));
    command.arg("-B").arg(repository().join("tests/python/notebooks.py")).arg("--nbclient");
    let said = run(command.current_dir(environment.0.path("")));
    for line in said.lines().filter_map(|line| line.strip_prefix("SKIPPED ")) {
        skip(&format!("the notebook {line}"));
    }
    assert!(said.contains("first-actuator: "), "{said}");
}
