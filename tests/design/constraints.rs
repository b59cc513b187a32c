//! What a design keeps exactly: walls and drafts, with what they are worth.

use serde_json::Value;
use tests::chamber;
use tests::reported::number;
use tests::workdir::Workdir;

/// A volume of air under load that only thin walls give, in levels of all kinds.
fn design(least: f64, volume: f64) -> String {
    format!(
        r#"
scene = "p1.toml"

[optimizer]
stagnation = 1e-4

[shape]
on = "cavity"

[[shape.level]]
offset = true
iterations = 5

[[shape.level]]
handles = 2
motion = "rigid-and-offset"
iterations = 6

[[objective]]
kind = "volume"
name = "air"
weight = 1e11
on = "cavity"
volume = {volume:e}
measure = "deformed"

[[constraint]]
kind = "wall"
name = "wall"
on = "cavity"
against = ["top", "skin"]
least = {least:e}
"#
    )
}

fn report(dir: &Workdir, design: &str) -> Value {
    dir.write("design.toml", design);
    dir.solver("optimize design.toml -o out --restart").assert_good();
    dir.json("out/report.json")
}

/// The chamber has walls of 10 mm at first. It grows until they have 7, and the wall there is what it lacks: the multiplier
/// is the derivative of the least objective by `least`. One variable, so that the optimum is found whatever the mesh.
/// Thresholds, set before: 1e-3 of the wall, a tenth of the derivative.
#[test]
fn a_wall_is_kept_and_its_worth_is_the_derivative_of_the_optimum() {
    let dir = chamber::workdir();
    let volume = 6e-5;
    let design = |least: f64| {
        let text = design(least, volume);
        let (levels, terms) = (text.rfind("[[shape.level]]"), text.find("[[objective]]"));
        text[..levels.unwrap()].to_owned() + &text[terms.unwrap()..]
    };
    let found = report(&dir, &design(7e-3));
    let wall = &found["constraints"]["wall"];
    let (kept, worth) = (number(&wall["found"]), number(&wall["worth"]));
    assert!((kept / 7e-3 - 1.0).abs() < 1e-3, "{wall}");
    let least = |wall: f64| number(&report(&dir, &design(wall))["objective_after"]);
    let by = 2e-4;
    let slope = (least(7e-3 + by) - least(7e-3 - by)) / (2.0 * by);
    eprintln!("worth {worth:.4e}, by differences {slope:.4e}");
    assert!((worth / slope - 1.0).abs() < 0.1, "{worth} {slope}");
}

/// The chamber is 20 mm wide and shall have little air: it shrinks until its core is as thin as may be. One variable, so that the
/// optimum is found whatever the mesh. Threshold, set before: 1e-3 of that.
#[test]
fn a_core_is_kept() {
    let dir = chamber::workdir();
    let wall = "kind = \"wall\"\nname = \"wall\"\non = \"cavity\"\nagainst = [\"top\", \"skin\"]";
    let core = "kind = \"core\"\nname = \"core\"\non = \"cavity\"";
    for least in [15e-3, 12e-3] {
        let text = design(least, 1e-6).replace(wall, core);
        let (levels, terms) = (text.rfind("[[shape.level]]"), text.find("[[objective]]"));
        let found = report(&dir, &(text[..levels.unwrap()].to_owned() + &text[terms.unwrap()..]));
        let core = &found["constraints"]["core"];
        assert!((number(&core["found"]) / least - 1.0).abs() < 1e-3, "{core}");
        assert!(number(&core["worth"]) > 0.0, "{core}");
    }
}

/// With room enough the target is met, no wall holds it back, and its worth is nothing.
#[test]
fn a_wall_that_is_far_is_worth_nothing() {
    let dir = chamber::workdir();
    let found = report(&dir, &design(2e-3, 2.4e-5));
    assert!(number(&found["objective_after"]) < 1e-4 * number(&found["objective_before"]));
    assert_eq!(number(&found["constraints"]["wall"]["worth"]), 0.0);
    assert_eq!(found["status"], "converged", "{}", found["levels"]);
}

/// A start that violates it is moved to where it is kept, before any run; one that cannot be is refused with numbers.
#[test]
fn a_start_outside_is_moved_and_one_without_a_way_is_refused() {
    let dir = chamber::workdir();
    report(&dir, &design(7e-3, 6e-5));
    std::fs::copy(dir.path("out/design.msh"), dir.path("body.msh")).unwrap();
    let found = report(&dir, &design(8e-3, 6e-5));
    let kept = number(&found["constraints"]["wall"]["found"]);
    assert!((kept / 8e-3 - 1.0).abs() < 1e-3, "{kept}");
    dir.write("design.toml", &design(3e-2, 2e-5));
    let run = dir.solver("optimize design.toml -o out --restart");
    run.assert_refused(
        2,
        &["level 1", "[[constraint]] \"wall\"", "at least 3.0000e-2 m is to be kept"],
    );
    assert!(!dir.path("out/report.json").exists());
}

/// Two that no shape meets are named together.
#[test]
fn contradictions_are_named_together() {
    let dir = chamber::workdir();
    let floor = "\n[[constraint]]\nkind = \"draft\"\nname = \"pulled\"\non = \"cavity\"\npull = [0, 0, 1]\nleast = 5\n";
    let wall = design(1.2e-2, 2e-5);
    dir.write("design.toml", &(wall + floor));
    let run = dir.solver("optimize design.toml -o out");
    run.assert_refused(
        2,
        &[
            "no shape was found next to this one",
            "[[constraint]] \"pulled\"",
            "at least 5.00° is to be kept",
        ],
    );
}

/// The pressure p is where its term (p/s)² and the term ((q − q*)/t)² of the probe balance.
#[test]
fn a_parameter_is_kept_small() {
    let dir = chamber::workdir();
    let scene = dir.text("p1.toml").replace("pressure = 8e3", "pressure = \"peak*t\"");
    dir.write("p1.toml", &(scene + "\n[parameters]\npeak = 8e3\n" + chamber::PROBES));
    let design = |small: &str| {
        format!(
            "scene = \"p1.toml\"\n\n[optimizer]\niterations = 8\n\n[[parameter]]\nname = \"peak\"\n\
             bounds = [1e3, 2e4]\n{small}\n[[objective]]\nkind = \"probe\"\nname = \"top\"\nweight = 1\n\
             probe = \"top\"\ntarget = 1e-4\nscale = 1e-5\n"
        )
    };
    let peak = |small: &str| {
        report(&dir, &design(small));
        let line = dir.lines("out/history.jsonl").pop().unwrap();
        (number(&line["parameters"]["peak"]), number(&line["probes"]["top"]), line["terms"].clone())
    };
    let (free, _, _) = peak("");
    let (held, top, terms) = peak("small = 1.0\nscale = 2e3\n");
    assert!(held < 0.99 * free, "{held} {free}");
    assert!((number(&terms["peak"]) / (held / 2e3).powi(2) - 1.0).abs() < 1e-9, "{terms}");
    // at the least of both: dJ/dp = 2 p/s² + 2 (q − q*) q′/t² = 0, with q′ by a difference
    let slope = (1e-4 - top) / (free - held);
    let balance = (held / 2e3f64.powi(2)) / ((1e-4 - top) * slope / 1e-10);
    assert!((balance - 1.0).abs() < 0.05, "{balance}");
}
