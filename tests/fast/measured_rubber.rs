//! `solver fit` on rubber that was measured: Treloar 1944 and Kawabata 1981.

use serde_json::Value;
use tests::shared;
use tests::workdir::Workdir;

/// A table of stretch and nominal stress for `solver fit`.
fn table(points: &[(f64, f64)]) -> String {
    let lines = points.iter().map(|(stretch, stress)| format!("{stretch}, {stress}\n"));
    "stretch [1], stress [MPa]\n".to_owned() + &lines.collect::<String>()
}

/// Rows of numbers below a header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split(',').map(|cell| cell.trim().parse().unwrap()).collect();
    text.lines().skip(1).filter(|line| !line.is_empty()).map(row).collect()
}

fn r2(report: &Value, law: &str) -> f64 {
    let fits = report["fits"].as_array().unwrap();
    let fit = fits.iter().find(|fit| fit["name"] == law).unwrap_or_else(|| panic!("{report}"));
    fit["quality"]["r2"].as_f64().unwrap()
}

/// Natural rubber to 7.6 times its length: two parameters of Gent's law describe the whole
/// curve within R² 0.99, as Gent 1996 says; the neo-Hookean law does not stiffen. Gent's limit
/// lies within 7.6 in both directions, so that a law that is stable there is recommended.
#[test]
fn treloars_tensile_test() {
    let Some(path) = shared("data/measured/rubber-treloar-1944-uniaxial.csv") else { return };
    let dir = Workdir::new();
    let points: Vec<_> =
        rows(&std::fs::read_to_string(path).unwrap()).iter().map(|row| (row[0], row[1])).collect();
    dir.write("treloar.csv", &table(&points));
    let run = dir.solver("fit treloar.csv -o fit");
    run.assert_good();
    eprintln!("{}", run.stdout);
    let report = dir.json("fit/fit.json");
    assert!(r2(&report, "gent") > 0.99, "{report}");
    assert!(r2(&report, "neo-hookean") < 0.9, "{report}");
    assert!(r2(&report, report["written"].as_str().unwrap()) > 0.99, "{report}");
}

/// Tension along one axis, two axes and one of two held, of one rubber: a law of Ī₁ alone, as
/// Gent's, cannot describe all three as well as laws that also have Ī₂ or stretches.
#[test]
fn kawabatas_biaxial_tests() {
    let Some(path) = shared("data/measured/rubber-kawabata-1981-biaxial.csv") else { return };
    let dir = Workdir::new();
    let rows = rows(&std::fs::read_to_string(path).unwrap());
    let write = |name: &str, keep: fn(&[f64]) -> bool| {
        let kept = rows.iter().filter(|row| keep(row)).map(|row| (row[0], row[2]));
        let points: Vec<_> = kept.collect();
        assert!(points.len() > 5, "{name}: {points:?}");
        dir.write(name, &table(&points));
    };
    write("uniaxial.csv", |row| row[3] == 0.0);
    write("biaxial.csv", |row| row[0] == row[1]);
    write("planar.csv", |row| row[1] == 1.0);
    let run = dir.solver("fit uniaxial.csv --biaxial biaxial.csv --planar planar.csv -o fit");
    run.assert_good();
    eprintln!("{}", run.stdout);
    let report = dir.json("fit/fit.json");
    assert!(r2(&report, "gent") > 0.95, "{report}");
    let chosen = r2(&report, report["written"].as_str().unwrap());
    assert!(chosen > 0.98 && chosen > r2(&report, "gent"), "{report}");
}
