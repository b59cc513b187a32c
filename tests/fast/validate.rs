//! `solver validate` on made-up measurements, whose errors are known, and given what it cannot use.

use tests::workdir::Workdir;

const TITLES: &str = "load [N], height [mm], trial a [Pa], trial b [Pa]\n";
const POINTS: &str = "\
1, 10, 90, 110
1, 20, 380, 420
2, 10, 190, 210
";

/// Pressures of h²/mm² Pa in steps of 5 mm: the polynomials between them are exact.
const STEPS: &str = r#"{"height": 0.005, "pressure": 25.0}
{"height": 0.01, "pressure": 100.0}
{"height": 0.015, "pressure": 225.0}
{"height": 0.025, "pressure": 625.0}
"#;

const CONFIG: &str = r#"
[[row]]
name = "cushion"
measured = "table.csv"
where = { "load [N]" = 1 }
x = "height [mm]"
y = ["trial a [Pa]", "trial b [Pa]"]
condition = { measured = "height [mm]", simulated = "height*1e3" }
simulated = "pressure*1.1"
tolerance = [-0.05, 0.15]
plot = "cushion"

[[row.run]]
name = "ours"
steps = "steps.jsonl"
"#;

pub fn workdir() -> Workdir {
    let dir = Workdir::new();
    dir.write("table.csv", &format!("{TITLES}{POINTS}"));
    dir.write("steps.jsonl", STEPS);
    dir.write("validation.toml", CONFIG);
    dir
}

#[test]
fn known_errors_are_found() {
    let dir = workdir();
    let run = dir.solver("validate validation.toml -o out");
    run.assert_good();
    assert_eq!(dir.files("out"), ["cushion.svg", "errors.json", "errors.md"]);
    assert_eq!(run.stdout.trim_end(), dir.text("out/errors.md").trim_end());
    assert!(
        run.stdout.contains("| cushion | ours | 2 of 2 | +10.0 %, +25.000 Pa |"),
        "{}",
        run.stdout
    );
    let rows = &dir.json("out/errors.json")["rows"];
    assert_eq!(rows[0]["within"], true);
    let measured = &rows[0]["measured"][1];
    assert_eq!([&measured["x"], &measured["y"], &measured["spread"]], [20.0, 400.0, 20.0]);
    for (i, expected) in [110.0, 440.0].into_iter().enumerate() {
        let simulated = rows[0]["simulated"][i].as_f64().unwrap();
        assert!((simulated / expected - 1.0).abs() < 1e-12, "{simulated}");
    }
}

#[test]
fn what_is_outside_of_the_tolerance_or_not_reached_is_missed() {
    let missed = |file: &str, from: &str, to: &str, words: &str| {
        let dir = workdir();
        dir.write(file, &dir.text(file).replace(from, to));
        let run = dir.solver("validate validation.toml -o out");
        run.assert_good();
        assert!(run.stdout.contains(words) && run.stdout.contains("missed"), "{}", run.stdout);
        assert_eq!(dir.json("out/errors.json")["rows"][0]["within"], false);
    };
    missed("validation.toml", "0.15]", "0.05]", "| 2 of 2 |");
    missed("table.csv", "1, 20,", "1, 30,", "| 1 of 2 |");
}

/// Tables whose titles have no unit, lines that have a run each, a maximum of a run, and a band.
#[test]
fn tables_are_taken_as_they_are() {
    let dir = Workdir::new();
    dir.write("walls.csv", "wall_mm,buckles\n1,10\n2,30\n3,50\n");
    let run = |peak: f64| {
        format!("{{\"t\": 1, \"p\": 0}}\n{{\"t\": 2, \"p\": {peak}}}\n{{\"t\": 3, \"p\": 0}}\n")
    };
    for (name, peak) in [("thin", 11.0), ("thick", 33.0), ("stiff", 36.0), ("soft", 27.0)] {
        dir.write(&format!("{name}.jsonl"), &run(peak));
    }
    dir.write(
        "validation.toml",
        r#"
[[row]]
name = "walls"
measured = "walls.csv"
x = "wall_mm [mm]"
y = ["buckles [kPa]"]
passage = "peak"
simulated = "p"
tolerance = [-0.2, 0.2]
reason = "made up"
plot = "walls"

[[row.run]]
name = "ours"
where = { wall_mm = 1 }
steps = "thin.jsonl"

[[row.run]]
name = "ours"
where = { wall_mm = 2 }
steps = "thick.jsonl"

[[row]]
name = "band"
measured = "walls.csv"
where = { wall_mm = 2 }
x = "wall_mm [mm]"
y = ["buckles [kPa]"]
condition = { measured = "wall_mm [mm]", simulated = "t" }
simulated = "p"
tolerance = [-0.1, 0.1]
plot = "band"
band = ["soft", "stiff"]

[[row.run]]
name = "soft"
steps = "soft.jsonl"

[[row.run]]
name = "stiff"
steps = "stiff.jsonl"
"#,
    );
    dir.solver("validate validation.toml -o out").assert_good();
    let rows = dir.json("out/errors.json")["rows"].clone();
    assert_eq!([&rows[0]["unit"], &rows[0]["reason"]], ["kPa", "made up"]);
    assert_eq!(rows[0]["simulated"], serde_json::json!([11.0, 33.0]));
    assert_eq!(
        [&rows[1]["run"], &rows[1]["within"]],
        [&serde_json::json!("soft … stiff"), &serde_json::json!(true)]
    );
    assert_eq!(rows[1]["simulated"], serde_json::json!([30.0]), "inside of the band");
    assert_eq!(rows[1]["ends"][0]["simulated"], serde_json::json!([27.0]));
    let made = dir.command_of("cad2fem", "report out -o page.html").output().expect("it runs");
    assert!(made.status.success(), "{made:?}");
    let page = dir.text("page.html");
    assert!(page.contains("Beside measurements") && page.contains("made up"), "{page}");
}
