//! `mold.json` is what its schema says: each key is there, and no other.

use serde_json::{Value, json};
use tests::chamber::{self, SIM};
use tests::reported::{check_mold, is_no_mold};

/// Pointers to all objects in a value, to itself first.
fn objects(value: &Value) -> Vec<String> {
    let below = |key: &str, value: &Value| -> Vec<String> {
        objects(value).into_iter().map(|pointer| format!("/{key}{pointer}")).collect()
    };
    match value {
        Value::Object(map) => {
            let inner = map.iter().flat_map(|(key, value)| below(key, value));
            std::iter::once(String::new()).chain(inner).collect()
        }
        Value::Array(items) => {
            let items = items.iter().enumerate();
            items.flat_map(|(i, item)| below(&i.to_string(), item)).collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn a_key_more_or_less_is_found() {
    let dir = chamber::workdir();
    dir.run("fab", "mold body.msh --no-pictures -o mold").assert_good();
    let report = dir.json("mold/mold.json");
    check_mold(&report);
    let mut required = 0;
    for pointer in objects(&report) {
        let changed = |change: &dyn Fn(&mut serde_json::Map<String, Value>)| {
            let mut other = report.clone();
            change(other.pointer_mut(&pointer).and_then(Value::as_object_mut).unwrap());
            is_no_mold(&other)
        };
        let more = changed(&|map| drop(map.insert("nobodys_key".into(), json!(1))));
        assert_eq!(more, (true, true), "{pointer}");
        let keys = report.pointer(&pointer).and_then(Value::as_object).unwrap().keys();
        for key in keys {
            let (found, by_schema) = changed(&|map| drop(map.remove(key)));
            assert!(found, "{pointer} without {key}");
            required += usize::from(by_schema);
        }
    }
    assert!(required > 60, "the schema asks for {required} keys");
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
