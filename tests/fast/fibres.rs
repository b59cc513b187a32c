//! Fibres, threads and sheets in scenes: what they hold, and where they lie.

use mesh::Vec3;
use mesh::io::npy::write_f64;
use mesh::io::read_tets;
use mesh::io::vtu::read_vtu;
use reports::Segment;
use tests::chamber;
use tests::reported::number;
use tests::workdir::Workdir;

use crate::samples::{FIBRE, FIBRE_PROFILES, SHEET, TIGHT, WINDING, covered, half, wound};

/// The volume in the chamber under load.
fn air(dir: &Workdir) -> f64 {
    dir.solver("simulate p1.toml -o out --restart").assert_good();
    dir.probe("out", "air")
}

#[test]
fn fibres_and_threads_hold_a_chamber() {
    let bare = air(&wound(""));
    let dir = wound(FIBRE);
    assert!(air(&dir) < bare);
    let report = dir.json("out/report.json");
    let row = &report["fibres"][0];
    // 50 × 40 × 40 mm less 40 × 20 × 20 mm
    assert!((number(&row["volume"]) / 6.4e-5 - 1.0).abs() < 1e-9, "{row}");
    assert!((number(&row["energy"]) / number(&report["energies"]["fibre"]) - 1.0).abs() < 1e-9);
    assert!(number(&report["force_balance"]["out_of_balance"]) < 1e-9);
    let grid = read_vtu(&dir.path("out/result.vtu")).unwrap();
    for (name, components) in [("direction", 3), ("stretch", 1), ("stress", 1)] {
        let name = format!("fibre_weave_{name}");
        let field = grid.cell_fields.iter().find(|field| field.name == name).unwrap();
        assert_eq!(field.components, components);
    }

    let dir = wound(WINDING);
    assert!(air(&dir) < bare);
    let report = dir.json("out/report.json");
    let row = &report["windings"][0];
    // 2.1 turns of each hand around a square of 40 mm
    assert!((number(&row["turns"]) - 4.2).abs() < 1e-9, "{row}");
    let round = 4.2 * 0.16_f64.hypot(0.02);
    assert!((number(&row["length"]) / round - 1.0).abs() < 0.02, "{row} {round}");
    assert!((number(&row["energy"]) / number(&report["energies"]["winding"]) - 1.0).abs() < 1e-9);
    axial_force_is_that_of_the_segments(&dir);
    // half of what it would bear, and twice
    let largest = number(&row["force"][1]);
    for (part, breaks) in [(2.0, false), (0.5, true)] {
        let strength = format!("stiffness = 50\nstrength = {:e}", part * largest);
        dir.write("p2.toml", &dir.text("p1.toml").replace("stiffness = 50", &strength));
        let run = dir.solver("simulate p2.toml -o strong");
        run.assert_good();
        assert_eq!(run.stderr.contains("it breaks"), breaks, "{}", run.stderr);
        let margin = number(&dir.json("strong/report.json")["windings"][0]["margin"]);
        assert!((margin / part - 1.0).abs() < 1e-9, "{margin}");
    }
}

/// The axial force of the thread by its segments in `windings.csv`, in the middle third from 4 to 46 mm: the share of a
/// plane of nodes there is linear between planes, which are 10 mm apart. Threshold, set before: 1e-9 of it. The
/// section carries the pressure on the end of the chamber, of 20 mm by 20 mm, to the 20 % by which that grows.
fn axial_force_is_that_of_the_segments(dir: &Workdir) {
    let report = dir.json("out/report.json");
    let row = &report["windings"][0];
    let share = |x: f64| {
        let at_node = |k: f64| ((0.01 * k - 0.018) / 0.014).clamp(0.0, 1.0);
        let below = (x / 0.01).floor();
        let part = x / 0.01 - below;
        (1.0 - part) * at_node(below) + part * at_node(below + 1.0)
    };
    let segments = Segment::all(&dir.text("out/windings.csv")).unwrap();
    assert_eq!(segments.len() as u64, row["segments"].as_u64().unwrap());
    let mut force = 0.0;
    for Segment { ends: [start, end], force: own, .. } in segments {
        let along = (Vec3::from(end.now) - Vec3::from(start.now)).normalize();
        force += own * along.x * (share(end.rest[0]) - share(start.rest[0]));
    }
    assert!((number(&row["axial_force"]) / force - 1.0).abs() < 1e-9, "{row} {force}");
    let section = number(&row["section_force"]);
    assert!((number(&row["load_share"]) * section / force - 1.0).abs() < 1e-9, "{row}");
    let load = number(&report["chambers"]["cavity"]["pressure"]) * 4e-4;
    assert!((section / load - 1.0).abs() < 0.2, "{section} {load}");
}

