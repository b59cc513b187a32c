//! Values that are set or included from outside, and paths that hold from every folder.

use tests::chamber;
use tests::workdir::Workdir;

fn pressure(dir: &Workdir, folder: &str) -> f64 {
    dir.json(&format!("{folder}/report.json"))["chambers"]["cavity"]["pressure"].as_f64().unwrap()
}

#[test]
fn what_is_set_is_simulated_and_reported() {
    let dir = chamber::workdir();
    let run = "simulate p1.toml --final-only -o out --set";
    dir.solver(&format!("{run} chamber.cavity.pressure=4e3")).assert_good();
    assert_eq!(pressure(&dir, "out"), 4e3);
    let report = dir.json("out/report.json");
    assert_eq!(report["set"], serde_json::json!(["chamber.cavity.pressure=4e3"]));
    assert_eq!(report["inputs"]["scene"]["path"], "../p1.toml");
    // the same as a file with that number, to the last bit
    dir.write("less.toml", &dir.text("p1.toml").replace("8e3", "4e3"));
    dir.solver("simulate less.toml --final-only -o less").assert_good();
    let state =
        |folder: &str| std::fs::read(dir.path(&format!("{folder}/displacement.npy"))).unwrap();
    assert!(state("out") == state("less"));
}

#[test]
fn a_designed_pressure_is_included_by_a_scene() {
    let dir = chamber::workdir();
    dir.write("design.toml", &chamber::DESIGN.replace("sim.toml", "p1.toml"));
    std::fs::create_dir(dir.path("out")).unwrap();
    dir.write(
        "out/pressures.toml",
        "[[chamber]]\non = \"cavity\"\npressure = { t = [0.0, 1.0], value = [0.0, 3e3] }\n",
    );
    dir.write("designed.toml", "include = [\"p1.toml\", \"out/pressures.toml\"]\n");
    dir.solver("simulate designed.toml --final-only -o run").assert_good();
    assert_eq!(pressure(&dir, "run"), 3e3);
    let included = dir.json("run/report.json")["inputs"]["included"].clone();
    assert_eq!(included[1]["path"], "../out/pressures.toml");
    // what is given anew is not used: said, not guessed
    dir.write("own.toml", &format!("include = \"out/pressures.toml\"\n{}", dir.text("p1.toml")));
    dir.solver("simulate own.toml -o none")
        .assert_refused(2, &["own.toml: nothing of", "out/pressures.toml is used", "third file"]);
}

#[test]
fn runs_are_compared_from_every_folder() {
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml --final-only -o runs/one").assert_good();
    let from = |folder: &str, arguments: &str| {
        let mut command = dir.command(arguments);
        let output = command.current_dir(dir.path(folder)).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    from("runs", "compare one one -o here.json --spacing 4e-3");
    from("runs/one", "compare . . -o ../there.json --spacing 4e-3");
    assert_eq!(
        dir.json("runs/here.json")["runs"][0]["dofs"],
        dir.json("runs/there.json")["runs"][0]["dofs"]
    );
    // moved together with their mesh
    std::fs::create_dir(dir.path("moved")).unwrap();
    for name in ["runs", "body.msh"] {
        std::fs::rename(dir.path(name), dir.path("moved").join(name)).unwrap();
    }
    from("moved", "compare runs/one runs/one -o here.json --spacing 4e-3");
}
