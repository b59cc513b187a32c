//! `solver calibrate` of walls: those that are off are found from mass, gauges and probes, and scenes take them.

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
    dir.write("calibrate.toml", &calibration(&["cavity"], &[WEIGHED], &[0.03]));
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

const WEIGHED: &str = "weighed = true";
const PROBED: &str = "probe = \"top\"";
/// On the top, where 10 mm of silicone are over the chamber.
const GAUGED: &str = "gauge = [0.0211, 0.0193, 0.0401]";

/// What finds walls from values that were measured.
fn calibration(walls: &[&str], experiments: &[&str], values: &[f64]) -> String {
    let walls = walls.iter().map(|tag| format!("[[number]]\nof = \"wall.{tag}\"\n\n"));
    let experiment = |(i, (keys, value)): (usize, (&&str, &f64))| {
        format!(
            "[[experiment]]\nname = \"{i}\"\nscene = \"sim.toml\"\n{keys}\nvalue = {value:e}\nuncertainty = 1e-6\n\n"
        )
    };
    let experiments = experiments.iter().zip(values).enumerate().map(experiment);
    walls.chain(experiments).collect()
}

/// The offsets that are found [m].
fn found(dir: &Workdir) -> Vec<f64> {
    dir.solver("calibrate calibrate.toml -o out").assert_good();
    let report = dir.json("out/calibration.json");
    let numbers = report["numbers"].as_array().unwrap().iter();
    numbers.map(|number| number["value"].as_f64().unwrap()).collect()
}

#[test]
fn a_wall_is_found_from_the_mass_alone() {
    let dir = workdir();
    let off = -0.13e-3;
    let mass = cast(&dir, &[("cavity", off)]);
    dir.write("calibrate.toml", &calibration(&["cavity"], &[WEIGHED], &[mass]));
    let [wall] = found(&dir)[..] else { panic!("one wall") };
    assert!((wall / off - 1.0).abs() < 1e-6, "{wall}");
    // a scene that includes it is that of the cast body
    dir.write("cast.toml", "include = [\"sim.toml\", \"out/numbers.toml\"]\n");
    dir.solver("simulate cast.toml -o cast").assert_good();
    dir.solver("simulate sim.toml --mesh cast.msh -o truth").assert_good();
    for name in ["top", "air"] {
        let [a, b] = ["cast", "truth"].map(|folder| dir.probe(folder, name));
        assert!((a / b - 1.0).abs() < 1e-6, "{name}: {a:e} {b:e}");
    }
}

#[test]
fn two_walls_are_told_apart_by_mass_probe_and_gauge() {
    let dir = workdir();
    let truth = [("cavity", 0.09e-3), ("top", -0.2e-3)];
    let mass = cast(&dir, &truth);
    dir.solver("simulate sim.toml --mesh cast.msh -o truth").assert_good();
    let (top, thickness) = (dir.probe("truth", "top"), 0.01 + truth[0].1 + truth[1].1);
    for (beside, value) in [(PROBED, top), (GAUGED, thickness)] {
        let text = calibration(&["cavity", "top"], &[WEIGHED, beside], &[mass, value]);
        dir.write("calibrate.toml", &text);
        for (found, (tag, off)) in found(&dir).iter().zip(truth) {
            assert!((found / off - 1.0).abs() < 1e-5, "{beside}: {tag}: {found:e}");
        }
    }
}
