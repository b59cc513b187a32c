//! `[[membrane]]` in scenes and design problems: reports, facets inside a body, derivatives by
//! its numbers, and what is refused.

use mesh::io::{read_tets, write_tets};
use mesh::{facet_key, topology};
use tests::chamber;
use tests::workdir::Workdir;

const PAPER: &str = r#"
[[membrane]]
on = "top"
thickness = 1e-4
material = { kind = "sheet", young = 3e6, poisson = 0.3 }
"#;

/// Fabric on the bias, the warp around an axis below the body.
const FABRIC: &str = r#"
[[membrane]]
on = "top"
thickness = 1e-4
material = { kind = "woven", warp = 3e6, weft = 1e6, shear = 2e5, poisson = 0.3 }
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = 30
"#;

const BARS: &str = r#"
[uncertainty]
membrane = 0.1

[solver]
relative_tolerance = 1e-13
absolute_tolerance = 1e-12
"#;

/// The chamber with linear elements, and these tables in its scene.
fn workdir(tables: &str) -> Workdir {
    let dir = chamber::workdir();
    let scene = dir.text("p1.toml") + chamber::PROBES + tables;
    dir.write("p1.toml", &scene);
    dir
}

#[test]
fn a_sheet_holds_its_side_and_is_reported() {
    let dir = workdir(&(PAPER.to_owned() + BARS));
    let run = dir.solver("simulate p1.toml -o paper");
    run.assert_good();
    assert!(run.stderr.contains("membrane on top: 0.100 mm, sheet (young 3.000e6 Pa"));
    let report = dir.json("paper/report.json");
    let row = &report["membranes"][0];
    assert_eq!((row["on"].as_str(), row["kind"].as_str()), (Some("top"), Some("sheet")));
    // 50 × 40 mm
    let number = |key: &str| row[key].as_f64().unwrap();
    assert!((number("area") / 2e-3 - 1.0).abs() < 1e-12);
    let shares = number("taut") + number("wrinkled") + number("slack");
    assert!((shares - 1.0).abs() < 1e-12);
    let energy = report["energies"]["membrane"].as_f64().unwrap();
    assert!(energy > 0.0 && (number("energy") / energy - 1.0).abs() < 1e-12);
    assert!(report["force_balance"].get("membrane").is_none());
    assert!(report["force_balance"]["out_of_balance"].as_f64().unwrap() < 1e-9);

    // the top rises as its error bar says
    let bar = &report["error_bars"]["top"]["bars"][0];
    assert_eq!(bar["of"], "membrane");
    let slope = bar["derivative"].as_f64().unwrap();
    let thicker = |factor: f64| {
        let text = dir.text("p1.toml");
        let other = format!("thickness = {:e}", 1e-4 * factor);
        dir.write("other.toml", &text.replace("thickness = 1e-4", &other));
        dir.solver("simulate other.toml -o other").assert_good();
        dir.probe("other", "top")
    };
    let step = 1e-3;
    let difference = (thicker(1.0 + step) - thicker(1.0 - step)) / (2.0 * step);
    assert!((difference / slope - 1.0).abs() < 1e-5, "{difference} {slope}");
    // pressure lengthens the body, but for its top: it bends towards the sheet
    dir.solver("simulate sim.toml -o bare --degree 1").assert_good();
    let bare = dir.json("bare/report.json");
    let mean = |report: &serde_json::Value, axis: usize| {
        report["tags"]["top"]["mean_displacement_vector"][axis].as_f64().unwrap()
    };
    assert!(mean(&bare, 0) > 0.0 && mean(&report, 0) < mean(&bare, 0));
    assert!(mean(&bare, 2) > 0.0 && mean(&report, 2) > mean(&bare, 2));
}

/// The plane z = 10 mm, a tag inside the body.
fn tag_inside(dir: &Workdir) {
    let mut file = read_tets(&dir.path("body.msh")).unwrap();
    file.tags.names.push("layer".to_owned());
    let id = file.tags.id("layer").unwrap();
    let at = |v: usize| (file.mesh.vertices[v].z - 0.01).abs() < 1e-9;
    for tet in &file.mesh.tets {
        for corners in topology::TET_FACETS {
            let facet = facet_key(corners.map(|c| tet[c]));
            if facet.iter().all(|&v| at(v)) && file.tags.get(facet).is_none() {
                file.tags.set(facet, id);
            }
        }
    }
    write_tets(&dir.path("body.msh"), &file.mesh, &file.tags).unwrap();
}

