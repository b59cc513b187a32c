//! Families of fibres whose stiffness and angle change along an axis: numbers, derivatives, designs, symmetric bodies, and
//! what is refused.

use mesh::Vec3;
use mesh::io::write_tets;
use tests::chamber;
use tests::workdir::Workdir;
use tests::{block, tag};

const FAMILY: &str = r#"
[[fibre]]
name = "weave"
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = { values = [70, 40, 55], start = -0.001, end = 0.051 }
k1 = { values = [1e5, 3e5], start = -0.001, end = 0.051 }
slack = 0.1
"#;

const PROBES: &str = r#"
[[probe]]
name = "air"
kind = "volume"
on = "cavity"

[[probe]]
name = "near"
kind = "displacement"
on = "near"
axis = [0, 0, 1]

[[probe]]
name = "far"
kind = "displacement"
on = "far"
axis = [0, 0, 1]
"#;

/// A chamber along x, 50 mm long, with linear elements; its top has two tags, near the seat and far from it.
fn workdir(tables: &str) -> Workdir {
    let dir = chamber::workdir();
    let middle = |i: usize| (1..3).contains(&i);
    let mesh = block([5, 4, 4], 0.01, |c| c[0] < 4 && middle(c[1]) && middle(c[2]), |p| p);
    let inner = |x: f64| x > 0.009 && x < 0.031;
    let top = |p: Vec3| p.z > 0.04 - 1e-6;
    let body = tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6),
            ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
            ("near", &|p| top(p) && p.x < 0.021),
            ("far", &|p| top(p)),
            ("side", &|_| true),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.write("p1.toml", &(dir.text("p1.toml") + PROBES + tables));
    dir
}

/// Equal values are a number, and a value that is set by its path is the one in the table. Threshold, set before: 1e-9
/// of the volume, as far as states are balanced.
#[test]
fn numbers_along_an_axis_are_numbers() {
    let equal = FAMILY.replace("[70, 40, 55]", "[50, 50, 50]").replace("[1e5, 3e5]", "[2e5, 2e5]");
    let table = |of: &str| of.split_once(" = ").map(|(key, _)| key.to_owned());
    let plain: Vec<String> = equal
        .lines()
        .map(|line| match table(line).as_deref() {
            Some("angle") => "angle = 50".to_owned(),
            Some("k1") => "k1 = 2e5".to_owned(),
            _ => line.to_owned(),
        })
        .collect();
    let airs = [equal, plain.join("\n")].map(|tables| {
        let dir = workdir(&tables);
        dir.solver("simulate p1.toml -o out").assert_good();
        dir.probe("out", "air")
    });
    assert!((airs[0] / airs[1] - 1.0).abs() < 1e-9, "{airs:?}");

    let dir = workdir(FAMILY);
    let numbers = "\n[numbers]\n\"fibre.weave.angle.2\" = 20\n\"fibre.weave.k1.2\" = 5e5\n";
    dir.write("set.toml", &(dir.text("p1.toml") + numbers));
    let run = dir.solver("simulate set.toml -o set");
    run.assert_good();
    assert!(
        run.stderr.contains("fibre weave: at 20 to 70° to an axis, k1 1.000e5 to 5.000e5 Pa"),
        "{}",
        run.stderr
    );
    let by_hand = dir.text("p1.toml").replace("[70, 40, 55]", "[70, 20, 55]");
    dir.write("hand.toml", &by_hand.replace("[1e5, 3e5]", "[1e5, 5e5]"));
    dir.solver("simulate hand.toml -o hand").assert_good();
    assert_eq!(dir.probe("set", "air").to_bits(), dir.probe("hand", "air").to_bits());
    dir.write("bad.toml", &dir.text("set.toml").replace("k1.2", "k1.3"));
    dir.solver("simulate bad.toml -o bad")
        .assert_refused(2, &["fibre.weave.k1.3", "no such number", "fibre.weave.k1.2"]);
    dir.write("bad.toml", &dir.text("set.toml").replace("5e5", "-5e5"));
    dir.solver("simulate bad.toml -o bad").assert_refused(2, &["value 2 is -500000 Pa"]);
}

/// By shape, which moves points along the axis, and by every value.
#[test]
fn gradients_by_shape_and_values_pass_their_test() {
    let dir = workdir(FAMILY);
    dir.write(
        "design.toml",
        "scene = \"p1.toml\"\n[shape]\non = \"cavity\"\n[[shape.level]]\nhandles = 1\niterations = 1\n\
         [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = 1e6\non = \"cavity\"\nvolume = 2e-5\n\
         measure = \"deformed\"\n",
    );
    let run = dir.solver("check design.toml --random 1");
    run.assert_good();
    assert_eq!(run.stdout.matches("by fibre.weave, ").count(), 2, "{}", run.stdout);
}

