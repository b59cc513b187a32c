//! The casting sheet of a body that is wound, and `mold.json`, which is what its schema says.

use tests::chamber::{self, SIM};
use tests::reported::check_mold;

/// Along the line on its top that the scene lays a thread on.
#[test]
fn the_casting_sheet_says_how_to_wind() {
    let dir = chamber::workdir();
    dir.write("bare.toml", SIM);
    let line = "[[winding]]\nname = \"seam\"\non = \"top\"\nstiffness = 50\nstrength = 5\n\
                points = [[0.006, 0.02, 0.04], [0.034, 0.02, 0.04]]\n";
    dir.write("wound.toml", &format!("{SIM}\n{line}"));
    for scene in ["bare", "wound"] {
        dir.solver(&format!("simulate {scene}.toml --final-only -o {scene}")).assert_good();
    }
    let mold = |config: &str| {
        dir.write("mold.toml", config);
        dir.run("fab", "mold body.msh --config mold.toml --no-pictures -o mold")
    };
    for (report, words) in [
        ("bare/report.json", "no threads in it"),
        ("wound.toml", "not a report of `solver simulate`"),
        ("nowhere.json", "nowhere.json"),
    ] {
        mold(&format!("wound = \"{report}\"\n")).assert_refused(2, &[words]);
    }
    let words = "mL already; expected the mesh of a body within";
    mold("around = \"body.msh\"\n").assert_refused(1, &[words]);
    mold("[casting]\nfirst_shot = true\n").assert_good();
    let first = dir.text("mold/cast.html");
    assert!(first.contains("Leave the core inside") && !first.contains("Glue the tube"), "{first}");
    mold("wound = \"wound/report.json\"\n").assert_good();
    let report = dir.json("mold/mold.json");
    check_mold(&report);
    let length = report["threads"][0]["length"].as_f64().unwrap();
    assert!((length / 28.0 - 1.0).abs() < 1e-6, "{length}");
    let sheet = dir.text("mold/cast.html");
    for words in [
        "0.2 m of thread that bears 5.0 N (<code>seam</code>)",
        "Lay the thread <code>seam</code> on <code>top</code>",
        "28 mm, without slack",
    ] {
        assert!(sheet.contains(words), "{words}: {sheet}");
    }
}
