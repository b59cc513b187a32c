//! A ball pressed between two rigid plates, against Hertz.

use std::f64::consts::FRAC_PI_2;

use mechanics::element::at;
use mesh::{TetMesh, Vec3};
use tests::meshes::{extrude, triangle};
use tests::motion::begin;
use tests::{plate, tag};

/// Radius of the ball [m].
const RADIUS: f64 = 0.01;
/// Radius of the contact over that of the ball, by Hertz.
const CONTACT: f64 = 0.06;
const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;

/// The quarter x, y ≥ 0 of the half ball below z = 0. Facets at the pole have
/// edges of `fine`; their number is `even` as far as 1.5 times the contact, and
/// beyond they grow by a factor, as the layers do with the depth.
fn quarter(even: usize, growth: f64) -> TetMesh {
    let fine = 1.5 * CONTACT / even as f64;
    // angles of the rings from the pole
    let mut rings: Vec<f64> = (0..=even).map(|i| fine * i as f64).collect();
    let mut edge = fine;
    while rings[rings.len() - 1] < FRAC_PI_2 {
        edge *= growth;
        rings.push(rings[rings.len() - 1] + edge);
    }
    let n = rings.len() - 1;
    // the last ones share what is left, and stay off the equator
    let graded = rings[even];
    let scale = (1.4 - graded) / (rings[n] - graded);
    rings[even + 1..].iter_mut().for_each(|a| *a = graded + scale * (*a - graded));
    let mut depths = vec![0.0];
    let mut thickness = fine;
    while depths[depths.len() - 1] < 1.0 {
        depths.push(depths[depths.len() - 1] + thickness);
        thickness *= growth;
    }
    let layers = depths.len() - 1;
    extrude(&triangle(n), layers, |[s, t], h| {
        let ring = ((s + t) * n as f64).round() as usize;
        let turn = if ring == 0 { 0.0 } else { FRAC_PI_2 * t / (s + t) };
        let (angle, depth) = (rings[ring], depths[(h * layers as f64).round() as usize]);
        let depth = depth / depths[layers];
        let (skin, flat) = ((angle.sin(), -angle.cos()), angle / rings[n]);
        let (r, z) = (skin.0 + depth * (flat - skin.0), skin.1 * (1.0 - depth));
        RADIUS * Vec3::new(r * turn.cos(), r * turn.sin(), z)
    })
}

/// Presses a ball and compares with Hertz.
fn press(even: usize, growth: f64) {
    let clock = std::time::Instant::now();
    let mesh = quarter(even, growth);
    let tets = mesh.tets.len();
    let near = 1e-9 * RADIUS;
    let ball = tag(
        mesh,
        &[
            ("left", &|p| p.x < near),
            ("front", &|p| p.y < near),
            ("equator", &|p| p.z > -near),
            ("skin", &|_| true),
        ],
    );
    let approach = CONTACT * CONTACT * RADIUS;
    let activation = approach / 50.0;
    let (side, height) = (2.0 * RADIUS, -RADIUS - activation);
    let plate = plate([-side, side], [-side, 1.1 * side], height);
    let text = format!(
        "degree = 2\n[[body]]\nname = \"ball\"\nmesh = \"ball.msh\"\n\
         material = {{ kind = \"neo-hookean\", young = {YOUNG:e}, poisson = {POISSON} }}\n\
         [[fixed]]\non = \"ball.left\"\ncomponents = \"x\"\n\
         [[fixed]]\non = \"ball.front\"\ncomponents = \"y\"\n\
         [[fixed]]\non = \"ball.equator\"\ncomponents = \"z\"\n\
         [[obstacle]]\nname = \"plate\"\nsurface = \"plate.stl\"\n\
         displacement = [0, 0, {:e}]\n\
         [contact]\nactivation = {activation:e}\nstiffness = {YOUNG:e}\n\
         [solver]\nfirst_load_step = 0.01\n",
        approach + activation
    );
    let mut press = begin(&[("ball", &ball)], &[("plate", &plate)], &text);
    press.go(1);
    let force = 4.0 * press.force_by("plate", "contact").z;
    let nodes = press.problem.space.node_positions(&press.scene.body.mesh.vertices);
    let pole = nodes.iter().position(|x| (x + Vec3::new(0.0, 0.0, RADIUS)).norm() < near);
    let delta = at(press.u(), pole.unwrap()).z;
    // ∫ p r² dA = 2/5 a² F of Hertz's pressure
    let field = press.contact_field();
    let (mut moment, mut sum) = (0.0, 0.0);
    for (node, x) in nodes.iter().enumerate() {
        let x = x + at(press.u(), node);
        moment += at(&field, node).z * (x.x * x.x + x.y * x.y);
        sum += at(&field, node).z;
    }
    let radius = (2.5 * moment / sum).sqrt();
    let modulus = YOUNG / (1.0 - POISSON * POISSON);
    let by_approach = 4.0 / 3.0 * modulus * RADIUS.sqrt() * delta.powf(1.5);
    let by_radius = 4.0 / 3.0 * modulus * radius.powi(3) / RADIUS;
    eprintln!(
        "Hertz, {tets} tetrahedra P2: force {:.4} of that by the approach, {:.4} of that by \
         the radius; radius {:.4} of √(R δ) = {:.3} R; {} Newton iterations, {:.1} s",
        force / by_approach,
        force / by_radius,
        radius / (RADIUS * delta).sqrt(),
        (delta / RADIUS).sqrt(),
        press.stepper.progress.newton_iterations,
        clock.elapsed().as_secs_f64()
    );
    assert!((force / by_approach - 1.0).abs() < 0.05, "{force} {by_approach}");
    assert!((radius / (RADIUS * delta).sqrt() - 1.0).abs() < 0.05, "{radius}");
}

#[test]
#[ignore = "ten seconds: runs in make test-all"]
fn a_ball_on_a_plate_follows_hertz() {
    press(4, 1.6);
}

#[test]
#[ignore = "takes a minute"]
fn a_finer_one_does_so_closer() {
    press(6, 1.5);
}
