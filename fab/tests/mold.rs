//! `fab mold` and `fab verify` on small bodies, with good and bad input.

#![allow(clippy::unwrap_used)]

use std::process::Command;
use std::sync::OnceLock;

use crate::fixture::{CHAMBER, Cubes, Run, Scene, TWO_TOPS, change_report, copy, names};
use fab::files::report::MoldReport;
use fab::mold::Purpose;

const PLANE: &str = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]\n";

/// The report of a mold that is written.
fn molded(scene: &Scene) -> MoldReport {
    scene.made();
    scene.report(".")
}

/// The chamber in an upper and a lower shell.
fn shells() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| {
        let scene = Scene::new(&CHAMBER, "");
        molded(&scene);
        scene
    })
}

/// The chamber between two sides on a base, with pictures, and without the hole of a pin, so that its volume is exact.
fn sides() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| {
        let scene = Scene::new(&CHAMBER, &format!("{PLANE}\n[core]\nsupport = \"stub\""));
        let command = ["mold", "design.msh", "--config", "mold.toml", "-o", "mold"];
        scene.run(&command).good();
        scene
    })
}

#[test]
fn shells_on_a_base_and_above_each_other() {
    for (scene, parts, count_of) in [
        // Three keys between the shells and three on the base; one flat top.
        (sides(), &["left", "right", "base", "core"][..], [6, 1, 0]),
        (shells(), &["upper", "lower", "core"], [3, 1, 0]),
    ] {
        scene.assert_verified();
        let report = scene.report(".");
        assert_eq!(names(&report), parts);
        assert_eq!(
            [Purpose::Key, Purpose::Sprue, Purpose::Vent].map(|kind| report.outlines(kind).count()),
            count_of
        );
    }
    // 7 · 5 · 6 cubes less 27 + 2, of 64 mm³ each, around walls of 6 · 12² − 4² + 8 · 16 mm².
    let cast = sides().report(".").cast;
    assert!((cast.volume - 181.0 * 64.0).abs() < 1e-9, "{}", cast.volume);
    assert!((cast.chamber_area - 976.0).abs() < 1e-6, "{}", cast.chamber_area);
}

/// A blind hole of 4 × 4 × 4 mm in the seat, as for a screw.
const SCREWED: Cubes = Cubes {
    count: [5, 7, 6],
    solid: |c| !(c[0] == 1 && c[1] == 5 && c[2] < 1),
    chamber: CHAMBER.chamber,
};

#[test]
fn the_plug_of_a_hole_in_the_seat_belongs_to_the_base() {
    let base = |body: &Cubes| {
        let scene = Scene::new(body, &format!("{PLANE}\n[core]\nsupport = \"stub\""));
        let report = molded(&scene);
        assert_eq!(names(&report)[..3], ["left", "right", "base"]);
        report.parts[2].volume
    };
    let plug = base(&SCREWED) - base(&CHAMBER);
    assert!((plug - 4.0 * 4.0 * 4.0).abs() < 1e-3, "{plug}");
}

