//! Loads and supports over time against static solutions at the same loads.

use mechanics::element::at;
use mesh::Vec3;
use run::report::results;
use tests::bar::{HELD, difference, simulate};

/// Equilibria are sought to 1e-10 of the forces.
const SAME: f64 = 1e-8;

#[test]
fn a_schedule_passes_through_the_static_solutions_at_its_loads() {
    let loads = "[time]\nmethod = \"quasistatic\"\nat = [0.5, 1.0, 3.0]\n\
                 [[chamber]]\non = \"left\"\npressure = \"20e3*sin(pi*t/6)\"\n\
                 [[body_force]]\nforce = [0, 0, -9810]\n\
                 [[traction]]\non = \"top\"\ntraction = [\"200*t\", 0, 0]\n";
    let timed = simulate(&format!("{HELD}{loads}"));
    let ends = timed.ends();
    assert_eq!(ends.iter().map(|s| s.time).collect::<Vec<_>>(), [0.5, 1.0, 3.0]);
    for step in ends {
        let t = step.time;
        let pressure = 20e3 * (std::f64::consts::PI * t / 6.0).sin();
        // a number is constant from the first step on
        let loads = format!(
            "[[chamber]]\non = \"left\"\npressure = {pressure:e}\n\
             [[body_force]]\nforce = [0, 0, -9810]\n\
             [[traction]]\non = \"top\"\ntraction = [{:e}, 0, 0]\n",
            200.0 * t
        );
        let gap = difference(&step.u, &simulate(&format!("{HELD}{loads}")).solution.u);
        eprintln!("schedule at t = {t} against the static scene: {gap:.1e}");
        assert!(gap < SAME, "t = {t}: {gap:e}");
    }
}

/// Time steps that Newton's method cannot take at once are cut, which their ends
/// do not show.
#[test]
fn a_time_step_is_cut_where_it_is_too_long() {
    let with = |solver: &str| {
        simulate(&format!(
            "{HELD}[time]\nmethod = \"quasistatic\"\nat = [1.0, 4.0]\n\
             [[chamber]]\non = \"left\"\npressure = {{ t = [0, 1, 4], value = [0, 5e3, 90e3] }}\n{solver}"
        ))
    };
    let cut = with("[solver]\nfirst_load_step = 1.0\nnewton_iterations = 3\n");
    let whole = with("[solver]\nfirst_load_step = 1.0\n");
    assert_eq!(whole.solution.steps.len(), 2, "with 30 iterations no cut is needed");
    let between = cut.solution.steps.iter().filter(|s| !s.ends_time_step);
    assert!(between.clone().count() > 0 && between.clone().all(|s| s.time > 0.0 && s.time < 4.0));
    for (a, b) in cut.ends().iter().zip(whole.ends()) {
        assert_eq!(a.time, b.time);
        assert!(difference(&a.u, &b.u) < SAME, "t = {}", a.time);
    }
}

/// There and back: the body is at rest again, without stress.
#[test]
fn a_support_moves_in_time() {
    let scene = |displacement: &str, time: &str| {
        format!("{time}{HELD}[[fixed]]\non = \"end\"\ndisplacement = [{displacement}, 0, 0]\n")
    };
    let time = "[time]\nmethod = \"quasistatic\"\nend = 1.0\nsteps = 8\n";
    let moving = simulate(&scene("\"5e-3*sin(2*pi*t)\"", time));
    let ends = moving.ends();
    let body = moving.scene.body.clone();
    let facets = body.facets("end").unwrap();
    for (step, expected) in ends.iter().zip([1.0, 2.0_f64.sqrt(), 1.0, 0.0, -1.0]) {
        let expected = 5e-3 * expected / 2.0_f64.sqrt();
        for node in facets.iter().flat_map(|&f| moving.problem.space.facet_nodes(f)) {
            assert!((at(&step.u, node) - expected * Vec3::x()).norm() < 1e-15);
        }
    }
    let largest = |u: &[f64]| u.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(largest(&ends[3].u) < 1e-10 && largest(&ends[7].u) < 1e-10);
    let quarter = simulate(&scene("5e-3", ""));
    let gap = difference(&ends[1].u, &quarter.solution.u);
    eprintln!(
        "moving support against the static scene: {gap:.1e}, and back: {:.1e} m",
        largest(&ends[3].u)
    );
    assert!(gap < SAME);
    let report =
        results::step(&moving.scene, &body, &moving.problem, &ends[1], None, (&[], 0.0)).unwrap();
    assert!(report.reactions["end"][0] > 1.0, "{report:?}");
    assert_eq!((report.t, report.load), (0.25, None));
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
    let simulated =
        simulate(&format!("{fixed}[time]\nmethod = \"quasistatic\"\nat = [0.7, 1.5]\n"));
    let nodes = simulated.problem.space.node_positions(&simulated.scene.body.mesh.vertices);
    for step in simulated.ends() {
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

/// ∫ of the force over the body, and of the traction over its top.
#[test]
fn forces_that_depend_on_the_position_have_their_resultants() {
    let loads = "[[body_force]]\nforce = [0, 0, \"-1e5*x*t\"]\n\
                 [[traction]]\non = \"top\"\ntraction = [\"1e6*x*y*t\", 0, 0]\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    let rest = simulated.scene.body.mesh.vertices.clone();
    let u = simulated.solution.u.clone();
    let at = simulated.problem.iterate(&rest, &u, 1.0);
    let balance = results::balance(&simulated.problem, &at);
    let number = |key: &str, k: usize| balance.resultants[key][k];
    // the chambers are centred in the bar, so ∫ x dX is volume times half its length
    let weight = -1e5 * 0.035 * (63.0 - 3.0) * 1e-6;
    assert!((number("body_force", 2) / weight - 1.0).abs() < 1e-12, "{balance:?}");
    let pull = 1e6 * (0.07_f64.powi(2) / 2.0) * (0.03_f64.powi(2) / 2.0);
    assert!((number("traction", 0) / pull - 1.0).abs() < 1e-12, "{balance:?}");
    assert!(balance.out_of_balance < 1e-9, "{balance:?}");
}