/// Both values of a stiffness along the chamber are found again from how far its top rises near the seat and far from
/// it. Threshold, set before: 1e-2 of each.
#[test]
fn two_values_are_found_again() {
    let dir = workdir(FAMILY);
    let numbers = "\n[numbers]\n\"fibre.weave.k1.1\" = 3e5\n\"fibre.weave.k1.2\" = 1.5e5\n";
    dir.write("wanted.toml", &(dir.text("p1.toml") + numbers));
    dir.solver("simulate wanted.toml -o wanted").assert_good();
    let objective = |name: &str| {
        let target = dir.probe("wanted", name);
        format!(
            "\n[[objective]]\nkind = \"probe\"\nname = \"{name}\"\nweight = 1\nprobe = \"{name}\"\n\
             target = {target:e}\nscale = 1e-5\n"
        )
    };
    let parameter = |place: usize| {
        format!("\n[[parameter]]\nname = \"fibre.weave.k1.{place}\"\nbounds = [5e4, 1e6]\n")
    };
    let design = "scene = \"p1.toml\"\n\n[optimizer]\nmethod = \"gauss-newton\"\niterations = 15\n";
    let terms = [parameter(1), parameter(2), objective("near"), objective("far")];
    dir.write("design.toml", &(design.to_owned() + &terms.concat()));
    dir.solver("optimize design.toml -o out").assert_good();
    let text = dir.text("out/history.jsonl");
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    for (place, wanted) in [(1, 3e5), (2, 1.5e5)] {
        let found = last["parameters"][format!("fibre.weave.k1.{place}")].as_f64().unwrap();
        assert!((found / wanted - 1.0).abs() < 1e-2, "{place}: {found}");
    }
}

#[test]
fn profiles_that_cannot_be_used_are_refused() {
    let around = "around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }\n";
    let angle = "angle = { values = [70, 40, 55], start = -0.001, end = 0.051 }\n";
    let line = "end = 0.051, line = { point = [0, 0, 0], axis = [1, 0, 0] } }\nslack";
    for (from, to, words) in [
        ("[1e5, 3e5]", "[1e5]", &["[[fibre]] \"weave\": k1: values", "without a table"][..]),
        ("[1e5, 3e5]", "[1e5, -1]", &["k1 = -1 Pa", "positive"]),
        ("[1e5, 3e5]", "\"stiff\"", &["k1", "invalid type: string"]),
        ("[70, 40, 55]", "[400, 40]", &["angle = 400°", "between -360 and 360"]),
        ("end = 0.051 }\nslack", "end = -1 }\nslack", &["k1: end = -1 m, with start = -0.001 m"]),
        ("end = 0.051 }\nslack", "till = 1 }\nslack", &["unknown field `till`", "`end`"]),
        ("end = 0.051 }\nslack", line, &["k1: line beside around"]),
        (angle, &*format!("{angle}radial = true\n"), &["radial beside angle"]),
        (around, "", &["angle without an axis"]),
        (&*format!("{around}{angle}"), "direction = [1, 0, 0]\n", &["k1 has no axis", "line = {"]),
        (
            "point = [0, 0.02, -0.02]",
            "point = [0, 0.02, 0.02]",
            &["the axis passes through the material at (0.0"],
        ),
    ] {
        let dir = workdir(&FAMILY.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
    // along its own line; and along the axis itself, where that is in the material
    let own = FAMILY.replace(&format!("{around}{angle}"), "direction = [1, 0, 0]\n");
    let untwisted = FAMILY
        .replace(
            "[70, 40, 55], start = -0.001, end = 0.051",
            "[60, 0, 0, 0, 0], start = 0, end = 0.04",
        )
        .replace("point = [0, 0.02, -0.02]", "point = [0, 0.02, 0.02]");
    for good in [own.replace("end = 0.051 }\nslack", line), untwisted] {
        workdir(&good).solver("simulate p1.toml -o out").assert_good();
    }
}

/// The mirror image of a profile has the opposite angles at the mirror images of the heights.
#[test]
fn symmetric_bodies_need_symmetric_profiles() {
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
                ("near", &|p| p.z > 0.04 - 1e-6 && p.x < 0.021),
                ("far", &|_| true),
            ],
        );
        write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
        dir.solver("simulate p1.toml -o out")
    };
    let words = ["[[fibre]] \"weave\"", "mirror image", "opposite angle"];
    half(FAMILY).assert_refused(2, &words);
    let other = FAMILY.replace("weave", "weft");
    let opposite = other.replace("[70, 40, 55]", "[-70, -40, -55]");
    half(&(FAMILY.to_owned() + &opposite)).assert_good();
    for wrong in [
        other.replace("[70, 40, 55]", "[-70, -40, -50]"),
        opposite.replace("[1e5, 3e5]", "[1e5, 3.1e5]"),
    ] {
        half(&(FAMILY.to_owned() + &wrong)).assert_refused(2, &words);
    }
    // across the plane a profile may be its own image: odd angles, and an even stiffness
    let across = FAMILY
        .replace("[0, 0.02, -0.02], axis = [1, 0, 0]", "[0.02, 0.02, -0.02], axis = [0, 1, 0]")
        .replace(
            "[70, 40, 55], start = -0.001, end = 0.051",
            "[-30, 30], start = -0.02, end = 0.02",
        );
    let stiffness = |values: &str| {
        across.replace(
            "[1e5, 3e5], start = -0.001, end = 0.051",
            &format!("{values}, start = -0.02, end = 0.02"),
        )
    };
    half(&stiffness("[1e5, 3e5, 1e5]")).assert_good();
    half(&stiffness("[1e5, 3e5, 2e5]")).assert_refused(2, &words);
    let even = stiffness("[1e5, 3e5, 1e5]").replace("[-30, 30]", "[30, 30]");
    half(&even).assert_refused(2, &words);
}
