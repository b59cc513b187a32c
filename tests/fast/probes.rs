//! Probes of scenes, by the program: against what reports have besides, and as objectives.

use serde_json::Value;
use tests::chamber::{self, MOUTH, PRESSURE};
use tests::reported::number;
use tests::workdir::Workdir;

/// Beside those of the chamber, one probe of each kind that needs no contact.
const PROBES: &str = r#"
[[probe]]
name = "inside"
kind = "point"
at = [0.045, 0.02, 0.021]
axis = [1, 0, 0]

[[probe]]
name = "marker"
kind = "point"
at = [0.02, 0.02, 0.1]
on = "top"
axis = [0, 0, 2]

[[probe]]
name = "bend"
kind = "angle"
on = "top"
to = "seat"

[[probe]]
name = "apart"
kind = "distance"
on = "top"
to = "seat"

[[probe]]
name = "wall"
kind = "gap"
on = "top"
to = "cavity"

[[probe]]
name = "bow"
kind = "curvature"
on = ["seat", "cavity", "top"]

[[probe]]
name = "held"
kind = "reaction"
on = "seat"
axis = [3, 0, 0]

[[probe]]
name = "turn"
kind = "bending"
on = "top"
to = "seat"
axis = [0, 1, 0]
"#;

#[track_caller]
fn near(found: &Value, expected: f64) {
    let found = number(found);
    assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
}

/// A folder with `scene` and probes in `probes.toml`, and their design.
pub fn with_probes(scene: &str, more: &str) -> Workdir {
    let dir = chamber::workdir();
    let text = dir.text(scene);
    dir.write("probes.toml", &format!("{text}{}{PROBES}{more}", chamber::PROBES));
    dir.write("probes.design.toml", &design("probes.toml"));
    dir
}

#[test]
fn probes_are_columns_and_agree_with_the_report() {
    let dir = with_probes("sim.toml", "[solver]\nlargest_load_step = 0.3\n");
    let report = dir.report("simulate probes.toml -o out");
    let last = |name: &str| &report["probes"][name]["value"];
    near(last("top"), number(&report["tags"]["top"]["mean_displacement_vector"][2]));
    near(last("air"), number(&report["chambers"]["cavity"]["volume"]));
    near(last("held"), number(&report["tags"]["seat"]["reaction"][0]));
    // the gas pushes with the pressure times the area of the mouth, and only the seat holds it
    near(last("held"), -PRESSURE * MOUTH * MOUTH);
    assert_eq!(report["probes"]["bend"]["unit"], "deg");
    assert_eq!(report["probes"]["marker"]["kind"], "point");
    assert_eq!(report["config"]["probe"][8]["on"], "seat");

    let lines = dir.lines("out/steps.jsonl");
    assert!(lines.len() >= 4, "{}", lines.len());
    for name in ["top", "inside", "marker", "bend", "apart", "wall", "bow", "air", "held", "turn"] {
        assert_eq!(&lines[lines.len() - 1]["probes"][name], last(name), "{name}");
        assert_ne!(lines[0]["probes"][name], lines[1]["probes"][name], "{name}");
    }
    let table = dir.text("out/curve.csv");
    let mut rows = table.lines();
    let header = "load [1],cavity pressure [Pa],cavity volume [m³],top [m],air [m³],inside [m],\
                  marker [m],bend [deg],apart [m],wall [m],bow [1/m],held [N],turn [deg]";
    assert_eq!(rows.next(), Some(header));
    assert_eq!(rows.clone().count(), lines.len() + 1);
    let rest = &report["rest"];
    let first: Vec<f64> = rows.next().unwrap().split(',').map(|n| n.parse().unwrap()).collect();
    assert_eq!([first[0], first[1], first[3], number(&rest["load"])], [0.0; 4]);
    near(&rest["chambers"]["cavity"]["volume_rest"], first[2]);
    let load = |row: &str| row.split(',').next().unwrap().len();
    assert!(table.lines().skip(1).all(|row| load(row) <= 14), "twelve digits: {table}");
    let row: Vec<f64> = rows.last().unwrap().split(',').map(|n| n.parse().unwrap()).collect();
    assert_eq!([row[0], row[1]], [1.0, PRESSURE]);
    near(last("turn"), row[12]);
    for run in ["steps.jsonl", "report.json"] {
        let x = "--x chambers.cavity.pressure";
        dir.solver(&format!("plot out/{run} {x} --y probes.top -o curve.svg")).assert_good();
        assert_eq!(dir.text("curve.svg").matches("<circle").count(), lines.len() + 1, "{run}");
        dir.solver(&format!("plot out/{run} {x} --log-x --y probes.top -o log.svg")).assert_good();
        assert_eq!(dir.text("log.svg").matches("<circle").count(), lines.len(), "{run}");
    }
}

/// Objectives of all probes at once, each with a wanted value.
fn design(scene: &str) -> String {
    let mut text = format!(
        "scene = \"{scene}\"\n[shape]\non = \"cavity\"\n[[shape.level]]\nhandles = 2\niterations = 1\n"
    );
    for (name, target, scale) in [
        ("top", "1e-3", "1e-4"),
        ("inside", "1e-3", "1e-4"),
        ("marker", "1e-3", "1e-4"),
        ("bend", "80", "1"),
        ("apart", "0.04", "1e-3"),
        ("wall", "0.02", "1e-3"),
        ("bow", "3", "1"),
        ("air", "2e-5", "1e-6"),
        ("held", "\"-t\"", "1"),
    ] {
        text += &format!(
            "[[objective]]\nkind = \"probe\"\nname = \"{name}\"\nweight = 1.0\nprobe = \"{name}\"\n\
             target = {target}\nscale = {scale}\n"
        );
    }
    text
}

/// Taylor slopes by shape, loads and material: under pressure; with a prescribed volume, the
/// pressure of which is part of the reaction; and with a rim that slides in its support, where
/// the pressure's stiffness is not symmetric.
#[test]
fn derivatives_of_designs_are_exact() {
    let volume = |text: &str| text.replace("pressure = 8e3", "volume_factor = 1.2");
    let sliding = |text: &str| {
        let held = "components = \"x\"\n[[fixed]]\non = \"top\"\n[[chamber]]";
        text.replacen("[[chamber]]", held, 1)
    };
    let plain = |text: &str| text.to_owned();
    let changes: [&dyn Fn(&str) -> String; 3] = [&plain, &volume, &sliding];
    for change in changes {
        let dir = with_probes("p1.toml", "");
        let text = change(&dir.text("probes.toml"));
        dir.write("probes.toml", &text);
        dir.solver("check probes.design.toml").assert_good();
    }
}
