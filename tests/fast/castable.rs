//! `[mold]` in a design: what `fab plan` says of every accepted shape. Constraints of kind `draft`. And the casting sheet of a
//! body that is wound, with `mold.json`, which is what its schema says.

use serde_json::Value;
use tests::chamber::{self, DESIGN, SIM, workdir};
use tests::reported::check_mold;
use tests::workdir::Workdir;

/// The walls lean away from the pull of the core by a degree; they are straight as modelled.
const DRAFT: &str = "
[[constraint]]
kind = \"draft\"
name = \"pull\"
on = \"cavity\"
pull = [-1, 0, 0]
least = 1
";

/// The chamber's core is pulled out at its mouth; its mouth is as wide as it is.
fn folder(mold: &str, more: &str) -> Workdir {
    let dir = workdir();
    dir.write("p1.toml", &SIM.replace("degree = 2", "degree = 1"));
    dir.write("mold.toml", mold);
    let asked = "[mold]\nconfig = \"mold.toml\"\n\n[optimizer]";
    let design = DESIGN.replace("sim.toml", "p1.toml").replace("[optimizer]", asked);
    dir.write("design.toml", &format!("{design}{more}"));
    dir
}

fn verdicts(dir: &Workdir) -> Vec<Value> {
    dir.lines("out/history.jsonl").iter().map(|line| line["mold"].clone()).collect()
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn the_history_tells_how_each_shape_can_be_cast() {
    let dir = folder("", "");
    let run = dir.solver("optimize design.toml -o out");
    run.assert_good();
    let found = verdicts(&dir);
    assert_eq!(found.len(), 8);
    for verdict in &found {
        assert_eq!(verdict["method"], "pull-out", "{verdict}");
        let girth = verdict["measures"]["girth of the core over girth of its inlet"].as_f64();
        assert!(girth.is_some_and(|g| (0.9..1.6).contains(&g)), "{verdict}");
    }
    assert_ne!(found[0], found[7], "the shape has changed");
    let report = dir.json("out/report.json");
    assert_eq!((&report["mold_before"], &report["mold_after"]), (&found[0], &found[7]));
    // said once, as it does not change
    assert_eq!(run.stderr.matches("fab plan: pull-out").count(), 1, "{}", run.stderr);
    // the program itself says the same of the last shape
    let command = "plan out/design.msh --config mold.toml -o plan --no-pictures";
    dir.run("fab", command).assert_good();
    assert_eq!(dir.json("plan/plan.json")["reason"], found[7]["reason"]);
}

/// The core is pulled out at the start; the objective wants it thicker than its mouth lets through. As the file names a
/// method, such shapes are no steps; else they are said to be refused, and the last that can be cast is kept.
#[test]
fn shapes_that_cannot_be_cast_as_asked_are_no_steps() {
    let dir = folder("method = \"pull-out\"\n\n[limits]\ngirth = 1.01\n", "");
    let is_refused =
        |verdict: &Value| verdict["refused"].as_str().is_some_and(|why| why.contains("girth"));
    let run = dir.solver("optimize design.toml -o out");
    assert!(!verdicts(&dir).iter().any(is_refused), "{:?}", verdicts(&dir));
    assert!(run.stderr.contains("it cannot be cast"), "{}", run.stderr);
    assert!(!dir.path("out/castable.msh").exists());
    let design = dir.text("design.toml").replace("[mold]", "[mold]\nrequired = false");
    dir.write("design.toml", &design);
    let run = dir.solver("optimize design.toml -o out --restart");
    run.assert_good();
    let found = verdicts(&dir);
    assert!(!is_refused(&found[0]) && is_refused(&found[7]), "{found:?}");
    for said in ["this shape cannot be cast", "the last shape that can is out/castable.msh"] {
        assert!(run.stderr.contains(said), "{said}: {}", run.stderr);
    }
    let plan = "plan out/castable.msh --config mold.toml -o plan --no-pictures";
    dir.run("fab", plan).assert_good();
}

#[test]
fn a_wrong_file_of_the_mold_is_refused() {
    let dir = folder("wal = 3\n", "");
    dir.solver("optimize design.toml -o out").assert_refused(2, &["mold.toml", "wal"]);
    dir.write("mold.toml", "method = \"pull-out\"\n\n[limits]\ngirth = 0.5\n");
    dir.solver("optimize design.toml -o out").assert_refused(2, &["mold.toml", "must stretch to"]);
    assert!(!dir.path("out").exists());
    std::fs::remove_file(dir.path("mold.toml")).unwrap();
    dir.solver("optimize design.toml -o new").assert_refused(2, &["[mold] config", "no such file"]);
    let text = dir
        .text("design.toml")
        .replace("config = \"mold.toml\"", "config = \"p1.toml\"\nbody = \"hand\"");
    dir.write("design.toml", &text);
    dir.solver("optimize design.toml -o new").assert_refused(2, &["[mold] body", "\"hand\""]);
}

/// The straight walls of the chamber are moved to where they lean away from the pull, or it is said why not.
#[test]
fn draft_is_kept_by_a_design() {
    let dir = folder("", DRAFT);
    dir.solver("optimize design.toml -o out")
        .assert_refused(2, &["[[constraint]] \"pull\"", "at least 1.00° is to be kept"]);
    dir.write("design.toml", &dir.text("design.toml").replace("least = 1", "least = 0"));
    let kept =
        dir.report("optimize design.toml -o out")["constraints"]["pull"]["found"].as_f64().unwrap();
    assert!(kept > -1e-3, "{kept}");
}

/// Along the line on its top that the scene lays a thread on.
#[test]
fn the_casting_sheet_says_how_to_wind() {
    let dir = chamber::workdir();
    dir.write("bare.toml", SIM);
    let line = "[[winding]]\nname = \"seam\"\non = \"top\"\nstiffness = 50\nstrength = 5\n\
                points = [[0.006, 0.02, 0.04], [0.034, 0.02, 0.04]]\n";
    dir.write("wound.toml", &format!("{SIM}\n{line}"));
    for scene in ["bare", "wound"] {
        dir.solver(&format!("simulate {scene}.toml --final-only -o {scene}")).assert_good();
    }
    let mold = |config: &str| {
        dir.write("mold.toml", config);
        dir.run("fab", "mold body.msh --config mold.toml --no-pictures -o mold")
    };
    for (report, words) in [
        ("bare/report.json", "no threads in it"),
        ("wound.toml", "not a report of `solver simulate`"),
        ("nowhere.json", "nowhere.json"),
    ] {
        mold(&format!("wound = \"{report}\"\n")).assert_refused(2, &[words]);
    }
    let words = "mL already; expected the mesh of a body within";
    mold("around = \"body.msh\"\n").assert_refused(1, &[words]);
    mold("[casting]\nfirst_shot = true\n").assert_good();
    let first = dir.text("mold/cast.html");
    assert!(first.contains("Leave the core inside") && !first.contains("Glue the tube"), "{first}");
    mold("wound = \"wound/report.json\"\n").assert_good();
    let report = dir.json("mold/mold.json");
    check_mold(&report);
    let length = report["threads"][0]["length"].as_f64().unwrap();
    assert!((length / 28.0 - 1.0).abs() < 1e-6, "{length}");
    let sheet = dir.text("mold/cast.html");
    for words in [
        "0.2 m of thread that bears 5.0 N (<code>seam</code>)",
        "Lay the thread <code>seam</code> on <code>top</code>",
        "28 mm, without slack",
    ] {
        assert!(sheet.contains(words), "{words}: {sheet}");
    }
}
