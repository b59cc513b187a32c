//! The wheel that `make wheel` builds, in a clean environment of Python, without Rust and without the checkout: from
//! `puffer new` to a page and a verified mold. And one that pip builds of the sources that are published beside it.

use std::path::{Path, PathBuf};
use std::process::Command;

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

/// The wheel of this checkout, built now.
pub(crate) fn wheel() -> PathBuf {
    make("wheel");
    let entries = std::fs::read_dir(repository().join("build/wheel")).unwrap().flatten();
    let mut wheels = entries.map(|entry| entry.path());
    wheels.find(|path| path.extension().is_some_and(|e| e == "whl")).unwrap()
}

#[test]
#[ignore = "builds the wheel and makes a beam with it, minutes: runs in make test-all"]
fn a_wheel_makes_a_body_without_the_checkout() {
    let wheel = wheel();
    // made for machines with a glibc of 2014 or newer, and for each CPython from 3.10 on
    let name = wheel.file_name().unwrap().to_string_lossy().into_owned();
    assert!(name.contains("-cp310-abi3-") && name.contains("manylinux_2_17_"), "{name}");
    let Some(environment) = Environment::new(&wheel) else {
        return skip("pip cannot install the meshers here");
    };
    let doctor = environment.says("puffer doctor", &[]);
    assert!(doctor.contains("site-packages/softpuffer/share/puffer/folder.mk"), "{doctor}");
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
