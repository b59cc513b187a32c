//! `cast.pdf`, the sheet for the bench, and how checks are listed.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::Read as _;
use std::path::Path;

use crate::fixture::{CHAMBER, Scene, TWO_CHAMBERS, fab, stderr, stdout};
use pdf_writer::{Content, Str};

const FONTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../cad2fem/render/fonts/Inter-");

/// Unpacks all packed streams of a PDF file.
fn unpacked(pdf: &[u8]) -> Vec<u8> {
    let find = |text: &[u8], from: usize| {
        pdf[from..].windows(text.len()).position(|w| w == text).map(|at| from + at)
    };
    let (mut all, mut from) = (Vec::new(), 0);
    while let Some(begin) = find(b"stream\n", from) {
        let end = find(b"endstream", begin).unwrap();
        // what is no zlib has no letters
        let mut decoder = flate2::read::ZlibDecoder::new(&pdf[begin + 7..end]);
        let _ = decoder.read_to_end(&mut all);
        from = end + 9;
    }
    all
}

/// Whether a sheet has a line of a text.
fn has(pdf: &Path, text: &str, weight: &str) -> bool {
    let font = fs::read(format!("{FONTS}{weight}.otf")).unwrap();
    let face = ttf_parser::Face::parse(&font, 0).unwrap();
    let glyphs = text.chars().flat_map(|c| face.glyph_index(c).unwrap().0.to_be_bytes());
    let mut content = Content::new();
    content.show(Str(&glyphs.collect::<Vec<_>>()));
    let wanted = content.finish().to_vec();
    unpacked(&fs::read(pdf).unwrap()).windows(wanted.len()).any(|found| found == wanted)
}

#[test]
fn a_sheet_for_the_bench_has_parts_masses_and_steps() {
    let scene = Scene::planned(
        &CHAMBER,
        "method = \"soluble\"\n[casting]\nsilicone = \"dragon-skin-20\"\nprinter = \"prusa-mk4\"\n",
    );
    let made = scene.mold();
    assert!(made.status.success(), "{}", stderr(&made));
    let path = scene.path("mold/cast.pdf");
    let cast: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(scene.path("mold/cast.json")).unwrap()).unwrap();
    let grams = format!("{:.1} g", cast["silicone"]["mass_g"].as_f64().unwrap());
    let file = cast["printed"][0]["file"].as_str().unwrap();
    for text in ["Dragon Skin 20", file, &grams] {
        assert!(has(&path, text, "Regular"), "{text}");
    }
    assert!(has(&path, "design", "Bold"), "the title is the name of the mesh");
    let sheet = fs::read(&path).unwrap();
    assert!(sheet.starts_with(b"%PDF-1.7") && !sheet.windows(12).any(|w| w == b"CreationDate"));
    let pages = |pdf: &[u8]| pdf.windows(11).filter(|w| w == b"/Type /Page").count() - 1;
    assert!((1..=2).contains(&pages(&sheet)), "{}", pages(&sheet));
    // the same bits, and gone with the mold
    assert!(scene.mold().status.success());
    assert!(fs::read(&path).unwrap() == sheet, "another sheet of the same mold");
}

#[test]
fn one_sheet_has_all_molds_of_a_body() {
    let scene = Scene::planned(&TWO_CHAMBERS, "method = \"halves\"\n");
    let made = scene.mold();
    assert!(made.status.success(), "{}", stderr(&made));
    let path = scene.path("mold/cast.pdf");
    for text in ["Cast the half-a", "Cast the half-b", "Put it together"] {
        assert!(has(&path, text, "Bold"), "{text}");
    }
    let sheet = fs::read_to_string(scene.path("mold/half-a-mold/cast.md")).unwrap();
    assert!(sheet.contains("the other half is glued to it, as `cast.md`"), "{sheet}");
    let whole = fs::read_to_string(scene.path("mold/cast.md")).unwrap();
    assert!(whole.contains("Method: halves; the plane "), "{whole}");
}

#[test]
fn checks_that_hold_are_counted_and_listed_on_demand() {
    let scene = Scene::new(&CHAMBER, "");
    assert!(scene.mold().status.success());
    let [mold, file] = ["mold", "checks.txt"].map(|name| scene.path(name));
    let verify = |more: &[&std::ffi::OsStr]| {
        let command = ["verify".as_ref(), mold.as_os_str()];
        stdout(&fab(&[&command[..], more].concat()))
    };
    let all = verify(&["--all".as_ref()]);
    let folded = verify(&["-o".as_ref(), file.as_os_str()]);
    let count = |text: &str, status: &str| text.lines().filter(|l| l.starts_with(status)).count();
    let [held, warned] = ["ok", "warn"].map(|status| count(&all, status));
    assert!(held > 30, "{all}");
    let last = format!("{held} checks hold, {warned} warn, 0 fail");
    assert_eq!(all.lines().last().unwrap(), last);
    assert_eq!(folded.lines().count(), warned + 1, "{folded}");
    assert_eq!(folded.lines().last().unwrap(), last + "; --all lists those that hold");
    let written = fs::read_to_string(&file).unwrap();
    assert_eq!([count(&written, "ok"), written.lines().count()], [held, held + warned]);
    fs::remove_file(mold.join("lower.3mf")).unwrap();
    let folded = verify(&[]);
    assert!(folded.starts_with("FAIL") && count(&folded, "FAIL") == 2, "{folded}");
}
