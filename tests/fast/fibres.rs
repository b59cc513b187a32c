//! `[[fibre]]` and `[[winding]]` in scenes and design problems: reports, fields, derivatives by their
//! numbers, and what is refused.

use mesh::Vec3;
use mesh::io::vtu::read_vtu;
use mesh::io::write_tets;
use tests::chamber;
use tests::chamber::VOLUME_DESIGN;
use tests::workdir::Workdir;
use tests::{block, tag};

const FIBRE: &str = r#"
[[fibre]]
name = "weave"
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = 40
k1 = 2e5
k2 = 1.0
dispersion = 0.1
"#;

pub const WINDING: &str = r#"
[[winding]]
name = "thread"
on = "side"
around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }
pitch = 0.02
start = 0.004
end = 0.046
double = true
stiffness = 50
"#;

/// The chamber, whose long outer faces are one tag, with linear elements and these tables.
pub fn workdir(tables: &str) -> Workdir {
    workdir_with(tables, &[("side", &|_| true)])
}

/// The chamber with these tags of its long outer faces.
fn workdir_with(tables: &str, sides: &[(&str, &dyn Fn(Vec3) -> bool)]) -> Workdir {
    let dir = chamber::workdir();
    let middle = |i: usize| (1..3).contains(&i);
    let hollow = |c: [usize; 3]| c[0] < 4 && middle(c[1]) && middle(c[2]);
    let mesh = block([5, 4, 4], 0.01, hollow, |p| p);
    let inner = |x: f64| x > 0.009 && x < 0.031;
    let ends: [(&str, &dyn Fn(Vec3) -> bool); 3] = [
        ("seat", &|p| p.x < 1e-6),
        ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
        ("tip", &|p| p.x > 0.05 - 1e-6),
    ];
    let body = tag(mesh, &[&ends, sides].concat());
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.write("p1.toml", &(dir.text("p1.toml") + PROBES + tables));
    dir
}

const PROBES: &str = r#"
[[probe]]
name = "air"
kind = "volume"
on = "cavity"
"#;

