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
    dir.solver("simulate sim.toml -o out --restart --threads 1").assert_good();
    let report = dir.json("out/report.json");
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

/// Loads of less than 1e-10 N on a body of ordinary size and stiffness: linear, and as accurate.
#[test]
fn tiny_loads() {
    let dir = Workdir::new();
    let scene = |pull: f64| {
        format!(
            "mesh = \"body.msh\"\n[material]\nkind = \"neo-hookean\"\nyoung = 1e5\npoisson = 0.45\n\
             [[fixed]]\non = \"seat\"\n[[traction]]\non = \"top\"\ntraction = [0, 0, {pull:e}]\n"
        )
    };
    let [(u, _), (tiny, iterations)] =
        [1e-4, 1e-9].map(|pull| run(&dir, &chamber::chamber(), &scene(pull), 1.0));
    assert!(iterations[0].as_u64().unwrap() > 0, "{iterations:?}");
    let size = |u: &[f64]| u.iter().map(|u| u * u).sum::<f64>().sqrt();
    let off: Vec<f64> = u.iter().zip(&tiny).map(|(u, tiny)| u - 1e5 * tiny).collect();
    // a strain of 1e-9 leaves that much that is not linear; forces are 1e-6 accurate
    assert!(size(&off) < 2e-6 * size(&u), "{}", size(&off) / size(&u));
}

/// A load that comes and goes: what is left where there is none, and Newton's method still ends.
#[test]
fn a_load_that_goes() {
    let dir = Workdir::new();
    let scene = "mesh = \"body.msh\"\n[material]\nkind = \"neo-hookean\"\nyoung = 1e5\npoisson = 0.45\n\
                 [[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\n\
                 pressure = \"3e3 * t * (2 - t)\"\n\
                 [time]\nend = 3\nsteps = 3\nmethod = \"quasistatic\"\n";
    let scene = scene.replace("t * (2 - t)", "max(t * (2 - t), 0)");
    let (u, iterations) = run(&dir, &chamber::chamber(), &scene, 1.0);
    assert!(
        u.iter().all(|u| u.abs() < 1e-14),
        "{:e}",
        u.iter().fold(0.0_f64, |m, u| m.max(u.abs()))
    );
    assert!(iterations.iter().all(|n| n.as_u64().unwrap() < 12), "{iterations:?}");
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
