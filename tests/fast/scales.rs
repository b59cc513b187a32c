//! A scene in other units is the same scene: with moduli and loads, or lengths, a million times smaller or
//! larger it takes the same Newton iterations, and its displacements are those of the scene times the
//! factor, bit for bit, as all factors are powers of two. Forces are then 1e-18 to 1e18 times as large.

use mechanics::body::Body;
use mesh::Vec3;
use mesh::io::{npy, write_surface, write_tets};
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;
use tests::{block, plate, tag};

/// About a million.
const MILLION: f64 = 1048576.0;
/// Factors of moduli and of lengths.
const SCALES: [[f64; 2]; 6] = [
    [1.0 / MILLION, 1.0],
    [MILLION, 1.0],
    [1.0, 1.0 / MILLION],
    [1.0, MILLION],
    [1.0 / MILLION, 1.0 / MILLION],
    [MILLION, MILLION],
];

/// Displacements, and of each step the Newton iterations.
fn run(dir: &Workdir, body: &Body, scene: &str, length: f64) -> (Vec<f64>, Vec<Value>) {
    let mut mesh = body.mesh.clone();
    mesh.vertices.iter_mut().for_each(|x| *x *= length);
    write_tets(&dir.path("body.msh"), &mesh, &body.tags).unwrap();
    let floor = plate([-length, length], [-length, 1.1 * length], 0.0);
    write_surface(&dir.path("floor.ply"), &floor).unwrap();
    dir.write("sim.toml", scene);
    let report = dir.report("simulate sim.toml -o out --restart --threads 1");
    assert_eq!(report["tolerance_met"], true, "{report}");
    let (u, _) = npy::read_f64(&dir.path("out/displacement.npy")).unwrap();
    let steps = report["steps"].as_array().unwrap();
    (u, steps.iter().map(|step| step["newton_iterations"].clone()).collect())
}

fn check(body: &Body, scene: impl Fn(f64, f64) -> String) {
    let dir = Workdir::new();
    let (u, iterations) = run(&dir, body, &scene(1.0, 1.0), 1.0);
    assert!(u.iter().any(|u| *u != 0.0) && iterations.iter().any(|n| *n != 0));
    for [modulus, length] in SCALES {
        let (scaled, same) = run(&dir, body, &scene(modulus, length), length);
        assert_eq!(same, iterations, "modulus × {modulus}, length × {length}");
        let off = u.iter().zip(&scaled).position(|(u, scaled)| u * length != *scaled);
        assert_eq!(off, None, "modulus × {modulus}, length × {length}");
    }
}

/// A chamber under pressure that is pulled at its top, moved at its seat and weighs something.
#[test]
fn a_static_scene() {
    check(&chamber::chamber(), |modulus, length| {
        format!(
            "mesh = \"body.msh\"\ngravity = [0, 0, -9.81]\n\
             [material]\nkind = \"mooney-rivlin\"\nc1 = {:e}\nc2 = {:e}\nc3 = {:e}\nd1 = {:e}\n\
             density = {:e}\n\
             [[fixed]]\non = \"seat\"\ndisplacement = [{:e}, 0, 0]\n\
             [[chamber]]\non = \"cavity\"\npressure = {:e}\n\
             [[traction]]\non = \"top\"\ntraction = [0, 0, {:e}]\n",
            modulus * 55e3,
            modulus * 5e3,
            modulus * 1.7e3,
            modulus * 1e6,
            modulus / length * 1070.0,
            length * 1e-3,
            modulus * 8e3,
            modulus * 500.0
        )
    });
}

/// A block that falls on a floor and slides there, with inertia and friction.
#[test]
fn a_scene_in_time_with_contact() {
    let mesh = block([2, 2, 2], 5e-3, |_| false, |p| p + Vec3::new(0.0, 0.0, 3e-4));
    check(&tag(mesh, &[("skin", &|_| true)]), |modulus, length| {
        format!(
            "degree = 1\ngravity = [0, 0, {:e}]\n[[body]]\nname = \"block\"\nmesh = \"body.msh\"\n\
             velocity = [{:e}, 0, {:e}]\n\
             material = {{ kind = \"neo-hookean\", young = {:e}, poisson = 0.35, density = {:e} }}\n\
             [[obstacle]]\nname = \"floor\"\nsurface = \"floor.ply\"\n\
             [contact]\nactivation = {:e}\nstiffness = {:e}\nfriction = 0.3\nfriction_speed = {:e}\n\
             [time]\nend = 4e-3\nsteps = 8\n",
            length * -9.81,
            length * 0.1,
            length * -0.2,
            modulus * 1e5,
            modulus / (length * length) * 1000.0,
            length * 2e-4,
            modulus * 1e5,
            length * 1e-3
        )
    });
}
