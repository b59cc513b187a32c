//! Other programs find the same as `fab verify`. Each is skipped, and says so, if it is missing.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

#[path = "../../tests/support/skip.rs"]
#[allow(clippy::expect_used)]
mod skip;
#[path = "../../tests/support/judges.rs"]
#[allow(dead_code, clippy::expect_used)]
mod programs;

use std::sync::OnceLock;

use crate::fixture::{CHAMBER, Scene, stderr};
use fab::files::report::MoldReport;
use fab::geometry::overhang::needs_supports;
use programs::{Lengths, Solid};

/// A mold of the chamber for a printer.
fn molded(parting: &str) -> Scene {
    let scene = Scene::new(&CHAMBER, &format!("{parting}\n[casting]\nprinter = \"prusa-mk4\""));
    let output = scene.mold();
    assert!(output.status.success(), "{}", stderr(&output));
    scene
}

const PLANE: &str = "[parting]\nkind = \"plane\"";
const FIELD: &str = "[parting]\nkind = \"height-field\"\npull = [0, 0, 1]";

fn molds() -> &'static [Scene; 2] {
    static MOLDS: OnceLock<[Scene; 2]> = OnceLock::new();
    MOLDS.get_or_init(|| [molded(FIELD), molded(PLANE)])
}

/// The printed parts of a mold.
fn parts(scene: &Scene) -> Vec<Solid> {
    let folder = scene.path("mold");
    let report = MoldReport::read(&folder).unwrap();
    let solid = |p: fab::files::report::Part| Solid {
        file: folder.join(p.file),
        name: p.name,
        volume: p.volume,
    };
    report.parts.into_iter().map(solid).collect()
}

/// The parts and what is cast.
fn solids(scene: &Scene) -> Vec<Solid> {
    let folder = scene.path("mold");
    let cast = MoldReport::read(&folder).unwrap().cast;
    let mut solids = parts(scene);
    let file = folder.join(cast.file);
    solids.push(Solid { file, name: "cast".into(), volume: cast.volume });
    solids
}

#[test]
fn trimesh_and_manifold3d_agree() {
    let Some(python) = programs::python(programs::PACKAGES) else { return };
    for scene in molds() {
        programs::trimesh_and_manifold3d_agree(&python, &solids(scene));
        let places: Vec<_> = MoldReport::read(&scene.path("mold")).unwrap().parts;
        let places: Vec<_> = places.iter().map(|part| part.to_mold).collect();
        programs::trimesh_reads_3mf(&python, &parts(scene), &places);
    }
}

#[test]
fn admesh_repairs_nothing() {
    if programs::installed("admesh") {
        molds().iter().for_each(|scene| programs::admesh_repairs_nothing(&solids(scene)));
    }
}

/// Where we see no need for supports the slicer sees none, either.
#[test]
fn prusa_slicer_needs_supports_where_told() {
    if !programs::installed("prusa-slicer") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = &molds()[1];
    let report = MoldReport::read(&scene.path("mold")).unwrap();
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
