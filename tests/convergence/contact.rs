//! Contact and friction against closed forms.

use std::f64::consts::{PI, TAU};

use mechanics::body::Body;
use mechanics::contact::barrier::{Barrier, Form};
use mechanics::contact::density::Density;
use mesh::{SurfaceMesh, Vec3};
use tests::motion::{Motion, SILICONE, begin};
use tests::{block, plate, tag};

const G: f64 = 9.8;
/// Edge of the block, and radius of the roll [m].
const EDGE: f64 = 0.01;
const MASS: f64 = 1000.0 * EDGE * EDGE * EDGE;
/// d̂ [m].
const ACTIVATION: f64 = 1e-4;

/// Gap / d̂ at the start of a block on a floor, about where its weight is carried:
/// friction of the first step has the normal force of the start.
const START: f64 = 0.991;

fn cube() -> Body {
    tag(block([2, 2, 2], EDGE / 2.0, |_| false, |p| p), &[("skin", &|_| true)])
}

/// The square of 0.4 m around the origin in the plane z = 0.
fn floor() -> SurfaceMesh {
    plate([-0.2, 0.2], [-0.2, 0.22], 0.0)
}

/// A block just above a floor, in a field of gravity and with a velocity. No edge
/// of the floor is below it on its path.
fn on_floor(gravity: Vec3, velocity: f64, friction: f64, dt: f64, steps: usize) -> Motion {
    let [x, y, z] = gravity.into();
    let text = format!(
        "degree = 1\ngravity = [{x:e}, {y:e}, {z:e}]\n[[body]]\nname = \"block\"\n\
         mesh = \"block.msh\"\ntranslate = [-0.05, -0.1, {:e}]\nvelocity = [{velocity:e}, 0, 0]\n\
         {SILICONE}[[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
         [contact]\nactivation = {ACTIVATION:e}\nstiffness = 1e5\nfriction = {friction:e}\n\
         [time]\nend = {:e}\nsteps = {steps}\n",
        START * ACTIVATION,
        dt * steps as f64
    );
    begin(&[("block", &cube())], &[("floor", &floor())], &text)
}

/// Gap / d̂ at which vertices alone carry a pressure [Pa]. They are a quarter of
/// the potential; the floor has no vertices there, another quarter, and no edges,
/// half of it.
fn gap_under(pressure: f64) -> f64 {
    let barrier = Barrier {
        form: Form::Convergent,
        density: Density::Log,
        activation: ACTIVATION,
        stiffness: 1e5,
        thickness: 0.0,
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let gap = f64::midpoint(low, high);
        let d = gap * ACTIVATION;
        let push = -0.25 * barrier.scale() * barrier.repulsion().at(d * d)[1] * 2.0 * d;
        if push > pressure { low = gap } else { high = gap }
    }
    low
}

/// Mean velocity of the block along x [m/s].
fn speed(motion: &Motion) -> f64 {
    motion.momentum(motion.v()).x / MASS
}

#[test]
fn a_resting_block_presses_with_its_weight_whatever_the_step() {
    for dt in [0.01, 0.005, 0.0025] {
        let steps = (0.4 / dt) as usize;
        let mut rest = on_floor(Vec3::new(0.0, 0.0, -G), 0.0, 0.0, dt, steps);
        rest.go(steps);
        let force = rest.force_by("floor", "contact");
        let gap = rest.report()["collisions"]["smallest_gap"].as_f64().unwrap();
        eprintln!(
            "resting block, step {dt} s: {:.6} of its weight, gap {gap:.4}",
            force.z / (MASS * G)
        );
        assert!((force.z / (MASS * G) - 1.0).abs() < 1e-4, "{force}");
        assert!(force.xy().norm() < 1e-6 * MASS * G, "{force}");
        assert!((gap - gap_under(MASS * G / EDGE.powi(2))).abs() < 2e-4, "{gap}");
    }
}

