//! `cad2fem doctor`: what this machine lacks.

use std::env::consts::EXE_SUFFIX;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use program::Unusable;

use crate::installation::rules;
use crate::mesher::TetMesher as _;
use crate::mesher::ftetwild::FTetWild;
use crate::mesher::gmsh::Gmsh;
use crate::mesher::python::Python;

/// Prints what the programs need and whether it is there, and how to get what is missing; exit
/// code 1 if anything is
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Something that is needed.
struct Finding {
    what: String,
    /// What was found, or how to get it.
    found: Result<String, String>,
    /// What cannot be done without it.
    for_what: &'static str,
}

/// Packages that the meshers are called with, of which one is needed, and what for.
fn packages() -> [(&'static str, &'static [&'static str], &'static str); 3] {
    [
        ("fTetWild", FTetWild.packages(), "cad2fem tetmesh"),
        ("gmsh", Gmsh.packages(), "CAD files and .geo models"),
        ("numpy", &["numpy"], "both meshers"),
    ]
}

/// What pip cannot install here.
const NO_WHEEL: &str = if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    " (gmsh has no wheel for Linux on ARM: make CAD files STL, OBJ, PLY or 3MF elsewhere)"
} else {
    ""
};

/// What gmsh loads, which a Debian without a desktop lacks.
const LIBRARIES: &str = "apt install libglu1-mesa libgl1 libgomp1 libxcursor1 libxft2 libxinerama1";

/// How to get make.
const MAKE: &str =
    if cfg!(target_os = "linux") { "apt install make" } else { "install GNU Make, in PATH" };

/// Memory below which the frog's design does not fit [MB].
const MEMORY: usize = 2000;

/// Runs the verb.
pub fn run(_: &Args) -> Result<()> {
    let findings = findings();
    let mut out = program::stdout();
    for Finding { what, found, for_what } in &findings {
        match found {
            Ok(found) => writeln!(out, "ok       {what:<14} {found}")?,
            Err(remedy) => writeln!(out, "missing  {what:<14} for {for_what}: {remedy}")?,
        }
    }
    let missing = findings.iter().filter(|finding| finding.found.is_err()).count();
    if missing > 0 {
        return Err(Unusable(format!("{missing} of {} are missing", findings.len())).into());
    }
    Ok(())
}

fn findings() -> Vec<Finding> {
    let mut all = Vec::new();
    let mut add = |what: &str, for_what, found| {
        all.push(Finding { what: what.to_owned(), found, for_what });
    };
    for name in ["tagger", "solver", "fab"] {
        add(name, "the chain from a model to a mold", beside(name));
    }
    let found = rules().map(|file| file.display().to_string());
    let remedy = "pip install softpuffer, or clone Puffer and run `make setup` there";
    add("rules for make", "make -C of a body", found.ok_or_else(|| remedy.into()));
    add("make", "make -C of a body", in_path("make", MAKE));
    match Python::find() {
        Err(error) => add("Python", "meshes", Err(format!("{error:#}"))),
        Ok(python) => {
            add("Python", "meshes", Ok(python.name()));
            for (what, names, for_what) in packages() {
                add(what, for_what, loadable(&python, names));
            }
        }
    }
    add("memory", "designs of the frog's size", memory());
    all
}

/// The program of this name beside this one.
fn beside(name: &str) -> Result<String, String> {
    let name = format!("{name}{EXE_SUFFIX}");
    let path = std::env::current_exe().map(|own| own.with_file_name(name)).unwrap_or_default();
    let found = path.is_file().then(|| path.display().to_string());
    found.ok_or_else(|| format!("{} is not there; run `make setup`", path.display()))
}

/// A program in a folder of PATH.
fn in_path(name: &str, remedy: &str) -> Result<String, String> {
    let name = format!("{name}{EXE_SUFFIX}");
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found: Option<PathBuf> =
        std::env::split_paths(&folders).map(|folder| folder.join(&name)).find(|p| p.is_file());
    found.map(|path| path.display().to_string()).ok_or_else(|| remedy.to_owned())
}

/// The first of some packages that is installed, if it can be loaded.
fn loadable(python: &Python, names: &'static [&'static str]) -> Result<String, String> {
    let missing = if names.contains(&"gmsh") { NO_WHEEL } else { "" };
    let package = python.first_of(names).map_err(|error| format!("{error:#}{missing}"))?;
    package.load().context(package.name).map_err(|error| {
        let why = format!("{error:#}");
        if why.contains(".so") { format!("{why}: {LIBRARIES}") } else { why }
    })?;
    let which = if names.len() > 1 { format!("{} ", package.name) } else { String::new() };
    Ok(which + &package.version)
}

/// Memory that is free [MB].
fn memory() -> Result<String, String> {
    match system::available_memory().map(|bytes| bytes / 1_000_000) {
        Some(free) if free < MEMORY => Err(format!("{free} MB are free, {MEMORY} needed")),
        Some(free) => Ok(format!("{free} MB free")),
        None => Ok("not known on this system".into()),
    }
}
