use serde_json::{Value, json};

use super::{Options, read, scene, with};

#[test]
fn slips_name_the_file_the_key_and_what_is_needed() {
    let refused = |json: &Value, words: &[&str]| {
        let message = format!("{:#}", read(json, &Options::default()).err().expect("refused"));
        assert!(message.contains("scene.json"), "{message}");
        for word in words {
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    };
    for (pointer, value, words) in [
        ("/geometry", json!([]), &["/geometry: no body"][..]),
        (
            "/geometry/0/mesh",
            json!("absent.msh"),
            &["/geometry/0/mesh: there is no file", "absent.msh", "put it there"],
        ),
        ("/geometry/0/n_refs", json!(2), &["/geometry/0/n_refs: 2: bodies are not refined"]),
        (
            "/geometry/0/transformation/rotation",
            json!([0, 90, 0]),
            &["rotation: only", "apply it to the mesh"],
        ),
        (
            "/geometry/0/transformation/scale",
            json!([1, 2]),
            &["scale: found [1,2], expected a list of 3"],
        ),
        (
            "/geometry/0/transformation/scale",
            json!(-1),
            &["scale: -1: expected factors greater than 0"],
        ),
        (
            "/geometry/0/surface_selection",
            json!("strangers.txt"),
            &["strangers.txt: 2 of its 2 facets are not on", "another mesh"],
        ),
        (
            "/geometry/0/surface_selection",
            json!("absent.txt"),
            &["/geometry/0/surface_selection", "absent.txt"],
        ),
        (
            "/geometry/0/surface_selection/0/axis",
            json!("w"),
            &["/axis: \"w\": expected one of x, y, z"],
        ),
        ("/geometry/0/surface_selection/0", json!({ "id": 1 }), &["unknown kind of selection"]),
        ("/geometry/0/type", json!("plane"), &["unknown kind \"plane\""]),
        (
            "/materials/1/type",
            json!("Rubber"),
            &["/materials/1/type: unknown law \"Rubber\"; known are"],
        ),
        ("/materials/1/E", Value::Null, &["/materials/1: there is no \"E\", Young's modulus [Pa]"]),
        ("/materials/1/nu", json!(0.5), &["poisson"]),
        ("/materials/1/id", json!(8), &["/materials: no material has the id 7"]),
        ("/space/discr_order", json!(4), &["/space/discr_order: 4: expected 1, 2 or 3"]),
        ("/time/dt", json!(0), &["/time/dt: found 0, expected a number greater than 0"]),
        ("/time/tend", Value::Null, &["/time: expected two of tend"]),
        ("/time/tend", json!(-1), &["/time: ", "expected 1 to 10⁶"]),
        ("/contact/dhat", json!("wide"), &["/contact/dhat: found \"wide\""]),
        (
            "/boundary_conditions/rhs",
            json!([0, 0]),
            &["/boundary_conditions/rhs: expected 3 values"],
        ),
        (
            "/boundary_conditions/pressure_boundary/0/value",
            json!("-6*sn(t)"),
            &["pressure_boundary/0/value: \"-6*sn(t)\"", "unknown function \"sn\""],
        ),
        ("/boundary_conditions/pressure_boundary/0/value", json!("x"), &["must depend on t alone"]),
        (
            "/boundary_conditions/pressure_boundary/0/value",
            json!([1, 2]),
            &["2 values; expected one for the start and each of 3"],
        ),
    ] {
        refused(&with(pointer, value), words);
    }
    refused(&json!({ "output": 1 }), &["no \"geometry\""]);
    refused(
        &json!({ "states": [{}] }),
        &["no \"geometry\"", "the \"states\" of this optimisation"],
    );
    let thin = Options { form: None, thickness: Some(0.0) };
    let message = read(&scene(), &thin).err().expect("refused").to_string();
    assert!(message.contains("thickness = 0 m: must be positive"), "{message}");
}
