//! Sheets and fabrics in scenes and design problems.

use mesh::io::{read_tets, write_tets};
use mesh::{facet_key, topology};
use tests::reported::number;

use crate::samples::{FABRIC, SHEET, TIGHT, covered};

const BARS: &str = "\n[uncertainty]\nmembrane = 0.1\n";

#[test]
fn a_sheet_holds_its_side_with_error_bars() {
    let dir = covered(&(SHEET.to_owned() + BARS + TIGHT));
    dir.solver("simulate p1.toml -o paper").assert_good();
    let report = dir.json("paper/report.json");
    let row = &report["membranes"][0];
    // 50 × 40 mm
    assert!((number(&row["area"]) / 2e-3 - 1.0).abs() < 1e-12, "{row}");
    let shares = ["taut", "wrinkled", "slack"].map(|key| number(&row[key]));
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{row}");
    let energy = number(&report["energies"]["membrane"]);
    assert!(energy > 0.0 && (number(&row["energy"]) / energy - 1.0).abs() < 1e-12);
    assert!(report["force_balance"].get("membrane").is_none());
    assert!(number(&report["force_balance"]["out_of_balance"]) < 1e-9);
    // the top rises as its error bar says
    let slope = number(&report["error_bars"]["top"]["bars"][0]["derivative"]);
    let thicker = |factor: f64| {
        let other = format!("thickness = {:e}", 1e-4 * factor);
        dir.write("other.toml", &dir.text("p1.toml").replace("thickness = 1e-4", &other));
        dir.solver("simulate other.toml -o other").assert_good();
        dir.probe("other", "top")
    };
    let step = 1e-3;
    let difference = (thicker(1.0 + step) - thicker(1.0 - step)) / (2.0 * step);
    assert!((difference / slope - 1.0).abs() < 1e-5, "{difference} {slope}");
    // pressure lengthens the body, but for its top: it bends towards the sheet
    dir.solver("simulate sim.toml -o bare --degree 1").assert_good();
    let bare = dir.json("bare/report.json");
    let [with, without] = [&report, &bare].map(|report| {
        [0, 2].map(|axis| number(&report["tags"]["top"]["mean_displacement_vector"][axis]))
    });
    assert!(without[0] > 0.0 && with[0] < without[0], "{with:?} {without:?}");
    assert!(without[1] > 0.0 && with[1] > without[1], "{with:?} {without:?}");
}

/// On a tag inside the body, the plane z = 10 mm, which is kept where the interior is re-meshed.
#[test]
fn a_sheet_inside_a_body_is_optimised_with_it() {
    let dir = covered(&(SHEET.replace("\"top\"", "\"layer\"") + "tension = true\n" + TIGHT));
    let mut file = read_tets(&dir.path("body.msh")).unwrap();
    file.tags.names.push("layer".to_owned());
    let id = file.tags.id("layer").unwrap();
    let at = |v: usize| (file.mesh.vertices[v].z - 0.01).abs() < 1e-9;
    let all = file
        .mesh
        .tets
        .iter()
        .flat_map(|tet| topology::TET_FACETS.map(|corners| facet_key(corners.map(|c| tet[c]))));
    for facet in all.filter(|facet| facet.iter().all(|&v| at(v))) {
        if file.tags.get(facet).is_none() {
            file.tags.set(facet, id);
        }
    }
    write_tets(&dir.path("body.msh"), &file.mesh, &file.tags).unwrap();
    let run = dir.solver("simulate p1.toml -o layer");
    run.assert_good();
    assert!(run.stderr.contains("membrane on layer") && run.stderr.contains("tension only"));
    let row = &dir.json("layer/report.json")["membranes"][0];
    // 50 × 40 mm without the floor of the chamber
    assert!((number(&row["area"]) / 1.2e-3 - 1.0).abs() < 1e-12, "{row}");
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
}

/// A fabric that is pulled along its warp gives way less than along its weft; the number sets the angle.
#[test]
fn the_angle_of_a_fabric_is_set_by_its_path() {
    let along = [0.0, 90.0].map(|angle: f64| {
        let dir = covered(FABRIC);
        let numbers = format!("\n[numbers]\n\"membrane.top.angle\" = {angle}\n");
        dir.write("set.toml", &(dir.text("p1.toml") + &numbers));
        let by_hand = dir.text("p1.toml").replace("angle = 30", &format!("angle = {angle}"));
        dir.write("hand.toml", &by_hand);
        for name in ["set", "hand"] {
            dir.solver(&format!("simulate {name}.toml -o {name}")).assert_good();
        }
        assert_eq!(dir.probe("set", "top").to_bits(), dir.probe("hand", "top").to_bits());
        number(&dir.json("set/report.json")["tags"]["top"]["mean_displacement_vector"][0])
    });
    assert!(along[0] < along[1], "{along:?}");
}

#[test]
fn scenarios_change_the_sheet() {
    let dir = covered(SHEET);
    let design = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
    let scenarios =
        "\n[[scenario]]\nname = \"as it is\"\n\n[[scenario]]\nname = \"thin\"\nmembrane = 0.5\n";
    dir.write("design.toml", &(design + scenarios));
    dir.solver("optimize design.toml -o design").assert_good();
    let history = dir.text("design/history.jsonl");
    let first: serde_json::Value = serde_json::from_str(history.lines().next().unwrap()).unwrap();
    let of = |name: &str| number(&first["scenarios"][name]["objective"]);
    assert!((of("thin") / of("as it is") - 1.0).abs() > 1e-4);
}
