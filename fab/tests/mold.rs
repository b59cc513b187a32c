//! `fab mold` and `fab verify` on small bodies, with good and bad input.

#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::fixture::{
    CHAMBER, CLOSED, Cubes, Scene, TWO_CHAMBERS, TWO_TOPS, copy, fab, stderr, stdout,
};
use fab::files::report::MoldReport;
use mesh::Vec3;
use mesh::io::{read_tets, write_tets};

const PLANE: &str = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]\n";

/// `fab mold` writes a mold only if the checks of `fab verify` hold for its surfaces.
fn molded(scene: &Scene) -> MoldReport {
    let molded = scene.mold();
    assert!(molded.status.success(), "{}", stderr(&molded));
    MoldReport::read(&scene.path("mold")).unwrap()
}

/// The report of a mold whose files hold the checks, too.
fn verified(scene: &Scene) -> MoldReport {
    let verified = scene.verify();
    assert!(verified.status.success(), "{}{}", stdout(&verified), stderr(&verified));
    MoldReport::read(&scene.path("mold")).unwrap()
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

/// The chamber between two sides on a base, with pictures.
fn sides() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| {
        // No hole of a pin, so that its volume is exact.
        let scene = Scene::new(&CHAMBER, &format!("{PLANE}\n[core]\nsupport = \"stub\""));
        let folder = |name| scene.path(name).display().to_string();
        let [mesh, config, out] = ["design.msh", "mold.toml", "mold"].map(folder);
        let output = fab(&["mold", &mesh, "--config", &config, "-o", &out]);
        assert!(output.status.success(), "{}", stderr(&output));
        scene
    })
}

fn names(report: &MoldReport) -> Vec<&str> {
    report.parts.iter().map(|part| part.name.as_str()).collect()
}

fn count(report: &MoldReport, purpose: &str) -> usize {
    report.features.iter().filter(|f| f.purpose.name() == purpose).count()
}

#[test]
fn shells_on_a_base() {
    let report = verified(sides());
    assert_eq!(names(&report), ["left", "right", "base", "core"]);
    // Three between the shells and three on the base; one flat top.
    assert_eq!((count(&report, "key"), count(&report, "sprue"), count(&report, "vent")), (6, 1, 0));
    // 7 · 5 · 6 cubes less 27 + 2, of 64 mm³ each.
    assert!((report.cast.volume - 181.0 * 64.0).abs() < 1e-9);
}

/// Flanges of 3.4 mm have no place for letters of 2.5 mm with a fifth of that on both sides.
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
        molded(&scene);
        let report = verified(&scene);
        assert_eq!(names(&report)[..3], ["left", "right", "base"]);
        report.parts[2].volume
    };
    let plug = base(&SCREWED) - base(&CHAMBER);
    assert!((plug - 4.0 * 4.0 * 4.0).abs() < 1e-3, "{plug}");
}

#[test]
fn a_name_that_does_not_fit_is_reported() {
    let scene = Scene::new(&CHAMBER, "[keys]\nheight = 2e-3\n[flange]\nthickness = 3.4e-3\n");
    let output = scene.mold();
    assert!(output.status.success(), "{}", stderr(&output));
    let sheet = scene.sheet();
    for said in [stderr(&output), sheet] {
        for name in ["upper", "lower"] {
            let words = format!("label: the name \"{name}\" does not fit on a face of ");
            assert!(said.contains(&words), "{said}");
        }
        assert!(said.contains(" × 3.4 mm"), "{said}");
    }
}

#[test]
fn upper_and_lower_shell() {
    let report = verified(shells());
    assert_eq!(names(&report), ["upper", "lower", "core"]);
    assert_eq!(count(&report, "key"), 3);
}

#[test]
fn the_other_directions() {
    for parting in [
        "[parting]\nkind = \"height-field\"\npull = [0, 1, 0]",
        "up = [0, 0, 1]\n[parting]\nkind = \"plane\"\npull = [-1, 1, 0]",
    ] {
        molded(&Scene::new(&CHAMBER, parting));
    }
}