#[test]
fn fibres_and_threads_hold_a_chamber_and_are_reported() {
    let dir = workdir("");
    dir.solver("simulate p1.toml -o bare").assert_good();
    let dir_fibre = workdir(FIBRE);
    let run = dir_fibre.solver("simulate p1.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("fibre weave: at 40° to an axis"), "{}", run.stderr);
    let report = dir_fibre.json("out/report.json");
    let row = &report["fibres"][0];
    let number = |key: &str| row[key].as_f64().unwrap();
    // 50 × 40 × 40 mm less 40 × 20 × 20 mm
    assert!((number("volume") / 6.4e-5 - 1.0).abs() < 1e-9 && number("stress") > 0.0, "{row}");
    assert!(number("taut") > 0.0 && row["stretch"][1].as_f64().unwrap() > 1.0, "{row}");
    assert!((number("energy") / report["energies"]["fibre"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    assert!(report["force_balance"]["out_of_balance"].as_f64().unwrap() < 1e-9);
    let grid = read_vtu(&dir_fibre.path("out/result.vtu")).unwrap();
    for (name, components) in [("direction", 3), ("stretch", 1), ("stress", 1)] {
        let name = format!("fibre_weave_{name}");
        let field = grid.cell_fields.iter().find(|field| field.name == name).unwrap();
        assert_eq!(field.components, components);
    }
    assert!(dir_fibre.probe("out", "air") < dir.probe("bare", "air"));

    let dir_thread = workdir(WINDING);
    let run = dir_thread.solver("simulate p1.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("helix of pitch 20.000 mm, double"), "{}", run.stderr);
    let report = dir_thread.json("out/report.json");
    let row = &report["windings"][0];
    let number = |key: &str| row[key].as_f64().unwrap();
    // 2.1 turns of each hand around a square of 40 mm
    assert!((number("turns") - 4.2).abs() < 1e-9, "{row}");
    let round = 4.2 * 0.16_f64.hypot(0.02);
    assert!((number("length") / round - 1.0).abs() < 0.02, "{row} {round}");
    assert!(row["force"][1].as_f64().unwrap() > number("mean_force") && number("mean_force") > 0.0);
    assert!(
        (number("energy") / report["energies"]["winding"].as_f64().unwrap() - 1.0).abs() < 1e-9
    );
    // half of what it would bear, and twice
    let largest = row["force"][1].as_f64().unwrap();
    for (part, breaks) in [(2.0, false), (0.5, true)] {
        let strength = format!("stiffness = 50\nstrength = {:e}", part * largest);
        dir_thread
            .write("p2.toml", &dir_thread.text("p1.toml").replace("stiffness = 50", &strength));
        let run = dir_thread.solver("simulate p2.toml -o strong");
        run.assert_good();
        assert_eq!(run.stderr.contains("it breaks"), breaks, "{}", run.stderr);
        let margin =
            dir_thread.json("strong/report.json")["windings"][0]["margin"].as_f64().unwrap();
        assert!((margin / part - 1.0).abs() < 1e-9, "{margin}");
    }
    axial_force_is_that_of_the_segments(&dir_thread);
    let table = dir_thread.text("out/windings.csv");
    let segments = row["segments"].as_u64().unwrap() as usize;
    assert!(
        table.starts_with("winding,start at rest x [m],") && table.lines().count() == 1 + segments
    );
    assert!(dir_thread.probe("out", "air") < dir.probe("bare", "air"));
}

/// The axial force of the thread by its segments in `windings.csv`, in the middle third from 4 to 46 mm: the share of a
/// plane of nodes there is linear between planes, which are 10 mm apart. Threshold, set before: 1e-9 of it. The
/// section carries the pressure on the end of the chamber, of 20 mm by 20 mm, to the 20 % by which that grows.
fn axial_force_is_that_of_the_segments(dir: &Workdir) {
    let row = &dir.json("out/report.json")["windings"][0];
    let number = |key: &str| row[key].as_f64().unwrap();
    let share = |x: f64| {
        let at_node = |k: f64| ((0.01 * k - 0.018) / 0.014).clamp(0.0, 1.0);
        let below = (x / 0.01).floor();
        let part = x / 0.01 - below;
        (1.0 - part) * at_node(below) + part * at_node(below + 1.0)
    };
    let mut force = 0.0;
    for line in dir.text("out/windings.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        let [start, end] = [3, 9].map(|k| Vec3::from_column_slice(&cells[k..k + 3]));
        let along = (end - start).normalize();
        force += cells[12] * along.x * (share(cells[6]) - share(cells[0]));
    }
    assert!((number("axial_force") / force - 1.0).abs() < 1e-9, "{row} {force}");
    let section = number("section_force");
    assert!((number("load_share") * section / force - 1.0).abs() < 1e-9, "{row}");
    let pressure = dir.json("out/report.json")["chambers"]["cavity"]["pressure"].as_f64().unwrap();
    let load = pressure * 4e-4;
    assert!((section / load - 1.0).abs() < 0.2, "{section} {load}");
}

/// Threshold, set before: 1e-9 of the volume, the order of sums apart.
#[test]
fn a_thread_passes_from_tag_to_tag() {
    let whole = workdir(WINDING);
    whole.solver("simulate p1.toml -o out").assert_good();
    let list = |tags: &str| WINDING.replace("\"side\"", tags);
    let halves: [(&str, &dyn Fn(Vec3) -> bool); 2] =
        [("low", &|p| p.z < 0.02), ("high", &|_| true)];
    let parts = workdir_with(&list(r#"["high", "low"]"#), &halves);
    let run = parts.solver("simulate p1.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("winding thread on high and low"), "{}", run.stderr);
    assert!((parts.probe("out", "air") / whole.probe("out", "air") - 1.0).abs() < 1e-9);
    let none = workdir(&list("[]")).solver("simulate p1.toml -o out");
    assert!(none.stderr.contains("on = []: no tag"), "{}", none.stderr);
    assert_eq!(none.code, Some(2));
}

/// The gradients by shape and by all numbers, as a user asks for them: those of a thread by its stiffness and
/// pretension, and by pitch or angle and phase.
#[test]
fn gradients_by_shape_and_numbers_pass_their_test() {
    // the slack is wide, so that its curvature is seen by the steps of the test; with the phase, the thread does not
    // start on an edge of the mesh, where forces have a kink
    let winding = WINDING.to_owned() + "slack = 0.1\npretension = 0.5\nphase = 10\n";
    for (course, shape) in [("pitch = 0.02", true), ("angle = 80", false)] {
        let winding = winding.replace("pitch = 0.02", course) + PULL;
        let dir = workdir(&(FIBRE.to_owned() + "slack = 0.1\n" + &winding));
        let design =
            if shape { VOLUME_DESIGN.to_owned() } else { VOLUME_DESIGN.replace(SHAPE, PARAMETER) };
        dir.write("design.toml", &(design + PULLED));
        let run = dir.solver("check design.toml --random 1");
        run.assert_good();
        // two terms along two directions; a thread has its law and its course
        for (path, tests) in [("fibre.weave", 4), ("winding.thread", 8)] {
            let found = run.stdout.matches(&format!("by {path}, ")).count();
            assert_eq!(found, tests, "{}", run.stdout);
        }
    }
}

const PULL: &str = r#"
[[probe]]
name = "pull"
kind = "winding-force"
winding = "thread"
power = 4
"#;

const PULLED: &str = r#"
[[objective]]
kind = "probe"
name = "pull"
weight = 1
probe = "pull"
"#;

const PARAMETER: &str = r#"
[optimizer]
iterations = 1

[[parameter]]
name = "winding.thread.angle"
bounds = [75, 85]
"#;

const SHAPE: &str = r#"
[shape]
on = "cavity"

[[shape.level]]
handles = 1
iterations = 1
"#;

/// Angle and stiffness of a family are found again from what they did, within bounds, and the gradient by both passes
/// its test.
#[test]
fn angle_and_stiffness_of_a_family_are_designed() {
    let dir = workdir(&FIBRE.replace("k2 = 1.0\ndispersion = 0.1\n", "slack = 0.1\n"));
    let probe =
        "[[probe]]\nname = \"tip\"\nkind = \"displacement\"\non = \"tip\"\naxis = [1, 0, 0]\n";
    dir.write("p1.toml", &(dir.text("p1.toml") + probe));
    let numbers = "\n[numbers]\n\"fibre.weave.angle\" = 55\n\"fibre.weave.k1\" = 4e5\n";
    dir.write("wanted.toml", &(dir.text("p1.toml") + numbers));
    dir.solver("simulate wanted.toml -o wanted").assert_good();
    let [air, tip] = ["air", "tip"].map(|name| dir.probe("wanted", name));
    let objective = |name: &str, target: f64, scale: f64| {
        format!(
            "\n[[objective]]\nkind = \"probe\"\nname = \"{name}\"\nweight = 1\nprobe = \"{name}\"\n\
             target = {target:e}\nscale = {scale:e}\n"
        )
    };
    let design = |most: f64| {
        format!(
            "scene = \"p1.toml\"\n\n[optimizer]\nmethod = \"gauss-newton\"\niterations = 12\n\n\
             [[parameter]]\nname = \"fibre.weave.angle\"\nbounds = [20, {most}]\n\n\
             [[parameter]]\nname = \"fibre.weave.k1\"\nbounds = [1e5, 1e6]\n"
        ) + &objective("air", air, 1e-8)
            + &objective("tip", tip, 1e-5)
    };
    dir.write("design.toml", &design(80.0));
    let run = dir.solver("check design.toml --random 1");
    run.assert_good();
    assert!(run.stdout.contains("fibre.weave"), "{}", run.stdout);
    let found = |design: &str| {
        dir.write("design.toml", design);
        dir.solver("optimize design.toml -o out --restart").assert_good();
        let text = dir.text("out/history.jsonl");
        let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        ["angle", "k1"]
            .map(|key| last["parameters"][format!("fibre.weave.{key}")].as_f64().unwrap())
    };
    let [angle, k1] = found(&design(80.0));
    assert!((angle - 55.0).abs() < 0.05 && (k1 / 4e5 - 1.0).abs() < 1e-2, "{angle} {k1}");
    // a bound that is nearer holds
    let [angle, _] = found(&design(48.0).replace("iterations = 12", "iterations = 4"));
    assert!((angle - 48.0).abs() < 1e-9, "{angle}");
}

/// A pitch is found again from the volume and the force that it made, from 20 mm. Threshold, set before: 1e-3 of it.
#[test]
fn the_pitch_of_a_thread_is_designed() {
    let dir = workdir(&(WINDING.to_owned() + "slack = 0.1\nphase = 10\n" + PULL));
    let wanted = dir.text("p1.toml") + "\n[numbers]\n\"winding.thread.pitch\" = 0.0163\n";
    dir.write("wanted.toml", &wanted);
    dir.solver("simulate wanted.toml -o wanted").assert_good();
    let objective = |name: &str, scale: f64| {
        let target = dir.probe("wanted", name);
        format!(
            "\n[[objective]]\nkind = \"probe\"\nname = \"{name}\"\nweight = 1\nprobe = \"{name}\"\n\
             target = {target:e}\nscale = {scale:e}\n"
        )
    };
    let design = "scene = \"p1.toml\"\n\n[optimizer]\nmethod = \"gauss-newton\"\niterations = 15\n\n\
                  [[parameter]]\nname = \"winding.thread.pitch\"\nbounds = [0.01, 0.03]\n";
    let design = design.to_owned() + &objective("air", 1e-8) + &objective("pull", 1e-2);
    dir.write("design.toml", &design);
    dir.solver("optimize design.toml -o out").assert_good();
    let text = dir.text("out/history.jsonl");
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    let pitch = last["parameters"]["winding.thread.pitch"].as_f64().unwrap();
    assert!((pitch / 0.0163 - 1.0).abs() < 1e-3, "{pitch}");
}

#[test]
fn numbers_are_set_by_their_paths() {
    let dir = workdir(&(FIBRE.to_owned() + WINDING));
    let numbers = "\n[numbers]\n\"fibre.weave.angle\" = 80\n\"winding.thread.stiffness\" = 100\n";
    dir.write("set.toml", &(dir.text("p1.toml") + numbers));
    dir.solver("simulate set.toml -o set").assert_good();
    let by_hand = dir.text("p1.toml").replace("angle = 40", "angle = 80");
    dir.write("hand.toml", &by_hand.replace("stiffness = 50", "stiffness = 100"));
    dir.solver("simulate hand.toml -o hand").assert_good();
    assert_eq!(dir.probe("set", "air").to_bits(), dir.probe("hand", "air").to_bits());
    let bad = dir.text("p1.toml") + "\n[numbers]\n\"fibre.weave.dispersion\" = 0.5\n";
    dir.write("bad.toml", &bad);
    dir.solver("simulate bad.toml -o bad").assert_refused(2, &["dispersion = 0.5", "1/3"]);
}

#[test]
fn fibres_that_cannot_be_used_are_refused() {
    for (from, to, words) in [
        ("k1 = 2e5", "k1 = 0", &["[[fibre]] \"weave\": k1 = 0 Pa", "positive"][..]),
        ("k2 = 1.0", "k2 = -1.0", &["k2 = -1"]),
        ("dispersion = 0.1", "dispersion = 0.4", &["dispersion = 0.4", "1/3"]),
        ("dispersion = 0.1", "slack = 0", &["slack = 0"]),
        ("dispersion = 0.1", "slack = 0.1\ncompression = true", &["slack", "never slack"]),
        ("angle = 40\n", "", &["around without angle", "radial = true"]),
        ("angle = 40", "angle = 40\nradial = true", &["radial beside angle"]),
        ("angle = 40", "direction = [1, 0, 0]", &["direction beside around"]),
        (
            "around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }\n",
            "",
            &["angle without an axis", "add around"],
        ),
        ("axis = [1, 0, 0]", "axis = [0, 0, 0]", &["around", "axis", "a direction with a length"]),
        (
            "point = [0, 0.02, -0.02]",
            "point = [0, 0.02, 0.02]",
            &["the axis passes through the material at (0.0", "0.020000, 0.020000) m"],
        ),
        (
            "angle = 40",
            "angle = 40\non = \"liner\"",
            &["\"liner\"", "unknown body or volume", "body"],
        ),
        ("name = \"weave\"", "name = \"a.b\"", &["\"a.b\"", "no dot"]),
        ("angle = 40", "angel = 40", &["unknown field `angel`", "`angle`"]),
    ] {
        let dir = workdir(&FIBRE.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
    let dir = workdir(&(FIBRE.to_owned() + FIBRE));
    dir.solver("simulate p1.toml -o out")
        .assert_refused(2, &["two [[fibre]] are called \"weave\""]);
    let dir = workdir(FIBRE);
    dir.solver("export p1.toml -o out.inp --degree 1").assert_refused(2, &["[[fibre]]", "deck"]);
}

#[test]
fn threads_that_cannot_be_used_are_refused() {
    for (from, to, words) in [
        ("stiffness = 50", "stiffness = -50", &["[[winding]] \"thread\": stiffness = -50 N"][..]),
        ("pitch = 0.02\n", "", &["no course", "pitch or angle"]),
        ("pitch = 0.02", "pitch = 0.0", &["pitch = 0 m"]),
        ("pitch = 0.02", "pitch = 0.02\nangle = 60", &["angle beside pitch"]),
        ("pitch = 0.02", "pitch = 1e-7", &["turns", "10000"]),
        ("pitch = 0.02", "angle = 90", &["angle = 90°"]),
        ("end = 0.046", "end = 0.001", &["end = 0.001 m", "start = 0.004 m"]),
        (
            "end = 0.046",
            "end = 0.08",
            &[
                "it leaves the facets at (0.05",
                "% of its way",
                "0.000000 to 0.050000 m",
                "0.004000 to 0.080000 m",
            ],
        ),
        (
            "start = 0.004",
            "start = -0.004",
            &["none of the facets", "thread from -0.004000 to 0.046"],
        ),
        ("on = \"side\"", "on = \"roof\"", &["unknown tag \"roof\"", "side"]),
        ("on = \"side\"", "on = \"tip\"", &["the axis passes through a facet"]),
        ("start = 0.004\nend = 0.046", "start = 0.2\nend = 0.3", &["it meets none of the facets"]),
        ("double = true", "points = [[0, 0, 0], [0.05, 0, 0]]", &["around beside points"]),
        ("double = true", "strength = 0", &["strength = 0 N"]),
        ("double = true", "pretension = -1", &["pretension = -1 N"]),
        (
            "around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }\n",
            "",
            &["a helix without an axis"],
        ),
        ("stiffness = 50", "stiffnes = 50", &["unknown field `stiffnes`", "`stiffness`"]),
        (
            "stiffness = 50\n",
            "stiffness = 50\n[[probe]]\nname = \"f\"\nkind = \"winding-force\"\nwinding = \"tread\"\n",
            &["unknown winding; did you mean `thread`?", "there are: thread"],
        ),
        (
            "stiffness = 50\n",
            "stiffness = 50\n[[probe]]\nname = \"f\"\nkind = \"winding-force\"\nwinding = \"thread\"\npower = 0.5\n",
            &["power = 0.5", "from 1, the mean, to 100"],
        ),
    ] {
        let dir = workdir(&WINDING.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
}

/// Left and right meet where 2π (2 z)/20 mm is 100° and every turn more: after 2.78, 12.78, 22.78 and 32.78 of 42 mm.
#[test]
fn threads_that_cross_and_points_off_their_tag_are_told() {
    let other = WINDING
        .replace("\"thread\"", "\"left\"")
        .replace("pitch = 0.02", "pitch = -0.02\nphase = 100");
    let one = format!("{WINDING}{other}").replace("double = true\n", "");
    let run = workdir(&one).solver("simulate p1.toml -o out");
    run.assert_good();
    let told = "windings thread and left cross at 4 points, where they do not touch: neither holds the other";
    assert!(run.stderr.contains(told) && !run.stderr.contains("itself"), "{}", run.stderr);
    let run = workdir(WINDING).solver("simulate p1.toml -o out");
    assert!(run.stderr.contains("winding thread crosses itself at "), "{}", run.stderr);

    let line = |points: &str| {
        let keys = "[[winding]]\nname = \"line\"\non = \"side\"\nstiffness = 50\n";
        workdir(&format!("\n{keys}points = {points}\n")).solver("simulate p1.toml -o out").stderr
    };
    // the top is at 40 mm, and the mean edge has more than 10 mm
    let far = line("[[0.02, 0.013, 0.04], [0.03, 0.013, 0.047]]");
    let words = [
        "winding line: point 2 of the line, (30.000, 13.000, 47.000) mm, is 7.000 mm from \"side\"",
    ];
    assert!(words.iter().all(|word| far.contains(word)), "{far}");
    let near = line("[[0.02, 0.013, 0.04], [0.03, 0.013, 0.041]]");
    assert!(!near.contains("of the line,"), "{near}");
}

/// Mirror images: a helix has none, two families of opposite angles have each other.
#[test]
fn symmetric_bodies_need_symmetric_fibres() {
    let half = |tables: &str| {
        let dir = workdir(&(tables.to_owned() + "\n[[symmetry]]\non = \"cut\"\n"));
        let mesh =
            block([5, 2, 4], 0.01, |c| c[0] < 4 && c[1] == 1 && (1..3).contains(&c[2]), |p| p);
        let body = tag(
            mesh,
            &[
                ("cut", &|p| p.y > 0.02 - 1e-6),
                ("seat", &|p| p.x < 1e-6),
                ("cavity", &|p| p.x < 0.041 && p.y > 0.009 && p.z > 0.009 && p.z < 0.031),
                ("side", &|_| true),
            ],
        );
        write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
        dir.solver("simulate p1.toml -o out")
    };
    half(FIBRE).assert_refused(2, &["[[fibre]] \"weave\"", "mirror image", "opposite angle"]);
    let other = FIBRE.replace("weave", "weft").replace("angle = 40", "angle = -40");
    half(&(FIBRE.to_owned() + &other)).assert_good();
    half(WINDING).assert_refused(2, &["[[winding]] \"thread\"", "[[symmetry]]", "solver mirror"]);
}
