//! Chambers at the end of a line: `supply`, `checked_supply`, a leak, and several on one manifold.

use mesh::Vec3;
use mesh::io::write_tets;
use tests::workdir::Workdir;
use tests::{block, tag};

/// Ambient pressure [Pa].
const AMBIENT: f64 = 101_325.0;
/// Volume of each of the two hollows [m³].
const HOLLOW: f64 = 1e-6;
/// Resistance of the line [Pa s/m³], with which a hollow of this volume fills in 0.1 s.
const RESISTANCE: f64 = 0.1 * AMBIENT / HOLLOW;

/// A block of 70 x 30 x 30 mm with two hollows of 1 mL, and a scene of it through half a second.
fn twins(young: f64, chambers: &str) -> Workdir {
    let dir = Workdir::new();
    let inside = |p: Vec3, x: f64| (p - Vec3::new(x, 0.015, 0.015)).amax() < 0.006;
    let hole = |cell: [usize; 3]| cell == [1, 1, 1] || cell == [5, 1, 1];
    let body = tag(
        block([7, 3, 3], 0.01, hole, |p| p),
        &[
            ("left", &|p| inside(p, 0.015)),
            ("right", &|p| inside(p, 0.055)),
            ("seat", &|p| p.z < 1e-9),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let scene = format!(
        "mesh = \"body.msh\"\ndegree = 1\n\n[material]\nkind = \"neo-hookean\"\nyoung = {young:e}\npoisson = 0.3\n\n\
         [[fixed]]\non = \"seat\"\n\n{chambers}\n[time]\nend = 0.5\nsteps = 10\nmethod = \"quasistatic\"\n"
    );
    dir.write("sim.toml", &scene);
    dir
}

fn on(tags: &str, supply: &str, leak: f64) -> String {
    format!("[[chamber]]\n{tags}\n{supply}\nresistance = {RESISTANCE:e}\nleak = {leak:e}\n\n")
}

/// Pressure of a chamber at the end of each time step [Pa].
fn pressures(dir: &Workdir, chamber: &str) -> Vec<f64> {
    dir.solver("simulate sim.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let steps = report["steps"].as_array().unwrap().iter();
    steps.map(|step| step["chambers"][chamber]["pressure"].as_f64().unwrap()).collect()
}

/// In a rigid hollow (P_∞ − P) falls by the formula of implicit Euler, with P_∞ = P_s/(1 + L R) and the time
/// V/(p_a (1/R + L)).
#[test]
fn a_rigid_chamber_fills_exponentially() {
    let leak = 0.25 / RESISTANCE;
    let dir = twins(1e12, &on("on = \"left\"", "supply = 20e3", leak));
    let (settled, rate) = (20e3 / 1.25, 1.25 / 0.1 * 0.05);
    for (n, found) in pressures(&dir, "left").into_iter().enumerate() {
        let expected = settled * (1.0 - f64::powi(1.0 + rate, -(n as i32 + 1)));
        assert!((found / expected - 1.0).abs() < 1e-4, "step {n}: {found} {expected}");
    }
}

/// While the pump is off again, a check valve keeps the air that the other line lets go.
#[test]
fn a_check_valve_keeps_the_air() {
    let pump = "supply = { t = [0, 0.25, 0.26, 0.5], value = [20e3, 20e3, 0, 0] }";
    let both =
        on("on = \"left\"", pump, 0.0) + &on("on = \"right\"", &format!("checked_{pump}"), 0.0);
    let dir = twins(200e3, &both);
    let (open, checked) = (pressures(&dir, "left"), pressures(&dir, "right"));
    let largest = checked[4];
    assert!(largest > 15e3 && (open[4] / largest - 1.0).abs() < 1e-2, "{open:?} {checked:?}");
    assert!(open[9] < 0.3 * largest, "{open:?}");
    // that of the other changes its volume a little
    assert!((checked[9] / largest - 1.0).abs() < 1e-2, "{checked:?}");
}

#[test]
fn hollows_on_a_manifold_share_their_gas() {
    let shared = on("name = \"both\"\non = [\"left\", \"right\"]", "supply = 20e3", 0.0);
    let together = twins(200e3, &shared);
    let found = pressures(&together, "both");
    let volume = &together.json("out/report.json")["chambers"]["both"]["volume_rest"];
    assert!((volume.as_f64().unwrap() / (2.0 * HOLLOW) - 1.0).abs() < 1e-9, "{volume}");
    // each through a line of twice the resistance is the same: the block is symmetric
    let each = shared.replace(&format!("{RESISTANCE:e}"), &format!("{:e}", 2.0 * RESISTANCE));
    let each = ["left", "right"].map(|tag| {
        each.replace("name = \"both\"\non = [\"left\", \"right\"]", &format!("on = \"{tag}\""))
    });
    let apart = pressures(&twins(200e3, &each.concat()), "left");
    for (found, apart) in found.iter().zip(&apart) {
        assert!((found / apart - 1.0).abs() < 1e-3, "{found} {apart}");
    }
}

/// In a static scene the flow has settled.
#[test]
fn without_time_the_flow_has_settled() {
    let dir = twins(200e3, &on("on = \"left\"", "supply = 20e3", 1.0 / RESISTANCE));
    let scene = dir.text("sim.toml");
    dir.write("sim.toml", scene.split("[time]").next().unwrap());
    dir.solver("simulate sim.toml -o out").assert_good();
    let pressure = &dir.json("out/report.json")["chambers"]["left"]["pressure"];
    assert!((pressure.as_f64().unwrap() - 10e3).abs() < 1e-6, "{pressure}");
}

/// Beside a viscous body, whose internal variables come first.
#[test]
fn gradients_through_a_line_pass_the_taylor_test() {
    for supply in ["supply = \"40e3*t\"", "checked_supply = \"80e3*t*(1 - 2*t)\""] {
        let chamber = on("on = \"left\"", supply, 0.2 / RESISTANCE);
        let dir =
            twins(200e3, &format!("{chamber}[[relaxation]]\noverstress = 0.4\ntime = 0.1\n\n"));
        dir.write(
            "design.toml",
            "scene = \"sim.toml\"\n\n[shape]\non = \"left\"\n\n[[shape.level]]\nhandles = 3\niterations = 1\n\n\
             [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = -1e6\non = \"left\"\nmeasure = \"deformed\"\n",
        );
        dir.solver("check design.toml --handles 3").assert_good();
    }
}

#[test]
fn lines_that_cannot_be_are_refused() {
    let refuse = |chambers: &str, words: &[&str]| {
        twins(200e3, chambers).solver("simulate sim.toml -o out").assert_refused(2, words);
    };
    let good = on("on = \"left\"", "supply = 20e3", 0.0);
    refuse(
        &good.replace(&format!("resistance = {RESISTANCE:e}"), "resistance = 0"),
        &["[[chamber]] on \"left\"", "resistance = 0 Pa s/m³", "must be positive"],
    );
    refuse(&good.replace("leak = 0e0", "leak = -1"), &["leak = -1 m³/(Pa s)", "not negative"]);
    refuse(&good.replace("20e3", "-102e3"), &["ambient + supply = -675 Pa", "must be positive"]);
    refuse(
        &good.replace("on = \"left\"", "on = [\"left\", \"right\"]"),
        &["on: 2 tags; expected a `name`"],
    );
    refuse(
        &(good.replace("on = \"left\"", "name = \"both\"\non = [\"left\", \"right\"]")
            + "[[chamber]]\non = \"right\"\npressure = 1e3\n"),
        &["\"right\" is the wall of two chambers"],
    );
}
