//! The wheels that `make wheel` builds, in a clean environment of Python, without Rust and without the checkout: from
//! `puffer new` to a page and a verified mold. And one that pip builds of the sources that are published beside it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use tests::skip::skip;
use tests::workdir::{Workdir, repository};

use crate::{make, run};

/// An environment of Python with the wheel in it, and a folder to work in.
pub(crate) struct Environment(pub(crate) Workdir);

impl Environment {
    /// Nothing if the packages that the wheel needs cannot be had here.
    pub(crate) fn new(wheel: &Path) -> Option<Self> {
        let dir = Workdir::new();
        run(Command::new("python3").args(["-m", "venv"]).arg(dir.path("env")));
        let environment = Self(dir);
        // pip may need variables of this machine to reach a registry
        let pip = || Command::new(environment.0.path("env/bin/pip"));
        run(pip().args(["install", "--quiet", "--no-deps"]).arg(wheel));
        let packages = pip().args(["install", "--quiet"]).arg(wheel).output().unwrap();
        packages.status.success().then_some(environment)
    }

    /// Words of a command, and paths after them. Neither cargo nor variables of the test are known to it.
    fn command(&self, words: &str, paths: &[&Path]) -> Command {
        let mut words = words.split_whitespace();
        let bin = self.0.path("env/bin");
        let own = bin.join(words.next().unwrap());
        let program = if own.exists() { own } else { "make".into() };
        let mut command = Command::new(program);
        command.args(words).args(paths).current_dir(self.0.path("")).env_clear();
        command.env("PATH", format!("{}:/usr/bin:/bin", bin.display()));
        command.env("HOME", self.0.path("home"));
        command
    }

    /// What a command says that succeeds and names no place in the checkout.
    fn says(&self, words: &str, paths: &[&Path]) -> String {
        let said = run(&mut self.command(words, paths));
        assert!(!said.contains(&repository().display().to_string()), "{said}");
        said
    }
}

/// The wheel of this checkout, built now, in a folder of its own: `build/wheel` holds the latest.
pub(crate) fn wheel(goal: &str) -> (Workdir, PathBuf) {
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    make(goal);
    let mut entries = repository().join("build/wheel").read_dir().unwrap().flatten();
    let name =
        entries.find_map(|e| e.file_name().into_string().ok().filter(|n| n.ends_with(".whl")));
    let (dir, name) = (Workdir::new(), name.unwrap());
    std::fs::copy(repository().join("build/wheel").join(&name), dir.path(&name)).unwrap();
    let path = dir.path(&name);
    (dir, path)
}

/// The oldest glibc that a wheel says it runs with; it is for each CPython from 3.10 on.
fn glibc(wheel: &Path) -> u32 {
    let name = wheel.file_name().unwrap().to_string_lossy().into_owned();
    let (_, tag) = name.split_once("-cp310-abi3-manylinux_2_").expect(&name);
    tag.split('_').next().unwrap().parse().expect(&name)
}

#[test]
#[ignore = "builds the wheel and makes a beam with it, minutes: runs in make test-all"]
fn a_wheel_makes_a_body_without_the_checkout() {
    let (_dir, wheel) = wheel("wheel");
    // for machines like this one, whose programs it has
    assert!(glibc(&wheel) >= 17);
    makes_a_body(&wheel);
}

#[test]
#[ignore = "compiles everything for an older glibc, half an hour: runs in make test-all"]
fn a_wheel_to_be_published_serves_machines_of_2014() {
    let own = format!("wheel TARGET={}-unknown-linux-gnu", std::env::consts::ARCH);
    let (_dir, wheel) = wheel(&own);
    assert_eq!(glibc(&wheel), 17);
    makes_a_body(&wheel);
}

/// From `puffer new` to a page and a verified mold, and to a gallery.
fn makes_a_body(wheel: &Path) {
    let Some(environment) = Environment::new(wheel) else {
        return skip("pip cannot install the meshers here");
    };
    let doctor = environment.says("puffer doctor", &[]);
    assert!(doctor.contains("site-packages/softpuffer/share/puffer/folder.mk"), "{doctor}");
    assert!(environment.says("puffer", &[]).contains("puffer new mine --like beam"));
    environment.says("puffer new mine --like beam", &[]);
    environment.says("make -C mine", &[]);
    let dir = &environment.0;
    assert!(
        dir.path("mine/build/report.html").exists() && dir.path("mine/build/mine.zip").exists()
    );
    let checks = dir.text("mine/build/mold.checks.txt");
    assert!(checks.lines().count() > 10 && !checks.contains("FAIL"), "{checks}");
    assert!(environment.says("puffer make -C mine", &[]).contains("nothing to do"));
    environment.says("puffer gallery mine", &[]);
    assert!(dir.text("gallery/index.html").contains("mine.html"));
    // the program itself finds the Python that it was installed for, and keeps meshes in the user's cache
    let mut libraries = dir.path("env/lib").read_dir().unwrap().flatten().map(|e| e.path());
    let packages = libraries.find_map(|path| path.join("site-packages").canonicalize().ok());
    let mut alone = Command::new(packages.unwrap().join("softpuffer/bin/cad2fem"));
    alone.args(["tetmesh", "mine/build/model/model.stl", "--config", "mine/cad2fem.toml"]);
    let alone = alone.args(["-o", "again.msh"]).current_dir(dir.path("")).env_clear();
    let said = run(alone.env("HOME", dir.path("home")));
    assert!(dir.path("home/.cache/puffer/meshes").exists() && said.contains("cache"), "{said}");
    let version =
        environment.says("python -c", &[Path::new("import softpuffer as s; print(s.__version__)")]);
    assert_eq!(version.trim(), env!("CARGO_PKG_VERSION"));
}

#[test]
#[ignore = "compiles the package from its sources, fifteen minutes: runs in make test-all"]
fn pip_builds_the_sources_without_the_checkout() {
    make(".cargo-tools/wheel/installed");
    let dir = Workdir::new();
    let mut pack = Command::new(repository().join(".cargo-tools/wheel/bin/python"));
    pack.args(["-B", "-c", "import backend, sys; backend.build_sdist(sys.argv[1])"]);
    run(pack.arg(dir.path("")).current_dir(repository().join("solver/python")));
    let sources = format!("softpuffer-{}.tar.gz", env!("CARGO_PKG_VERSION"));
    run(Command::new("python3").args(["-m", "venv"]).arg(dir.path("env")));
    // pip fetches maturin, and cargo is in PATH
    let mut build = Command::new(dir.path("env/bin/pip"));
    build.args(["wheel", "--quiet", "--no-deps", "--wheel-dir", "built", &sources]);
    run(build.current_dir(dir.path("")));
    let mut built = dir.path("built").read_dir().unwrap().flatten().map(|entry| entry.path());
    let Some(environment) = Environment::new(&built.next().unwrap()) else {
        return skip("pip cannot install the meshers here");
    };
    let doctor = environment.says("puffer doctor", &[]);
    assert!(doctor.contains("site-packages/softpuffer/share/puffer/folder.mk"), "{doctor}");
    let listed =
        environment.says("python -c", &[Path::new("import softpuffer as s; print(s.Scene)")]);
    assert!(listed.contains("softpuffer.scene.Scene"), "{listed}");
    environment.says("puffer new mine --like beam", &[]);
    environment.says("puffer cad2fem model mine/model.toml -o model", &[]);
}
