//! Two bodies: a chamber that is inflated against a block, which slides over it, and should press
//! harder.

use mesh::io::write_tets;
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;
use tests::{block, tag};

const SCENE: &str = r#"
degree = 1

[[body]]
name = "chamber"
mesh = "body.msh"
material = { kind = "mooney-rivlin", c1 = 55e3, c2 = 5e3, c3 = 1.7e3, d1 = 1e6, density = 1000.0 }

[[body]]
name = "block"
mesh = "block.msh"
material = { kind = "mooney-rivlin", c1 = 55e3, c2 = 5e3, c3 = 1.7e3, d1 = 1e6, density = 1000.0 }
translate = [0.005, 0.003, 0.0405]

[[fixed]]
on = "chamber.seat"

[[fixed]]
on = "block.far"
displacement = ["1e-3*t", 0, 0]

[[chamber]]
on = "chamber.cavity"
pressure = "1.2e4*t"

[contact]
activation = 3e-4
stiffness = 1e5
friction = 0.4

[time]
end = 1.0
steps = 3
method = "quasistatic"
"#;

const DESIGN: &str = r#"
scene = "sim.toml"

[optimizer]
first_step = 0.1

[shape]
on = "chamber.cavity"

[[shape.level]]
handles = 2
iterations = 5

[[objective]]
kind = "contact-force"
name = "grip"
weight = -1.0
on = "block"
form = "squared"

[[objective]]
kind = "wall-thickness"
name = "wall"
weight = 1e6
on = "chamber.cavity"
against = ["chamber.top", "chamber.skin"]
minimum = 2e-3
activation = 5e-3
"#;

fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let mesh = block([3, 3, 1], 0.01, |_| false, |p| p);
    let body = tag(mesh, &[("far", &|p| p.z > 0.01 - 1e-6), ("skin", &|_| true)]);
    write_tets(&dir.path("block.msh"), &body.mesh, &body.tags).unwrap();
    dir.write("sim.toml", SCENE);
    dir.write("design.toml", DESIGN);
    dir
}

/// |Σ f| between the two, as `simulate` reports it at the end [N].
fn force(dir: &Workdir, arguments: &str) -> f64 {
    dir.solver(&format!("-q simulate sim.toml -o run --restart {arguments}")).assert_good();
    let report = dir.json("run/report.json");
    let last = report["steps"].as_array().unwrap().last().unwrap().clone();
    let sum = |kind: &str| -> [f64; 3] {
        let pair = &last["collisions"][kind][0]["force"];
        std::array::from_fn(|k| pair[k].as_f64().unwrap_or(0.0))
    };
    let (contact, friction) = (sum("contact"), sum("friction"));
    (0..3).map(|k| (contact[k] + friction[k]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn the_force_on_a_block_grows_and_its_gradient_is_exact() {
    let dir = workdir();
    dir.solver("check design.toml --steps 5 --random 0").assert_good();
    let before = force(&dir, "");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let after = force(&dir, "--mesh chamber=out/design.chamber.msh");
    assert!(before > 0.01 && after > 1.3 * before, "{before} N, {after} N");
    // runs next to one that is known need fewer iterations
    let iterations = |line: &Value| line["newton_iterations"].as_u64().unwrap();
    let newton: Vec<u64> = dir.lines("out/history.jsonl").iter().map(iterations).collect();
    assert!(newton[1..].iter().all(|n| *n < newton[0]), "{newton:?}");
    let report = dir.json("out/report.json");
    let grip = -report["terms_after"]["grip"].as_f64().unwrap();
    assert!((grip.sqrt() / after - 1.0).abs() < 1e-3, "{grip} {after}");
}