/// Flanges of 3.4 mm have no place for letters of 2.5 mm with a fifth of that on both sides.
#[test]
fn a_name_that_does_not_fit_is_reported() {
    let scene = Scene::new(&CHAMBER, "[keys]\nheight = 2e-3\n[flange]\nthickness = 3.4e-3\n");
    let output = scene.mold();
    let sheet = scene.sheet();
    for said in [output.good(), sheet.as_str()] {
        for name in ["upper", "lower"] {
            let words = format!("label: the name \"{name}\" does not fit on a face of ");
            assert!(said.contains(&words), "{said}");
        }
        assert!(said.contains(" × 3.4 mm"), "{said}");
    }
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn every_top_gets_a_channel() {
    let scene = Scene::new(&TWO_TOPS, "[sprue]\nat = [0.01, 0.014, 0]");
    let report = molded(&scene);
    assert_eq!([Purpose::Sprue, Purpose::Vent].map(|kind| report.outlines(kind).count()), [1, 1]);
    // Parts of an earlier mold do not stay beside those of a new one.
    scene.configure(&format!("method = \"soluble\"\n{PLANE}"));
    assert_eq!(names(&molded(&scene)), ["left", "right", "base", "core"]);
    assert!(!scene.path("mold/upper.stl").exists());
    assert!(!scene.path("mold/upper.3mf").exists());
    // Of a body that is refused nothing is lost.
    let files = files_below(&scene.path("mold"));
    scene.configure(&format!("method = \"soluble\"\n{PLANE}\n[sprue]\nat = [1, 0, 0]"));
    scene.mold().ended(2, &["an older mold is still there"]);
    assert_eq!(files_below(&scene.path("mold")), files);
}

/// A sprue beside the top is as high as one above it.
#[test]
fn nothing_runs_over_before_the_mold_is_full() {
    let report = molded(&Scene::new(&TWO_TOPS, "[sprue]\nat = [0.032, 0.014, 0]"));
    let sprue = report.outlines(Purpose::Sprue).next().unwrap();
    // It stands on the step, 16 mm high; the top is at 24 mm.
    assert!((15.0..16.0).contains(&sprue.base[2]), "{sprue:?}");
    assert!(sprue.base[2] + sprue.axis[2] >= 29.0, "{sprue:?}");
}

/// The sheet's numbers by hand, and its warnings.
#[test]
fn the_sheet_adds_up() {
    let config = "[casting]\nsilicone = \"elastosil-m4601\"\nwaste = 0.1\nleak_test = 2e4\n";
    let scene =
        Scene::new(&CHAMBER, &format!("{config}printer = \"form-4\"\n[core]\nsupport = \"stub\""));
    let report = molded(&scene);
    let text = std::fs::read_to_string(scene.path("mold/cast.json")).unwrap();
    let sheet: serde_json::Value = serde_json::from_str(&text).unwrap();
    let number = |path: &str| sheet.pointer(path).unwrap().as_f64().unwrap();
    // 181 cubes of 64 mm³, and less than a millilitre of channels.
    assert!((number("/body_ml") - 11.584).abs() < 1e-6);
    assert!((0.0..1.0).contains(&(number("/mold_ml") - 11.584)));
    // 1.13 g/mL, nine parts to one.
    let mass = 1.1 * number("/mold_ml") * 1.13;
    assert!((number("/silicone/mass_g") - mass).abs() < 1e-9);
    assert!((number("/silicone/parts_g/0") - 0.9 * mass).abs() < 1e-9);
    assert!((number("/silicone/parts_g/1") - 0.1 * mass).abs() < 1e-9);
    assert_eq!(number("/leak_test_kpa"), 20.0);
    let solid: f64 = report.parts.iter().map(|part| part.volume).sum();
    assert!((number("/plastic_g") - 1.2e-3 * solid).abs() < 1e-9);
    let modulus = "shear modulus</th><td>220 kPa; one source</td>";
    let pressure = "A pressure computed with μ kPa has to be multiplied by 220/μ.";
    let grams = format!("{mass:.1} g");
    scene.assert_sheet(&["Uncured resin inhibits", "20.0 kPa", "Wacker", "`core.stl`"]);
    scene.assert_sheet(&[modulus, pressure, &grams, "<h1>design</h1>", "type=\"checkbox\""]);
    assert!(!scene.sheet().contains("<script") && !scene.sheet().contains("src=\"http"));
    // A filament printer inhibits nothing; a silicone with several sources has a range.
    let config = config.replace("elastosil-m4601", "dragon-skin-20");
    let scene = Scene::new(&CHAMBER, &format!("{config}printer = \"prusa-mk4\""));
    molded(&scene);
    assert!(!scene.sheet().contains("Uncured resin"), "{}", scene.sheet());
    // 135.9/180.5 and 193/180.5
    scene.assert_sheet(&[
        "sources give 136 to 193 kPa",
        "computed with 180 kPa has to be multiplied by a factor between 0.75 and 1.07",
        "between 136/μ and 193/μ",
    ]);
}

#[test]
fn pictures_are_drawn() {
    for file in ["assembled.png", "exploded.png"] {
        let file = std::fs::File::open(sides().path("mold").join(file)).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        // Shaded parts of several colours, and the cast.
        let colors: std::collections::BTreeSet<&[u8]> = pixels.chunks_exact(3).collect();
        assert!(colors.len() > 100, "{}", colors.len());
    }
}

#[test]
fn the_same_mold_again() {
    let bytes = |scene: &Scene| {
        [
            "mold.json",
            "upper.stl",
            "core.3mf",
            "assembly.3mf",
            "cast.html",
            "reference/assembly.vtu",
        ]
        .map(|file| std::fs::read(scene.path("mold").join(file)).unwrap())
    };
    let again = Scene::new(&CHAMBER, "");
    molded(&again);
    assert_eq!(bytes(shells()), bytes(&again));
}

#[test]
fn bad_files() {
    let scene = Scene::new(&CHAMBER, "");
    let design = scene.path("design.msh");
    let text = std::fs::read_to_string(&design).unwrap();
    std::fs::write(&design, &text[..text.len() / 2]).unwrap();
    scene.mold().ended(2, &["design.msh"]);
    std::fs::write(&design, text.replacen("0.004", "nan", 1)).unwrap();
    scene.mold().ended(2, &["design.msh"]);
    std::fs::remove_file(&design).unwrap();
    scene.mold().ended(2, &["design.msh"]);
    scene.verify().ended(2, &["mold.json"]);
    // A file where the folder should be.
    std::fs::write(&design, text).unwrap();
    std::fs::write(scene.path("mold"), "").unwrap();
    scene.mold().ended(2, &["mold"]);
    scene.run(&["mold"]).ended(2, &["Usage"]);
}

#[test]
fn a_report_that_names_files_elsewhere_is_refused() {
    let scene = Scene::new(&CHAMBER, "");
    copy(&shells().path("mold"), &scene.path("mold"));
    change_report(&scene.path("mold"), |report| report.parts[0].file = "../design.msh".into());
    scene.verify().ended(2, &["files must lie in its own folder"]);
}

fn files_below(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let below = |path: std::path::PathBuf| match path.is_dir() {
        true => files_below(&path),
        false => vec![path],
    };
    entries.flat_map(|entry| below(entry.path())).collect()
}

/// A limit on the size of files stands for a full disk.
#[test]
#[cfg(unix)]
fn a_full_disk_leaves_no_half_mold() {
    let scene = Scene::new(&CHAMBER, "");
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 60; exec \"$0\" mold design.msh -o mold"])
        .arg(env!("CARGO_BIN_EXE_fab"))
        .current_dir(scene.path(""))
        .output()
        .unwrap();
    Run::from(output).ended(2, &[".stl"]);
    let left = files_below(&scene.path("mold"));
    assert!(left.is_empty(), "{left:?}");
}
