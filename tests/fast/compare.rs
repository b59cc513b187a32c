//! `solver compare`, by the program.

use tests::chamber;
use tests::reported::number;
use tests::workdir::Workdir;

/// The chamber with linear and quadratic displacements in `P1` and `P2`.
fn runs() -> Workdir {
    let dir = chamber::workdir();
    for degree in [1, 2] {
        let run = format!("simulate sim.toml --degree {degree} -o P{degree} --final-only");
        dir.solver(&run).assert_good();
    }
    dir
}

#[test]
fn runs_are_compared_with_a_reference_and_drawn() {
    let dir = runs();
    dir.solver("compare P2 P1 P2 -o compare.json --spacing 1e-3").assert_good();
    let found = dir.json("compare.json");
    let reports = [dir.json("P1/report.json"), dir.json("P2/report.json")];
    assert_eq!(found["reference"]["run"], "P2");
    for (row, report) in found["runs"].as_array().unwrap().iter().zip(&reports) {
        assert_eq!(row["degree"], report["config"]["degree"]);
        assert_eq!((&row["dofs"], &row["tets"]), (&report["dofs"], &report["tets"]));
        assert_eq!(row["time_s"], report["equilibrium_s"]);
        assert!(number(&row["time_s"]) <= number(&report["wall_s"]), "{row}");
        // one mesh: the same at rest, and all points in common
        assert!(number(&row["surface_at_rest"]["hausdorff"]) < 1e-15, "{row}");
        let displacement = &row["displacement"];
        assert!((number(&displacement["volume_share"]) - 1.0).abs() < 1e-9, "{row}");
    }
    let [linear, same] = [0, 1].map(|i| &found["runs"][i]);
    assert!(number(&same["surface"]["hausdorff"]) < 1e-15, "{same}");
    assert!(number(&same["displacement"]["max"]) < 1e-15, "{same}");

    // the surfaces are no farther apart than the points that are moved
    let largest = number(&found["reference"]["largest_displacement"]);
    let apart = number(&linear["surface"]["hausdorff"]);
    let off = number(&linear["displacement"]["max"]);
    assert!(0.05 * largest < apart && apart <= 1.02 * off && off < largest, "{linear}");

    let plot = "plot compare.json --x dofs --y surface.hausdorff*1e3,displacement.max*1e3";
    dir.solver("compare P2 P1 -o one.json --spacing 4e-3").assert_good();
    dir.solver(&format!("{} --log --log-x -o error.svg", plot.replace("compare", "one")))
        .assert_good();
    assert!(dir.text("error.svg").contains("dofs"));
    // the reference itself has no error, so no place on a logarithmic axis
    dir.solver(&format!("{plot} --log -o none.svg")).assert_refused(2, &["positive along y"]);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let dir = runs();
    let compare = |arguments: &str| dir.solver(&format!("compare {arguments} -o none.json"));
    compare("P2 P1 --spacing 0").assert_refused(2, &["--spacing"]);
    compare("P2 nowhere").assert_refused(2, &["nowhere/report.json"]);

    // another mesh in the place of the one that was used
    let kept = std::fs::read(dir.path("body.msh")).unwrap();
    std::fs::write(dir.path("body.msh"), [&kept[..], b"\n"].concat()).unwrap();
    compare("P2 P1").assert_refused(2, &["P2/report.json", "body.msh", "make it again"]);
    std::fs::write(dir.path("body.msh"), &kept).unwrap();

    // another state than the report's
    std::fs::copy(dir.path("P2/displacement.npy"), dir.path("P1/displacement.npy")).unwrap();
    compare("P2 P1").assert_refused(2, &["P1", "displacement.npy", "819", "146"]);

    dir.write("high.toml", &chamber::beyond_any_equilibrium(chamber::SIM));
    dir.solver("simulate high.toml -o high").assert_refused(1, &["no equilibrium"]);
    compare("P2 high").assert_refused(2, &["high/report.json", "no equilibrium"]);
    assert!(!dir.path("none.json").exists());

    dir.solver("simulate sim.toml --degree 4 -o P4").assert_refused(2, &["--degree", "4"]);
}
