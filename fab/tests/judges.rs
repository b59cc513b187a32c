//! The slicer finds the same overhangs as `fab`; skipped, with a word, if it is missing. `tests/slow/molds.rs` lets other
//! programs judge the molds of all scenes.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

#[path = "../../tests/support/skip.rs"]
#[allow(clippy::expect_used)]
mod skip;
#[path = "../../tests/support/judges.rs"]
#[allow(dead_code, clippy::expect_used)]
mod programs;

use geometry::overhang::needs_supports;

use crate::fixture::{CHAMBER, Scene};
use programs::Lengths;

/// Where we see no need for supports the slicer sees none, either.
#[test]
fn prusa_slicer_needs_supports_where_told() {
    if !programs::installed("prusa-slicer") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let config = "[parting]\nkind = \"plane\"\n[casting]\nprinter = \"prusa-mk4\"";
    let scene = Scene::new(&CHAMBER, config);
    scene.made();
    let report = scene.report(".");
    // One shell is as the other.
    for part in report.parts.iter().filter(|part| part.name != "right") {
        let file = scene.path("mold").join(&part.file);
        let needs = needs_supports(part.overhang);
        for options in [&[][..], &["--support-material"]] {
            let Lengths { part: printed, support } =
                programs::slice(&file, &file.with_extension("ini"), options, folder.path());
            eprintln!(
                "{}: {:.1} mm2 hang over, {printed:.0} and {support:.0} mm of filament",
                part.name, part.overhang
            );
            assert!(printed > 0.0 && (support > 0.0) == needs, "{}", part.name);
        }
    }
    let needy = report.parts.iter().filter(|part| needs_supports(part.overhang));
    assert_eq!(needy.map(|part| part.name.as_str()).collect::<Vec<_>>(), ["left", "right", "core"]);
}