#[test]
fn a_sheet_inside_a_body_is_optimised_with_it() {
    let inside = PAPER.replace("\"top\"", "\"layer\"") + "tension = true\n";
    let dir = workdir(&(inside + BARS));
    tag_inside(&dir);
    let run = dir.solver("simulate p1.toml -o layer");
    run.assert_good();
    assert!(run.stderr.contains("membrane on layer") && run.stderr.contains("tension only"));
    let row = &dir.json("layer/report.json")["membranes"][0];
    // 50 × 40 mm without the floor of the chamber
    assert!((row["area"].as_f64().unwrap() / 1.2e-3 - 1.0).abs() < 1e-12, "{row}");
    let design = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
    dir.write("design.toml", &design);
    let run = dir.solver("optimize design.toml -o design");
    run.assert_good();
    assert!(run.stderr.contains("re-meshed the interior"), "{}", run.stderr);
    let facets = |name: &str| {
        let file = read_tets(&dir.path(name)).unwrap();
        file.tags.facets_of(file.tags.id("layer").unwrap()).len()
    };
    assert_eq!(facets("design/design.msh"), facets("body.msh"));
    dir.solver("simulate p1.toml --mesh design/design.msh -o last").assert_good();
}

#[test]
fn gradients_by_shape_and_sheet_pass_their_test() {
    let dir = workdir(PAPER);
    let run = dir.solver("check design.toml --handles 1 --random 1");
    run.assert_good();
    assert!(run.stdout.contains("membrane.top"), "{}", run.stdout);
}

/// By the shape of the fabric itself, with which the warp turns, and by all numbers of it with the angle.
#[test]
fn gradients_by_shape_and_fabric_pass_their_test() {
    for tension in ["", "tension = true\n"] {
        // numbers of the fabric change little: states are as accurate as their remainders need
        let tolerance = "\n[solver]\nrelative_tolerance = 1e-12\nabsolute_tolerance = 1e-14\n";
        let dir = workdir(&(FABRIC.to_owned() + tension + tolerance));
        let design = "scene = \"p1.toml\"\n\n[shape]\non = \"top\"\n\n[[shape.level]]\nhandles = 2\n\
                      iterations = 1\n\n[[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = 1e6\n\
                      on = \"cavity\"\nvolume = 2e-5\nmeasure = \"deformed\"\n";
        dir.write("design.toml", design);
        let run = dir.solver("check design.toml --random 1");
        run.assert_good();
        for path in ["shape", "membrane.top"] {
            assert_eq!(run.stdout.matches(&format!("by {path}, ")).count(), 2, "{}", run.stdout);
        }
    }
}

/// A fabric that is pulled along its warp gives way less than along its weft; the number sets the angle.
#[test]
fn the_angle_of_a_fabric_is_set_by_its_path() {
    let rise = |angle: f64| {
        let dir = workdir(FABRIC);
        let numbers = format!("\n[numbers]\n\"membrane.top.angle\" = {angle}\n");
        dir.write("set.toml", &(dir.text("p1.toml") + &numbers));
        let run = dir.solver("simulate set.toml -o out");
        run.assert_good();
        assert!(run.stderr.contains("woven (warp 3.000e6 Pa") && run.stderr.contains("to an axis"));
        let by_hand = dir.text("p1.toml").replace("angle = 30", &format!("angle = {angle}"));
        dir.write("hand.toml", &by_hand);
        dir.solver("simulate hand.toml -o hand").assert_good();
        assert_eq!(dir.probe("out", "top").to_bits(), dir.probe("hand", "top").to_bits());
        let along = &dir.json("out/report.json")["tags"]["top"]["mean_displacement_vector"][0];
        along.as_f64().unwrap()
    };
    let [along, across] = [0.0, 90.0].map(rise);
    assert!(along < across, "{along} {across}");
}

#[test]
fn scenarios_change_the_sheet() {
    let dir = workdir(PAPER);
    let design = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
    let scenarios = "\n[[scenario]]\nname = \"as it is\"\n\n[[scenario]]\nname = \"thin\"\n";
    dir.write("design.toml", &(design.clone() + scenarios + "membrane = 0.5\n"));
    dir.solver("optimize design.toml -o design").assert_good();
    let history = dir.text("design/history.jsonl");
    let first: serde_json::Value = serde_json::from_str(history.lines().next().unwrap()).unwrap();
    let of = |name: &str| first["scenarios"][name]["objective"].as_f64().unwrap();
    assert!((of("thin") / of("as it is") - 1.0).abs() > 1e-4);
    // without a sheet there is nothing to change
    let bare = chamber::workdir();
    bare.write("design.toml", &(design + scenarios + "membrane = 0.5\n"));
    let words = ["scenario \"thin\"", "the scene has no [[membrane]]"];
    bare.solver("optimize design.toml -o design").assert_refused(2, &words);
}

