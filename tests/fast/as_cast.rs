//! `simulate --as-cast`: walls that are off are found from mass, gauges and probes.

use mesh::Vec3;
use mesh::io::{read_tets, write_tets};
use mesh::measure::volume;
use scene::Scene;
use scene::number::Walls;
use tests::chamber;
use tests::workdir::Workdir;

const DENSITY: f64 = 1070.0;

/// The chamber with a density, linear elements and small tolerances, which was weighed.
pub fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let scene = chamber::SIM
        .replace("degree = 2", "degree = 1")
        .replace("d1 = 1e6", &format!("d1 = 1e6\ndensity = {DENSITY}"));
    let tight = "\n[solver]\nrelative_tolerance = 1e-13\nabsolute_tolerance = 1e-12\n";
    dir.write("sim.toml", &(scene + chamber::PROBES + tight));
    dir.write("measured.toml", "[mass]\nvalue = 0.03\nuncertainty = 1e-5\n");
    dir
}

/// Writes the body with walls moved by distances [m], and gives its mass [kg].
fn cast(dir: &Workdir, off: &[(&str, f64)]) -> f64 {
    let file = read_tets(&dir.path("body.msh")).unwrap();
    let scene = Scene::read(&dir.path("sim.toml")).unwrap();
    let walls = Walls::new(&scene).unwrap();
    let mut mesh = file.mesh;
    for (tag, d) in off {
        let moves = walls.moves(tag).unwrap();
        mesh.vertices.iter_mut().zip(moves).for_each(|(x, m): (&mut Vec3, Vec3)| *x += *d * m);
    }
    write_tets(&dir.path("cast.msh"), &mesh, &file.tags).unwrap();
    DENSITY * volume(&mesh)
}

/// The offsets that were found [m].
fn offsets(dir: &Workdir) -> Vec<f64> {
    let report = dir.json("out/report.json");
    let walls = report["as_cast"]["walls"].as_array().unwrap().iter();
    walls.map(|wall| wall["offset"].as_f64().unwrap()).collect()
}

const COMMAND: &str = "simulate sim.toml -o out --as-cast measured.toml";

#[test]
fn a_wall_is_found_from_the_mass_alone() {
    let dir = workdir();
    let off = -0.13e-3;
    let mass = cast(&dir, &[("cavity", off)]);
    dir.write("measured.toml", &format!("[mass]\nvalue = {mass:e}\nuncertainty = 1e-5\n"));
    let said = dir.solver(COMMAND);
    said.assert_good();
    assert!(said.stderr.contains("as cast: wall of cavity -0.130"), "{}", said.stderr);
    let found = offsets(&dir);
    assert!((found[0] / off - 1.0).abs() < 1e-6, "{found:?}");
    // what is simulated is the cast body
    dir.solver("simulate sim.toml --mesh cast.msh -o truth").assert_good();
    for name in ["top", "air"] {
        let [a, b] = ["out", "truth"].map(|folder| dir.probe(folder, name));
        assert!((a / b - 1.0).abs() < 1e-6, "{name}: {a:e} {b:e}");
    }
}

#[test]
fn two_walls_are_told_apart_by_mass_probe_and_gauge() {
    let dir = workdir();
    let truth = [("cavity", 0.09e-3), ("top", -0.2e-3)];
    let mass = cast(&dir, &truth);
    dir.solver("simulate sim.toml --mesh cast.msh -o truth").assert_good();
    let top = dir.probe("truth", "top");
    let walls = "walls = [\"cavity\", \"top\"]\n";
    let weighed = format!("[mass]\nvalue = {mass:e}\nuncertainty = 1e-6\n");
    let probed = format!("[[probe]]\nname = \"top\"\nvalue = {top:e}\nuncertainty = 1e-6\n");
    dir.write("measured.toml", &format!("{walls}{weighed}{probed}"));
    dir.solver(COMMAND).assert_good();
    let found = offsets(&dir);
    for (found, (tag, off)) in found.iter().zip(truth) {
        assert!((found / off - 1.0).abs() < 1e-5, "{tag}: {found:e}");
    }
    // a gauge on the top, where 10 mm of silicone are over the chamber
    let thickness = 0.01 + truth[0].1 + truth[1].1;
    let gauge = format!(
        "[[gauge]]\nat = [0.0211, 0.0193, 0.0401]\nthickness = {thickness:e}\nuncertainty = 1e-6\n"
    );
    dir.write("measured.toml", &format!("{walls}{gauge}{weighed}"));
    dir.solver(COMMAND).assert_good();
    for (found, (tag, off)) in offsets(&dir).iter().zip(truth) {
        assert!((found / off - 1.0).abs() < 1e-5, "{tag}: {found:e}");
    }
}
