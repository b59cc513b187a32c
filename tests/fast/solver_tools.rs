//! `solver list` and `plot`, and named silicones, by the program.

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
        "/dawood-2026          32.4 kPa  compression, stiffening of marechal-2021\n",
        "gent: mu 31700, j_m 39.6, bulk 6340000; range unknown\n",
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

#[test]
fn columns_of_runs_are_drawn() {
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o out").assert_good();
    let plot = "plot out/report.json --x load --y chambers.cavity.volume*1e6 -o volume.svg";
    dir.solver(plot).assert_good();
    assert!(dir.text("volume.svg").contains("chambers.cavity.volume*1e6"));
    dir.solver("plot out/report.json --y chambers.hole.volume -o none.svg")
        .assert_refused(2, &["out/report.json", "\"hole\"", "cavity"]);
    assert!(!dir.path("none.svg").exists());
    // measured points over it
    dir.write("measured.csv", "load, volume\n0.5, 8e-6\n1, 9e-6\n");
    dir.solver(&format!("{plot} --points measured.csv:load,volume*1e6")).assert_good();
    assert!(dir.text("volume.svg").contains(">\nmeasured\n"), "{}", dir.text("volume.svg"));
    dir.solver(&format!("{plot} --points measured.csv:load,volum")).assert_refused(
        2,
        &["measured.csv", "no column \"volum\"; there are: \"load\", \"volume\""],
    );
}
