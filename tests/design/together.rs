//! Numbers of a scene as design variables, alone and together with the shape.

use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

const STEPS: usize = 5;

/// The chamber with linear elements, blown up and let down after a while.
fn scene(peak: f64, delay: f64) -> String {
    let pulse = "\"if(t - delay, peak*sin(5*(t - delay)), 0)\"";
    let parameters = format!("[parameters]\npeak = {peak}\ndelay = {delay}\n");
    let time = format!("[time]\nmethod = \"quasistatic\"\nend = 0.5\nsteps = {STEPS}\n");
    let sim = chamber::SIM.replace("degree = 2", "degree = 1");
    sim.replace("pressure = 8e3", &format!("pressure = {pulse}")) + &parameters + &time
}

/// Volume of the chamber after each step [m³].
fn volumes(dir: &Workdir) -> Vec<f64> {
    let volume = |line: &Value| line["chambers"]["cavity"]["volume"].as_f64().unwrap();
    dir.lines("out/steps.jsonl").iter().map(volume).collect()
}

#[test]
fn a_peak_and_a_delay_are_found_again() {
    let dir = chamber::workdir();
    dir.write("wanted.toml", &scene(9e3, 0.06));
    dir.solver("-q simulate wanted.toml -o out").assert_good();
    let mut design = String::from(
        "scene = \"begin.toml\"\n\
         [optimizer]\niterations = 15\nfirst_step = 1.0\n\
         [[parameter]]\nname = \"peak\"\nbounds = [0, 12e3]\nchange = 3e3\n\
         [[parameter]]\nname = \"delay\"\nbounds = [0, 0.09]\n",
    );
    for (n, volume) in volumes(&dir).iter().enumerate() {
        let step = n + 1;
        design += &format!(
            "[[objective]]\nkind = \"volume\"\nname = \"step {step}\"\nweight = 1e14\n\
             on = \"cavity\"\nvolume = {volume:e}\nmeasure = \"deformed\"\n\
             over = {{ steps = [{step}] }}\n"
        );
    }
    dir.write("design.toml", &design);
    dir.write("begin.toml", &scene(5e3, 0.01));
    dir.solver("check design.toml --steps 5").assert_good();
    dir.solver("-q optimize design.toml -o designed").assert_good();
    let found: toml::Table = toml::from_str(&dir.text("designed/parameters.toml")).unwrap();
    let of = |name: &str| found["parameters"][name].as_float().unwrap();
    assert!((of("peak") / 9e3 - 1.0).abs() < 1e-4, "{found}");
    assert!((of("delay") / 0.06 - 1.0).abs() < 1e-4, "{found}");
    let line = dir.lines("designed/history.jsonl").pop().unwrap();
    assert_eq!(line["parameters"]["peak"].as_f64(), Some(of("peak")));
}

/// A shape and the volume that is pumped into it.
#[test]
fn shape_and_volume_are_designed_together() {
    let dir = chamber::workdir();
    let sim = chamber::SIM.replace("degree = 2", "degree = 1");
    let pumped = sim.replace(
        "[[chamber]]\non = \"cavity\"\npressure = 8e3",
        "[parameters]\nmore = 0.1\n[[chamber]]\non = \"cavity\"\nvolume_factor = \"1 + more*t\"",
    );
    dir.write("sim.toml", &pumped);
    let parameter = "[[parameter]]\nname = \"more\"\nbounds = [0.0, 0.5]\n";
    dir.write("design.toml", &(chamber::DESIGN.to_owned() + parameter));
    dir.solver("check design.toml --steps 5").assert_good();
    dir.solver("-q optimize design.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let of = |key: &str| report[key].as_f64().unwrap();
    assert!(of("objective_after") < 0.8 * of("objective_before"), "{report}");

    let found: toml::Table = toml::from_str(&dir.text("out/parameters.toml")).unwrap();
    let more = found["parameters"]["more"].as_float().unwrap();
    assert!((more - 0.1).abs() > 1e-3, "the volume has not changed: {more}");
    dir.write("sim.toml", &pumped.replace("more = 0.1", &format!("more = {more:?}")));
    dir.solver("-q simulate sim.toml --mesh out/design.msh -o again").assert_good();
    let again = dir.json("again/report.json");
    let factor = again["chambers"]["cavity"]["volume"].as_f64().unwrap()
        / again["chambers"]["cavity"]["volume_rest"].as_f64().unwrap();
    assert!((factor - 1.0 - more).abs() < 1e-6, "{factor} and {more}");
}

/// A load that a path names is a design variable: its value acts on the run, not its derivative alone.
#[test]
fn a_traction_is_designed() {
    let dir = chamber::workdir();
    let load = "\n[[traction]]\non = \"top\"\ntraction = [0, 0, 100]\n";
    dir.write("pulled.toml", &(dir.text("p1.toml") + load));
    dir.write(
        "design.toml",
        "scene = \"pulled.toml\"\n[optimizer]\niterations = 3\n\
         [[parameter]]\nname = \"traction.top.z\"\nbounds = [-500, 500]\n\
         [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = 1e6\non = \"cavity\"\nmeasure = \"deformed\"\n",
    );
    dir.solver("-q optimize design.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let of = |key: &str| report[key].as_f64().unwrap();
    assert!(of("objective_after") < of("objective_before"), "{report}");
}
