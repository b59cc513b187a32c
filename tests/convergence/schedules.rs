//! Loads and supports over time against static solutions at the same loads.

use mesh::Vec3;
use run::report::results;
use tests::motion::{HELD, bar, difference};

/// Equilibria are sought to 1e-10 of the forces.
const SAME: f64 = 1e-8;

#[test]
fn a_schedule_passes_through_the_static_solutions_at_its_loads() {
    let scene = |displacement: &str, pressure: &str, traction: &str| {
        format!(
            "{HELD}[[fixed]]\non = \"end\"\ncomponents = \"x\"\ndisplacement = [{displacement}, 0, 0]\n\
             [[chamber]]\non = \"left\"\npressure = {pressure}\n\
             [[body_force]]\nforce = [0, 0, -9810]\n\
             [[traction]]\non = \"top\"\ntraction = [{traction}, 0, 0]\n"
        )
    };
    let loads = scene("\"5e-3*sin(pi*t/2)\"", "\"20e3*sin(pi*t/6)\"", "\"200*t\"");
    let mut timed =
        bar(&format!("{loads}[time]\nmethod = \"quasistatic\"\nat = [0.5, 1.0, 3.0]\n"));
    let ends = timed.ends();
    assert_eq!(ends.iter().map(|s| s.time).collect::<Vec<_>>(), [0.5, 1.0, 3.0]);
    for step in ends {
        let t = step.time;
        let part = |period: f64| (std::f64::consts::PI * t / period).sin();
        // a number is constant from the first step on
        let [moved, pressure, traction] = [5e-3 * part(2.0), 20e3 * part(6.0), 200.0 * t];
        let mut still =
            bar(&scene(&moved.to_string(), &pressure.to_string(), &traction.to_string()));
        let gap = difference(&step.u, &still.ends()[0].u);
        eprintln!("schedule at t = {t} against the static scene: {gap:.1e}");
        assert!(gap < SAME, "t = {t}: {gap:e}");
    }
}

/// A motion of the whole boundary that is linear in the position is a patch test
/// with displacements from expressions, walls of chambers aside.
#[test]
fn supports_follow_expressions_of_the_position() {
    let rows = ["0.1*t*x + 0.05*y", "-0.04*z*t^2", "0.02*x*t - 0.03*t*z"];
    let on = |tag: &str| {
        format!(
            "[[fixed]]\non = \"{tag}\"\ndisplacement = [\"{}\", \"{}\", \"{}\"]\n",
            rows[0], rows[1], rows[2]
        )
    };
    let tags = ["root", "end", "top", "left", "middle", "right", "skin"];
    let fixed: String = tags.iter().map(|tag| on(tag)).collect();
    let mut moved = bar(&format!("{fixed}[time]\nmethod = \"quasistatic\"\nat = [0.7, 1.5]\n"));
    let nodes = moved.problem.space.node_positions(&moved.scene.body.mesh.vertices);
    for step in moved.ends() {
        let t = step.time;
        let exact: Vec<f64> = nodes
            .iter()
            .flat_map(|p| {
                [0.1 * t * p.x + 0.05 * p.y, -0.04 * p.z * t * t, 0.02 * p.x * t - 0.03 * t * p.z]
            })
            .collect();
        let gap = difference(&step.u, &exact);
        eprintln!("motion linear in the position at t = {t}: {gap:.1e}");
        assert!(gap < 1e-10, "t = {t}: {gap:e}");
    }
}

/// ∫ of a force over the body, and of a traction over its top; a closed wall has no resultant; and supports bear the sum.
#[test]
fn reactions_balance_every_load() {
    let mut loaded = bar(&format!(
        "{HELD}[[fixed]]\non = \"end\"\ncomponents = \"xz\"\ndisplacement = [4e-3, 0.0, 2e-3]\n\
         [[body_force]]\nforce = [0, 0, \"-1e5*x*t\"]\n\
         [[traction]]\non = \"top\"\ntraction = [\"1e6*x*y*t\", 0, 0]\n\
         [[chamber]]\non = \"middle\"\npressure = 2e3\n"
    ));
    let u = loaded.ends()[0].u.clone();
    let at = loaded.problem.iterate(&loaded.scene.body.mesh.vertices, &u, 1.0);
    let balance = results::balance(&loaded.problem, &at);
    let [force, traction, pressure, reaction] = ["body_force", "traction", "chamber", "reaction"]
        .map(|key| Vec3::from(balance.resultants[key]));
    // the chambers are centred in the bar, so ∫ x dX is volume times half its length
    let weight = -1e5 * 0.035 * (63.0 - 3.0) * 1e-6;
    assert!((force.z / weight - 1.0).abs() < 1e-12, "{balance:?}");
    let pull = 1e6 * (0.07_f64.powi(2) / 2.0) * (0.03_f64.powi(2) / 2.0);
    assert!((traction.x / pull - 1.0).abs() < 1e-12, "{balance:?}");
    assert!(pressure.norm() < 1e-12, "{pressure}");
    assert!((force + traction + reaction).norm() < 1e-9, "{balance:?}");
    assert!(balance.out_of_balance < 1e-9, "{balance:?}");
    let tags = results::tags(&loaded.scene, &loaded.scene.body, &loaded.problem, &at).unwrap();
    let [root, end, top] = ["root", "end", "top"].map(|name| Vec3::from(tags[name].reaction));
    assert!((root + end - reaction).norm() < 1e-9);
    assert!(end.x > 0.1 && end.y == 0.0, "the end is pulled and free along y: {end}");
    assert_eq!(top, Vec3::zeros());
    let moved = tags["end"].mean_displacement_vector;
    assert!((moved[0] - 4e-3).abs() < 1e-15 && (moved[2] - 2e-3).abs() < 1e-15, "{moved:?}");
}