#[test]
fn on_an_incline_a_block_creeps_or_slides_as_the_laws_say() {
    let (friction, full) = (0.5, 1e-3);
    for r in [0.5, 0.9, 2.0] {
        let angle = f64::atan(r * friction);
        let gravity = G * Vec3::new(angle.sin(), 0.0, -angle.cos());
        let (dt, steps) = (0.002, 100);
        let mut slide = on_floor(gravity, 0.0, friction, dt, steps);
        slide.go(steps / 2);
        let before = speed(&slide);
        slide.go(steps / 2);
        let after = speed(&slide);
        let (found, expected, what) = if r < 1.0 {
            (after, full * (1.0 - f64::sqrt(1.0 - r)), "creep speed")
        } else {
            let acceleration = (after - before) / (dt * (steps / 2) as f64);
            (acceleration, G * (angle.sin() - friction * angle.cos()), "acceleration")
        };
        eprintln!("incline r = {r}: {what} {found:.6}, expected {expected:.6}");
        assert!((found / expected - 1.0).abs() < 0.02, "r = {r}: {found} {expected}");
    }
}

/// Two blocks meet in flight, one vertex first.
#[test]
fn bodies_that_collide_in_flight_keep_their_momentum() {
    // the rows of a rotation
    let [a, b] = [Vec3::new(2.0, 1.0, 2.0) / 3.0, Vec3::new(-2.0, 2.0, 1.0) / 3.0];
    let turn = |p: Vec3| Vec3::new(a.dot(&p), b.dot(&p), a.cross(&b).dot(&p));
    let tilted = tag(block([2, 2, 2], EDGE / 2.0, |_| false, turn), &[("skin", &|_| true)]);
    let text = format!(
        "degree = 1\n[[body]]\nname = \"a\"\nmesh = \"a.msh\"\nvelocity = [0.5, 0, 0]\n{SILICONE}\
         [[body]]\nname = \"b\"\nmesh = \"b.msh\"\ntranslate = [0.016, 0, 0]\n\
         velocity = [-0.3, 0.1, 0]\n{SILICONE}\
         [contact]\nactivation = 1e-4\nstiffness = 1e5\nfriction = 0.4\n\
         [time]\nend = 0.05\nsteps = 50\n"
    );
    let mut flight = begin(&[("a", &cube()), ("b", &tilted)], &[], &text);
    let start = flight.momentum(flight.v());
    let mut touched = 0;
    for _ in 0..50 {
        flight.go(1);
        touched += usize::from(!flight.report()["collisions"]["smallest_gap"].is_null());
    }
    let end = flight.momentum(flight.v());
    eprintln!(
        "collision: in contact for {touched} of 50 steps, momentum kept to {:.1e}",
        (end - start).norm() / start.norm()
    );
    assert!(touched > 3 && touched < 50, "{touched}");
    assert!((end - start).norm() < 1e-8 * start.norm(), "{start} {end}");
}

/// Nothing holds the block but the plates, one of which comes down by 2 %.
#[test]
fn a_loose_block_between_plates_is_in_balance_without_inertia() {
    // the gaps are larger where rims of the block add to areas, so they must be small
    let activation = 0.1 * ACTIVATION;
    let start = 0.5 * activation;
    let at = |z: f64| plate([-0.2, 0.2], [-0.2, 0.22], z);
    for time in ["", "[time]\nmethod = \"quasistatic\"\nend = 1.0\nsteps = 4\n"] {
        let text = format!(
            "degree = 1\n[[body]]\nname = \"block\"\nmesh = \"block.msh\"\n{SILICONE}\
             [[obstacle]]\nname = \"low\"\nsurface = \"low.stl\"\n\
             [[obstacle]]\nname = \"high\"\nsurface = \"high.stl\"\n\
             displacement = [0, 0, \"-{:e}*t\"]\n\
             [contact]\nactivation = {activation:e}\nstiffness = 1e5\n{time}",
            0.02 * EDGE
        );
        let plates = [("low", &at(-start)), ("high", &at(EDGE + start))];
        let mut press = begin(&[("block", &cube())], &plates, &text);
        press.go(press.scene.times().len());
        let forces = ["low", "high"].map(|plate| press.force_by(plate, "contact").z);
        let heights = |top: bool| {
            let nodes = press.scene.body.mesh.vertices.iter().zip(press.u().chunks(3));
            let level = |x: f64| (x > 0.99 * EDGE) == top && (x < 0.01 * EDGE) != top;
            nodes.filter(|(x, _)| level(x.z)).map(|(x, u)| x.z + u[2]).collect::<Vec<f64>>()
        };
        let mean = |v: Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
        let stretch = (mean(heights(true)) - mean(heights(false))) / EDGE;
        let expected = 1e-4 * uniaxial_stress(stretch);
        eprintln!(
            "loose block, {} steps: stretch {stretch:.5}, forces {:.6} and {:.6} N, expected {expected:.6}",
            press.scene.times().len(),
            forces[0],
            forces[1]
        );
        // the tiny mass carries what is left: by its rule a thousandth of the weight per centimetre
        assert!((forces[0] + forces[1]).abs() < 1e-3 * MASS * G, "{forces:?}");
        assert!((forces[0] / expected - 1.0).abs() < 2e-3, "{forces:?} {expected}");
        let out = press.report()["force_balance"]["out_of_balance"].as_f64().unwrap();
        assert!(out < 1e-8 * expected, "{out}");
    }
}

