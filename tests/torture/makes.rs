//! Two whole makes of a body in one folder.

use std::process::Command;
use std::time::Duration;

use tests::workdir::{Workdir, program, python, repository};

use crate::child::{self, Running};

/// A make that takes longer hangs: it takes 15 s undisturbed.
const LONGEST: Duration = Duration::from_secs(900);

/// Each ends well or says that the other one is at work, and one more make ends with results that belong together; the
/// second begins so long after the first.
pub fn both(later: Duration) -> Result<(), String> {
    let dir = Workdir::new();
    child::run(dir.command_of("cad2fem", "-q new mine --like blank"))?.expect(&[0])?;
    let make = || {
        let fab = program("fab");
        let mut command = Command::new("make");
        // the programs are those of this test; a make that runs it must not hand its own flags down
        command.env_remove("MAKEFLAGS").env_remove("MAKELEVEL");
        command.args(["-o", "setup", "body"]);
        command.arg(format!("BIN={}", fab.parent().unwrap().display()));
        command.arg(format!("DIR={}", dir.path("mine").display()));
        command.env("PUFFER_CACHE", dir.path("cache")).current_dir(repository());
        command
    };
    let mut first = Running::start(make()).within(LONGEST);
    first.runs_for(later);
    let second = Running::start(make()).within(LONGEST);
    let ends = [first.end()?, second.end()?];
    for end in &ends {
        end.expect(&[0, 2])?;
        if end.code != Some(0) && !end.said.contains("writes to this folder") {
            return Err(format!("does not say that the other make is at work: {}", end.said));
        }
    }
    if ends.iter().all(|end| end.code != Some(0)) {
        return Err(format!("both are refused: {} and {}", ends[0].said, ends[1].said));
    }
    Running::start(make()).within(LONGEST).end()?.expect(&[0])?;
    let page =
        || std::fs::metadata(dir.path("mine/build/report.html")).unwrap().modified().unwrap();
    let made = page();
    Running::start(make()).within(LONGEST).end()?.expect(&[0])?;
    if page() != made {
        return Err("what is done is made again".into());
    }
    child::run(dir.command_of("fab", "verify mine/build/mold"))?.expect(&[0])?;
    let report = dir.text("mine/build/baseline/report.json");
    let mesh = std::fs::read(dir.path("mine/build/tagged.msh")).unwrap();
    if !report.contains(&::program::sha256(&mesh)) {
        return Err("the report is of another mesh than the one that is there".into());
    }
    Ok(())
}

/// Whether the meshers are there; if not, the test is counted as skipped.
pub fn possible() -> bool {
    python("wildmeshing, gmsh").is_some()
}
