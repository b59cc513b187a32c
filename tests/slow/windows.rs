//! The programs for Windows, by mingw, under Wine: a beam from its model to a verified mold and a page, with a mesh that
//! is brought along, beside what the programs of this machine make of the same files.

use std::process::Command;

use tests::skip::skip;
use tests::workdir::{Workdir, repository};

use crate::{make, run};

const TARGET: &str = "x86_64-pc-windows-gnu";

/// From model to page, into the folder `out`; the mesh lies in `volume.msh`.
const CHAIN: [&str; 8] = [
    "cad2fem model sources/model.toml -o OUT/model",
    "tagger tag volume.msh --config sources/tags.toml --patches OUT/model/patches -o OUT/tagged.msh",
    "solver simulate sources/sim.toml --mesh OUT/tagged.msh --curve -o OUT/baseline",
    "fab mold OUT/tagged.msh --model OUT/model/model.stl --config sources/mold.toml -o OUT/mold",
    "fab verify OUT/mold --simulation OUT/baseline -o OUT/mold.checks.txt",
    "cad2fem report OUT --title beam -o OUT/report.html",
    "cad2fem pack OUT --sources sources -o OUT/beam.zip",
    "fab schema mold",
];

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success())
}

/// The programs for Windows in a folder.
fn built() -> Workdir {
    let dir = Workdir::new();
    let cargo = ["build", "--release", "--locked", "--target", TARGET];
    let packages = ["-p", "cad2fem", "-p", "tagger", "-p", "solver", "-p", "fab"];
    run(Command::new(env!("CARGO")).args(cargo).args(packages).current_dir(repository()));
    let target = std::env::var("CARGO_TARGET_DIR").map_or(repository().join("target"), Into::into);
    for name in ["cad2fem", "tagger", "solver", "fab"].map(|name| format!("{name}.exe")) {
        let program = target.join(TARGET).join("release").join(&name);
        run(Command::new("x86_64-w64-mingw32-strip").arg(program).arg("-o").arg(dir.path(&name)));
    }
    dir
}

#[test]
#[ignore = "compiles the programs for Windows, minutes: runs in make test-all"]
fn a_beam_is_made_on_windows_as_on_linux() {
    let needed = ["wine", "x86_64-w64-mingw32-gcc"];
    if let Some(missing) = needed.into_iter().find(|program| !is_there(program)) {
        return skip(&format!("{missing} is not installed: apt install wine gcc-mingw-w64-x86-64"));
    }
    let installed = run(Command::new("rustup").args(["target", "list", "--installed"]));
    if !installed.contains(TARGET) {
        return skip(&format!("rustup target add {TARGET}"));
    }
    make("beam");
    let (programs, dir) = (built(), Workdir::new());
    std::fs::create_dir(dir.path("sources")).unwrap();
    for file in repository().join("pipelines/beam").read_dir().unwrap().flatten() {
        let name = file.file_name().to_string_lossy().into_owned();
        std::fs::copy(file.path(), dir.path(&format!("sources/{name}"))).unwrap();
    }
    std::fs::copy(repository().join("build/beam/volume.msh"), dir.path("volume.msh")).unwrap();
    let wine = |program: &str| {
        let mut command = Command::new("wine");
        command.arg(programs.path(&format!("{program}.exe")));
        command.env("WINEDEBUG", "-all").env("WINEPREFIX", programs.path("wine"));
        command
    };
    let own = |program: &str| Command::new(repository().join("target/release").join(program));
    let [windows, linux] = [(&wine as &dyn Fn(&str) -> Command, "windows"), (&own, "linux")]
        .map(|(program, out)| made(&dir, program, out));
    assert_eq!(windows, linux);
    for file in
        ["model/model.stl", "tagged.msh", "mold/left.stl", "mold/cast.json", "mold.checks.txt"]
    {
        let read = |out: &str| std::fs::read(dir.path(&format!("{out}/{file}"))).unwrap();
        let [a, b] = ["windows", "linux"].map(read);
        assert!(a == b, "{file} differs");
    }
    let stretch = |out: &str| {
        let report = dir.json(&format!("{out}/baseline/report.json"));
        report["stretch_range"]["largest"].as_f64().unwrap()
    };
    assert!((stretch("windows") / stretch("linux") - 1.0).abs() < 1e-12);
    assert!(!dir.text("windows/report.html").contains("%5C"), "a link with a backslash");
}

/// What the last verb says, which writes no file.
fn made(dir: &Workdir, program: &dyn Fn(&str) -> Command, out: &str) -> String {
    let said = CHAIN.map(|line| {
        let line = line.replace("OUT", out);
        let (name, words) = line.split_once(' ').unwrap();
        run(program(name).args(words.split(' ')).current_dir(dir.path("")))
    });
    said[7].replace('\r', "")
}
