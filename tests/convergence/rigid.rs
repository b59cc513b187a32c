//! Rigid bodies in contact against closed forms: rolling, sliding, and at rest on each other.

use std::f64::consts::{PI, TAU};

use mechanics::body::Body;
use mesh::{SurfaceMesh, Vec3};
use tests::motion::{Motion, SILICONE, begin};
use tests::{block, plate, tag};

const G: f64 = 9.8;
/// Edge of the block, and radius of the roll [m].
const EDGE: f64 = 0.01;
/// d̂ [m].
const ACTIVATION: f64 = 1e-4;

fn cube() -> Body {
    tag(block([1, 1, 1], EDGE, |_| false, |p| p), &[("skin", &|_| true)])
}

/// A prism of 32 sides around the y axis, which touches z = 0.
fn roll() -> Body {
    const CELLS: usize = 8;
    let round = |p: Vec3| {
        let [x, z] = [p.x, p.z].map(|c| 2.0 * c / CELLS as f64 - 1.0);
        let radius = x.abs().max(z.abs());
        // along the square of that radius, a side for each quarter
        let angle = match radius {
            0.0 => 0.0,
            r if z == -r => 0.25 * PI * (x / r),
            r if x == r => 0.25 * PI * (2.0 + z / r),
            r if z == r => 0.25 * PI * (4.0 - x / r),
            r => 0.25 * PI * (6.0 - z / r),
        };
        let (sin, cos) = angle.sin_cos();
        EDGE * Vec3::new(radius * sin, 0.5 * p.y, 1.0 - radius * cos)
    };
    tag(block([CELLS, 1, CELLS], 1.0, |_| false, round), &[("skin", &|_| true)])
}

/// The square of 0.4 m around the origin in the plane z = 0.
fn floor() -> SurfaceMesh {
    plate([-0.2, 0.2], [-0.2, 0.22], 0.0)
}

/// A rigid body of the text, one above it if there is, and a floor below.
fn scene(
    gravity: Vec3,
    height: f64,
    velocity: f64,
    friction: f64,
    dt: f64,
    steps: usize,
) -> String {
    let [x, y, z] = gravity.into();
    format!(
        "degree = 1\ngravity = [{x:e}, {y:e}, {z:e}]\n[[body]]\nname = \"body\"\nmesh = \"body.msh\"\n\
         translate = [-0.05, -0.1, {height:e}]\nvelocity = [{velocity:e}, 0, 0]\n{SILICONE}\
         [[rigid]]\non = \"body\"\n[[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
         [contact]\nactivation = {ACTIVATION:e}\nstiffness = 1e5\nfriction = {friction:e}\n\
         [time]\nend = {:e}\nsteps = {steps}\nmethod = \"generalized-alpha\"\n",
        dt * steps as f64
    )
}

fn mass(motion: &Motion) -> f64 {
    let one = vec![1.0; motion.u().len()];
    motion.momentum(&one).x
}

fn mean_x(motion: &Motion, field: &[f64]) -> f64 {
    motion.momentum(field).x / mass(motion)
}

/// a = g sin α / (1 + k²/r²): a prism of n sides has k² = R²/6 (2 + cos 2π/n). Its corners would hit the floor one by one and
/// lose energy each time; on a soft barrier, wider than the sides are deep, several bear it at once.
#[test]
fn a_rigid_roll_rolls_down_an_incline() {
    let (angle, dt, steps) = (0.15_f64, 5e-4, 480);
    let gravity = G * Vec3::new(angle.sin(), 0.0, -angle.cos());
    let text = scene(gravity, 6e-4, 0.0, 0.5, dt, steps)
        .replace(&format!("activation = {ACTIVATION:e}"), "activation = 1e-3")
        .replace("stiffness = 1e5", "stiffness = 1e3");
    let mut motion = begin(&[("body", &roll())], &[("floor", &floor())], &text);
    motion.go(steps / 3);
    let before = mean_x(&motion, motion.v());
    motion.go(2 * steps / 3);
    let after = mean_x(&motion, motion.v());
    let found = (after - before) / (dt * (2 * steps / 3) as f64);
    let sides = TAU / 32.0;
    let inertia = (2.0 + sides.cos()) / 6.0;
    let expected = G * angle.sin() / (1.0 + inertia / (0.5 * sides).cos());
    let turned = motion.report()["rigid"]["body"]["rotation"][1].as_f64().unwrap();
    let way = mean_x(&motion, motion.u());
    eprintln!(
        "rolling: {found:.4} m/s², expected {expected:.4}; turned by {turned:.3} over {:.2} mm",
        1e3 * way
    );
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    // it does not slip, and turns as it goes
    assert!((way / EDGE - turned).abs() < 0.02 * turned, "{way} {turned}");
}

#[test]
fn a_rigid_block_slides_until_its_energy_is_used_up() {
    let (friction, start, dt, steps) = (0.3, 0.2, 5e-4, 200);
    let text = scene(Vec3::new(0.0, 0.0, -G), 0.99 * ACTIVATION, start, friction, dt, steps);
    let mut motion = begin(&[("body", &cube())], &[("floor", &floor())], &text);
    motion.go(steps);
    let (way, expected) = (mean_x(&motion, motion.u()), start * start / (2.0 * friction * G));
    eprintln!("sliding: {:.3} mm, expected {:.3} mm", 1e3 * way, 1e3 * expected);
    assert!((way / expected - 1.0).abs() < 0.03, "{way} {expected}");
}

/// The upper of two rigid blocks presses with its weight, the lower with that of both.
#[test]
fn rigid_blocks_rest_on_each_other() {
    let (dt, steps) = (0.005, 80);
    let mut text = scene(Vec3::new(0.0, 0.0, -G), 0.99 * ACTIVATION, 0.0, 0.0, dt, steps);
    let upper = format!(
        "[[body]]\nname = \"upper\"\nmesh = \"upper.msh\"\ntranslate = [-0.05, -0.1, {:e}]\n{SILICONE}\
         [[rigid]]\non = \"upper\"\n[[rigid]]",
        EDGE + 1.98 * ACTIVATION
    );
    text = text.replacen("[[rigid]]", &upper, 1);
    let mut motion = begin(&[("body", &cube()), ("upper", &cube())], &[("floor", &floor())], &text);
    motion.go(steps);
    let weight = 1000.0 * EDGE.powi(3) * G;
    let report = motion.report();
    let forces = report["collisions"]["contact"].as_array().unwrap();
    let size = |other: &str| {
        let of = |f: &&serde_json::Value| f["bodies"].as_array().unwrap().contains(&other.into());
        forces.iter().find(of).expect("they touch")["force"][2].as_f64().unwrap().abs()
    };
    for (other, expected) in [("floor", 2.0 * weight), ("upper", weight)] {
        let found = size(other);
        eprintln!("at rest: {found:.6e} N on {other}, expected {expected:.6e} N");
        assert!((found / expected - 1.0).abs() < 1e-4, "{other}: {found} {expected}");
    }
}