/// Nominal pressure of the silicone at a uniaxial stretch [Pa], from
/// P = μ (λ − 1/λ) + Λ ln J / λ and the same across, where it is zero.
fn uniaxial_stress(stretch: f64) -> f64 {
    let (young, poisson) = (1e5, 0.35);
    let mu = young / (2.0 * (1.0 + poisson));
    let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let stress = |l: f64, j: f64| mu * (l - 1.0 / l) + lame * j.ln() / l;
    let (mut low, mut high) = (0.5, 2.0);
    for _ in 0..100 {
        let across = f64::midpoint(low, high);
        if stress(across, stretch * across * across) < 0.0 { low = across } else { high = across }
    }
    -stress(stretch, stretch * low * low)
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

/// a = g sin α / (1 + k²/r²): a prism of n sides has k² = R²/6 (2 + cos 2π/n). Its corners would hit the floor one by one and
/// lose energy each time; on a soft barrier, wider than the sides are deep, several bear it at once.
#[test]
fn a_rigid_roll_rolls_down_an_incline() {
    let (angle, dt, steps) = (0.15_f64, 5e-4, 480);
    let gravity = G * Vec3::new(angle.sin(), 0.0, -angle.cos());
    let [x, y, z] = gravity.into();
    let text = format!(
        "degree = 1\ngravity = [{x:e}, {y:e}, {z:e}]\n[[body]]\nname = \"body\"\nmesh = \"body.msh\"\n\
         translate = [-0.05, -0.1, 6e-4]\n{SILICONE}[[rigid]]\non = \"body\"\n\
         [[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
         [contact]\nactivation = 1e-3\nstiffness = 1e3\nfriction = 0.5\n\
         [time]\nend = {:e}\nsteps = {steps}\nmethod = \"generalized-alpha\"\n",
        dt * steps as f64
    );
    let mut motion = begin(&[("body", &roll())], &[("floor", &floor())], &text);
    motion.go(steps / 3);
    let one = vec![1.0; motion.u().len()];
    let mass = motion.momentum(&one).x;
    let before = motion.momentum(motion.v()).x / mass;
    motion.go(2 * steps / 3);
    let after = motion.momentum(motion.v()).x / mass;
    let found = (after - before) / (dt * (2 * steps / 3) as f64);
    let sides = TAU / 32.0;
    let inertia = (2.0 + sides.cos()) / 6.0;
    let expected = G * angle.sin() / (1.0 + inertia / (0.5 * sides).cos());
    let turned = motion.report()["rigid"]["body"]["rotation"][1].as_f64().unwrap();
    let way = motion.momentum(motion.u()).x / mass;
    eprintln!(
        "rolling: {found:.4} m/s², expected {expected:.4}; turned by {turned:.3} over {:.2} mm",
        1e3 * way
    );
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    // it does not slip, and turns as it goes
    assert!((way / EDGE - turned).abs() < 0.02 * turned, "{way} {turned}");
}
