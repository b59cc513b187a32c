//! Contact of bodies whose walls and slots are thinner than the activation.

use mesh::io::write_tets;
use mesh::{Tags, TetMesh, Vec3, topology};
use serde_json::{Value, json};
use tests::meshes::{ball, prisms};
use tests::workdir::Workdir;
use tests::{block, shared, tag};

/// Activation of contact [m]; edges of the surfaces are longer.
const ACTIVATION: f64 = 1.2e-3;

/// Writes a spherical shell of radius 1 cm around a chamber, with a wall of this thickness
/// [m], that sits on some of its facets.
fn write_shell(dir: &Workdir, wall: f64) {
    let ball = ball(1);
    let skin = topology::boundary(&ball).facets;
    let count = ball.vertices.len() - 1;
    let at = |radius: f64| ball.vertices[..count].iter().map(move |v| radius * v);
    let mesh = prisms(&skin, at(10e-3 - wall).chain(at(10e-3)).collect(), count);
    let mut tags = Tags::new(["chamber", "seat", "skin"].map(str::to_owned).to_vec());
    for facet in topology::boundary(&mesh).facets {
        let low = facet.iter().all(|&v| mesh.vertices[v].z < -6e-3);
        let outside = facet[0] >= count;
        tags.set(facet, if outside { if low { 2 } else { 3 } } else { 1 });
    }
    write_tets(&dir.path("body.msh"), &mesh, &tags).unwrap();
}

/// A ring that is cut open: both ends are 0.8 mm apart.
fn open_ring() -> TetMesh {
    let ends = |p: Vec3| {
        let at_cut = p.x > 7e-3 && p.z > 3e-3 && p.z < 9e-3;
        if at_cut { Vec3::new(p.x, p.y, 6e-3 + 0.2 * (p.z - 6e-3)) } else { p }
    };
    block([3, 1, 3], 4e-3, |c| c[2] == 1 && c[0] > 0, ends)
}

/// What a simulation reports; `contact` has more keys of the table, or there is none.
fn run(dir: &Workdir, mesh: &str, degree: usize, load: &str, contact: Option<&str>) -> Value {
    let word = if contact.is_none() { "contact = \"ignored\"" } else { "" };
    let keys = format!("[contact]\nactivation = {ACTIVATION}\nstiffness = 1e5\n");
    let table = contact.map_or_else(String::new, |more| keys + more);
    let text = format!(
        "mesh = \"{mesh}\"\ndegree = {degree}\n{word}\n\
         [material]\nkind = \"neo-hookean\"\nyoung = 1e5\npoisson = 0.4\n\
         [[fixed]]\non = \"seat\"\n{load}\n{table}\n"
    );
    dir.write("sim.toml", &text);
    dir.solver("simulate sim.toml -o out").assert_good();
    dir.json("out/report.json")
}

fn moved(report: &Value, tag: &str) -> f64 {
    report["tags"][tag]["max_displacement"].as_f64().unwrap()
}

fn pressure(pascal: f64) -> String {
    format!("[[chamber]]\non = \"chamber\"\npressure = {pascal}")
}

/// From a fifth of the activation to twice as thick.
#[test]
fn nothing_moves_without_load() {
    let dir = Workdir::new();
    for (wall, degree) in
        [(0.2, 1), (0.2, 2), (0.5, 1), (0.5, 2), (0.95, 1), (1.05, 2), (1.5, 1), (3.0, 1)]
    {
        write_shell(&dir, wall * ACTIVATION);
        let report = run(&dir, "body.msh", degree, &pressure(0.0), Some(""));
        assert_eq!(moved(&report, "skin"), 0.0, "wall {wall}, degree {degree}");
        let collisions = &report["steps"][0]["collisions"];
        assert!(collisions["pairs"] == 0 && collisions["contact"] == json!([]));
    }
    // as it was: the wall pushes itself apart
    write_shell(&dir, 0.5 * ACTIVATION);
    let all = run(&dir, "body.msh", 1, &pressure(0.0), Some("pairs = \"all\""));
    assert!(moved(&all, "skin") > 1e-5, "{}", moved(&all, "skin"));
}

/// Of a closed shell whose walls were half of the activation, and moved by 6.1 mm.
#[test]
fn the_shell_that_was_found_to_move_stays() {
    let Some(scene) = shared("data/hostile/third/barrier-through-wall/sim.toml") else { return };
    let dir = Workdir::new();
    dir.solver(&format!("simulate {} -o out", scene.display())).assert_good();
    assert_eq!(moved(&dir.json("out/report.json"), "skin"), 0.0);
}

/// The wall becomes thinner under pressure; without contact the state is the same.
#[test]
fn a_wall_under_pressure_is_as_without_contact() {
    let dir = Workdir::new();
    for wall in [0.5, 1.05] {
        write_shell(&dir, wall * ACTIVATION);
        let [with, without] = [Some(""), None].map(|contact| {
            let report = run(&dir, "body.msh", 1, &pressure(2e3), contact);
            (moved(&report, "skin"), report["chambers"]["chamber"]["volume"].as_f64().unwrap())
        });
        assert!(with.0 > 2e-4, "{with:?}");
        // both end at the tolerance of Newton's method
        assert!((with.0 / without.0 - 1.0).abs() < 1e-9, "{wall}: {with:?} {without:?}");
        assert!((with.1 / without.1 - 1.0).abs() < 1e-9, "{wall}: {with:?} {without:?}");
    }
}

#[test]
fn ends_of_an_open_ring_meet_at_less_than_their_distance_at_rest() {
    let dir = Workdir::new();
    let seat = |p: Vec3| p.z < 1e-9;
    let top = |p: Vec3| p.z > 12e-3 - 1e-9;
    let ring = tag(open_ring(), &[("seat", &seat), ("top", &top), ("skin", &|_| true)]);
    write_tets(&dir.path("ring.msh"), &ring.mesh, &ring.tags).unwrap();
    let press = |down: f64| format!("[[fixed]]\non = \"top\"\ndisplacement = [0, 0, {}]", -down);
    let collisions = |down: f64| {
        run(&dir, "ring.msh", 1, &press(down), Some(""))["steps"][0]["collisions"].clone()
    };
    // drawn apart
    assert_eq!(collisions(-0.1e-3)["pairs"], 0);
    let pressed = collisions(2e-3);
    let gap = pressed["smallest_gap"].as_f64().unwrap() * ACTIVATION;
    assert!(gap > 0.1e-3 && gap < 0.8e-3, "{pressed}");
    assert!(pressed["contact"][0]["magnitude"].as_f64().unwrap() > 1e-3, "{pressed}");
}
