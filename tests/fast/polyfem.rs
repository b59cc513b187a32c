//! The first steps of published scenes against those of PolyFEM.

use serde_json::{Value, json};
use solver::import::Options;
use tests::polyfem::{differences, reference, scene};

/// Asserts how far probes are off before and after surfaces meet, as a fraction
/// of the largest displacement.
fn agree(differences: &[(usize, f64)], contact: usize, before: f64, after: f64) {
    assert!(!differences.is_empty());
    for &(step, difference) in differences {
        let limit = if step < contact { before } else { after };
        assert!(difference < limit, "step {step}: {difference:.2e}, not below {limit:.0e}");
    }
}

fn as_published(_: &mut Value) {}

#[test]
fn the_gripper_alone_in_four_quasistatic_steps_with_linear_elements() {
    let Some(reference) = reference("gripper_qs_p1_steps1to4") else { return };
    let alone = |json: &mut Value| {
        json["geometry"].as_array_mut().unwrap().truncate(1);
        json["contact"] = json!({ "enabled": false });
        json["space"]["discr_order"] = json!(1);
        json["time"] = json!({ "t0": 0, "tend": 4, "dt": 1, "quasistatic": true });
        json["boundary_conditions"]["pressure_boundary"][0]["value"] = json!("-5000*t");
    };
    let file = "gripper_bellows/state_gripper_bellows.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), alone) else { return };
    agree(&differences(scene, &reference, 4), usize::MAX, 1e-6, 0.0);
}

/// Until the legs touch the ground in step 5. In a slab the field may vary
/// over the depth, where theirs may not: the less the thinner it is.
#[test]
fn the_walker_in_flight() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    for (thickness, limit) in [(None, 1e-4), (Some(3e-4), 2e-6)] {
        let options = Options { form: None, thickness };
        let Some((_dir, scene)) = scene(file, &options, as_published) else { return };
        eprintln!("slab of {thickness:?} m");
        agree(&differences(scene, &reference, 4), usize::MAX, limit, 0.0);
    }
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn the_walker_on_its_way() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), as_published) else { return };
    agree(&differences(scene, &reference, 50), 5, 1e-4, 1e-2);
}

#[test]
#[ignore = "two minutes: runs in make test-all"]
fn the_worm_falls_and_lands() {
    let Some(reference) = reference("worm_dyn_steps1to2") else { return };
    let file = "worm/state_worm.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), as_published) else { return };
    agree(&differences(scene, &reference, 2), 2, 1e-9, 1e-6);
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn the_gripper_begins_to_swell() {
    let Some(reference) = reference("gripper_dyn_step1") else { return };
    let file = "gripper_bellows/state_gripper_bellows.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), as_published) else { return };
    agree(&differences(scene, &reference, 1), usize::MAX, 1e-6, 0.0);
}
