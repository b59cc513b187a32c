//! STEP, IGES and BREP files with random changes, which OpenCASCADE reads in a program of its own.

use std::process::Command;
use std::sync::OnceLock;

use mechanics::math::random::Random;
use tests::fuzz::mutate;
use tests::workdir::{Workdir, python};

use crate::any;
use crate::child;
use crate::job::Sound;
use crate::trial::Tally;

const FORMATS: [&str; 3] = ["step", "iges", "brep"];

/// A block with a bore, written in each format.
const BLOCK: &str = "
import gmsh
gmsh.initialize()
gmsh.option.setNumber('General.Terminal', 0)
occ = gmsh.model.occ
occ.cut([(3, occ.addBox(0, 0, 0, 10, 8, 6))], [(3, occ.addCylinder(5, 4, -1, 0, 0, 5, 2))])
occ.synchronize()
for name in ('step', 'iges', 'brep'):
    gmsh.write('block.' + name)
";

/// The sound files; none where gmsh cannot be loaded.
fn corpus() -> Option<&'static [Vec<u8>]> {
    static FILES: OnceLock<Option<Vec<Vec<u8>>>> = OnceLock::new();
    let make = || {
        let (python, dir) = (python("gmsh")?, Workdir::new());
        let mut command = Command::new(python);
        let run = command.args(["-c", BLOCK]).current_dir(dir.path(".")).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let file = |format| std::fs::read(dir.path(&format!("block.{format}"))).unwrap();
        Some(FORMATS.map(file).to_vec())
    };
    FILES.get_or_init(make).as_deref()
}

/// `cad2fem model` or `import` with one of them ends in time, with a result or an error, whatever becomes of
/// OpenCASCADE, and leaves nothing behind.
pub fn damaged(_: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let Some(files) = corpus() else { return Ok(()) };
    let (kind, verb) = (any(random, FORMATS.len()), ["model", "import"][any(random, 2)]);
    let (format, dir) = (FORMATS[kind], Workdir::new());
    let bytes = mutate(&files[kind..=kind], random);
    std::fs::write(dir.path(&format!("a.{format}")), &bytes).map_err(|e| e.to_string())?;
    std::fs::create_dir(dir.path("tmp")).map_err(|e| e.to_string())?;
    let unit = if format == "brep" { " --unit mm" } else { "" };
    let arguments = format!("-q {verb} a.{format}{unit} --timeout 20 -o out");
    let mut command = dir.command_of("cad2fem", &arguments);
    command.env("TMPDIR", dir.path("tmp"));
    let context = |what: String| format!("cad2fem {arguments}: {what}");
    let end = child::run(command).map_err(context)?;
    end.expect(&[0, 1, 2]).map_err(context)?;
    tally.interruptions += usize::from(end.code != Some(0));
    if end.code != Some(0) && end.said.trim().is_empty() {
        return Err(context("says nothing".into()));
    }
    let left = dir.files("tmp").into_iter().chain(match end.code {
        Some(0) => Vec::new(),
        _ => dir.files("out"),
    });
    match left.collect::<Vec<_>>().first() {
        Some(name) => Err(context(format!("{name} is left behind"))),
        None => Ok(()),
    }
}
