//! `solver list`, `fit` and `plot`, and named silicones, by the program.

use tests::chamber;
use tests::reported::number;
use tests::workdir::Workdir;

#[test]
fn list_names_every_law_and_silicone() {
    let dir = Workdir::new();
    let run = dir.solver("list");
    run.assert_good();
    for word in ["mooney-rivlin", "ogden", "[Pa]", "shear modulus at rest", "source"] {
        assert!(run.stdout.contains(word), "{word}");
    }
    let run = dir.solver("list --silicones");
    run.assert_good();
    for words in [
        "ODbL",
        "shear modulus 31.7 kPa (campbell-2025, tension); sources give 14.4 to 39.4 kPa",
        "/campbell-2025        31.7 kPa  tension\n",
        "/dawood-2026          32.4 kPa  compression, stiffening of marechal-2021\n",
        "/datasheet            39.4 kPa  100 % modulus\n",
        "/marechal-2021        14.4 kPa  tension, crosshead strain\n",
        "gent: mu 31700, j_m 39.6, bulk 6340000; range unknown\n",
        "1.3 to 3.1 times as much as such tests say",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
}

#[test]
fn a_silicone_is_named_and_its_range_is_kept() {
    let dir = chamber::workdir();
    let sim = dir.text("sim.toml");
    let table = &sim[sim.find("[material]").unwrap()..sim.find("[[fixed]]").unwrap()];
    let named = |name: &str| {
        let scene =
            sim.replace(table, "").replace("degree", &format!("material = \"{name}\"\ndegree"));
        dir.write("named.toml", &scene.replace("8e3", "1e3"));
        dir.solver("simulate named.toml -o out")
    };
    let run = named("ecoflex-00-30/ogden");
    run.assert_good();
    let line = "ecoflex-00-30: shear modulus 14.4 kPa (marechal-2021, tension, crosshead strain); \
                sources give 14.4 to 39.4 kPa";
    assert_eq!(run.stderr.matches(line).count(), 1, "{}", run.stderr);
    let material = &dir.json("out/report.json")["material"]["silicone"];
    assert_eq!(material["source"], "marechal-2021", "{material}");
    assert_eq!(material["shear_modulus_range"], serde_json::json!([14440.0, 39400.0]));
    let soft = number(&dir.json("out/report.json")["chambers"]["cavity"]["volume"]);
    named("ecoflex-00-30").assert_good();
    // 31.7 kPa in place of 14.4
    let stiff = number(&dir.json("out/report.json")["chambers"]["cavity"]["volume"]);
    assert!(stiff < soft, "{stiff} {soft}");
    let range = &dir.json("out/report.json")["stretch_range"];
    assert!(number(&range["largest"]) > 1.0 && number(&range["smallest"]) < 1.0, "{range}");
    // 900 % of elongation at break
    assert_eq!(number(&range["at_break"]), 10.0);
    assert!((number(&range["margin"]) * number(&range["largest"]) - 10.0).abs() < 1e-12, "{range}");
    named("ecoflex").assert_refused(2, &["\"ecoflex\"", "ecoflex-00-30"]);
}

/// Data of a neo-Hookean material of 100 kPa: σ = μ (λ − λ⁻²).
#[test]
fn a_tensile_test_becomes_a_material() {
    let dir = Workdir::new();
    let mut csv = "stretch [1], stress [kPa]\n".to_owned();
    for i in 0..=40 {
        let stretch = 1.0 + 0.05 * f64::from(i);
        csv += &format!("{stretch}, {}\n", 100.0 * (stretch - stretch.powi(-2)));
    }
    dir.write("test.csv", &csv);
    dir.solver("fit test.csv -o fit --law neo-hookean").assert_good();
    assert_eq!(dir.files("fit"), ["fit.json", "fit.svg", "material.toml"]);
    let material: toml::Table = dir.text("fit/material.toml").parse().unwrap();
    let material = material["material"].as_table().unwrap();
    let young = material["young"].as_float().unwrap();
    let poisson = material["poisson"].as_float().unwrap();
    let shear = young / (2.0 * (1.0 + poisson));
    assert!((shear / 1e5 - 1.0).abs() < 1e-6, "{shear}");
    assert!(dir.text("fit/fit.svg").contains("nominal stress [kPa]"));

    dir.write("bad.csv", "stretch [1], stress [kPa]\n1.0, 0.0\n1.1, abc\n");
    dir.solver("fit bad.csv -o none").assert_refused(2, &["bad.csv", "line 3", "abc"]);
    assert!(dir.files("none").is_empty());
}

#[test]
fn columns_of_runs_are_drawn() {
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o out").assert_good();
    let plot = "plot out/report.json --x load --y chambers.cavity.volume*1e6 -o volume.svg";
    dir.solver(plot).assert_good();
    assert!(dir.text("volume.svg").contains("chambers.cavity.volume*1e6"));
    let run = dir.solver("plot out/report.json --y chambers.hole.volume -o none.svg");
    run.assert_refused(2, &["out/report.json", "\"hole\"", "cavity"]);
    assert!(!dir.path("none.svg").exists());
    let run = dir.solver("plot out/report.json --y chambers.cavity.volume -o none.pdf");
    run.assert_refused(2, &["none.pdf", "written as SVG or PNG"]);
    // measured points over it, and both as PNG
    dir.write("measured.csv", "load, volume\n0.5, 8e-6\n1, 9e-6\n");
    dir.solver(&format!("{plot} --points measured.csv:load,volume*1e6")).assert_good();
    assert!(dir.text("volume.svg").contains(">\nmeasured\n"), "{}", dir.text("volume.svg"));
    dir.solver(&plot.replace(".svg", ".png")).assert_good();
    let png = std::fs::read(dir.path("volume.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    let run = dir.solver(&format!("{plot} --points measured.csv:load,volum"));
    run.assert_refused(
        2,
        &["measured.csv", "no column \"volum\"; there are: \"load\", \"volume\""],
    );
}