/// From tag to tag it lies as on one tag. Threshold, set before: 1e-9, the order of sums apart.
#[test]
fn a_thread_lies_where_its_tags_are() {
    let list = WINDING.replace("\"side\"", r#"["high", "low"]"#);
    let tip: tests::Place = &|p| p.x > 0.05 - 1e-6;
    let parts = chamber::body(1, &[("tip", tip), ("low", &|p| p.z < 0.02), ("high", &|_| true)]);
    let parts = chamber::with(&parts, &list);
    parts.solver("simulate p1.toml -o out").assert_says(&["winding thread on high and low"]);
    let whole = wound(WINDING);
    air(&whole);
    let [one, other] = [&parts, &whole].map(|dir| dir.json("out/report.json"));
    for key in ["length", "turns", "mean_force", "axial_force", "energy"] {
        let [a, b] = [&one, &other].map(|report| number(&report["windings"][0][key]));
        assert!((a / b - 1.0).abs() < 1e-9, "{key}: {a} {b}");
    }
    let [a, b] = [&one, &other].map(|r| number(&r["chambers"]["cavity"]["volume"]));
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
}

/// Left and right meet where 2π (2 z)/20 mm is 100° and every turn more: after 2.78, 12.78, 22.78 and 32.78 of 42 mm.
#[test]
fn threads_that_cross_and_points_off_their_tag_are_told() {
    let other = WINDING
        .replace("\"thread\"", "\"left\"")
        .replace("pitch = 0.02", "pitch = -0.02\nphase = 100");
    let one = format!("{WINDING}{other}").replace("double = true\n", "");
    let run = wound(&one).solver("simulate p1.toml -o out");
    run.assert_good();
    let told = "windings thread and left cross at 4 points, where they do not touch: neither holds the other";
    assert!(run.stderr.contains(told) && !run.stderr.contains("itself"), "{}", run.stderr);
    let line = |points: &str| {
        let keys = "[[winding]]\nname = \"line\"\non = \"side\"\nstiffness = 50\n";
        wound(&format!("\n{keys}points = {points}\n")).solver("simulate p1.toml -o out").stderr
    };
    // the top is at 40 mm, and the mean edge has more than 10 mm
    let far = line("[[0.02, 0.013, 0.04], [0.03, 0.013, 0.047]]");
    let told =
        "winding line: point 2 of the line, (30.000, 13.000, 47.000) mm, is 7.000 mm from \"side\"";
    assert!(far.contains(told), "{far}");
    let near = line("[[0.02, 0.013, 0.04], [0.03, 0.013, 0.041]]");
    assert!(!near.contains("of the line,"), "{near}");
}

/// The mirror image of a family has the opposite angles at the mirror images of the heights; across the plane a profile
/// may be its own image: odd angles, and an even stiffness.
#[test]
fn symmetric_bodies_have_symmetric_fibres() {
    let other = FIBRE.replace("weave", "weft").replace("angle = 40", "angle = -40");
    half(&(FIBRE.to_owned() + &other)).solver("simulate p1.toml -o out").assert_good();
    let opposite =
        FIBRE_PROFILES.replace("weave", "weft").replace("[70, 40, 55]", "[-70, -40, -55]");
    half(&(FIBRE_PROFILES.to_owned() + &opposite)).solver("simulate p1.toml -o out").assert_good();
    let across = |angles: &str, stiffness: &str| {
        let tables = FIBRE_PROFILES
            .replace("[0, 0.02, -0.02], axis = [1, 0, 0]", "[0.02, 0.02, -0.02], axis = [0, 1, 0]")
            .replace("[70, 40, 55]", angles)
            .replace("[1e5, 3e5]", stiffness)
            .replace("start = -0.001, end = 0.051", "start = -0.02, end = 0.02");
        half(&tables).solver("simulate p1.toml -o out")
    };
    across("[-30, 30]", "[1e5, 3e5, 1e5]").assert_good();
    let words = ["[[fibre]] \"weave\"", "mirror image", "opposite angle"];
    across("[-30, 30]", "[1e5, 3e5, 2e5]").assert_refused(2, &words);
    across("[30, 30]", "[1e5, 3e5, 1e5]").assert_refused(2, &words);
}

/// The same bits, however one direction is said; and files that say none.
#[test]
fn one_direction_is_the_same_from_a_formula_and_a_file() {
    let family = |keys: &str| {
        covered(&format!("\n[[fibre]]\nname = \"weave\"\nk1 = 2e5\nslack = 0.1\n{keys}\n"))
    };
    let formula = family("direction = [1, 0, 0]");
    let expected = air(&formula).to_bits();
    let grid = family("file = \"formula.vtu\"\nfield = \"fibre_weave_direction\"");
    std::fs::copy(formula.path("out/result.vtu"), grid.path("formula.vtu")).unwrap();
    assert_eq!(air(&grid).to_bits(), expected);
    grid.write("p1.toml", &grid.text("p1.toml").replace("field = \"fibre_weave_direction\"", ""));
    grid.solver("simulate p1.toml -o none")
        .assert_refused(2, &["formula.vtu: no vectors called \"\"", "fibre_weave_direction"]);

    let table = family("file = \"a.npy\"");
    let write = |count: usize, x: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..count).flat_map(|i| [x(i), 0.0, 0.0]).collect();
        write_f64(&table.path("a.npy"), &values, &[count, 3]).unwrap();
    };
    let body = read_tets(&table.path("body.msh")).unwrap().mesh;
    write(body.tets.len(), &|_| 4.0);
    assert_eq!(air(&table).to_bits(), expected);
    // fibres have no sense
    write(body.vertices.len(), &|v| if v % 2 == 0 { 1.0 } else { -1.0 });
    assert_eq!(air(&table).to_bits(), expected);
    let refused =
        |words: &[&str]| table.solver("simulate p1.toml -o none").assert_refused(2, words);
    write(7, &|_| 1.0);
    refused(&["a.npy: 7 vectors", "tetrahedra of the mesh"]);
    write(body.tets.len(), &|e| if e == 3 { 0.0 } else { 1.0 });
    refused(&["file: no direction in the element at (", "the vector is [0, 0, 0]"]);
    write_f64(&table.path("a.npy"), &[1.0; 4], &[2, 2]).unwrap();
    refused(&["shape [2, 2]", "three columns"]);
}

#[test]
fn a_sheet_is_measured() {
    let dir = covered(&(SHEET.to_owned() + TIGHT));
    let report = dir.report("simulate p1.toml -o paper");
    let row = &report["membranes"][0];
    // 50 × 40 mm
    assert!((number(&row["area"]) / 2e-3 - 1.0).abs() < 1e-12, "{row}");
    let shares = ["taut", "wrinkled", "slack"].map(|key| number(&row[key]));
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{row}");
    let energy = number(&report["energies"]["membrane"]);
    assert!(energy > 0.0 && (number(&row["energy"]) / energy - 1.0).abs() < 1e-12);
    assert!(report["force_balance"].get("membrane").is_none());
    assert!(number(&report["force_balance"]["out_of_balance"]) < 1e-9);
}