#[test]
fn the_thickness_is_found_from_a_measurement() {
    let dir = workdir(&(PAPER.to_owned() + BARS));
    let truth = dir.text("p1.toml").replace("thickness = 1e-4", "thickness = 1.2e-4");
    dir.write("real.toml", &truth);
    dir.solver("simulate real.toml -o real").assert_good();
    dir.write("top.csv", &format!("height [mm]\n{:e}\n", 1e3 * dir.probe("real", "top")));
    let calibrate = r#"
[[number]]
of = "membrane"
on = "top"

[[experiment]]
name = "camera"
scene = "p1.toml"
probe = "top"
measured = "top.csv"
columns = ["height [mm]"]
uncertainty = 0.01
"#;
    dir.write("calibrate.toml", calibrate);
    dir.solver("calibrate calibrate.toml -o out").assert_good();
    let found = dir.json("out/calibration.json")["numbers"][0]["value"].as_f64().unwrap();
    assert!((found / 1.2 - 1.0).abs() < 1e-6, "{found}");
    let material: toml::Table = dir.text("out/material.toml").parse().unwrap();
    let thickness = material["membrane"][0]["thickness"].as_float().unwrap();
    assert!((thickness / 1.2e-4 - 1.0).abs() < 1e-6, "{thickness}");
}

#[test]
fn what_cannot_be_used_is_refused() {
    for (from, to, words) in [
        ("\"top\"", "\"roof\"", &["unknown tag \"roof\"", "seat, cavity, top"][..]),
        ("1e-4", "0.0", &["[[membrane]] on \"top\": thickness = 0 m", "positive"]),
        ("1e-4", "-1e-4", &["thickness = -0.0001 m"]),
        (
            "\"sheet\"",
            "\"paper\"",
            &["[[membrane]] on \"top\"", "\"paper\"", "sheet, neo-hookean, woven"],
        ),
        ("young = 3e6, ", "", &["no \"young\"", "young [Pa]"]),
        ("poisson = 0.3", "poisson = 1.2", &["[[membrane]] on \"top\"", "bulk = "]),
        (
            "{ kind = \"sheet\", young = 3e6, poisson = 0.3 }",
            "\"ecoflex-00-30\"",
            &["\"ecoflex-00-30\"", "solver list --sheets"],
        ),
        ("thickness", "thicknes", &["unknown field `thicknes`", "`thickness`"]),
        ("poisson = 0.3 }", "poisson = 0.3 }\ntension = 1", &["tension", "boolean"]),
    ] {
        let dir = workdir(&PAPER.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
    for (from, to, words) in [
        ("angle = 30\n", "", &["[[membrane]] on \"top\": around without angle"][..]),
        (
            "around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }\nangle = 30\n",
            "",
            &["has no direction", "direction = [x, y, z]"],
        ),
        (
            "around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }\nangle = 30\n",
            "direction = [0.01, 0, 1]\n",
            &["the warp is across the sheet at (0.0", "1.0 % of its direction", "10 %"],
        ),
        (
            "around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }\nangle = 30\n",
            "direction = [0, 0, 0]\n",
            &["direction = [0.0, 0.0, 0.0]", "a direction with a length"],
        ),
        ("angle = 30", "angle = 30\ndirection = [1, 0, 0]", &["direction beside around"]),
        ("weft = 1e6", "weft = -1e6", &["[[membrane]] on \"top\"", "weft = -1e6 Pa", "above 0"]),
        (
            "poisson = 0.3",
            "poisson = 1.8",
            &["poisson = 1.8", "-1.7321 and 1.7321", "warp = 3e6 Pa", "weft = 1e6 Pa"],
        ),
        ("shear = 2e5", "shear = 0", &["shear = 0 Pa"]),
        (
            "{ kind = \"woven\", warp = 3e6, weft = 1e6, shear = 2e5, poisson = 0.3 }",
            "{ kind = \"sheet\", young = 3e6, poisson = 0.3 }",
            &["a direction beside kind = \"sheet\"", "\"woven\""],
        ),
    ] {
        let dir = workdir(&FABRIC.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
    // a tag without facets, and one that is a plane of symmetry
    let dir = workdir(&PAPER.replace("\"top\"", "\"none\""));
    let mut file = read_tets(&dir.path("body.msh")).unwrap();
    file.tags.names.push("none".to_owned());
    write_tets(&dir.path("body.msh"), &file.mesh, &file.tags).unwrap();
    let words = ["[[membrane]] on \"none\"", "no facet"];
    dir.solver("simulate p1.toml -o out").assert_refused(2, &words);
    let dir = workdir(&(PAPER.to_owned() + "\n[[symmetry]]\non = \"top\"\n"));
    let words = ["[[membrane]] on \"top\"", "a cut of [[symmetry]]"];
    dir.solver("simulate p1.toml -o out").assert_refused(2, &words);
}
