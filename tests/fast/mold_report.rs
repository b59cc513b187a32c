//! `mold.json` is what its schema says: each key is there, and no other.

use serde_json::{Value, json};
use tests::chamber;
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
    let run = dir.command_of("fab", "mold body.msh --no-pictures -o mold").output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
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
