//! Supports that move into something within one time step: the straight path is
//! blocked, so they are pulled (augmented Lagrangian), and what they meet is pushed along.

use mechanics::body::Body;
use mechanics::element::at;
use mechanics::energy::Iterate;
use mesh::Vec3;
use tests::motion::{Motion, SILICONE, begin};
use tests::{block, tag};

const EDGE: f64 = 0.02;
/// d̂ [m].
const ACTIVATION: f64 = 1e-4;

/// A cube with its lower and its upper end.
fn cube(cells: usize) -> Body {
    let mesh = block([cells; 3], EDGE / cells as f64, |_| false, |p| p);
    let (low, high) = (1e-6, EDGE - 1e-6);
    tag(
        mesh,
        &[("low", &|p: Vec3| p.z < low), ("high", &|p: Vec3| p.z > high), ("sides", &|_| true)],
    )
}

/// Goes to the end; how much of the straight path there is free, and the number of
/// load steps.
fn go(motion: &mut Motion) -> (f64, usize) {
    let rest = motion.scene.body.mesh.vertices.clone();
    let (still, end) = (vec![0.0; motion.problem.dofs()], *motion.scene.times().last().unwrap());
    let from = motion.problem.iterate(&rest, &still, 0.0);
    let to = Iterate { time: end, ..from };
    let straight = motion.workspace.move_supports(&motion.problem, &to);
    let free = motion.problem.max_step(&from, &Iterate { u: &straight, ..to });
    let count = motion.scene.times().len();
    (free, motion.go(count))
}

/// Largest difference of two displacements over the largest of the first.
fn apart(a: &Motion, b: &Motion) -> f64 {
    let largest = |w: &[f64]| (0..w.len() / 3).map(|n| at(w, n).norm()).fold(0.0, f64::max);
    let off: Vec<f64> = a.u().iter().zip(b.u()).map(|(a, b)| a - b).collect();
    largest(&off) / largest(a.u())
}

/// A body that is moved as a whole meets another one at rest, and covers it: with edges
/// 0.2 mm from each other there were several equilibria (energies 5.1182 and 5.1188 mJ).
#[test]
fn a_block_moved_onto_a_body_by_more_than_the_gap() {
    let mut wide = cube(3);
    wide.mesh.vertices.iter_mut().for_each(|x| *x *= 2.0);
    let run = |end: f64, time: &str| {
        let text = format!(
            "degree = 1\n[[body]]\nname = \"lower\"\nmesh = \"cube.msh\"\n{SILICONE}\
             [[body]]\nname = \"block\"\nmesh = \"wide.msh\"\n\
             translate = [-9e-3, -8e-3, {:e}]\n{SILICONE}\
             [[fixed]]\non = \"lower.low\"\n\
             [[fixed]]\non = \"block\"\ndisplacement = [0, 0, \"-{:e}*t\"]\n\
             [contact]\nactivation = {ACTIVATION:e}\nstiffness = 1e5\n\
             [time]\nend = {end:e}\n{time}\n[solver]\nfirst_load_step = 1.0\n",
            EDGE + 1e-3,
            3e-3 / end
        );
        let mut motion = begin(&[("cube", &cube(3)), ("wide", &wide)], &[], &text);
        let (free, load_steps) = go(&mut motion);
        assert!(free < 0.35, "{free}");
        (motion, load_steps)
    };
    let quasistatic =
        |steps: usize| run(1.0, &format!("method = \"quasistatic\"\nsteps = {steps}"));
    let (one, load_steps) = quasistatic(1);
    let (many, _) = quasistatic(40);
    let apart = apart(&one, &many);
    eprintln!(
        "block moved onto a body: {load_steps} load step, {} Newton iterations; in 40: {}; \
         {apart:.1e} apart",
        one.stepper.progress.newton_iterations, many.stepper.progress.newton_iterations
    );
    assert_eq!(load_steps, 1);
    assert!(apart < 1e-6, "{apart:e}");

    let (mut fast, load_steps) = run(0.05, "steps = 1");
    let gap = fast.report()["collisions"]["smallest_gap"].as_f64().unwrap();
    eprintln!("the same in a step of 50 ms with inertia: {load_steps} load step, gap {gap:.3}");
    assert!(load_steps == 1 && gap > 0.0 && gap < 1.0, "{load_steps} {gap}");
}
