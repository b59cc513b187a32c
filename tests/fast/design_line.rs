//! `solver design`: a design problem from one line, and what `solver optimize` says of it.

use tests::chamber::{PROBES, SIM, workdir};
use tests::workdir::Workdir;

fn folder() -> Workdir {
    let dir = workdir();
    dir.write("p1.toml", &format!("{}{PROBES}", SIM.replace("degree = 2", "degree = 1")));
    dir
}

#[test]
fn a_line_becomes_a_design_that_reaches_its_value() {
    let dir = folder();
    // At 8 kPa the top rises by less than a millimetre, at 12 kPa by about a half more.
    dir.solver("simulate p1.toml --set chamber.cavity.pressure=12e3 -o start").assert_good();
    let start = dir.probe("start", "top");
    let wanted = 1.2 * start;
    let line =
        format!("design p1.toml --probe top={wanted} --pressure 12e3 --wall 2e-3 -o line.toml");
    dir.solver(&line).assert_says(&["solver optimize line.toml -o optimize"]);
    let text = dir.text("line.toml");
    // The seat holds the rim of the chamber: it is no other side of a wall.
    assert!(text.contains("against = [\"top\", \"skin\"]"), "{text}");
    let text = text.replace("iterations = 4", "iterations = 3");
    let [from, to] =
        ["[[shape.level]]\nhandles = 3", "# The square"].map(|s| text.find(s).unwrap());
    dir.write("line.toml", &format!("{}{}", &text[..from], &text[to..]));

    let run = dir.solver("optimize line.toml -o out");
    run.assert_good();
    let probe = &dir.json("out/report.json")["probes"]["top"];
    let [before, after] = ["before", "after"].map(|when| probe[when].as_f64().unwrap());
    assert!((before / start - 1.0).abs() < 1e-6, "{probe} {start}");
    assert!((after - wanted).abs() < 0.1 * (before - wanted).abs(), "{probe}");
    let told = |x: f64| format!("{:.3} mm", x * 1e3).chars().take(4).collect::<String>();
    assert!(run.stderr.contains(&format!("top {}", told(before))), "{}", run.stderr);
    assert!(run.stderr.contains(&format!("(wanted {}", told(wanted))), "{}", run.stderr);
    // In every line of the history, too.
    let first = dir.lines("out/history.jsonl").swap_remove(0);
    assert_eq!(first["probes"]["top"].as_f64(), Some(before));
}

#[test]
fn the_core_is_that_of_the_line_or_of_the_mold() {
    let dir = folder();
    let line = |options: &str, file: &str| {
        dir.solver(&format!("design p1.toml --probe top=1e-3{options} -o {file}")).assert_good();
        dir.text(file)
    };
    assert!(!line("", "none.toml").contains("kind = \"core\""));
    dir.write(
        "mold.toml",
        "method = \"soluble\"\n\n[casting]\nleast_core = 1.2e-3\nleast_wall = 1.4e-3\n",
    );
    let kept = "kind = \"core\"\nname = \"core\"\non = \"cavity\"\nleast = ";
    assert!(line("", "mold.design.toml").contains(&format!("{kept}0.0012 ")));
    let text = line("", "wall.toml");
    assert!(
        text.contains("least = 0.0014 ") && text.contains("[mold]\nconfig = \"mold.toml\"\n"),
        "{text}"
    );
    assert!(line(" --wall 3e-3", "thick.toml").contains("least = 0.003 "));
    assert!(line(" --core 2e-3", "line.toml").contains(&format!("{kept}0.002 ")));
    dir.solver("check line.toml --design-only --handles 1").assert_good();
    dir.write("mold.toml", "casting.least_core = \"thin\"\n");
    dir.solver("design p1.toml --probe top=1e-3 -o bad.toml")
        .assert_refused(2, &["mold.toml", "casting.least_core must be a number above 0"]);
}

#[test]
fn lines_that_cannot_be_are_refused_and_nothing_is_overwritten() {
    let dir = folder();
    let fails = |line: &str, said: &str| {
        let run = dir.solver(line);
        assert!(run.code != Some(0) && run.stderr.contains(said), "{line}: {}", run.stderr);
    };
    fails("design p1.toml --probe bending=60", "there are: top, air");
    fails("design p1.toml --probe top", "expected NAME=VALUE");
    fails("design p1.toml --probe top=1e-3 --move cavty", "the mesh has");
    fails("design p1.toml --probe top=1e-3 --wall 0", "must be positive");
    // Of two files either both are written or none.
    fails("design p1.toml --probe bend=1 --pressure 9e3 -o two.toml", "there are: top, air");
    assert!(!dir.path("two.sim.toml").exists());
    dir.solver("design ./p1.toml --probe top=1e-3 -o one.toml").assert_good();
    let before = dir.text("one.toml");
    fails("design p1.toml --probe top=2e-3 -o one.toml", "is there already");
    assert_eq!(dir.text("one.toml"), before);
}
