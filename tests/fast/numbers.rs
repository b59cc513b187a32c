//! The numbers of a scene: derivatives of each, and what may be said of them by their paths.

use std::collections::BTreeSet;
use std::path::Path;

use mechanics::forward::TimeStepper;
use run::sensitivity::sensitivities;
use scene::Scene;
use scene::config::SimConfig;
use scene::number::{KINDS, Number, Swept, Walls};
use tests::chamber;
use tests::workdir::Workdir;

use crate::samples::{SOFTENING, moved};

/// Motion of a body that falls.
const MORE: &str = r#"
[[traction]]
on = "top"
traction = [5, 0, "50 * t / 0.02"]

[time]
end = 0.02
steps = 2

[solver]
relative_tolerance = 1e-13
absolute_tolerance = 1e-12
"#;

/// A scene with numbers of all kinds except friction, softening and rigid parts, in a folder of its own.
fn workdir(more: &str) -> Workdir {
    let dir = chamber::workdir();
    let sim = chamber::SIM.replace("degree = 2", "degree = 1\ngravity = [0, 0, -9.81]");
    let sim = sim.replace("d1 = 1e6", "d1 = 1e6\ndensity = 1070");
    let rooms: String =
        SimConfig::default().rooms().iter().map(|room| room.about().example).collect();
    dir.write("sim.toml", &(sim + chamber::PROBES + &rooms + MORE + more));
    dir
}

/// The first probe at the end, with its derivatives by all numbers.
fn first(scene: &Scene) -> (f64, Vec<f64>) {
    let (problem, mut workspace) = scene.problem(&scene.body).unwrap();
    let probes = scene.probes(&scene.body, &problem.space).unwrap();
    let mut stepper = TimeStepper::new(scene.stepping(), scene.integrator(&scene.body, &problem));
    let (rest, times) = (&scene.body.mesh.vertices, scene.times());
    let run = stepper.run(&problem, &mut workspace, rest, &times, 1e9, |_| ()).unwrap();
    let on = (&[&probes[0]][..], &run, run.steps());
    let found = sensitivities(scene, (&problem, &mut workspace), on).unwrap();
    let (value, by) = &found[0];
    let walls = Walls::new(scene).unwrap();
    let swept = Swept::new(scene, &problem, Some(&walls), by);
    let all = Number::all(scene);
    (*value, all.iter().map(|number| number.derivative(&swept)).collect())
}

/// Central differences: the remainder is of second order in the step.
#[test]
fn every_number_has_its_derivative() {
    let softened = moved(SOFTENING, &[8e-3, 3e-3, 6e-3]);
    let mut words = with_derivatives(&workdir("").path("sim.toml"));
    words.extend(with_derivatives(&softened.path("p1.toml")));
    let known: BTreeSet<&str> = KINDS.iter().map(|kind| kind.word).collect();
    // rigid parts, which no tag of these bodies can be, and friction have their tests in `features`
    assert_eq!(known.difference(&words).collect::<Vec<_>>(), [&"contact", &"rigid"]);
}

/// Compares the derivatives by all numbers of a scene with differences, and gives the kinds that move its first probe.
fn with_derivatives(path: &Path) -> BTreeSet<&'static str> {
    let scene = Scene::read(path).unwrap();
    let all = Number::all(&scene);
    let (_, derivatives) = first(&scene);
    let walls = Walls::new(&scene).unwrap();
    let mut words = BTreeSet::new();
    for (number, slope) in all.iter().zip(derivatives) {
        let value = number.value(&scene);
        // a stress of 1e-3 Pa would move the probe within rounding
        let zero = if number.path.starts_with("material.") { 1.0 } else { 1e-3 };
        let size = number.scale(&scene).unwrap_or(if value == 0.0 { zero } else { value });
        let moved = |part: f64| {
            let mut other = scene.clone();
            number.set(&mut other, Some(&walls), value + part * size).unwrap();
            number.check(&other).unwrap();
            first(&other).0
        };
        let step = 1e-3;
        let difference = (moved(step) - moved(-step)) / (2.0 * step * size);
        let scale = slope.abs().max(1e-9 / size);
        assert!((difference - slope).abs() < 1e-4 * scale, "{}: {difference} {slope}", number.path);
        // a kind counts by a number that moves the probe
        if (slope * size).abs() > 1e-9 {
            words.insert(number.word());
        }
    }
    words
}

/// Of a design whose variables are numbers of the material and a pressure: the wanted ones are found.
#[test]
fn numbers_are_designed_by_their_paths() {
    let dir = chamber::workdir();
    let scene = chamber::SIM.replace("degree = 2", "degree = 1") + chamber::PROBES;
    let tight = "[solver]\nrelative_tolerance = 1e-12\n";
    dir.write("wanted.toml", &(scene.replace("c1 = 55e3", "c1 = 50e3") + tight));
    dir.solver("-q simulate wanted.toml -o wanted").assert_good();
    let wanted = dir.probe("wanted", "air");
    dir.write("sim.toml", &(scene + tight));
    let design = format!(
        "scene = \"sim.toml\"\n[optimizer]\niterations = 8\nfirst_step = 1.0\n\
         [[parameter]]\nname = \"material.body.c1\"\nbounds = [40e3, 70e3]\n\
         [[objective]]\nkind = \"probe\"\nname = \"air\"\nweight = 1\nprobe = \"air\"\n\
         scale = 1e-7\ntarget = {wanted:e}\n"
    );
    dir.write("design.toml", &design);
    dir.solver("check design.toml --steps 4 --random 1").assert_good();
    dir.solver("-q optimize design.toml -o out").assert_good();
    let last = dir.lines("out/history.jsonl").pop().unwrap();
    let found = last["parameters"]["material.body.c1"].as_f64().unwrap();
    assert!((found / 50e3 - 1.0).abs() < 1e-3, "{found}");
    // the scene with what was designed
    dir.write("reached.toml", "include = [\"sim.toml\", \"out/parameters.toml\"]\n");
    dir.solver("-q simulate reached.toml -o reached").assert_good();
    let reached = dir.probe("reached", "air");
    assert!((reached / wanted - 1.0).abs() < 1e-5, "{reached} {wanted}");
    let twice = design.replace("material.body.c1", "velocity.body.x");
    dir.write("design.toml", &twice);
    dir.solver("optimize design.toml -o other").assert_refused(2, &["velocity.body.x"]);
}

/// Its value is made with the law.
#[test]
fn the_stress_of_a_law_has_its_gradient_by_the_law() {
    let dir = chamber::workdir();
    let design = "scene = \"p1.toml\"\n[[chamber]]\non = \"cavity\"\nslope = [-1e4, 1e4]\n\
                  [optimizer]\niterations = 1\n[[objective]]\nkind = \"stress\"\nname = \"stress\"\nweight = 1e-6\n";
    dir.write("stress.toml", design);
    let run = dir.solver("check stress.toml --random 0");
    run.assert_good();
    assert!(run.stdout.contains("material.body"), "{}", run.stdout);
    let by_law = "[[parameter]]\nname = \"material.body.c1\"\nbounds = [4e4, 7e4]\n";
    dir.write("law.toml", &format!("{design}{by_law}"));
    dir.solver("optimize law.toml -o out").assert_refused(2, &["\"stress\"", "material.body.c1"]);
}
