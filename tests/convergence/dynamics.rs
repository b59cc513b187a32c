//! Inertia and time integration against closed forms.

use mesh::Vec3;
use tests::motion::{Motion, SILICONE, begin};
use tests::{block, tag};

fn cube() -> mechanics::body::Body {
    let cube = block([2, 2, 2], 0.01, |_| false, |p| p + 1e-3 * Vec3::new(p.y, p.z, -p.x));
    tag(cube, &[("bottom", &|p| p.z < 2e-4), ("skin", &|_| true)])
}

fn time(method: &str, end: f64, steps: usize) -> String {
    format!("[time]\nmethod = \"{method}\"\nend = {end:e}\nsteps = {steps}\n")
}

#[test]
fn free_fall_is_the_recursion_of_implicit_euler() {
    let text = format!(
        "mesh = \"cube.msh\"\ngravity = [0, 0, -9.8]\n{SILICONE}{}",
        time("implicit-euler", 0.1, 10)
    );
    let mut fall = begin(&[("cube", &cube())], &[], &text);
    for n in 1..=10_u32 {
        fall.go(1);
        let expected = -0.5 * 9.8 * 1e-4 * f64::from(n * (n + 1));
        let worst = fall.u().chunks(3).map(|u| (u[2] / expected - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "step {n}: {worst:e}");
    }
    let report = fall.report();
    let mass: f64 = 1000.0 * tests_volume(&fall);
    let momentum = report["momentum"][2].as_f64().unwrap();
    assert!((momentum / (-9.8 * 0.1 * mass) - 1.0).abs() < 1e-9, "{momentum}");
    assert!(report["force_balance"]["out_of_balance"].as_f64().unwrap() < 1e-9 * 9.8 * mass);
}

fn tests_volume(motion: &Motion) -> f64 {
    let body = &motion.scene.body;
    let volume = |t: &[usize; 4]| {
        let [a, b, c, d] = t.map(|v| body.mesh.vertices[v]);
        mesh::measure::tet_volume(a, b, c, d)
    };
    body.mesh.tets.iter().map(volume).sum()
}

/// A cube on a fixed bottom is released under gravity and swings; halving the
/// step shows the order.
#[test]
#[ignore = "seven seconds: runs in make test-all"]
fn methods_have_their_order_in_the_length_of_the_step() {
    for (method, order, first) in [
        ("implicit-euler", 1.0, 80),
        ("bdf2", 2.0, 80),
        ("bdf3", 3.0, 160),
        ("newmark", 2.0, 80),
        ("generalized-alpha", 2.0, 80),
    ] {
        let height = |steps: usize| {
            // grows smoothly from nothing, so that the start is no kink
            let text = format!(
                "mesh = \"cube.msh\"\ndegree = 1\ngravity = [\"100*sin(150*t)^4\", 0, 0]\n{SILICONE}\
                 [[fixed]]\non = \"bottom\"\n{}",
                time(method, 0.01, steps)
            );
            let mut swing = begin(&[("cube", &cube())], &[], &text);
            swing.go(steps);
            swing.momentum(swing.u()).x
        };
        let values = [first, 2 * first, 4 * first].map(height);
        let slope = ((values[1] - values[0]) / (values[2] - values[1])).abs().log2();
        eprintln!("{method}: order {slope:.2}");
        assert!((slope - order).abs() < 0.25, "{method}: {slope} of {values:?}");
    }
}

/// Without forces from outside momentum stays, and implicit Euler gives no
/// energy away but what it damps.
#[test]
fn a_free_body_keeps_its_momentum() {
    let text = format!(
        "[[body]]\nname = \"cube\"\nmesh = \"cube.msh\"\nvelocity = [0.3, -0.2, 0.1]\n{SILICONE}{}",
        time("bdf2", 0.02, 10)
    );
    let mut flight = begin(&[("cube", &cube())], &[], &text);
    let start = flight.momentum(flight.v());
    flight.go(10);
    let end = flight.momentum(flight.v());
    assert!((end - start).norm() < 1e-9 * start.norm(), "{start} {end}");
    let expected = 0.02 * Vec3::new(0.3, -0.2, 0.1);
    assert!(flight.u().chunks(3).all(|u| (Vec3::from_column_slice(u) - expected).norm() < 1e-10));
}
