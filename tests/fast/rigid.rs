//! Rigid parts of scenes, by the program: a plate that is glued to the top of a block with a closed chamber.

use mesh::Vec3;
use mesh::io::write_tets;
use tests::reported::number;
use tests::workdir::Workdir;
use tests::{block, tag};

use crate::samples::{ONE, glued};

/// Volume of the body [m³], 3 · 3 · 4 cells of 5 mm less two.
const VOLUME: f64 = 34.0 * 5e-3 * 5e-3 * 5e-3;

/// The bottom bears what hangs on the plate, which turns.
#[test]
fn a_plate_that_is_glued_on_bears_its_load() {
    let dir = glued("mass = 0.02\nforce = [0.1, 0, \"-0.3*t\"]\n");
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let last = report["steps"].as_array().unwrap().last().unwrap();
    let held = [0, 1, 2].map(|k| number(&last["reactions"]["bottom"][k]));
    let weight = (0.02 + 1000.0 * VOLUME) * 9.81;
    for (held, expected) in held.into_iter().zip([-0.1, 0.0, 0.3 + weight]) {
        assert!((held - expected).abs() < 1e-8, "{held} {expected}");
    }
    let turn = number(&last["rigid"]["top"]["rotation"][1]);
    assert!((1e-3..0.5).contains(&turn), "{turn}");
}

/// Threads bear the plate, and not the body that it is glued to.
#[test]
fn a_plate_on_a_very_soft_body_is_rigid_as_well() {
    let threads = [[0.0, 0.0075], [0.015, 0.0075], [0.0075, 0.0], [0.0075, 0.015]];
    let thread = |(i, [x, y]): (usize, [f64; 2])| {
        format!(
            "[[winding]]\nname = \"thread {i}\"\non = \"sides\"\nstiffness = 5\n\
             points = [[{x}, {y}, 0], [{x}, {y}, 0.02]]\n"
        )
    };
    let threads: String = threads.into_iter().enumerate().map(thread).collect();
    let dir = glued(&format!("force = [0, 0, 0.05]\n{threads}"));
    let law = ONE.strip_prefix("[material]\n").unwrap();
    let soft =
        dir.text("p1.toml").replace(law, "kind = \"neo-hookean\"\nyoung = 0.05\npoisson = 0.3\n");
    let soft = soft.replace("gravity = [0, 0, -9.81]", "").replace("density = 1000.0\n", "");
    dir.write("p1.toml", &soft.replace("pressure = 2e3", "pressure = 0"));
    dir.solver("simulate p1.toml -o out").assert_good();
    let read = |name: &str| mesh::io::npy::read_f64(&dir.path(&format!("out/{name}"))).unwrap().0;
    let (rest, u) = (read("nodes.npy"), read("displacement.npy"));
    let points = |x: &[f64]| x.chunks(3).map(Vec3::from_column_slice).collect::<Vec<_>>();
    let (rest, u) = (points(&rest), points(&u));
    let top: Vec<usize> = (0..rest.len()).filter(|&n| rest[n].z > 0.02 - 1e-9).collect();
    let rise = u[top[0]].z;
    assert!((1e-5..1e-3).contains(&rise), "{rise}");
    for (&a, &b) in top.iter().zip(&top[1..]) {
        let length = (rest[a] - rest[b]).norm();
        let strain = (rest[a] + u[a] - rest[b] - u[b]).norm() / length - 1.0;
        assert!(strain.abs() < 1e-3, "{strain}");
    }
}

/// Under an open membrane there is no air at rest: what is pumped in lifts a guided plate.
#[test]
fn air_is_pumped_below_a_flat_wall() {
    let dir = glued("along = \"z\"\nturns = false\nforce = [0, 0, -0.2]\n");
    let text = dir.text("p1.toml");
    let (from, to) = (text.find("[[fixed]]").unwrap(), text.find("[[rigid]]").unwrap());
    let scene = format!(
        "{}[[fixed]]\non = \"sides\"\n\n[[chamber]]\non = \"bottom\"\nvolume_change = 2e-8\n\n{}",
        &text[..from],
        text[to..].replace("top", "air").replace("force = [0, 0, -0.2]\n", "")
    );
    dir.write("flat.toml", &scene.replace("gravity = [0, 0, -9.81]\n", ""));
    dir.solver("simulate flat.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let air = &report["chambers"]["bottom"];
    assert!((number(&air["volume"]) / 2e-8 - 1.0).abs() < 1e-9, "{air}");
    assert!(number(&air["pressure"]) > 0.0, "{air}");
}

/// A rigid body has a law of its own and no overstress: numbers of its material change nothing, and those of
/// `[[relaxation]]` are of the soft body alone.
#[test]
fn a_rigid_body_does_not_relax() {
    let dir = Workdir::new();
    let top = |z: f64| move |p: Vec3| p.z > z - 1e-9;
    let soft = tag(
        block([2, 2, 2], 5e-3, |_| false, |p| p),
        &[("bottom", &|p| p.z < 1e-9), ("top", &top(0.01)), ("skin", &|_| true)],
    );
    write_tets(&dir.path("soft.msh"), &soft.mesh, &soft.tags).unwrap();
    let heavy = tag(block([1, 1, 1], 9e-3, |_| false, |p| p), &[("skin", &|_| true)]);
    write_tets(&dir.path("heavy.msh"), &heavy.mesh, &heavy.tags).unwrap();
    let material =
        "{ kind = \"mooney-rivlin\", c1 = 9e3, c2 = 2e3, c3 = 1e3, d1 = 1e5, density = 1000 }";
    dir.write(
        "sim.toml",
        &format!(
            "degree = 1\ngravity = [0, 0, -9.81]\n\n\
             [[body]]\nname = \"soft\"\nmesh = \"soft.msh\"\nmaterial = {material}\n\n\
             [[body]]\nname = \"heavy\"\nmesh = \"heavy.msh\"\ntranslate = [3e-4, 4e-4, 10.3e-3]\n\
             velocity = [0, 0, -0.2]\nmaterial = {material}\n\n\
             [[rigid]]\non = \"heavy\"\n\n[[fixed]]\non = \"soft.bottom\"\n\n\
             [[relaxation]]\noverstress = 0.4\ntime = 2e-3\n\n\
             [contact]\nactivation = 2e-4\nstiffness = 3e3\n\n\
             [time]\nmethod = \"implicit-euler\"\nend = 8e-3\nsteps = 4\n\n\
             [solver]\nrelative_tolerance = 1e-12\nabsolute_tolerance = 1e-14\n"
        ),
    );
    dir.write(
        "design.toml",
        "scene = \"sim.toml\"\n[shape]\non = \"soft.skin\"\n[[shape.level]]\nhandles = 1\niterations = 1\n\
         [[objective]]\nkind = \"displacement\"\nname = \"down\"\nweight = 1e9\non = \"soft.top\"\n\
         displacement = [0, 0, -1e-3]\n",
    );
    dir.solver("gradient design.toml -o gradient").assert_good();
    let numbers = dir.json("gradient/gradient.json")["numbers"].clone();
    let derivative = |path: &str| {
        let found = numbers.as_array().unwrap().iter().find(|one| one["path"] == path);
        found.unwrap_or_else(|| panic!("{path} of {numbers}"))["derivative"].as_f64().unwrap()
    };
    for key in ["c1", "c2", "c3", "d1"] {
        assert_eq!(derivative(&format!("material.heavy.{key}")), 0.0, "{key}");
        assert!(derivative(&format!("material.soft.{key}")) != 0.0, "{key}");
    }
}