#[test]
#[ignore = "three seconds: runs in make test-all; the_other_directions has planes that are turned"]
fn a_plane_with_an_offset() {
    let parting = "[parting]\nkind = \"plane\"\npull = [0, 0, 1]\noffset = 0.0101";
    molded(&Scene::new(&CHAMBER, parting));
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn every_top_gets_a_channel() {
    let scene = Scene::new(&TWO_TOPS, "[sprue]\nat = [0.01, 0.014, 0]");
    molded(&scene);
    let report = verified(&scene);
    assert_eq!((count(&report, "sprue"), count(&report, "vent")), (1, 1));
    // Parts of an earlier mold do not stay beside those of a new one.
    scene.configure(&format!("method = \"soluble\"\n{PLANE}"));
    assert_eq!(names(&molded(&scene)), ["left", "right", "base", "core"]);
    assert!(!scene.path("mold/upper.stl").exists());
    assert!(!scene.path("mold/upper.3mf").exists());
    assert!(!scene.path("mold/replacing.txt").exists());
}

/// A sprue beside the top is as high as one above it.
#[test]
fn nothing_runs_over_before_the_mold_is_full() {
    let report = molded(&Scene::new(&TWO_TOPS, "[sprue]\nat = [0.032, 0.014, 0]"));
    let sprue = report.features.iter().find(|f| f.purpose.name() == "sprue").unwrap();
    // It stands on the step, 16 mm high; the top is at 24 mm.
    assert!((15.0..16.0).contains(&sprue.base[2]), "{sprue:?}");
    assert!(sprue.base[2] + sprue.axis[2] >= 29.0, "{sprue:?}");
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn two_chambers_have_two_cores() {
    for parting in ["", PLANE] {
        let report = molded(&Scene::new(&TWO_CHAMBERS, parting));
        assert!(names(&report).ends_with(&["core1", "core2"]));
        assert_eq!(count(&report, "socket"), 2);
    }
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
    let sheet = scene.sheet();
    let modulus = "shear modulus</th><td>220 kPa; one source</td>";
    let pressure = "A pressure computed with μ kPa has to be multiplied by 220/μ.";
    for words in ["Uncured resin inhibits", "20.0 kPa", "Wacker", "`core.stl`", modulus, pressure] {
        assert!(sheet.contains(words), "{words}: {sheet}");
    }
    // A filament printer inhibits nothing; a silicone with several sources has a range.
    let config = config.replace("elastosil-m4601", "dragon-skin-20");
    let scene = Scene::new(&CHAMBER, &format!("{config}printer = \"prusa-mk4\""));
    molded(&scene);
    let sheet = scene.sheet();
    assert!(!sheet.contains("Uncured resin"), "{sheet}");
    // 135.9/180.5 and 193/180.5
    for words in [
        "sources give 136 to 193 kPa",
        "computed with 180 kPa has to be multiplied by a factor between 0.75 and 1.07",
        "between 136/μ and 193/μ",
    ] {
        assert!(sheet.contains(words), "{words}: {sheet}");
    }
}

#[test]
fn pictures_show_every_part() {
    for file in ["assembled.png", "exploded.png"] {
        let file = std::fs::File::open(sides().path("mold").join(file)).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let width = info.width as usize;
        // Left of the legend, all but the background is the mold.
        let mut colors = std::collections::BTreeSet::new();
        for pixel in pixels.chunks_exact(3).enumerate().filter(|(i, _)| i % width < width * 3 / 4) {
            let [r, g, b] = [0, 1, 2].map(|k| i32::from(pixel.1[k]));
            if (r - g).abs().max((g - b).abs()) > 25 {
                // Hue in steps of a twelfth.
                let (max, min) = (r.max(g).max(b), r.min(g).min(b));
                let spread = f64::from(max - min);
                let hue = match max {
                    m if m == r => f64::from(g - b) / spread,
                    m if m == g => 2.0 + f64::from(b - r) / spread,
                    _ => 4.0 + f64::from(r - g) / spread,
                };
                colors.insert((2.0 * hue.rem_euclid(6.0)) as u8);
            }
        }
        // Blue, orange, green and red parts, and the green cast.
        assert!(colors.len() >= 4, "{colors:?}");
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

fn assert_refused(output: &Output, message: &str) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(message), "{said:?} does not say {message:?}");
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn bad_configurations() {
    for (config, message) in [
        (
            "wal = 1",
            "mold.toml:2:1: unknown field `wal`; did you mean `wall`? expected one of `chamber`, `method`, `layers`, `wound`, `around`, `surface`",
        ),
        (
            "chamber = \"hole\"",
            "the mesh has seat (68 facets), cavity (122 facets), skin (358 facets)",
        ),
        ("up = [1, 0, 0]", "faces 90.0° away from straight down"),
        ("[parting]\nkind = \"plane\"\npull = [0, 1, 1]", "makes an angle of 45.00° with up"),
        ("[sprue]\nat = [1, 0, 0]", "does not meet the part"),
        ("[core]\nshoulder = 1.6e-3", "an inscribed radius of 2.000 mm, at least 2.4"),
        ("[parting]\nkind = \"height-field\"\ncell = 2e-5\nsmoothing = 1e-4", "columns"),
    ] {
        assert_refused(&Scene::new(&CHAMBER, config).mold(), message);
    }
}

#[test]
fn bad_bodies() {
    assert_refused(&Scene::new(&CLOSED, "").mold(), "a chamber of 1728.0 mm³ is closed");
    assert_refused(&Scene::new(&CLOSED, "chamber = \"skin\"").mold(), "separate pieces");
    let spoil = |f: fn(&mut Vec3) -> bool| {
        let scene = Scene::new(&CHAMBER, "");
        let mut msh = read_tets(&scene.path("design.msh")).unwrap();
        assert!(msh.mesh.vertices.iter_mut().any(f));
        write_tets(&scene.path("design.msh"), &msh.mesh, &msh.tags).unwrap();
        scene.mold()
    };
    // A corner of the inlet, lifted.
    let lift = |p: &mut Vec3| {
        let corner = (*p - Vec3::new(8e-3, 12e-3, 0.0)).norm() < 1e-9;
        p.z += if corner { 1e-3 } else { 0.0 };
        corner
    };
    assert_refused(&spoil(lift), "leaves its plane by");
    // An inner vertex, moved through the opposite faces of its tetrahedra.
    let invert = |p: &mut Vec3| {
        let inner = (*p - Vec3::new(4e-3, 8e-3, 4e-3)).norm() < 1e-9;
        p.x += if inner { 5e-3 } else { 0.0 };
        inner
    };
    assert_refused(&spoil(invert), "some are inverted or overlap");
}

#[test]
fn bad_files() {
    let scene = Scene::new(&CHAMBER, "");
    let design = scene.path("design.msh");
    let text = std::fs::read_to_string(&design).unwrap();
    std::fs::write(&design, &text[..text.len() / 2]).unwrap();
    assert_refused(&scene.mold(), "design.msh");
    std::fs::write(&design, text.replacen("0.004", "nan", 1)).unwrap();
    assert_refused(&scene.mold(), "design.msh");
    std::fs::remove_file(&design).unwrap();
    assert_refused(&scene.mold(), "design.msh");
    assert_refused(&scene.verify(), "mold.json");
    // A file where the folder should be.
    std::fs::write(&design, text).unwrap();
    std::fs::write(scene.path("mold"), "").unwrap();
    assert_refused(&scene.mold(), "mold");
    assert_refused(&fab(&["mold"]), "Usage");
}

#[test]
fn a_report_that_cannot_be_is_refused() {
    let scene = Scene::new(&CHAMBER, "");
    copy(&shells().path("mold"), &scene.path("mold"));
    let sound = MoldReport::read(&scene.path("mold")).unwrap();
    let refused = |spoil: fn(&mut MoldReport), message: &str| {
        let mut report = sound.clone();
        spoil(&mut report);
        report.write(&scene.path("mold")).unwrap();
        assert_refused(&scene.verify(), message);
    };
    refused(|r| r.parts[0].file = "../design.msh".into(), "files must lie in its own folder");
    refused(|r| r.units = "cm".into(), "must be \"mm\"");
    refused(|r| r.parts[0].demolding = [0.0; 3], "must be one of ±y and ±z");
    refused(|r| r.parts[0].to_mold[0][0] = -1.0, "is turned by");
    refused(|r| r.design_to_mold[0][3] = 1e300, "must be 1000 times a rotation");
}

#[test]
fn an_older_mold_does_not_pass_for_one_that_was_refused() {
    let scene = Scene::new(&CHAMBER, "[sprue]\nat = [1, 0, 0]");
    copy(&shells().path("mold"), &scene.path("mold"));
    let files = files_below(&scene.path("mold"));
    assert_refused(&scene.mold(), "an older mold is still there");
    let verified = scene.verify();
    assert_eq!(verified.status.code(), Some(1), "{}", stdout(&verified));
    let said = stdout(&verified);
    assert!(
        said.contains("older than a failed `fab mold ") && said.contains("mold.toml"),
        "{said}"
    );
    // Nothing of it is lost, and a person may keep it.
    std::fs::remove_file(scene.path("mold/replacing.txt")).unwrap();
    assert_eq!(files_below(&scene.path("mold")), files);
    assert!(scene.verify().status.success());
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
    assert_refused(&output, ".stl");
    let left = files_below(&scene.path("mold"));
    assert!(left.is_empty(), "{left:?}");
}
